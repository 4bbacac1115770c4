//! Who owns which rows, and sums over all owners.

use std::ops::Range;

/// The processes that share a fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Comm {
    /// One process owns everything.
    #[default]
    Serial,
}

impl Comm {
    /// Layers of the last axis that this process owns, of `layers` in all.
    pub fn owned(self, layers: usize) -> Range<usize> {
        match self {
            Self::Serial => 0..layers,
        }
    }

    /// Sum over all processes, in a fixed order.
    pub fn sum(self, value: f64) -> f64 {
        match self {
            Self::Serial => value,
        }
    }

    /// Largest value over all processes; NaN if any is NaN.
    pub fn max(self, value: f64) -> f64 {
        match self {
            Self::Serial => value,
        }
    }
}
