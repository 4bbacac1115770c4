//! Sine I of n − 1 values by the odd–even split of Cooley, Lewis & Welch (1970). It is its own way
//! back.

use super::ends::{EmitPairs, Read};
use super::line::{Reader, Writer};
use crate::vector::{Complex, Real};
use pulp::Simd;

/// Sine I.
pub(super) struct One<T>(pub(super) T);

impl<S: Simd> One<Reader<'_, S>> {
    /// Value `j` of the real line whose Fourier transform holds the sine I.
    #[inline(always)]
    fn folded(&self, j: usize, t: usize) -> Real<S> {
        if j == 0 {
            return self.0.get(0, t) * 0.0;
        }
        let plan = self.0.plan;
        let (a, b) = (self.0.get(j - 1, t), self.0.get(plan.n - j - 1, t));
        (a + b) * plan.turn[j][0] + (a - b) * 0.5
    }
}

impl<S: Simd> Read<S> for One<Reader<'_, S>> {
    #[inline(always)]
    fn place(&self, j: usize, t: usize) -> Complex<S> {
        Complex::new(self.folded(2 * j, t), self.folded(2 * j + 1, t))
    }
}

impl<S: Simd, const ADD: bool> EmitPairs<S> for One<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn zero(&mut self, t: usize, z: Complex<S>) {
        self.0.sums[t] = ((z.re + z.im) * 0.5).get();
    }

    #[inline(always)]
    fn pair(&mut self, k: usize, t: usize, z: Complex<S>, mirror: Complex<S>) {
        let (n, per) = (self.0.plan.n, 8 / S::F64_LANES);
        let [low, high] = self.0.plan.unpack(k, z, mirror);
        self.0.put(2 * k - 1, t, -low.im);
        self.0.sums[k * per + t] = low.re.get();
        if 4 * k != n {
            self.0.put(n - 2 * k - 1, t, -high.im);
            self.0.sums[(n / 2 - k) * per + t] = high.re.get();
        }
    }
}

impl<S: Simd, const ADD: bool> One<Writer<'_, S, ADD>> {
    /// The odd amplitudes: the running sum of the real parts.
    #[inline(always)]
    pub(super) fn sum(mut self, simd: S) {
        let (places, per) = (self.0.plan.n / 2, 8 / S::F64_LANES);
        for t in 0..per {
            let mut sum = Real::new(simd, self.0.sums[t]);
            self.0.put(0, t, sum);
            for k in 1..places {
                sum = sum + Real::new(simd, self.0.sums[k * per + t]);
                self.0.put(2 * k, t, sum);
            }
        }
    }
}
