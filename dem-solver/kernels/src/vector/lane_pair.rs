//! Two sets of lanes side by side: while one waits for a root or a quotient, the other goes on.

use crate::vector::lanes::{Lanes, Mask};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

/// Two sets of lanes, or of bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LanePair<T>(pub(crate) T, pub(crate) T);

macro_rules! both {
    ($name:ident, $fn:ident) => {
        impl<T: $name<Output = T>> $name for LanePair<T> {
            type Output = Self;
            #[inline(always)]
            fn $fn(self, other: Self) -> Self {
                Self(self.0.$fn(other.0), self.1.$fn(other.1))
            }
        }
    };
}
both!(Add, add);
both!(Sub, sub);
both!(Mul, mul);
both!(Div, div);
both!(BitAnd, bitand);
both!(BitOr, bitor);

impl<T: Not<Output = T>> Not for LanePair<T> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0, !self.1)
    }
}

impl<M: Mask> Mask for LanePair<M> {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any() || self.1.any()
    }
}

macro_rules! fused {
    ($fn:ident) => {
        #[inline(always)]
        fn $fn(self, factor: Self, term: Self) -> Self {
            Self(self.0.$fn(factor.0, term.0), self.1.$fn(factor.1, term.1))
        }
    };
}

impl<L: Lanes> Lanes for LanePair<L> {
    type Token = L::Token;
    type Mask = LanePair<L::Mask>;

    #[inline(always)]
    fn splat(token: L::Token, value: f64) -> Self {
        let one = L::splat(token, value);
        Self(one, one)
    }

    fused!(times_plus);
    fused!(times_from);
    fused!(times_minus);

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        LanePair(self.0.lt(other.0), self.1.lt(other.1))
    }

    #[inline(always)]
    fn select(self, mask: Self::Mask, other: Self) -> Self {
        Self(self.0.select(mask.0, other.0), self.1.select(mask.1, other.1))
    }
}
