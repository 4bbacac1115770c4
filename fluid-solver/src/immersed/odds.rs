//! Odds of many cells at once: [`Kernel::odds`] without branches, so that it runs on whole vectors.
//!
//! Rows of cells are gathered as four sums over the axes, `r` being the arm from the grain's centre,
//! ```text
//! Σ r_a²,   Σ |r_a|,   Σ r_a² Δx_a²,   Σ r_a⁴ Δx_a²
//! ```
//! from which distance, thickness and the mask follow, 512 cells at a time.

use super::mask::{EDGE, Kernel, Mask, SOLID};
use super::volume_fraction::{SIGMA, SIGMA_SLOPE};
use crate::lanes::{self, dispatch};
use pulp::Simd;
use std::f64::consts::{LN_2, LOG2_E};

/// Cells that are treated together.
const BATCH: usize = 512;

/// Sums over the axes of one cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    /// Σ r_a², m².
    pub(super) square: f64,
    /// Σ |r_a|, m.
    pub(super) size: f64,
    /// Σ r_a² Δx_a², m⁴.
    pub(super) across: f64,
    /// Σ r_a⁴ Δx_a², m⁶.
    pub(super) fourth: f64,
}

/// Cells of one grain that wait for their odds.
pub(super) struct Batch {
    square: [f64; BATCH],
    size: [f64; BATCH],
    across: [f64; BATCH],
    fourth: [f64; BATCH],
    len: usize,
    law: Law,
}

/// What is the same for all cells of a grain.
#[derive(Clone, Copy)]
struct Law {
    /// 1/(2 f²): 1/w² = this Σr²·Σr² / (λ²σ² Σ r²Δx²) with λ from Σ|r|.
    thin: f64,
    /// q = (this / w²) e^{…}; zero for the seed's mask.
    rate: f64,
    /// Factor of Σ n⁴Δx²/w².
    shift: f64,
    /// Factor in place of `rate`/w² for the seed's mask, else zero.
    plain: f64,
    radius: f64,
    /// Squared radius within which a cell is solid, m².
    solid: f64,
}

impl Batch {
    /// For a grain of radius `radius` that is solid within `inner` (m).
    pub(super) fn new(kernel: &Kernel, radius: f64, inner: f64) -> Self {
        let (rate, shift, plain) = match kernel.mask {
            Mask::Seed => (0.0, 0.0, 1.0),
            Mask::ParameterFree => {
                let [rate, shift] = kernel.rate_and_shift();
                (rate, shift, 0.0)
            }
        };
        let thin = 0.5 / (kernel.width * kernel.width);
        let law = Law { thin, rate, shift, plain, radius, solid: inner * inner };
        let none = [0.0; BATCH];
        Self { square: none, size: none, across: none, fourth: none, len: 0, law }
    }

    /// Adds a row of cells at the arms `x` + `shift` along axis 0, of widths `widths`; `rest` are the
    /// sums over the other axes. Odds that are known go to `out`.
    pub(super) fn row(&mut self, x: &[f64], widths: &[f64], shift: f64, rest: &Sums, out: &mut Vec<f64>) {
        for (x, widths) in x.chunks(BATCH).zip(widths.chunks(BATCH)) {
            if self.len + x.len() > BATCH {
                self.flush(out);
            }
            let place = self.len..self.len + x.len();
            let (square, size) = (&mut self.square[place.clone()], &mut self.size[place.clone()]);
            let (across, fourth) = (&mut self.across[place.clone()], &mut self.fourth[place.clone()]);
            for k in 0..x.len() {
                let r = x[k] + shift;
                // at the centre itself any direction is as good as another
                let r = if rest.square + r * r == 0.0 { 1e-6 * widths[k] } else { r };
                let (r2, w2) = (r * r, widths[k] * widths[k]);
                square[k] = rest.square + r2;
                size[k] = rest.size + r.abs();
                across[k] = rest.across + r2 * w2;
                fourth[k] = rest.fourth + r2 * r2 * w2;
            }
            self.len = place.end;
        }
    }

    /// Appends the odds of all cells that wait to `out`.
    pub(super) fn flush(&mut self, out: &mut Vec<f64>) {
        let first = out.len();
        out.resize(first + self.len, 0.0);
        dispatch(Odds { batch: self, out: &mut out[first..] });
        self.len = 0;
    }
}

/// The arithmetic of [`Batch::flush`].
struct Odds<'a> {
    batch: &'a mut Batch,
    out: &'a mut [f64],
}

impl lanes::Kernel for Odds<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Batch { square, size, across, fourth, law, len } = self.batch;
        // whole vectors: what lies beyond the end is computed and not kept
        let n = len.next_multiple_of(16).min(BATCH);
        evaluate(*law, &mut square[..n], &size[..n], &across[..n], &fourth[..n]);
        self.out.copy_from_slice(&square[..*len]);
    }
}

