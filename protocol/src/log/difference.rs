//! What a solver sends against what was logged: word by word, named by step, grain and field.

use std::collections::BTreeMap;

use serde::Serialize;

use super::codec;
use crate::message::{Header, Record};

/// The first word that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Window.
    pub step: u64,
    /// Try of the window.
    pub attempt: u64,
    /// Grain, from 0; none in the header.
    pub grain: Option<usize>,
    /// Field with its component (`velocity[2]`, `header.substeps`).
    pub field: String,
    /// The logged word.
    pub logged: u64,
    /// The word that was sent.
    pub sent: u64,
    /// `f64` or `u64`: how the words are meant.
    pub kind: &'static str,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "step {}", self.step)?;
        if self.attempt > 0 {
            write!(f, " attempt {}", self.attempt)?;
        }
        match self.grain {
            Some(grain) => write!(f, ", grain {grain}")?,
            None => f.write_str(", header")?,
        }
        let (logged, sent) = (self.logged, self.sent);
        write!(f, ", field {}: logged ", self.field)?;
        match self.kind {
            "f64" => write!(
                f,
                "{:e} ({logged:016x}), sent {:e} ({sent:016x})",
                f64::from_bits(logged),
                f64::from_bits(sent)
            ),
            _ => write!(f, "{logged}, sent {sent}"),
        }
    }
}

/// How much one field differs over a replay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldDifference {
    /// Words compared.
    pub words: u64,
    /// Words that differ in any bit.
    pub differing: u64,
    /// Largest |sent − logged| (infinite if one is not finite and they differ).
    pub largest: f64,
    /// Root of the mean square of sent − logged, over all words.
    pub rms: f64,
}

/// Compares what a solver sends with what was logged, and keeps the tally.
#[derive(Debug, Default)]
pub struct Comparison {
    /// Ends at the first difference; else all are counted.
    verify: bool,
    first: Option<Difference>,
    /// Sums of squares stand in `rms` until [`Comparison::fields`].
    fields: BTreeMap<String, FieldDifference>,
    messages: u64,
    logged: Vec<u8>,
    sent: Vec<u8>,
}

/// Which record of which window.
#[derive(Clone, Copy, Debug)]
struct At {
    step: u64,
    attempt: u64,
    grain: Option<usize>,
}

impl Comparison {
    /// With `verify` it ends at the first difference; without, all differences are counted.
    #[must_use]
    pub fn new(verify: bool) -> Self {
        Self { verify, ..Self::default() }
    }

    /// First difference met.
    #[must_use]
    pub fn first(&self) -> Option<&Difference> {
        self.first.as_ref()
    }

    /// Is there nothing more to compare? Only with `verify`.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.verify && self.first.is_some()
    }

    /// Messages compared.
    #[must_use]
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Compares a message: header and records, one per grain.
    pub fn message<R: Record + Serialize>(&mut self, logged: (&Header, &[R]), sent: (&Header, &[R])) {
        self.messages += 1;
        let Header { step, attempt, .. } = *logged.0;
        self.record(At { step, attempt, grain: None }, logged.0, sent.0);
        for (grain, (theirs, ours)) in logged.1.iter().zip(sent.1).enumerate() {
            if self.is_over() {
                return;
            }
            self.record(At { step, attempt, grain: Some(grain) }, theirs, ours);
        }
    }

    fn record<R: Record + Serialize>(&mut self, at: At, logged: &R, sent: &R) {
        let (mut theirs, mut ours) = (std::mem::take(&mut self.logged), std::mem::take(&mut self.sent));
        words(logged, &mut theirs);
        words(sent, &mut ours);
        if theirs != ours {
            self.first.get_or_insert_with(|| first_difference::<R>(at, &theirs, &ours));
        }
        if !self.verify {
            self.tally::<R>(at, &theirs, &ours);
        }
        (self.logged, self.sent) = (theirs, ours);
    }

    fn tally<R: Record>(&mut self, at: At, logged: &[u8], sent: &[u8]) {
        let mut pairs = word_pairs(logged, sent);
        for field in R::FIELDS {
            let name = prefixed(at, field.name.to_owned());
            let sum = match self.fields.get_mut(&name) {
                Some(sum) => sum,
                None => self.fields.entry(name).or_default(),
            };
            for (theirs, ours) in pairs.by_ref().take(field.words) {
                sum.add(field.kind, theirs, ours);
            }
        }
    }

    /// How far each field is off, over all messages; empty with `verify`.
    #[must_use]
    pub fn fields(&self) -> BTreeMap<String, FieldDifference> {
        let mut fields = self.fields.clone();
        for field in fields.values_mut() {
            field.rms = (field.rms / field.words.max(1) as f64).sqrt();
        }
        fields
    }
}

