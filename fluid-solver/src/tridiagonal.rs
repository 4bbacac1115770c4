//! Thomas' algorithm on eight systems at once, with the pivots computed beforehand.
//!
//! The systems are `(σ − c (L + λ)) x = b`: L the stencil along the swept axis, λ the eigenvalue of
//! the transformed axes, one per lane. Off-diagonals are the same for all lanes, so only the
//! inverse pivots are stored per lane.

use crate::lanes::{Lanes, ZERO};
use pulp::{Arch, Simd, WithSimd};

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

    /// Solves `K` sets of eight systems in place: `x` holds `b` on entry and the solution of
    /// `… = scale · b` on return. Two sets at once hide half of the wait for the value before.
    pub fn solve<const K: usize>(&self, c: f64, scale: f64, pivots: [&[Lanes]; K], x: [&mut [Lanes]; K]) {
        Arch::new().dispatch(Solve { sweep: self, c, scale, pivots, x });
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
struct Solve<'a, const K: usize> {
    sweep: &'a Sweep,
    c: f64,
    scale: f64,
    pivots: [&'a [Lanes]; K],
    x: [&'a mut [Lanes]; K],
}

impl<const K: usize> WithSimd for Solve<'_, K> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.sweep.len();
        let (lower, upper) = (&self.sweep.lower[..n], &self.sweep.upper[..n]);
        let per = 8 / S::F64_LANES;
        let mut pivots: [&[S::f64s]; K] = [&[]; K];
        let mut x: [&mut [S::f64s]; K] = std::array::from_fn(|_| Default::default());
        for (k, data) in self.x.into_iter().enumerate() {
            pivots[k] = &S::as_simd_f64s(self.pivots[k][..n].as_flattened()).0[..n * per];
            x[k] = &mut S::as_mut_simd_f64s(data[..n].as_flattened_mut()).0[..n * per];
        }
        let scale = simd.splat_f64s(self.scale);
        let mut previous = [[simd.splat_f64s(0.0); 8]; K];
        for i in 0..n {
            let weight = simd.splat_f64s(self.c * lower[i]);
            for k in 0..K {
                for t in 0..per {
                    let at = i * per + t;
                    let pivot = pivots[k][at];
                    // Only one product and one sum wait for the value before.
                    let own = simd.mul_f64s(simd.mul_f64s(scale, pivot), x[k][at]);
                    let carried = simd.mul_f64s(simd.mul_f64s(weight, pivot), previous[k][t]);
                    previous[k][t] = simd.add_f64s(own, carried);
                    x[k][at] = previous[k][t];
                }
            }
        }
        for i in (0..n - 1).rev() {
            let weight = simd.splat_f64s(self.c * upper[i]);
            for k in 0..K {
                for t in 0..per {
                    let at = i * per + t;
                    let share = simd.mul_f64s(weight, pivots[k][at]);
                    previous[k][t] = simd.add_f64s(x[k][at], simd.mul_f64s(share, previous[k][t]));
                    x[k][at] = previous[k][t];
                }
            }
        }
    }
}
