//! The force carried from step to step (docs/equations-immersed.md, section 3: yu-shao-fixed-point;
//! yu-shao-2007 for comparison).
//!
//! ```text
//! λ' = β (λ + (U − u*) / dt)
//! u  = u* + dt (λ' − λ)        yu-shao-fixed-point: λ is a true fixed point, whatever dt
//! u  = u* + β (U − u*)         yu-shao-2007 (Yu & Shao 2007): holds (2 − β) λ at steady state
//! ```
//! With several grains `β(λ + (U − u*)/dt)` is `Σ b_i (λ + (U_i − u*)/dt)`. Where no grain is any
//! more, λ' = 0 and the fluid gets its force back.

use super::component::Rule;
use crate::lanes::Lanes;

/// Which velocity the force leaves behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Imposed {
    /// yu-shao-fixed-point.
    ByForce,
    /// yu-shao-2007.
    ByVelocity,
}

/// Imposes the grains' motion on the velocity and updates the force λ.
pub(super) struct Impose {
    /// yu-shao-fixed-point.
    pub(super) by_force: bool,
    pub(super) dt: f64,
}

impl Rule<2> for Impose {
    #[inline(always)]
    fn change(&self, ratio: &Lanes, target: &Lanes, [u, lambda]: [&mut Lanes; 2]) {
        let rate = 1.0 / self.dt;
        for l in 0..8 {
            let (now, before) = (u[l], lambda[l]);
            let inverse = 1.0 / (1.0 + ratio[l]);
            let correction = (target[l] - ratio[l] * now) * inverse;
            let after = ratio[l] * inverse * before + rate * correction;
            u[l] = if self.by_force { now + self.dt * (after - before) } else { now + correction };
            lambda[l] = after;
        }
    }
}

/// [`Impose`], which leaves the mask b of the grains too.
pub(super) struct ImposeAndStoreMask(pub(super) Impose);

impl Rule<3> for ImposeAndStoreMask {
    #[inline(always)]
    fn change(&self, ratio: &Lanes, target: &Lanes, [u, lambda, mask]: [&mut Lanes; 3]) {
        self.0.change(ratio, target, [u, lambda]);
        StoreMask.change(ratio, target, [mask]);
    }
}

/// Leaves the mask b of the grains.
pub(super) struct StoreMask;

impl Rule<1> for StoreMask {
    #[inline(always)]
    fn change(&self, ratio: &Lanes, _: &Lanes, [mask]: [&mut Lanes; 1]) {
        for l in 0..8 {
            mask[l] = ratio[l] / (1.0 + ratio[l]);
        }
    }
}

/// Changes nothing, so that only the cells are marked.
pub(super) struct MarkForced;

impl Rule<0> for MarkForced {
    #[inline(always)]
    fn change(&self, _: &Lanes, _: &Lanes, []: [&mut Lanes; 0]) {}
}
