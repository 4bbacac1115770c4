//! The force carried from step to step (docs/equations-immersed.md, section 3: yu-shao-fixed-point; yu-shao-2007 for comparison).
//!
//! ```text
//! λ' = β (λ + (U − u*) / dt)
//! u  = u* + dt (λ' − λ)        yu-shao-fixed-point: λ is a true fixed point, whatever dt
//! u  = u* + β (U − u*)         yu-shao-2007 (Yu & Shao 2007): holds (2 − β) λ at steady state
//! ```
//! With several grains `β(λ + (U − u*)/dt)` is `Σ b_i (λ + (U_i − u*)/dt)`. Where no grain is any
//! more, λ' = 0 and the fluid gets its share back.

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
pub(super) struct Hold {
    /// yu-shao-fixed-point.
    pub(super) by_force: bool,
    pub(super) dt: f64,
}

impl Rule<2> for Hold {
    #[inline(always)]
    fn change(&self, odds: &Lanes, target: &Lanes, [u, lambda]: [&mut Lanes; 2]) {
        let rate = 1.0 / self.dt;
        for l in 0..8 {
            let (now, before) = (u[l], lambda[l]);
            let inverse = 1.0 / (1.0 + odds[l]);
            let pull = (target[l] - odds[l] * now) * inverse;
            let after = odds[l] * inverse * before + rate * pull;
            u[l] = if self.by_force { now + self.dt * (after - before) } else { now + pull };
            lambda[l] = after;
        }
    }
}

/// [`Hold`], which leaves the share b of the grains too.
pub(super) struct HoldAndShare(pub(super) Hold);

impl Rule<3> for HoldAndShare {
    #[inline(always)]
    fn change(&self, odds: &Lanes, target: &Lanes, [u, lambda, share]: [&mut Lanes; 3]) {
        self.0.change(odds, target, [u, lambda]);
        Share.change(odds, target, [share]);
    }
}

/// Leaves the share b of the grains.
pub(super) struct Share;

impl Rule<1> for Share {
    #[inline(always)]
    fn change(&self, odds: &Lanes, _: &Lanes, [share]: [&mut Lanes; 1]) {
        for l in 0..8 {
            share[l] = odds[l] / (1.0 + odds[l]);
        }
    }
}

/// Changes nothing, so that only the cells are marked.
pub(super) struct Mark;

impl Rule<0> for Mark {
    #[inline(always)]
    fn change(&self, _: &Lanes, _: &Lanes, []: [&mut Lanes; 0]) {}
}
