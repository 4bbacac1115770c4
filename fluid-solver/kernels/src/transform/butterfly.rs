//! Fourier transforms of a few places in registers: the heart of each pass.

use crate::vector::Complex;
use pulp::Simd;

/// Fourier transform of `R` places in registers.
pub(super) trait Butterfly<const R: usize> {
    /// Σ_k x_k e^{−2πi jk/R}.
    fn apply<S: Simd>(x: [Complex<S>; R]) -> [Complex<S>; R];
}

pub(super) struct Two;

impl Butterfly<2> for Two {
    #[inline(always)]
    fn apply<S: Simd>([a, b]: [Complex<S>; 2]) -> [Complex<S>; 2] {
        [a + b, a - b]
    }
}

pub(super) struct Three;

impl Butterfly<3> for Three {
    #[inline(always)]
    fn apply<S: Simd>([a, b, c]: [Complex<S>; 3]) -> [Complex<S>; 3] {
        let (sum, difference) = (b + c, (b - c).minus_i() * (0.75_f64).sqrt());
        let middle = a - sum * 0.5;
        [a + sum, middle + difference, middle - difference]
    }
}

pub(super) struct Four;

impl Butterfly<4> for Four {
    #[inline(always)]
    fn apply<S: Simd>([a, b, c, d]: [Complex<S>; 4]) -> [Complex<S>; 4] {
        let (ac, bd) = (a + c, b + d);
        let (a_c, b_d) = (a - c, (b - d).minus_i());
        [ac + bd, a_c + b_d, ac - bd, a_c - b_d]
    }
}

pub(super) struct Five;

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

pub(super) struct Eight;

impl Butterfly<8> for Eight {
    #[inline(always)]
    fn apply<S: Simd>([a, b, c, d, e, f, g, h]: [Complex<S>; 8]) -> [Complex<S>; 8] {
        const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
        let [a, c, e, g] = Four::apply([a, c, e, g]);
        let [b, d, f, h] = Four::apply([b, d, f, h]);
        // e^{−iπ/4} d, −i f, e^{−3iπ/4} h.
        let d = Complex::new(d.re + d.im, d.im - d.re) * HALF;
        let h = Complex::new(h.im - h.re, -(h.re + h.im)) * HALF;
        let f = f.minus_i();
        [a + b, c + d, e + f, g + h, a - b, c - d, e - f, g - h]
    }
}
