//! A real line as a complex one of half the length: what all kinds share.

use super::plan::Plan;
use crate::vector::{Complex, Real};
use pulp::Simd;

/// Reads the values, or amplitudes, of eight lines.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a, S: Simd> {
    pub(super) plan: &'a Plan,
    pub(super) simd: S,
    pub(super) rows: &'a [S::f64s],
    /// Vectors from row to row.
    pub(super) stride: usize,
}

impl<S: Simd> Reader<'_, S> {
    /// Vector `t` of value `j`.
    #[inline(always)]
    pub(super) fn get(&self, j: usize, t: usize) -> Real<S> {
        Real::new(self.simd, self.rows[j * self.stride + t])
    }

    /// Values `a` and `b` as one complex number.
    #[inline(always)]
    pub(super) fn complex(&self, a: usize, b: usize, t: usize) -> Complex<S> {
        Complex::new(self.get(a, t), self.get(b, t))
    }
}

/// Writes the amplitudes, or values, of eight lines, or adds them.
pub(super) struct Writer<'a, S: Simd, const ADD: bool> {
    pub(super) plan: &'a Plan,
    pub(super) rows: &'a mut [S::f64s],
    /// Vectors from row to row.
    pub(super) stride: usize,
    /// One row per place, for sums along the line.
    pub(super) sums: &'a mut [S::f64s],
}

impl<S: Simd, const ADD: bool> Writer<'_, S, ADD> {
    /// Writes vector `t` of value `j`.
    #[inline(always)]
    pub(super) fn put(&mut self, j: usize, t: usize, value: Real<S>) {
        let to = &mut self.rows[j * self.stride + t];
        *to = if ADD { value.plus(*to) } else { value.get() };
    }
}

impl Plan {
    /// Amplitudes k and n/2 − k (0 < k < n/2) of the real line whose packed transform has `z` at k
    /// and `mirror` at n/2 − k: even ± odd part, the second conjugated.
    #[inline(always)]
    pub(super) fn unpack<S: Simd>(&self, k: usize, z: Complex<S>, mirror: Complex<S>) -> [Complex<S>; 2] {
        let mirror = mirror.conj();
        let (even, odd) = ((z + mirror) * 0.5, (z - mirror).minus_i() * 0.5);
        let odd = odd.rotate(self.split[k]);
        [even + odd, (even - odd).conj()]
    }

    /// The way back (times 2): packed input k and n/2 − k from the amplitudes there, real and
    /// imaginary parts exchanged.
    #[inline(always)]
    pub(super) fn pack<S: Simd>(&self, k: usize, here: Complex<S>, mirror: Complex<S>) -> [Complex<S>; 2] {
        let mirror = mirror.conj();
        let [c, s] = self.split[k];
        let (even, odd) = (here + mirror, (here - mirror).rotate([c, -s]).minus_i());
        // even + i odd, and the conjugate of even − i odd.
        [(even - odd).swap(), (even + odd).conj().swap()]
    }
}
