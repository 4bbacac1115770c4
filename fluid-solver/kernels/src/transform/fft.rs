//! Complex Fourier transform of eight lines at once: Stockham's self-sorting passes.
//!
//! The first and the last pass are in [`super::ends`]: they read and write what the transform is
//! made for, so that no pass over the data is spent on sorting and packing alone.

use super::butterfly::{Butterfly, Eight, Five, Four, Three, Two};
use crate::vector::Complex;
use pulp::Simd;
use std::f64::consts::PI;

/// Real and imaginary part of one vector of one place.
pub(super) type Pair<S> = [<S as Simd>::f64s; 2];

/// One pass: `groups` butterflies of `radix`, each over `stride` neighbours.
pub(super) struct Pass {
    pub(super) radix: usize,
    pub(super) groups: usize,
    pub(super) stride: usize,
    /// e^{−2πi p j / (radix · groups)}, `[p][j − 1]`.
    pub(super) twiddles: Vec<[f64; 2]>,
}

/// Forward transform, Σ x_j e^{−2πi jk/m}. The inverse is the same with real and imaginary swapped.
pub(super) struct Fft {
    pub(super) first: Pass,
    middle: Vec<Pass>,
    pub(super) last: Pass,
}

impl Fft {
    /// Plans a transform of `m` places, or `None` if `m` has no two factors or a prime one above 5.
    pub(super) fn new(m: usize) -> Option<Self> {
        let radices = factors(m)?;
        let (mut rest, mut stride, mut passes) = (m, 1, Vec::new());
        for radix in radices {
            let groups = rest / radix;
            let angle = |p: usize, j: usize| -2.0 * PI * ((p * j) % rest) as f64 / rest as f64;
            let twiddles = (0..groups)
                .flat_map(|p| (1..radix).map(move |j| [angle(p, j).cos(), angle(p, j).sin()]))
                .collect();
            passes.push(Pass { radix, groups, stride, twiddles });
            (rest, stride) = (groups, stride * radix);
        }
        let last = passes.pop()?;
        let mut passes = passes.into_iter();
        Some(Self { first: passes.next()?, middle: passes.collect(), last })
    }

    /// The passes between the first, which wrote to `a`, and the last, which finds its input in the
    /// buffer that [`Fft::result`] names.
    #[inline(always)]
    pub(super) fn middle<S: Simd>(&self, simd: S, a: &mut [Pair<S>], b: &mut [Pair<S>]) {
        let (mut from, mut to) = (a, b);
        for pass in &self.middle {
            match pass.radix {
                2 => pass.run::<S, Two, 2>(simd, from, to),
                3 => pass.run::<S, Three, 3>(simd, from, to),
                4 => pass.run::<S, Four, 4>(simd, from, to),
                5 => pass.run::<S, Five, 5>(simd, from, to),
                _ => pass.run::<S, Eight, 8>(simd, from, to),
            }
            std::mem::swap(&mut from, &mut to);
        }
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.first.radix * self.first.groups
    }

    /// Number of the buffer where the last pass finds its input.
    pub(super) fn result(&self) -> usize {
        self.middle.len() % 2
    }
}

/// Radices of the passes: the fewest, with 2, 3, 4 or 5 at the ends.
fn factors(m: usize) -> Option<Vec<usize>> {
    const ENDS: [usize; 4] = [4, 5, 3, 2];
    let mut best: Option<Vec<usize>> = None;
    for (a, b) in ENDS.into_iter().flat_map(|a| ENDS.map(|b| (a, b))) {
        if !m.is_multiple_of(a * b) {
            continue;
        }
        let (mut rest, mut radices) = (m / (a * b), vec![a]);
        for radix in [8, 5, 4, 3, 2] {
            // 16 = 4 · 4 is better than 8 · 2.
            while rest.is_multiple_of(radix) && !(radix == 8 && rest.trailing_zeros() == 4) {
                radices.push(radix);
                rest /= radix;
            }
        }
        radices.push(b);
        if rest == 1 && best.as_ref().is_none_or(|best| radices.len() < best.len()) {
            best = Some(radices);
        }
    }
    best
}

impl Pass {
    /// A pass in the middle. Everything called from here must be inlined to use the machine's
    /// vectors, which rules out closures.
    #[inline(always)]
    fn run<S: Simd, B: Butterfly<R>, const R: usize>(&self, simd: S, from: &[Pair<S>], to: &mut [Pair<S>]) {
        let len = self.stride * (8 / S::F64_LANES);
        let apart = self.groups * len;
        for (p, to) in to[..R * apart].chunks_exact_mut(R * len).enumerate() {
            let mut x: [&[Pair<S>]; R] = [&[]; R];
            for k in 0..R {
                x[k] = &from[p * len + k * apart..][..len];
            }
            let to = split::<_, R>(to, len);
            let twiddles = &self.twiddles[p * (R - 1)..(p + 1) * (R - 1)];
            for t in 0..len {
                let mut z = [Complex::of(simd, x[0][t]); R];
                for k in 1..R {
                    z[k] = Complex::of(simd, x[k][t]);
                }
                let y = B::apply(z);
                for j in 0..R {
                    let y = if j == 0 || p == 0 { y[j] } else { y[j].rotate(twiddles[j - 1]) };
                    to[j][t] = y.parts();
                }
            }
        }
    }
}

/// Cuts `R` slices of `len` entries, so that one check of the length serves a whole loop.
#[inline(always)]
fn split<T, const R: usize>(mut rest: &mut [T], len: usize) -> [&mut [T]; R] {
    let mut parts: [&mut [T]; R] = std::array::from_fn(|_| Default::default());
    for part in &mut parts {
        let (head, tail) = rest.split_at_mut(len);
        (*part, rest) = (head, tail);
    }
    parts
}