impl FieldDifference {
    fn add(&mut self, kind: &str, logged: u64, sent: u64) {
        self.words += 1;
        if logged == sent {
            return;
        }
        self.differing += 1;
        let apart = match kind {
            "f64" => (f64::from_bits(sent) - f64::from_bits(logged)).abs(),
            _ => logged.abs_diff(sent) as f64,
        };
        let apart = if apart.is_nan() { f64::INFINITY } else { apart };
        self.largest = self.largest.max(apart);
        self.rms += apart * apart;
    }
}

/// The record as the log holds it. Encoding a record of fixed words cannot fail; if it ever did,
/// both sides would be empty, and the codec's own tests would say so.
fn words<R: Serialize>(record: &R, out: &mut Vec<u8>) {
    out.clear();
    let _ = codec::encode(record, out);
}

fn word_pairs<'a>(logged: &'a [u8], sent: &'a [u8]) -> impl Iterator<Item = (u64, u64)> + use<'a> {
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte));
    logged.chunks(8).map(word).zip(sent.chunks(8).map(word))
}

fn first_difference<R: Record>(at: At, logged: &[u8], sent: &[u8]) -> Difference {
    let found = word_pairs(logged, sent).enumerate().find(|(_, (a, b))| a != b);
    let (index, (logged, sent)) = found.unwrap_or_default();
    Difference {
        step: at.step,
        attempt: at.attempt,
        grain: at.grain,
        field: prefixed(at, R::field_of_word(index)),
        logged,
        sent,
        kind: kind_of_word::<R>(index),
    }
}

fn prefixed(at: At, field: String) -> String {
    if at.grain.is_some() { field } else { format!("header.{field}") }
}

fn kind_of_word<R: Record>(index: usize) -> &'static str {
    let mut end = 0;
    R::FIELDS
        .iter()
        .find(|field| {
            end += field.words;
            index < end
        })
        .map_or("u64", |field| field.kind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{Header, Kinematics};

    const AT: At = At { step: 3, attempt: 0, grain: Some(7) };

    #[test]
    fn signed_zero_and_nan_payload_are_differences() {
        let logged = Kinematics { velocity: [0.0, 1.0, f64::NAN], ..Kinematics::default() };
        let mut sent = logged;
        let mut comparison = Comparison::default();
        comparison.record(AT, &logged, &sent);
        assert_eq!(comparison.first(), None);
        sent.velocity[0] = -0.0;
        comparison.record(AT, &logged, &sent);
        let first = comparison.first().unwrap();
        assert_eq!((first.step, first.grain, first.field.as_str()), (3, Some(7), "velocity[0]"));
        let velocity = comparison.fields()["velocity"];
        assert_eq!((velocity.words, velocity.differing, velocity.largest), (6, 1, 0.0));
    }

    #[test]
    fn a_header_names_its_field_and_integers_print_as_such() {
        let logged = Header { substeps: 10, ..Header::default() };
        let sent = Header { substeps: 12, ..Header::default() };
        let mut comparison = Comparison::default();
        comparison.record(At { grain: None, ..AT }, &logged, &sent);
        let text = comparison.first().unwrap().to_string();
        assert_eq!(text, "step 3, header, field header.substeps: logged 10, sent 12");
        assert_eq!(comparison.fields()["header.substeps"].largest, 2.0);
    }
}
