//! The scene's text: parsing with places, `--set`, and sections for the crates that own them.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::SceneError;

/// The JSON Schema of a part of a scene; whatever it refers to stands within it.
pub fn schema<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        (settings.inline_subschemas, settings.meta_schema) = (true, None);
    });
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

/// A scene file as text, after `--set`.
#[derive(Clone, Debug)]
pub struct SceneSource {
    /// Path, for messages, and for the folder from which files are looked up.
    pub file: String,
    /// TOML text.
    pub text: String,
}

/// What a run that goes on may have otherwise: on how many ranks the fluid works, and how long is waited,
/// change no bit; a run that met a bound may go on without it.
const MAY_CHANGE: [(&str, &str); 6] = [
    ("fluid", "launcher"),
    ("coupling", "force"),
    ("coupling", "deadline"),
    ("coupling", "startup_deadline"),
    ("coupling", "checkpoint_every"),
    ("coupling", "spin"),
];

impl SceneSource {
    /// Reads a file and applies `KEY=VALUE` overrides.
    ///
    /// # Errors
    /// If the file cannot be read, is not TOML, or an override does not fit.
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let file = path.display().to_string();
        let text = protocol::input_file::read_text(path).map_err(|error| {
            SceneError::of_file(
                &file,
                format!("cannot read the scene: {error}"),
                "name a readable TOML file, such as scenes/bouncing-sphere.toml",
            )
        })?;
        Self { file, text }.with_overrides(overrides)
    }

    /// Applies `KEY=VALUE` overrides; KEY is dotted (`grains[0].density`), VALUE is TOML, or taken
    /// as a string where it is not.
    ///
    /// # Errors
    /// If the text is not TOML, or a key runs through something that is not a table or array.
    pub fn with_overrides(mut self, overrides: &[String]) -> Result<Self, SceneError> {
        self.tree()?;
        if overrides.is_empty() {
            return Ok(self);
        }
        let mut document: toml_edit::DocumentMut =
            self.text.parse().map_err(|error: toml_edit::TomlError| {
                self.error_at(error.span().unwrap_or(0..0), "", error.message().to_owned(), "mend the TOML")
            })?;
        for text in overrides {
            let refuse = |why: String| {
                SceneError::of_file(
                    "--set",
                    format!("`{text}`: {why}"),
                    "write --set KEY=VALUE with a dotted key of the scene, such as --set grains[0].density=2.0",
                )
            };
            let (key, value) = text.split_once('=').ok_or_else(|| refuse("has no `=`".into()))?;
            if key_path(key.trim()).is_empty() {
                return Err(refuse("names no key before the `=`".into()));
            }
            let value = value.trim().parse::<toml_edit::Value>().unwrap_or_else(|_| value.trim().into());
            set(document.as_item_mut(), &key_path(key.trim()), value).map_err(refuse)?;
        }
        self.text = document.to_string();
        self.file = format!("{} (with --set)", self.file);
        Ok(self)
    }

    /// The text as it would stand without `[chart]` and `[stability]`, which are about other runs
    /// than the scene's own. Comments above a table go with it.
    pub fn without_sweeps(&self) -> Cow<'_, str> {
        let Ok(mut document) = self.text.parse::<toml_edit::DocumentMut>() else {
            return Cow::Borrowed(&self.text);
        };
        let removed = SWEEPS.map(|name| document.remove(name).is_some());
        if removed.contains(&true) { Cow::Owned(document.to_string()) } else { Cow::Borrowed(&self.text) }
    }

    /// Keys and values in one order, without comments, folders of files, `until`, `[chart]` and
    /// `[stability]`.
    pub(crate) fn without_end(&self) -> Cow<'_, str> {
        let Ok(mut table) = self.text_without_folders().parse::<toml::Table>() else {
            return Cow::Borrowed(&self.text);
        };
        table.retain(|name, _| name != "until" && !SWEEPS.contains(&name));
        for (section, key) in MAY_CHANGE {
            if let Some(of) = table.get_mut(section).and_then(toml::Value::as_table_mut)
                && of.remove(key).is_some()
                && of.is_empty()
            {
                table.remove(section);
            }
        }
        Cow::Owned(table.to_string())
    }

    /// Reads the parts of the scene that `T` knows. `T` is a struct with one field per section;
    /// sections it does not name are left to their owners. Files have their whole paths.
    ///
    /// # Errors
    /// With the place of a missing or unknown key or a wrong type.
    pub fn section<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        let read = |text: &str| toml::from_str(text).map_err(|error| self.convert(&error));
        // As written first: the places of errors are those of the user's text.
        let as_written = read(&self.text)?;
        match self.text_for_any_folder() {
            Cow::Borrowed(_) => Ok(as_written),
            Cow::Owned(text) => read(&text),
        }
    }

    /// Refuses a list with more entries than what was read of it, such as a vector of four.
    ///
    /// # Errors
    /// At the first such list.
    pub fn refuse_longer_lists<T: Serialize>(&self, read: &T) -> Result<(), SceneError> {
        let Ok(read) = toml::Value::try_from(read) else { return Ok(()) };
        let written: toml::Value = toml::from_str(&self.text).map_err(|error| self.convert(&error))?;
        let Some((key, has, takes)) = longer_list(&written, &read, String::new()) else { return Ok(()) };
        let what = format!("has {has} entries; allowed: {takes}");
        Err(self.error(&key, what, "remove those that are too many"))
    }

    /// An error at a key; without a line where no part of the key stands in the text.
    pub fn error(&self, key: &str, message: impl Into<String>, remedy: &str) -> SceneError {
        let span = self.tree().ok().map_or(0..0, |tree| find(&tree, &key_path(key)).0);
        if span.is_empty() {
            return self.error_without_place(key, message.into(), remedy);
        }
        self.error_at(span, key, message.into(), remedy)
    }

    /// An error at a key where `wrong` holds.
    ///
    /// # Errors
    /// There alone.
    pub fn refuse_if(
        &self,
        wrong: bool,
        key: &str,
        message: impl std::fmt::Display,
        remedy: &str,
    ) -> Result<(), SceneError> {
        if wrong { Err(self.error(key, message.to_string(), remedy)) } else { Ok(()) }
    }

    fn error_without_place(&self, key: &str, message: String, remedy: &str) -> SceneError {
        SceneError { key: key.to_owned(), ..SceneError::of_file(&self.file, message, remedy) }
    }

    /// Whether `key` stands in the text.
    pub(crate) fn has(&self, key: &str) -> bool {
        let path = key_path(key);
        self.tree().is_ok_and(|tree| find(&tree, &path).1 == path.len())
    }

    pub(crate) fn tree(&self) -> Result<Spanned<DeTable<'_>>, SceneError> {
        DeTable::parse(&self.text).map_err(|error| {
            self.error_at(
                error.span().unwrap_or(0..0),
                "",
                format!("not valid TOML: {}", error.message()),
                "mend the syntax at the mark (https://toml.io)",
            )
        })
    }

    fn error_at(&self, span: Range<usize>, key: &str, message: String, remedy: &str) -> SceneError {
        let start = span.start.min(self.text.len());
        SceneError {
            file: self.file.clone(),
            line: 1 + self.text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count(),
            key: key.to_owned(),
            message,
            remedy: remedy.to_owned(),
            span: start..span.end.clamp(start, self.text.len()),
            text: self.text.clone(),
        }
    }

    /// Serde's error with our key and remedy. Inside tagged enums serde knows only the table's
    /// place; the field or value it names then narrows it.
    fn convert(&self, error: &toml::de::Error) -> SceneError {
        let mut span = error.span().unwrap_or(0..0);
        let message = error.message().trim_end().to_owned();
        let mut key = String::new();
        if let Ok(tree) = self.tree() {
            let all = places(tree.get_ref());
            if let Some(name) = quoted_after(&message, "unknown field `") {
                span = find_key(&all, &name, &span).unwrap_or(span);
            } else if message.starts_with("invalid ") || message.starts_with("unknown variant") {
                span = find_value(&all, &message, &span).unwrap_or(span);
            }
            // What spans the whole text belongs to no key.
            let spans_all = |span: Range<usize>| span.is_empty() || span.len() >= self.text.trim().len();
            let whole = error.span().is_none_or(spans_all);
            key = if whole { String::new() } else { key_at(&all, &span) };
            if let Some(name) = quoted_after(&message, "missing field `") {
                // A table that has the field holds the one that lacks it.
                let has = |key: &str| all.iter().any(|place| place.key == format!("{key}.{name}"));
                let within = |place: &&Place<'_>| {
                    let table = place.key.strip_prefix(&key).is_some_and(|rest| rest.starts_with('.'));
                    table && matches!(place.value, DeValue::Table(_)) && !has(&place.key)
                };
                if has(&key)
                    && let Some(place) = all.iter().find(within)
                {
                    (span, key) = (place.span.clone(), place.key.clone());
                }
                let joint = if key.is_empty() { "" } else { "." };
                key += &format!("{joint}{name}");
                if whole {
                    return self.error_without_place(&key, message, MISSING);
                }
            }
        }
        let remedy = if message.starts_with("missing field") {
            MISSING
        } else if message.starts_with("unknown") {
            "mend the name, or remove it; docs/scene.md lists every key"
        } else {
            "give a value of the type that docs/scene.md names for this key"
        };
        self.error_at(span, &key, message, remedy)
    }
}

