//! Complex Fourier transform of eight lines at once: Stockham's self-sorting passes, radix 4, 2, 3, 5.

use super::vector::{Complex, Real};
use pulp::Simd;
use std::f64::consts::PI;

/// One pass: `groups` butterflies of `radix`, each over `stride` neighbours.
struct Pass {
    radix: usize,
    groups: usize,
    stride: usize,
    /// e^{−2πi p j / (radix · groups)}, `[p][j − 1]`.
    twiddles: Vec<[f64; 2]>,
}

/// Forward transform, Σ x_j e^{−2πi jk/m}. The inverse is the same with real and imaginary swapped.
pub(super) struct Fft {
    passes: Vec<Pass>,
}

/// Real and imaginary parts, `m` places of eight lanes each.
pub(super) type Parts<'a, S> = [&'a mut [<S as Simd>::f64s]; 2];

impl Fft {
    /// Plans a transform of `m` places, or `None` if `m` has a prime factor above 5.
    pub(super) fn new(m: usize) -> Option<Self> {
        let (mut rest, mut stride, mut passes) = (m, 1, Vec::new());
        while rest > 1 {
            let radix = [4, 2, 3, 5].into_iter().find(|r| rest.is_multiple_of(*r))?;
            let groups = rest / radix;
            let angle = |p: usize, j: usize| -2.0 * PI * ((p * j) % rest) as f64 / rest as f64;
            let twiddles = (0..groups)
                .flat_map(|p| (1..radix).map(move |j| [angle(p, j).cos(), angle(p, j).sin()]))
                .collect();
            passes.push(Pass { radix, groups, stride, twiddles });
            (rest, stride) = (groups, stride * radix);
        }
        Some(Self { passes })
    }

    /// Whether the input has to be in the second buffer for the result to be in the first.
    pub(super) fn starts_in_second(&self) -> bool {
        !self.passes.len().is_multiple_of(2)
    }

    /// Transforms; the result is in `first`.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&self, simd: S, first: Parts<'_, S>, second: Parts<'_, S>) {
        let (mut from, mut to) = (first, second);
        if self.starts_in_second() {
            std::mem::swap(&mut from, &mut to);
        }
        for pass in &self.passes {
            match pass.radix {
                2 => pass.run::<S, Two, 2>(simd, &from, &mut to),
                3 => pass.run::<S, Three, 3>(simd, &from, &mut to),
                4 => pass.run::<S, Four, 4>(simd, &from, &mut to),
                _ => pass.run::<S, Five, 5>(simd, &from, &mut to),
            }
            std::mem::swap(&mut from, &mut to);
        }
    }
}

impl Pass {
    /// One pass. Everything called from here must be inlined to use the machine's vectors, which
    /// rules out closures.
    #[inline(always)]
    fn run<S: Simd, B: Butterfly<R>, const R: usize>(
        &self,
        simd: S,
        from: &Parts<'_, S>,
        to: &mut Parts<'_, S>,
    ) {
        let len = self.stride * (8 / S::F64_LANES);
        let apart = self.groups * len;
        let [to_re, to_im] = to;
        let (to_re, to_im) = (&mut to_re[..R * apart], &mut to_im[..R * apart]);
        let blocks = to_re.chunks_exact_mut(R * len).zip(to_im.chunks_exact_mut(R * len));
        for (p, (to_re, to_im)) in blocks.enumerate() {
            let mut re: [&[S::f64s]; R] = [&[]; R];
            let mut im: [&[S::f64s]; R] = [&[]; R];
            for k in 0..R {
                re[k] = &from[0][p * len + k * apart..][..len];
                im[k] = &from[1][p * len + k * apart..][..len];
            }
            let (to_re, to_im) = (split::<_, R>(to_re, len), split::<_, R>(to_im, len));
            let twiddles = &self.twiddles[p * (R - 1)..(p + 1) * (R - 1)];
            for t in 0..len {
                let mut x = [Complex::new(Real::new(simd, re[0][t]), Real::new(simd, im[0][t])); R];
                for k in 1..R {
                    x[k] = Complex::new(Real::new(simd, re[k][t]), Real::new(simd, im[k][t]));
                }
                let y = B::apply(x);
                for j in 0..R {
                    let y = if j == 0 || p == 0 { y[j] } else { y[j].rotate(twiddles[j - 1]) };
                    to_re[j][t] = y.re.get();
                    to_im[j][t] = y.im.get();
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

/// Fourier transform of `R` places in registers.
trait Butterfly<const R: usize> {
    /// Σ_k x_k e^{−2πi jk/R}.
    fn apply<S: Simd>(x: [Complex<S>; R]) -> [Complex<S>; R];
}

struct Two;

impl Butterfly<2> for Two {
    #[inline(always)]
    fn apply<S: Simd>([a, b]: [Complex<S>; 2]) -> [Complex<S>; 2] {
        [a + b, a - b]
    }
}

struct Three;

impl Butterfly<3> for Three {
    #[inline(always)]
    fn apply<S: Simd>([a, b, c]: [Complex<S>; 3]) -> [Complex<S>; 3] {
        let (sum, difference) = (b + c, (b - c).minus_i() * (0.75_f64).sqrt());
        let middle = a - sum * 0.5;
        [a + sum, middle + difference, middle - difference]
    }
}

struct Four;

impl Butterfly<4> for Four {
    #[inline(always)]
    fn apply<S: Simd>([a, b, c, d]: [Complex<S>; 4]) -> [Complex<S>; 4] {
        let (ac, bd) = (a + c, b + d);
        let (a_c, b_d) = (a - c, (b - d).minus_i());
        [ac + bd, a_c + b_d, ac - bd, a_c - b_d]
    }
}

struct Five;

impl Butterfly<5> for Five {
    #[inline(always)]
    fn apply<S: Simd>([a, b, c, d, e]: [Complex<S>; 5]) -> [Complex<S>; 5] {
        // cos and sin of 2π/5 and 4π/5.
        const C1: f64 = 0.309_016_994_374_947_45;
        const C2: f64 = -0.809_016_994_374_947_5;
        const S1: f64 = 0.951_056_516_295_153_5;
        const S2: f64 = 0.587_785_252_292_473_1;
        let (be, cd) = (b + e, c + d);
        let (b_e, c_d) = ((b - e).minus_i(), (c - d).minus_i());
        let (near, far) = (a + be * C1 + cd * C2, a + be * C2 + cd * C1);
        let (turn, twist) = (b_e * S1 + c_d * S2, b_e * S2 - c_d * S1);
        [a + be + cd, near + turn, far + twist, far - twist, near - turn]
    }
}
