//! What a solver sends against what was logged: word by word, named by step, grain and field.

use std::collections::BTreeMap;

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
    pub fn new(verify: bool) -> Self {
        Self { verify, ..Self::default() }
    }

    /// First difference met.
    pub fn first(&self) -> Option<&Difference> {
        self.first.as_ref()
    }

    /// Is there nothing more to compare? Only with `verify`.
    pub fn is_over(&self) -> bool {
        self.verify && self.first.is_some()
    }

    /// Messages compared.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Compares a message: header and records, one per grain.
    pub fn message<R: Record>(&mut self, logged: (&Header, &[R]), sent: (&Header, &[R])) {
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

    fn record<R: Record>(&mut self, at: At, logged: &R, sent: &R) {
        let (theirs, ours) = (logged.words(), sent.words());
        if theirs != ours {
            self.first.get_or_insert_with(|| first_difference::<R>(at, &theirs, &ours));
        }
        if !self.verify {
            self.tally::<R>(at, &theirs, &ours);
        }
    }

    fn tally<R: Record>(&mut self, at: At, logged: &[u64], sent: &[u64]) {
        let mut pairs = logged.iter().zip(sent);
        for field in R::FIELDS {
            let name = prefixed(at, field.name.to_owned());
            let sum = self.fields.entry(name).or_default();
            for (theirs, ours) in pairs.by_ref().take(field.words) {
                sum.add(field.kind, *theirs, *ours);
            }
        }
    }

    /// How far each field is off, over all messages; empty with `verify`.
    pub fn fields(&self) -> BTreeMap<String, FieldDifference> {
        let mut fields = self.fields.clone();
        for field in fields.values_mut() {
            field.rms = (field.rms / field.words.max(1) as f64).sqrt();
        }
        fields
    }
}

impl std::fmt::Display for FieldDifference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { words, differing, largest, rms } = self;
        match differing {
            0 => write!(f, "all {words} numbers the same"),
            _ => write!(
                f,
                "{differing} of {words} numbers differ, by {largest:e} at most, {rms:e} in root mean square"
            ),
        }
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

fn first_difference<R: Record>(at: At, logged: &[u64], sent: &[u64]) -> Difference {
    let index = logged.iter().zip(sent).position(|(a, b)| a != b).unwrap_or(0);
    Difference {
        step: at.step,
        attempt: at.attempt,
        grain: at.grain,
        field: prefixed(at, R::field_of_word(index)),
        logged: logged[index],
        sent: sent[index],
        kind: R::field_at(index).map_or("u64", |(field, _)| field.kind),
    }
}

fn prefixed(at: At, field: String) -> String {
    if at.grain.is_some() { field } else { format!("header.{field}") }
}
