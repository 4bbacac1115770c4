//! Cosine IV by one rotation before and one after, and sine IV by reversed values and alternating
//! signs. Both are their own way back.

use super::ends::{Emit, Read};
use super::line::{Reader, Writer};
use crate::vector::Complex;
use pulp::Simd;

/// Cosine IV (even below, odd above), or sine IV.
pub(super) struct Four<T>(pub(super) T);

impl<S: Simd> Read<S> for Four<Reader<'_, S>> {
    #[inline(always)]
    fn place(&self, j: usize, t: usize) -> Complex<S> {
        let plan = self.0.plan;
        let (a, b) = (2 * j, plan.n - 1 - 2 * j);
        let (a, b) = if plan.odd { (b, a) } else { (a, b) };
        self.0.complex(a, b, t).rotate(plan.turn[j])
    }
}

impl<S: Simd, const ADD: bool> Emit<S> for Four<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn place(&mut self, k: usize, t: usize, z: Complex<S>) {
        let plan = self.0.plan;
        let z = z.rotate(plan.turn[k]);
        self.0.put(2 * k, t, z.re);
        // n is even, so n − 1 − 2k is odd: the sign of sine IV turns once more.
        self.0.put(plan.n - 1 - 2 * k, t, if plan.odd { z.im } else { -z.im });
    }
}
