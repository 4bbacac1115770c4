//! Real and complex arithmetic on SIMD vectors of whatever width the machine has (`pulp`), no fused
//! multiply-add: every instruction set gives the same bits.

use crate::lanes::Lanes;
use pulp::Simd;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A vector of real numbers.
#[derive(Clone, Copy)]
pub(crate) struct Real<S: Simd> {
    simd: S,
    v: S::f64s,
}

impl<S: Simd> Real<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, v: S::f64s) -> Self {
        Self { simd, v }
    }

    /// Vector `t` of eight values.
    #[inline(always)]
    pub(crate) fn of(simd: S, values: &Lanes, t: usize) -> Self {
        Self::new(simd, S::as_simd_f64s(values).0[t])
    }

    /// Becomes vector `t` of eight values.
    #[inline(always)]
    pub(crate) fn put(self, values: &mut Lanes, t: usize) {
        S::as_mut_simd_f64s(values).0[t] = self.v;
    }

    /// Zero, as wide.
    #[inline(always)]
    pub(crate) fn zero(self) -> Self {
        Self::new(self.simd, self.simd.splat_f64s(0.0))
    }

    /// The same number in every lane, as wide.
    #[inline(always)]
    pub(crate) fn splat(self, value: f64) -> Self {
        Self::new(self.simd, self.simd.splat_f64s(value))
    }

    /// Another vector of the same machine.
    #[inline(always)]
    pub(crate) fn with(self, v: S::f64s) -> Self {
        Self::new(self.simd, v)
    }

    /// Plus a machine's vector.
    #[inline(always)]
    pub(crate) fn plus(self, v: S::f64s) -> S::f64s {
        self.simd.add_f64s(v, self.v)
    }

    /// The machine's vector.
    #[inline(always)]
    pub(crate) fn get(self) -> S::f64s {
        self.v
    }
}

impl<S: Simd> Add for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.simd, self.simd.add_f64s(self.v, o.v))
    }
}

impl<S: Simd> Sub for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.simd, self.simd.sub_f64s(self.v, o.v))
    }
}

impl<S: Simd> Neg for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, self.simd.neg_f64s(self.v))
    }
}

impl<S: Simd> Mul<f64> for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        let o = self.simd.splat_f64s(o);
        Self::new(self.simd, self.simd.mul_f64s(self.v, o))
    }
}

impl<S: Simd> Add<f64> for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: f64) -> Self {
        self + self.splat(o)
    }
}

impl<S: Simd> Div for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self::new(self.simd, self.simd.div_f64s(self.v, o.v))
    }
}

impl<S: Simd> Mul for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self::new(self.simd, self.simd.mul_f64s(self.v, o.v))
    }
}

/// A vector of complex numbers.
#[derive(Clone, Copy)]
pub(crate) struct Complex<S: Simd> {
    pub(crate) re: Real<S>,
    pub(crate) im: Real<S>,
}

impl<S: Simd> Complex<S> {
    #[inline(always)]
    pub(crate) fn new(re: Real<S>, im: Real<S>) -> Self {
        Self { re, im }
    }

    /// From real and imaginary part.
    #[inline(always)]
    pub(crate) fn of(simd: S, [re, im]: [S::f64s; 2]) -> Self {
        Self::new(Real::new(simd, re), Real::new(simd, im))
    }

    /// Real and imaginary part.
    #[inline(always)]
    pub(crate) fn parts(self) -> [S::f64s; 2] {
        [self.re.v, self.im.v]
    }

    /// Real and imaginary part exchanged: before and after a forward transform it makes the
    /// backward one.
    #[inline(always)]
    pub(crate) fn swap(self) -> Self {
        Self::new(self.im, self.re)
    }

    /// Complex conjugate.
    #[inline(always)]
    pub(crate) fn conj(self) -> Self {
        Self::new(self.re, -self.im)
    }

    /// Times −i.
    #[inline(always)]
    pub(crate) fn minus_i(self) -> Self {
        Self::new(self.im, -self.re)
    }

    /// Times a complex constant.
    #[inline(always)]
    pub(crate) fn rotate(self, [c, s]: [f64; 2]) -> Self {
        Self::new(self.re * c - self.im * s, self.re * s + self.im * c)
    }
}

impl<S: Simd> Add for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.re + o.re, self.im + o.im)
    }
}

impl<S: Simd> Sub for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.re - o.re, self.im - o.im)
    }
}

impl<S: Simd> Mul<f64> for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        Self::new(self.re * o, self.im * o)
    }
}