/// Sections of commands that make many runs of a scene.
const SWEEPS: [&str; 2] = ["chart", "stability"];

/// Remedy of a key that is not there.
const MISSING: &str = "add the key; docs/scene.md says what it means";

/// `a.b[2].c` → `a`, `b`, `2`, `c`.
fn key_path(key: &str) -> Vec<String> {
    key.split(['.', '[', ']']).filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

fn quoted_after(message: &str, prefix: &str) -> Option<String> {
    let rest = message.split_once(prefix)?.1;
    Some(rest.split_once('`')?.0.to_owned())
}

/// A value of the text, and where it stands.
pub(crate) struct Place<'a> {
    /// Dotted key, `grains[0].radius`.
    pub(crate) key: String,
    pub(crate) value: &'a DeValue<'a>,
    span: Range<usize>,
    /// Name in its table, and where that stands; an entry of a list has none.
    name: Option<(&'a str, Range<usize>)>,
}

/// Every value of the text, each before those that it holds.
pub(crate) fn places<'a>(table: &'a DeTable<'a>) -> Vec<Place<'a>> {
    type Name<'a> = Option<(&'a str, Range<usize>)>;
    fn of_table<'a>(table: &'a DeTable<'a>, before: &str, all: &mut Vec<Place<'a>>) {
        for (name, value) in table {
            let key = format!("{before}{}", name.get_ref());
            add(key, value, Some((name.get_ref(), name.span())), all);
        }
    }
    fn add<'a>(key: String, value: &'a Spanned<DeValue<'a>>, name: Name<'a>, all: &mut Vec<Place<'a>>) {
        all.push(Place { key: key.clone(), value: value.get_ref(), span: value.span(), name });
        match value.get_ref() {
            DeValue::Table(table) => of_table(table, &format!("{key}."), all),
            DeValue::Array(items) => {
                let items = items.iter().enumerate();
                items.for_each(|(index, item)| add(format!("{key}[{index}]"), item, None, all));
            }
            _ => {}
        }
    }
    let mut all = Vec::new();
    of_table(table, "", &mut all);
    all
}

