//! As a scene writes it: a value, rows `[t, value]`, `{ file }` or `{ amplitude, frequency, phase, offset }`.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use std::path::PathBuf;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{OverTime, Quantity, Sine, Table};

/// A value over time: a constant; rows `[t, value]`, linear between them and constant outside; a CSV file of
/// such rows; or offset + amplitude · sin(2π frequency t + phase).
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum Written<T> {
    Constant(T),
    Rows(Vec<(f64, T)>),
    File(FileTable),
    Sine(SineTable<T>),
}

/// A table in a file.
#[derive(Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FileTable {
    /// CSV file with a column `t`, s, and `x`, `y`, `z` of a vector, `value` of a number; looked up from the
    /// scene's folder.
    file: PathBuf,
}

/// offset + amplitude · sin(2π frequency t + phase).
#[derive(JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(dead_code)]
struct SineTable<T> {
    /// Amplitude, in the unit of the key.
    amplitude: T,
    /// Frequency, Hz.
    frequency: f64,
    /// Phase at t = 0, rad.
    #[serde(default)]
    phase: f64,
    /// Mean value, in the unit of the key.
    offset: Option<T>,
}

/// Either kind of table: told apart by its keys.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields<T> {
    file: Option<PathBuf>,
    amplitude: Option<T>,
    frequency: Option<f64>,
    phase: Option<f64>,
    offset: Option<T>,
}

impl<T: Quantity> JsonSchema for OverTime<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("OverTime_{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Written::<T>::json_schema(generator)
    }
}

impl<T: Quantity> Serialize for OverTime<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Constant(value) => value.serialize(to),
            Self::Table(table) => match &table.file {
                // Once it is read the rows say all.
                Some(file) if table.rows.is_empty() => FileTable { file: file.clone() }.serialize(to),
                _ => table.rows.serialize(to),
            },
            Self::Sine(sine) => sine.serialize(to),
        }
    }
}

impl<'de, T: Quantity> Deserialize<'de> for OverTime<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(Form(PhantomData))
    }
}

/// By hand rather than `untagged`, which would lose the place and the reason of an error.
struct Form<T>(PhantomData<T>);

/// A number of a vector, or a row of a table.
enum Entry<T> {
    Number(f64),
    Row(f64, T),
}

impl<'de, T: Quantity> Visitor<'de> for Form<T> {
    type Value = OverTime<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, rows [t, value], {{ file }} or {{ amplitude, frequency, phase, offset }}", T::NAME)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Self::Value, E> {
        self.visit_f64(number as f64)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Self::Value, E> {
        self.visit_f64(number as f64)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Self::Value, E> {
        let mut value = T::ZERO;
        match value.numbers_mut() {
            [only] => *only = number,
            _ => return Err(E::invalid_type(serde::de::Unexpected::Float(number), &self)),
        }
        Ok(OverTime::Constant(value))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let (mut numbers, mut rows, mut count) = (T::ZERO, Vec::new(), 0);
        while let Some(entry) = list.next_element::<Entry<T>>()? {
            match entry {
                Entry::Number(number) if rows.is_empty() => {
                    // What is too long is refused by the scene, with its key.
                    if let Some(place) = numbers.numbers_mut().get_mut(count) {
                        *place = number;
                    }
                    count += 1;
                }
                Entry::Row(t, value) if count == 0 => rows.push((t, value)),
                _ => return Err(A::Error::custom("mixes numbers and rows [t, value]")),
            }
        }
        let length = T::ZERO.numbers().len();
        match (count, length) {
            (0, _) => Ok(OverTime::table(rows)),
            (1.., 2..) if count >= length => Ok(OverTime::Constant(numbers)),
            _ => Err(A::Error::invalid_length(count, &self)),
        }
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Self::Value, M::Error> {
        let fields = Fields::<T>::deserialize(MapAccessDeserializer::new(map))?;
        match fields {
            Fields { file: Some(file), amplitude: None, frequency: None, phase: None, offset: None } => {
                Ok(OverTime::Table(Arc::new(Table::new(Vec::new(), Some(file)))))
            }
            Fields { file: None, amplitude: Some(amplitude), frequency: Some(frequency), phase, offset } => {
                let (phase, offset) = (phase.unwrap_or(0.0), offset.unwrap_or(T::ZERO));
                Ok(OverTime::sine(Sine { amplitude, frequency, phase, offset }))
            }
            Fields { file: Some(_), .. } => Err(M::Error::custom("has `file` and keys of a sine: give one")),
            Fields { amplitude: None, .. } => Err(M::Error::missing_field("amplitude")),
            Fields { .. } => Err(M::Error::missing_field("frequency")),
        }
    }
}

impl<'de, T: Quantity> Deserialize<'de> for Entry<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Of<T>(PhantomData<T>);
        impl<'de, T: Quantity> Visitor<'de> for Of<T> {
            type Value = Entry<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a number, or a row [t, value] with a value of {}", T::NAME)
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Self::Value, E> {
                Ok(Entry::Number(number as f64))
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<Self::Value, E> {
                Ok(Entry::Number(number as f64))
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Self::Value, E> {
                Ok(Entry::Number(number))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut row: A) -> Result<Self::Value, A::Error> {
                let short = |count| A::Error::invalid_length(count, &self);
                let t = row.next_element()?.ok_or_else(|| short(0))?;
                let value = row.next_element()?.ok_or_else(|| short(1))?;
                match row.next_element::<f64>()? {
                    None => Ok(Entry::Row(t, value)),
                    Some(_) => Err(short(3)),
                }
            }
        }
        from.deserialize_any(Of(PhantomData))
    }
}
