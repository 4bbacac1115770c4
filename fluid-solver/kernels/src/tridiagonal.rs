//! Thomas' algorithm on eight systems at once, its pivots computed beforehand.
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
    /// The last true unknown: there may be idle ones around, see [`Sweep::padded`].
    pub last: usize,
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

    /// The same with `before` idle unknowns in front and some behind, to whole tiles of eight. An
    /// idle one has no neighbour and nothing to do with the others.
    pub fn padded(mut self, before: usize) -> Self {
        let len = (self.len() + before).next_multiple_of(8);
        let pad = |values: &mut Vec<f64>, idle: f64| {
            values.splice(0..0, std::iter::repeat_n(idle, before));
            values.resize(len, idle);
        };
        pad(&mut self.lower, 0.0);
        pad(&mut self.upper, 0.0);
        pad(&mut self.diagonal, -1.0);
        pad(&mut self.volume, 0.0);
        self.last += before;
        self
    }

    /// Inverse pivots for eight eigenvalues. A lane in `singular` gets a zero pivot at the last true unknown:
    /// its system is solved up to a constant, with the last value zero.
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
            if let (true, Some(lane)) = (i == self.last, singular) {
                pivot[lane] = 0.0;
            }
            previous = *pivot;
        }
    }
}
