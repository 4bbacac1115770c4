//! First and last pass of a Fourier transform, joined to the reading and the writing.
//!
//! The real-to-real transforms need either each place by itself, or places `k` and `m − k`
//! together. In the first pass butterfly `p` takes the places `p + k g` (k < R, g = m/R), so their
//! mirrors `m − p − k g = (g − p) + (R − 1 − k) g` belong to butterfly `g − p`; likewise in the last.

use super::butterfly::Butterfly;
use super::fft::{Pair, Pass};
use crate::vector::Complex;
use pulp::Simd;

/// Input place by place.
pub(super) trait Read<S: Simd> {
    /// Vector `t` of place `j`.
    fn place(&self, j: usize, t: usize) -> Complex<S>;
}

/// Input of places and their mirrors.
pub(super) trait ReadPairs<S: Simd> {
    /// Vector `t` of place 0.
    fn zero(&self, t: usize) -> Complex<S>;
    /// Vector `t` of places `k` and `m − k`, 0 < k < m.
    fn pair(&self, k: usize, t: usize) -> [Complex<S>; 2];
}

/// Output place by place.
pub(super) trait Emit<S: Simd> {
    /// Takes vector `t` of place `k`.
    fn place(&mut self, k: usize, t: usize, z: Complex<S>);
}

/// Output of places and their mirrors.
pub(super) trait EmitPairs<S: Simd> {
    /// Takes vector `t` of place 0.
    fn zero(&mut self, t: usize, z: Complex<S>);
    /// Takes vector `t` of places `k` and `m − k`, 0 < k < m.
    fn pair(&mut self, k: usize, t: usize, z: Complex<S>, mirror: Complex<S>);
}

/// Calls `$self.$method::<S, Butterfly, radix>(…)` with the butterfly of the pass.
macro_rules! by_radix {
    ($pass:expr, $method:ident, $simd:expr, $($argument:expr),*) => {
        match $pass.radix {
            2 => $pass.$method::<_, crate::transform::butterfly::Two, _, 2>($simd, $($argument),*),
            3 => $pass.$method::<_, crate::transform::butterfly::Three, _, 3>($simd, $($argument),*),
            4 => $pass.$method::<_, crate::transform::butterfly::Four, _, 4>($simd, $($argument),*),
            _ => $pass.$method::<_, crate::transform::butterfly::Five, _, 5>($simd, $($argument),*),
        }
    };
}
pub(super) use by_radix;

#[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
impl Pass {
    /// Butterfly `p` of the first pass on `z`, its results to `to`.
    #[inline(always)]
    fn finish_first<S: Simd, B: Butterfly<R>, const R: usize>(
        &self,
        p: usize,
        t: usize,
        z: [Complex<S>; R],
        to: &mut [Pair<S>],
    ) {
        let per = 8 / S::F64_LANES;
        let y = B::apply(z);
        let twiddles = &self.twiddles[p * (R - 1)..][..R - 1];
        let to = &mut to[R * p * per..][..R * per];
        to[t] = y[0].parts();
        for j in 1..R {
            to[j * per + t] = y[j].rotate(twiddles[j - 1]).parts();
        }
    }

    /// First pass, place by place.
    #[inline(always)]
    pub(super) fn first<S: Simd, B: Butterfly<R>, I: Read<S>, const R: usize>(
        &self,
        _: S,
        input: &I,
        to: &mut [Pair<S>],
    ) {
        for p in 0..self.groups {
            for t in 0..8 / S::F64_LANES {
                let mut z = [input.place(p, t); R];
                for k in 1..R {
                    z[k] = input.place(p + k * self.groups, t);
                }
                self.finish_first::<S, B, R>(p, t, z, to);
            }
        }
    }

    /// First pass, places and mirrors.
    #[inline(always)]
    pub(super) fn first_pairs<S: Simd, B: Butterfly<R>, I: ReadPairs<S>, const R: usize>(
        &self,
        _: S,
        input: &I,
        to: &mut [Pair<S>],
    ) {
        let g = self.groups;
        for t in 0..8 / S::F64_LANES {
            let mut z = [input.zero(t); R];
            for k in 1..R / 2 + 1 {
                [z[k], z[R - k]] = input.pair(k * g, t);
            }
            self.finish_first::<S, B, R>(0, t, z, to);
            if g.is_multiple_of(2) {
                for k in 0..R.div_ceil(2) {
                    [z[k], z[R - 1 - k]] = input.pair(g / 2 + k * g, t);
                }
                self.finish_first::<S, B, R>(g / 2, t, z, to);
            }
        }
        for p in 1..g.div_ceil(2) {
            for t in 0..8 / S::F64_LANES {
                let [here, mirror] = input.pair(p, t);
                let (mut z, mut w) = ([here; R], [mirror; R]);
                for k in 1..R {
                    [z[k], w[R - 1 - k]] = input.pair(p + k * g, t);
                }
                self.finish_first::<S, B, R>(p, t, z, to);
                self.finish_first::<S, B, R>(g - p, t, w, to);
            }
        }
    }

    /// Butterfly `q` of the last pass.
    #[inline(always)]
    fn begin_last<S: Simd, B: Butterfly<R>, const R: usize>(
        &self,
        simd: S,
        q: usize,
        t: usize,
        from: &[Pair<S>],
    ) -> [Complex<S>; R] {
        let per = 8 / S::F64_LANES;
        let mut z = [Complex::of(simd, from[q * per + t]); R];
        for k in 1..R {
            z[k] = Complex::of(simd, from[(k * self.stride + q) * per + t]);
        }
        B::apply(z)
    }

    /// Last pass, place by place.
    #[inline(always)]
    pub(super) fn last<S: Simd, B: Butterfly<R>, O: Emit<S>, const R: usize>(
        &self,
        simd: S,
        from: &[Pair<S>],
        output: &mut O,
    ) {
        for q in 0..self.stride {
            for t in 0..8 / S::F64_LANES {
                let y = self.begin_last::<S, B, R>(simd, q, t, from);
                for j in 0..R {
                    output.place(q + j * self.stride, t, y[j]);
                }
            }
        }
    }

    /// Last pass, places and mirrors.
    #[inline(always)]
    pub(super) fn last_pairs<S: Simd, B: Butterfly<R>, O: EmitPairs<S>, const R: usize>(
        &self,
        simd: S,
        from: &[Pair<S>],
        output: &mut O,
    ) {
        let s = self.stride;
        for t in 0..8 / S::F64_LANES {
            let y = self.begin_last::<S, B, R>(simd, 0, t, from);
            output.zero(t, y[0]);
            for j in 1..R / 2 + 1 {
                output.pair(j * s, t, y[j], y[R - j]);
            }
            if s.is_multiple_of(2) {
                let y = self.begin_last::<S, B, R>(simd, s / 2, t, from);
                for j in 0..R.div_ceil(2) {
                    output.pair(s / 2 + j * s, t, y[j], y[R - 1 - j]);
                }
            }
        }
        for q in 1..s.div_ceil(2) {
            for t in 0..8 / S::F64_LANES {
                let y = self.begin_last::<S, B, R>(simd, q, t, from);
                let mirror = self.begin_last::<S, B, R>(simd, s - q, t, from);
                for j in 0..R {
                    output.pair(q + j * s, t, y[j], mirror[R - 1 - j]);
                }
            }
        }
    }
}
