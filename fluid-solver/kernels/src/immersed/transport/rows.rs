//! Working memory of one grain in one layer.

use super::interpolation::POINTS;
use super::sums::Sums;
use crate::immersed::piece::PIECES;

/// Rows that are interpolated between along the last axis, to be interpolated between along axis 1.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ring {
    /// Which row each of them is, counted on over a periodic face.
    pub(super) rows: [Option<isize>; POINTS],
    pub(super) sums: [Sums; POINTS],
}

/// Room for one grain in one layer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    pub(super) rings: [Ring; PIECES],
    pub(super) sums: Sums,
    /// Rows of λ and of b that a face of the box cuts.
    pub(super) cut: [[Vec<f64>; POINTS]; 2],
}
