//! Nearest images in several lanes.

use crate::vector::lanes::Lanes;

/// Nearest images along periodic axes: d − L round(d/L), the rounding by adding and taking away
/// 1.5 × 2⁵², so that d and −d give the same.
#[derive(Clone, Copy)]
pub(crate) struct Images<L> {
    length: [L; 3],
    inverse: [L; 3],
    shift: L,
}

impl<L: Lanes> Images<L> {
    /// Lengths of the periods, 0 where there is none.
    #[inline(always)]
    pub(crate) fn new(token: L::Token, length: [f64; 3]) -> Self {
        let inverse = |l: f64| if l > 0.0 { 1.0 / l } else { 0.0 };
        let splat = |v: f64| L::splat(token, v);
        Self {
            length: [splat(length[0]), splat(length[1]), splat(length[2])],
            inverse: [splat(inverse(length[0])), splat(inverse(length[1])), splat(inverse(length[2]))],
            shift: splat(6_755_399_441_055_744.0),
        }
    }

    #[inline(always)]
    pub(crate) fn nearest(&self, axis: usize, d: L) -> L {
        d - self.length[axis] * ((d * self.inverse[axis] + self.shift) - self.shift)
    }
}
