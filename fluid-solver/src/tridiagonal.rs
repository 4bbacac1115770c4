//! Thomas' algorithm on eight systems at once, with the pivots computed beforehand.
//!
//! The systems are `(σ − c (L + λ)) x = b`: L the stencil along the swept axis, λ the eigenvalue of
//! the transformed axes, one per lane. Off-diagonals are the same for all lanes, so only the
//! inverse pivots are stored per lane.

use crate::lanes::{Lanes, ZERO};

/// Tridiagonal form of a stencil along the swept axis, walls folded into the diagonal. Unknowns only.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Weight of the lower neighbour; zero for the first unknown.
    pub lower: Vec<f64>,
    /// Weight of the upper neighbour; zero for the last unknown.
    pub upper: Vec<f64>,
    /// Diagonal (negative).
    pub diagonal: Vec<f64>,
    /// Metric volume of each unknown, for the mean of the singular mode.
    pub volume: Vec<f64>,
}

impl Sweep {
    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// Whether there is nothing to solve.
    pub fn is_empty(&self) -> bool {
        self.diagonal.is_empty()
    }

    /// Inverse pivots for eight eigenvalues. A lane in `singular` gets a zero last pivot: its system
    /// is solved up to a constant, with the last value zero.
    #[inline(always)]
    pub fn pivots(&self, sigma: f64, c: f64, lambda: &Lanes, singular: Option<usize>, pivots: &mut [Lanes]) {
        let mut previous = ZERO;
        for (i, pivot) in pivots[..self.len()].iter_mut().enumerate() {
            // Eliminated product of the off-diagonals, (−c l_i)(−c u_{i−1}).
            let off = if i == 0 { 0.0 } else { c * c * self.lower[i] * self.upper[i - 1] };
            for l in 0..8 {
                let d = sigma - c * (self.diagonal[i] + lambda[l]);
                pivot[l] = 1.0 / (d - off * previous[l]);
            }
            previous = *pivot;
        }
        if let Some(lane) = singular {
            pivots[self.len() - 1][lane] = 0.0;
        }
    }

    /// Solves in place: `x` holds `b` on entry and the solution of `… = scale · b` on return.
    #[inline(always)]
    pub fn solve(&self, c: f64, scale: f64, pivots: &[Lanes], x: &mut [Lanes]) {
        let n = self.len();
        let (pivots, x) = (&pivots[..n], &mut x[..n]);
        let mut previous = ZERO;
        for ((x, pivot), lower) in x.iter_mut().zip(pivots).zip(&self.lower) {
            let weight = c * lower;
            for l in 0..8 {
                x[l] = (scale * x[l] + weight * previous[l]) * pivot[l];
            }
            previous = *x;
        }
        for ((x, pivot), upper) in x.iter_mut().zip(pivots).zip(&self.upper).rev().skip(1) {
            let weight = c * upper;
            for l in 0..8 {
                x[l] += weight * pivot[l] * previous[l];
            }
            previous = *x;
        }
    }

    /// Removes the volume mean of one lane (the singular mode of pressure).
    pub fn remove_mean(&self, lane: usize, x: &mut [Lanes]) {
        let total: f64 = self.volume.iter().sum();
        let sum: f64 = x.iter().zip(&self.volume).map(|(x, v)| x[lane] * v).sum();
        for x in &mut x[..self.len()] {
            x[lane] -= sum / total;
        }
    }
}
