//! The files that a run will leave: how often fields are written where the scene does not say, and sizes.

use bedload_scene::Observe;
use serde::Serialize;

use crate::number::Short;

/// Instants by default, for a film of some seconds.
const INSTANTS: f64 = 50.0;

/// Bytes that they may have in all; more bytes an instant, fewer instants.
const MOST_BYTES: f64 = 200e6;

/// Fewer than these show nothing: then none is written.
const FEWEST: f64 = 5.0;

/// Part of the run's estimated cost that they may add.
const PART: f64 = 0.01;

/// Bytes of fields a second that are made and written, measured: 33 instants of 2.6 MB in 0.4 s of CPU time.
const RATE: f64 = 200e6;

/// What an instant costs besides, s: 0.018 s of CPU time in the report, measured; the rest is for slow disks,
/// and was not.
const DRAWN: f64 = 0.05;

/// Files that a run will leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Files {
    /// Time between fields, s; 0: none but those that the scene names.
    pub fields_every: f64,
    /// Does the scene say so?
    pub fields_asked: bool,
    /// Instants of fields.
    pub instants: u64,
    /// Bytes of an instant; zero: no solver says.
    pub instant: u64,
    /// Bytes of a checkpoint; zero: no solver says.
    pub checkpoint: u64,
}

impl Files {
    /// Of a run to `until`, s, of so many windows, that costs `cost`, s on one core; an instant of fields has
    /// `instant` bytes, a checkpoint `checkpoint`.
    pub fn of(observe: &Observe, until: f64, windows: f64, cost: f64, instant: u64, checkpoint: u64) -> Self {
        let fields_asked = observe.fields_every.is_some() || !observe.fields_at.is_empty();
        let fields_every = match observe.fields_every {
            Some(every) => every,
            None if fields_asked => 0.0,
            None => by_default(until, windows, cost, instant as f64),
        };
        let every = if fields_every > 0.0 { (until / fields_every * (1.0 + 1e-9)).floor() } else { 0.0 };
        let at = observe.fields_at.iter().filter(|t| **t <= until).count() as f64;
        let instants = (every + at).min(windows) as u64;
        Self { fields_every, fields_asked, instants, instant, checkpoint }
    }

    /// What the plan says of them.
    pub(crate) fn lines(&self) -> [(&'static str, String); 2] {
        let size = |bytes: u64| format!("{} MiB", Short(bytes as f64 / f64::from(1 << 20)));
        let of_instant = if self.instant > 0 { size(self.instant) } else { "unknown size".into() };
        let why = if self.fields_asked { "" } else { " by default (observe.fields_every = 0: none)" };
        let fields = match (self.instants, self.fields_asked) {
            (0, true) => "none".into(),
            (0, false) => {
                format!("none by default, an instant has {of_instant} (observe.fields_every asks for some)")
            }
            (count, _) => {
                let all = if self.instant > 0 { size(count * self.instant) } else { "unknown size".into() };
                format!("{count} instants of {of_instant}, {all} in all{why}")
            }
        };
        let checkpoint = match self.checkpoint {
            0 => "unknown size".into(),
            bytes => format!("{}, and as much again while one is written", size(bytes)),
        };
        [("fields", fields), ("checkpoint", checkpoint)]
    }
}

/// Time between fields where the scene does not say, s; 0: none.
fn by_default(until: f64, windows: f64, cost: f64, instant: f64) -> f64 {
    if instant == 0.0 {
        return 0.0;
    }
    let afforded = PART * cost / (instant / RATE + DRAWN);
    let count = INSTANTS.min(MOST_BYTES / instant).min(afforded).min(windows).floor();
    if count < FEWEST { 0.0 } else { until / count }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn every(observe: Observe, cost: f64, instant: u64) -> (f64, u64) {
        let files = Files::of(&observe, 10.0, 1000.0, cost, instant, 0);
        (files.fields_every, files.instants)
    }

    #[test]
    fn fields_are_written_by_default_as_far_as_they_are_cheap_and_small() {
        let nothing = Observe::default;
        assert_eq!(every(nothing(), 1e4, 1_000_000), (0.2, 50));
        assert_eq!(every(nothing(), 1e4, 20_000_000), (1.0, 10), "200 MB");
        assert_eq!(every(nothing(), 1e4, 50_000_000), (0.0, 0), "four would fit");
        assert_eq!(every(nothing(), 1.0, 1_000_000), (0.0, 0), "a run of a second");
        assert_eq!(every(nothing(), 1e4, 0), (0.0, 0), "no solver says its size");
        let asked = |every, at: &[f64]| Observe { fields_every: every, fields_at: at.to_vec(), ..nothing() };
        assert_eq!(every(asked(Some(0.0), &[]), 1e4, 1_000_000), (0.0, 0));
        assert_eq!(every(asked(Some(0.1), &[]), 1e4, 1_000_000), (0.1, 100));
        assert_eq!(every(asked(None, &[0.0, 5.0, 20.0]), 1e4, 1_000_000), (0.0, 2));
    }
}
