//! Thomas' algorithm on eight systems at once, with the pivots computed beforehand.
//!
//! The systems are `(σ − c (L + λ)) x = b`: L the stencil along the swept axis, λ the eigenvalue of
//! the transformed axes, one per lane. Off-diagonals are the same for all lanes, so only the
//! inverse pivots are stored per lane.

use crate::lanes::{Kernel, Lanes, ZERO, dispatch};
use pulp::Simd;

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

    /// Solves eight systems in place: `x` holds `b` on entry and the solution of `… = scale · b` on
    /// return.
    pub fn solve(&self, c: f64, scale: f64, pivots: &[Lanes], x: &mut [Lanes]) {
        dispatch(Solve { sweep: self, c, scale, pivots, x });
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

/// [`Sweep::solve`] for any vector width; eight lanes are one, two or more vectors.
struct Solve<'a> {
    sweep: &'a Sweep,
    c: f64,
    scale: f64,
    pivots: &'a [Lanes],
    x: &'a mut [Lanes],
}

impl Kernel for Solve<'_> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
    fn run<S: Simd>(self, simd: S) {
        let n = self.sweep.len();
        let (lower, upper) = (&self.sweep.lower[..n], &self.sweep.upper[..n]);
        let per = 8 / S::F64_LANES;
        let pivots = &S::as_simd_f64s(self.pivots[..n].as_flattened()).0[..n * per];
        let x = &mut S::as_mut_simd_f64s(self.x[..n].as_flattened_mut()).0[..n * per];
        let scale = simd.splat_f64s(self.scale);
        let mut previous = [simd.splat_f64s(0.0); 8];
        for i in 0..n {
            let weight = simd.splat_f64s(self.c * lower[i]);
            for t in 0..per {
                let (at, pivot) = (i * per + t, pivots[i * per + t]);
                // Only one product and one sum wait for the value before.
                let own = simd.mul_f64s(simd.mul_f64s(scale, pivot), x[at]);
                let carried = simd.mul_f64s(simd.mul_f64s(weight, pivot), previous[t]);
                previous[t] = simd.add_f64s(own, carried);
                x[at] = previous[t];
            }
        }
        for i in (0..n - 1).rev() {
            let weight = simd.splat_f64s(self.c * upper[i]);
            for t in 0..per {
                let at = i * per + t;
                let share = simd.mul_f64s(weight, pivots[at]);
                previous[t] = simd.add_f64s(x[at], simd.mul_f64s(share, previous[t]));
                x[at] = previous[t];
            }
        }
    }
}