/// Span of the deepest part of `path` that stands in the text, and how many of its parts do; of the key where
/// a part is missing.
fn find(tree: &Spanned<DeTable<'_>>, path: &[String]) -> (Range<usize>, usize) {
    let all = places(tree.get_ref());
    let leading =
        all.iter().map(|place| (key_path(&place.key), place)).filter(|(key, _)| path.starts_with(key));
    leading.max_by_key(|(key, _)| key.len()).map_or((0..0, 0), |(key, place)| {
        let name = place.name.as_ref().filter(|_| place.value.is_table() || place.value.is_array());
        (name.map_or(&place.span, |(_, span)| span).clone(), key.len())
    })
}

/// Span of the first key `name` from the start of `within` on (the span of a table is its header).
fn find_key(all: &[Place<'_>], name: &str, within: &Range<usize>) -> Option<Range<usize>> {
    let mut names = all.iter().filter_map(|place| place.name.as_ref());
    names.find(|(known, span)| *known == name && span.start >= within.start).map(|(_, span)| span.clone())
}

/// Span of the only value in what stands at `within` that is what serde's `message` describes.
fn find_value(all: &[Place<'_>], message: &str, within: &Range<usize>) -> Option<Range<usize>> {
    let roots: Vec<&str> = all.iter().filter(|p| p.span == *within).map(|p| p.key.as_str()).collect();
    let inside = |key: &str| {
        let rest = |root: &&str| {
            key.strip_prefix(root).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        roots.iter().any(rest)
    };
    let mut found = all.iter().filter(|place| inside(&place.key) && describes(message, place.value));
    found.next().filter(|_| found.next().is_none()).map(|place| place.span.clone())
}

/// Does serde's `message` speak of this value?
fn describes(message: &str, value: &DeValue<'_>) -> bool {
    match value {
        DeValue::String(text) => {
            message.contains(&format!(": string {text:?},"))
                || message.starts_with(&format!("unknown variant `{text}`,"))
        }
        DeValue::Integer(number) => message.contains(&format!(": integer `{}`,", number.as_str())),
        DeValue::Float(number) => {
            let said = quoted_after(message, ": floating point `").and_then(|text| text.parse::<f64>().ok());
            said.is_some() && said == number.as_str().parse().ok()
        }
        DeValue::Boolean(truth) => message.contains(&format!(": boolean `{truth}`,")),
        DeValue::Array(items) => {
            message.starts_with("invalid type: sequence")
                || message.starts_with(&format!("invalid length {},", items.len()))
        }
        DeValue::Table(_) => message.starts_with("invalid type: map"),
        DeValue::Datetime(_) => false,
    }
}

/// Dotted key of the innermost that stands at `span`.
fn key_at(all: &[Place<'_>], span: &Range<usize>) -> String {
    let touches =
        |other: &Range<usize>| other.start <= span.start && span.start < other.end.max(other.start + 1);
    let is_here = |p: &&Place| touches(&p.span) || p.name.as_ref().is_some_and(|(_, name)| touches(name));
    let here = all.iter().rev().filter(is_here);
    here.max_by_key(|place| key_path(&place.key).len()).map_or(String::new(), |place| place.key.clone())
}

fn set(item: &mut toml_edit::Item, path: &[String], value: toml_edit::Value) -> Result<(), String> {
    let Some((part, rest)) = path.split_first() else {
        *item = toml_edit::Item::Value(value);
        return Ok(());
    };
    if let Ok(index) = part.parse::<usize>() {
        if let Some(tables) = item.as_array_of_tables_mut() {
            let count = tables.len();
            let table = tables.get_mut(index).ok_or(format!("index {index} is past the last of {count}"))?;
            let (name, rest) = rest.split_first().ok_or("names a whole table, not a key")?;
            return set(table.entry(name).or_insert(toml_edit::Item::None), rest, value);
        }
        if let Some(array) = item.as_array_mut() {
            let count = array.len();
            let slot = array.get_mut(index).ok_or(format!("index {index} is past the last of {count}"))?;
            let mut inner = toml_edit::Item::Value(slot.clone());
            set(&mut inner, rest, value)?;
            *slot = inner.into_value().map_err(|_| "does not fit an array")?;
            return Ok(());
        }
        return Err(format!("`{index}` counts into something that is not an array"));
    }
    if item.is_none() {
        *item = toml_edit::Item::Table(toml_edit::Table::new());
    }
    let table =
        item.as_table_like_mut().ok_or(format!("`{part}` goes into something that is not a table"))?;
    if let Some(inner) = table.get_mut(part) {
        return set(inner, rest, value);
    }
    // toml_edit hides empty items, and an inline table cannot hold them: the branch is put in whole.
    let mut inner = toml_edit::Item::None;
    set(&mut inner, rest, value)?;
    table.insert(part, inner);
    Ok(())
}

/// The first list that is longer as written than as read: its key and both lengths.
fn longer_list(written: &toml::Value, read: &toml::Value, key: String) -> Option<(String, usize, usize)> {
    use toml::Value::{Array, Table};
    match (written, read) {
        (Table(written), Table(read)) => written.iter().find_map(|(name, value)| {
            let inner = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            longer_list(value, read.get(name)?, inner)
        }),
        (Array(written), Array(read)) if written.len() > read.len() => Some((key, written.len(), read.len())),
        (Array(written), Array(read)) => (0..written.len())
            .find_map(|index| longer_list(&written[index], &read[index], format!("{key}[{index}]"))),
        _ => None,
    }
}
