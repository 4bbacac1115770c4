//! Which transform a line of values needs.

use crate::grid::Grid;
use std::f64::consts::PI;

/// Boundary type and staggering of one line of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Periodic, `n` values: real Fourier transform, cosine amplitudes of wave number k at place k,
    /// sine amplitudes at place n − k.
    Periodic,
    /// Cell centres, zero slope at both ends, `n` values: cosine transform II.
    EvenEven,
    /// Cell centres, zero value at both ends, `n` values: sine transform II.
    OddOdd,
    /// Cell centres, zero slope below and zero value above: cosine transform IV.
    EvenOdd,
    /// Cell centres, zero value below and zero slope above: sine transform IV.
    OddEven,
    /// Faces between two walls, zero on both, `n − 1` values: sine transform I.
    Fixed,
}

impl Kind {
    /// Kind of velocity component `d` along `axis`.
    pub fn of_component<const D: usize>(grid: &Grid<D>, d: usize, axis: usize) -> Self {
        let [low, high] = grid.boundaries[axis];
        match (low.is_periodic(), d == axis, low.is_odd(), high.is_odd()) {
            (true, ..) => Self::Periodic,
            (_, true, ..) => Self::Fixed,
            (_, _, false, false) => Self::EvenEven,
            (_, _, true, true) => Self::OddOdd,
            (_, _, false, true) => Self::EvenOdd,
            (_, _, true, false) => Self::OddEven,
        }
    }

    /// Number of values on an axis of `cells` cells.
    pub fn values(self, cells: usize) -> usize {
        cells - usize::from(self == Self::Fixed)
    }

    /// Eigenvalue of the second difference (unit width) that belongs to place `q` of the transform.
    pub fn eigenvalue(self, q: usize, cells: usize) -> f64 {
        let n = cells as f64;
        let angle = match self {
            Self::Periodic => 2.0 * PI * q.min(cells - q) as f64 / n,
            Self::EvenEven => PI * q as f64 / n,
            Self::OddOdd | Self::Fixed => PI * (q + 1) as f64 / n,
            Self::EvenOdd | Self::OddEven => PI * (q as f64 + 0.5) / n,
        };
        -4.0 * (0.5 * angle).sin().powi(2)
    }

    /// What `inverse(forward(x))` must be multiplied by to give `x`.
    pub fn scale(self, cells: usize) -> f64 {
        if self == Self::Periodic { 1.0 / cells as f64 } else { 2.0 / cells as f64 }
    }
}