/// Odds in place of `square`; only arguments tell that the result overlaps nothing.
#[inline(always)]
fn evaluate(law: Law, square: &mut [f64], size: &[f64], across: &[f64], fourth: &[f64]) {
    let n = square.len();
    let (size, across, fourth) = (&size[..n], &across[..n], &fourth[..n]);
    for k in 0..n {
        square[k] = law.odds(square[k], size[k], across[k], fourth[k]);
    }
}

impl Law {
    #[inline(always)]
    fn odds(&self, square: f64, size: f64, across: f64, fourth: f64) -> f64 {
        let distance = square.sqrt();
        let lambda2 = size * size / square;
        let sigma = SIGMA - SIGMA_SLOPE * lambda2;
        // 1/w², w² = 2 f² λ² σ² Σ n²Δx²
        let inverse = self.thin * square / (lambda2 * sigma * sigma * across);
        let edge = self.shift * fourth / (square * square) * inverse;
        let exponent = edge - 2.0 * (distance - self.radius) * inverse.sqrt();
        let odds = (self.rate * inverse + self.plain) * exp(exponent.clamp(-200.0, 200.0));
        let odds = if odds < 1.0 / EDGE { 0.0 } else { odds };
        let full = square < self.solid || odds > EDGE;
        if full { SOLID } else { odds }
    }
}

/// eˣ for |x| ≤ 200 to 1e-11 of itself: 2^k e^r with |r| ≤ ln 2/2, e^r by its series.
#[inline(always)]
fn exp(x: f64) -> f64 {
    /// Adding it leaves the nearest whole number in the last bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let shifted = x * LOG2_E + ROUND;
    let r = x - (shifted - ROUND) * LN_2;
    // written out: a loop in here would keep the loop over the cells from becoming vectors
    let high = 1.0 / 5_040.0 + r * (1.0 / 40_320.0 + r * (1.0 / 362_880.0 + r * (1.0 / 3_628_800.0)));
    let low = 1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * high)));
    let sum = 1.0 + r * (1.0 + r * (0.5 + r * low));
    let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0f64.to_bits()));
    sum * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_is_that_of_the_library() {
        for k in -4000..=4000 {
            let x = f64::from(k) * 0.05;
            assert!((exp(x) / x.exp() - 1.0).abs() < 3e-12, "{x}: {}", exp(x) / x.exp() - 1.0);
        }
    }

    /// Odds of rows of cells are those of the kernel, one by one, on a grid with unequal widths.
    #[test]
    fn odds_of_a_batch_are_those_of_the_kernel() {
        for mask in [Mask::ParameterFree, Mask::Seed] {
            let kernel = Kernel { mask, width: 0.5, viscosity: 1e-2, dt: 0.03 };
            let (radius, inner) = (0.5, 0.2);
            let spacing = |k: usize| 0.1 + 0.001 * (k % 7) as f64;
            let x: Vec<f64> = (0..40).map(|k| -0.7 + 0.035 * k as f64).collect();
            let widths: Vec<f64> = (0..40).map(spacing).collect();
            let mut batch = Batch::new(&kernel, radius, inner);
            let mut out = Vec::new();
            let mut expected = Vec::new();
            for (y, z) in [(0.0, 0.0), (0.1, -0.2), (0.3, 0.35), (-0.55, 0.1), (0.6, 0.6)] {
                let other = [0.11, 0.09];
                let arms = [y, z];
                let sum = |f: fn(f64, f64) -> f64| (0..2).map(|a| f(arms[a], other[a])).sum();
                let rest = Sums {
                    square: sum(|r, _| r * r),
                    size: sum(|r, _| r.abs()),
                    across: sum(|r, h| r * r * h * h),
                    fourth: sum(|r, h| r.powi(4) * h * h),
                };
                batch.row(&x, &widths, 0.01, &rest, &mut out);
                for (x, width) in x.iter().zip(&widths) {
                    let r = [x + 0.01, y, z];
                    let distance = r.iter().map(|r| r * r).sum::<f64>().sqrt();
                    let n = r.map(|r| r / distance);
                    let odds = kernel.odds(distance - radius, &n, &[*width, other[0], other[1]]);
                    expected.push(if distance < inner { SOLID } else { odds });
                }
            }
            batch.flush(&mut out);
            assert_eq!(out.len(), expected.len());
            for (k, (ours, exact)) in out.iter().zip(&expected).enumerate() {
                assert!((ours - exact).abs() <= 1e-10 * exact, "{mask:?} {k}: {ours} against {exact}");
            }
        }
    }
}
