//! Cosine II and III after Makhoul (1980), and the sines by reversal and alternating signs.

use super::ends::{Emit, EmitPairs, Read, ReadPairs};
use super::line::{Reader, Writer};
use super::plan::Plan;
use crate::vector::{Complex, Real};
use pulp::Simd;

/// Cosine II (even walls), or sine II (odd walls).
pub(super) struct Two<T>(pub(super) T);

/// Cosine III, the way back of [`Two`] (times n/2), and sine III.
pub(super) struct Three<T>(pub(super) T);

impl Plan {
    /// Place in the line of value `j` of the packed order, and whether it is one of the odd
    /// values: even values up, odd values down.
    #[inline(always)]
    fn makhoul(&self, j: usize) -> (usize, bool) {
        if j < self.n.div_ceil(2) { (2 * j, false) } else { (2 * (self.n - 1 - j) + 1, true) }
    }

    /// Where amplitude `k` of the cosine stands: sines are reversed.
    #[inline(always)]
    fn amplitude(&self, k: usize) -> usize {
        if self.odd { self.n - 1 - k } else { k }
    }
}

impl<S: Simd> Two<Reader<'_, S>> {
    /// Value `j` of the packed order, sign of the sine included.
    #[inline(always)]
    fn value(&self, j: usize, t: usize) -> Real<S> {
        let (from, flip) = self.0.plan.makhoul(j);
        let v = self.0.get(from, t);
        if flip && self.0.plan.odd { -v } else { v }
    }
}

impl<S: Simd> Read<S> for Two<Reader<'_, S>> {
    #[inline(always)]
    fn place(&self, j: usize, t: usize) -> Complex<S> {
        Complex::new(self.value(2 * j, t), self.value(2 * j + 1, t))
    }
}

impl<S: Simd, const ADD: bool> Two<Writer<'_, S, ADD>> {
    /// Amplitudes `k` and `n − k` from the Fourier amplitude `k`.
    #[inline(always)]
    fn turn(&mut self, k: usize, t: usize, z: Complex<S>) {
        let plan = self.0.plan;
        let z = z.rotate(plan.turn[k]);
        self.0.put(plan.amplitude(k), t, z.re);
        self.0.put(plan.amplitude(plan.n - k), t, -z.im);
    }
}

impl<S: Simd, const ADD: bool> EmitPairs<S> for Two<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn zero(&mut self, t: usize, z: Complex<S>) {
        let plan = self.0.plan;
        self.0.put(plan.amplitude(0), t, z.re + z.im);
        let quarter = plan.turn[plan.n / 2][0];
        self.0.put(plan.amplitude(plan.n / 2), t, (z.re - z.im) * quarter);
    }

    #[inline(always)]
    fn pair(&mut self, k: usize, t: usize, z: Complex<S>, mirror: Complex<S>) {
        let n = self.0.plan.n;
        let [low, high] = self.0.plan.unpack(k, z, mirror);
        self.turn(k, t, low);
        if 4 * k != n {
            self.turn(n / 2 - k, t, high);
        }
    }
}

impl<S: Simd> Three<Reader<'_, S>> {
    /// Fourier amplitude `k` that belongs to the cosine amplitudes `k` and `n − k`, halved.
    #[inline(always)]
    fn turned(&self, k: usize, t: usize) -> Complex<S> {
        let plan = self.0.plan;
        let z = self.0.complex(plan.amplitude(k), plan.amplitude(plan.n - k), t).conj();
        let [c, s] = plan.turn[k];
        z.rotate([0.5 * c, -0.5 * s])
    }
}

impl<S: Simd> ReadPairs<S> for Three<Reader<'_, S>> {
    #[inline(always)]
    fn zero(&self, t: usize) -> Complex<S> {
        let plan = self.0.plan;
        let z = self.0.complex(plan.amplitude(0), plan.amplitude(plan.n / 2), t);
        let (low, high) = (z.re * 0.5, z.im * (0.5 / plan.turn[plan.n / 2][0]));
        Complex::new(low + high, low - high).swap()
    }

    #[inline(always)]
    fn pair(&self, k: usize, t: usize) -> [Complex<S>; 2] {
        let plan = self.0.plan;
        plan.pack(k, self.turned(k, t), self.turned(plan.n / 2 - k, t))
    }
}

impl<S: Simd, const ADD: bool> Emit<S> for Three<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn place(&mut self, k: usize, t: usize, z: Complex<S>) {
        for (j, v) in [(2 * k, z.im), (2 * k + 1, z.re)] {
            let (to, flip) = self.0.plan.makhoul(j);
            self.0.put(to, t, if flip && self.0.plan.odd { -v } else { v });
        }
    }
}
