//! What the rows of a map say about the bound.

use serde::Serialize;

use super::classify::Class;
use crate::table::Row;

/// How classes and refusals go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Runs.
    pub runs: usize,
    /// Failed or oscillating, and refused.
    pub rightly_refused: usize,
    /// Stable, and accepted.
    pub rightly_accepted: usize,
    /// Failed, and accepted all the same: the bound is too weak.
    pub failed_accepted: usize,
    /// Oscillating, and accepted.
    pub oscillating_accepted: usize,
    /// Stable, and refused all the same.
    pub stable_refused: usize,
}

impl Counts {
    /// Of some rows.
    pub fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
        let mut counts = Self::default();
        for row in rows {
            counts.runs += 1;
            *match (row.class, row.refused) {
                (Some(Class::Stable), false) => &mut counts.rightly_accepted,
                (Some(Class::Stable), true) => &mut counts.stable_refused,
                (Some(Class::Failed) | None, false) => &mut counts.failed_accepted,
                (Some(Class::Oscillating), false) => &mut counts.oscillating_accepted,
                (_, true) => &mut counts.rightly_refused,
            } += 1;
        }
        counts
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} runs: {} stable and accepted, {} failed or oscillating and refused; wrong: {} failed and accepted, \
             {} oscillating and accepted, {} stable and refused",
            self.runs,
            self.rightly_accepted,
            self.rightly_refused,
            self.failed_accepted,
            self.oscillating_accepted,
            self.stable_refused
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_class_and_refusal_is_counted_once() {
        let row = |class, refused| Row { class: Some(class), refused, ..Row::default() };
        let rows: Vec<Row> =
            Class::ALL.iter().flat_map(|class| [row(*class, false), row(*class, true)]).collect();
        let counts = Counts::of(&rows);
        assert_eq!((counts.runs, counts.rightly_refused, counts.rightly_accepted), (6, 2, 1));
        let wrong = (counts.failed_accepted, counts.oscillating_accepted, counts.stable_refused);
        assert_eq!(wrong, (1, 1, 1));
    }
}
