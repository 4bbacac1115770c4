//! The force carried from step to step (docs/equations-immersed.md, section 3).
//!
//! ```text
//! λ' = β (λ + (U − u*) / dt)
//! u  = u* + dt (λ' − λ)        λ is a true fixed point, whatever dt
//! ```
//! With several grains `β(λ + (U − u*)/dt)` is `Σ b_i (λ + (U_i − u*)/dt)`. Where no grain is any
//! more, λ' = 0 and the fluid gets its force back.

use super::component::Rule;
use crate::vector::Real;
use pulp::Simd;

/// Imposes the grains' motion on the velocity and updates the force λ.
pub(super) struct Impose {
    pub(super) dt: f64,
}

impl Rule<2> for Impose {
    #[inline(always)]
    fn change<S: Simd>(&self, ratio: Real<S>, target: Real<S>, [now, before]: [Real<S>; 2]) -> [Real<S>; 2] {
        let rate = 1.0 / self.dt;
        let inverse = ratio.splat(1.0) / (ratio + 1.0);
        let correction = (target - ratio * now) * inverse;
        let after = ratio * inverse * before + correction * rate;
        [now + (after - before) * self.dt, after]
    }
}

/// [`Impose`], which leaves the mask b of the grains too.
pub(super) struct ImposeAndStoreMask(pub(super) Impose);

impl Rule<3> for ImposeAndStoreMask {
    #[inline(always)]
    fn change<S: Simd>(
        &self,
        ratio: Real<S>,
        target: Real<S>,
        [u, lambda, mask]: [Real<S>; 3],
    ) -> [Real<S>; 3] {
        let [u, lambda] = self.0.change(ratio, target, [u, lambda]);
        let [mask] = StoreMask.change(ratio, target, [mask]);
        [u, lambda, mask]
    }
}

/// Leaves the mask b of the grains.
pub(super) struct StoreMask;

impl Rule<1> for StoreMask {
    #[inline(always)]
    fn change<S: Simd>(&self, ratio: Real<S>, _: Real<S>, _: [Real<S>; 1]) -> [Real<S>; 1] {
        // As in `Impose`, so that both in one take one division.
        [ratio * (ratio.splat(1.0) / (ratio + 1.0))]
    }
}

/// Changes nothing, so that only the cells are marked.
pub(super) struct MarkForced;

impl Rule<0> for MarkForced {
    #[inline(always)]
    fn change<S: Simd>(&self, _: Real<S>, _: Real<S>, []: [Real<S>; 0]) -> [Real<S>; 0] {
        []
    }
}
