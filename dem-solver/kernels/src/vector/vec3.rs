//! Vectors of three components in several lanes.

use crate::vector::lanes::{Lanes, Lanes8};

#[derive(Clone, Copy)]
pub(crate) struct Vec3Lanes<L>(pub(crate) L, pub(crate) L, pub(crate) L);

impl<L: Lanes> Vec3Lanes<L> {
    #[inline(always)]
    pub(crate) fn dot(self, o: Self) -> L {
        self.2.times_plus(o.2, self.1.times_plus(o.1, self.0 * o.0))
    }

    #[inline(always)]
    pub(crate) fn cross(self, o: Self) -> Self {
        Self(
            self.1.times_minus(o.2, self.2 * o.1),
            self.2.times_minus(o.0, self.0 * o.2),
            self.0.times_minus(o.1, self.1 * o.0),
        )
    }

    #[inline(always)]
    pub(crate) fn scale(self, s: L) -> Self {
        Self(self.0 * s, self.1 * s, self.2 * s)
    }

    /// self × s + o.
    #[inline(always)]
    pub(crate) fn scale_plus(self, s: L, o: Self) -> Self {
        Self(self.0.times_plus(s, o.0), self.1.times_plus(s, o.1), self.2.times_plus(s, o.2))
    }

    /// o − self × s.
    #[inline(always)]
    pub(crate) fn scale_from(self, s: L, o: Self) -> Self {
        Self(self.0.times_from(s, o.0), self.1.times_from(s, o.1), self.2.times_from(s, o.2))
    }

    #[inline(always)]
    pub(crate) fn plus(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1, self.2 + o.2)
    }

    #[inline(always)]
    pub(crate) fn minus(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1, self.2 - o.2)
    }

    #[inline(always)]
    pub(crate) fn select(self, mask: L::Mask, o: Self) -> Self {
        Self(self.0.select(mask, o.0), self.1.select(mask, o.1), self.2.select(mask, o.2))
    }

    #[inline(always)]
    pub(crate) fn splat(token: L::Token, v: [f64; 3]) -> Self {
        Self(L::splat(token, v[0]), L::splat(token, v[1]), L::splat(token, v[2]))
    }
}

impl<L: Lanes8> Vec3Lanes<L> {
    #[inline(always)]
    pub(crate) fn load(token: L::Token, from: &[[f64; 8]; 3]) -> Self {
        Self(L::load(token, &from[0]), L::load(token, &from[1]), L::load(token, &from[2]))
    }

    #[inline(always)]
    pub(crate) fn store(self, to: &mut [[f64; 8]; 3]) {
        self.0.store(&mut to[0]);
        self.1.store(&mut to[1]);
        self.2.store(&mut to[2]);
    }
}
