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

/// One operator of two vectors, or of a vector and a number.
macro_rules! operator {
    ($type:ident, $name:ident, $fn:ident, $other:ty, |$a:ident, $o:ident| $value:expr) => {
        impl<S: Simd> $name<$other> for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $fn(self, $o: $other) -> Self {
                let $a = self;
                $value
            }
        }
    };
}
operator!(Real, Add, add, Self, |a, o| a.with(a.simd.add_f64s(a.v, o.v)));
operator!(Real, Sub, sub, Self, |a, o| a.with(a.simd.sub_f64s(a.v, o.v)));
operator!(Real, Mul, mul, Self, |a, o| a.with(a.simd.mul_f64s(a.v, o.v)));
operator!(Real, Div, div, Self, |a, o| a.with(a.simd.div_f64s(a.v, o.v)));
operator!(Real, Add, add, f64, |a, o| a + a.splat(o));
operator!(Real, Mul, mul, f64, |a, o| a * a.splat(o));
operator!(Complex, Add, add, Self, |a, o| Self::new(a.re + o.re, a.im + o.im));
operator!(Complex, Sub, sub, Self, |a, o| Self::new(a.re - o.re, a.im - o.im));
operator!(Complex, Mul, mul, f64, |a, o| Self::new(a.re * o, a.im * o));

impl<S: Simd> Neg for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.neg_f64s(self.v))
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
