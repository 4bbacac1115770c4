//! What grains do to the velocity in their cells, and what is summed over them.
//!
//! The force carried from step to step (docs/equations-immersed.md, section 3):
//! ```text
//! λ' = β (λ + (U − u*) / dt)
//! u  = u* + dt (λ' − λ)        λ is a true fixed point, whatever dt
//! ```
//! With several grains `β(λ + (U − u*)/dt)` is `Σ b_i (λ + (U_i − u*)/dt)`. Where no grain is any
//! more, λ' = 0 and the fluid gets its force back.

use super::component::{Integrand, Point, Rule};
use crate::vector::Real;
use pulp::Simd;

/// Imposes the grains' motion on the velocity and updates the force λ; with a third field it leaves the mask
/// b of the grains there.
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

impl Rule<3> for Impose {
    #[inline(always)]
    fn change<S: Simd>(&self, ratio: Real<S>, target: Real<S>, fields: [Real<S>; 3]) -> [Real<S>; 3] {
        let [u, lambda, mask] = fields;
        let [u, lambda] = self.change(ratio, target, [u, lambda]);
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

/// Imposes the grains' motion on the predicted velocity (Izard et al. 2014, eq. 7): `f = α (U − V) / dt`,
/// `u = V + dt f`.
pub(super) struct ImposeDirectly;

impl Rule<1> for ImposeDirectly {
    #[inline(always)]
    fn change<S: Simd>(&self, ratio: Real<S>, target: Real<S>, [u]: [Real<S>; 1]) -> [Real<S>; 1] {
        [u + (target - ratio * u) / (ratio + 1.0)]
    }
}

/// b (λ + (U − u)/dt): the force where it is carried from step to step; by 1/dt, 1/s.
pub(super) struct CarriedForce(pub(super) f64);

impl Integrand<2> for CarriedForce {
    #[inline(always)]
    fn value<S: Simd>(&self, point: Point<S, 2>) -> Real<S> {
        let [u, lambda] = point.fields;
        point.mask() * (lambda + (point.solid - u) * self.0)
    }
}

/// b (U − u)/dt: eq. 7 (Izard et al. 2014); by 1/dt, 1/s.
pub(super) struct DirectForce(pub(super) f64);

impl Integrand<1> for DirectForce {
    #[inline(always)]
    fn value<S: Simd>(&self, point: Point<S, 1>) -> Real<S> {
        point.mask() * self.0 * (point.solid - point.fields[0])
    }
}

/// b u: the momentum of the fluid in the place of a grain.
pub(super) struct Content;

impl Integrand<1> for Content {
    #[inline(always)]
    fn value<S: Simd>(&self, point: Point<S, 1>) -> Real<S> {
        point.mask() * point.fields[0]
    }
}
