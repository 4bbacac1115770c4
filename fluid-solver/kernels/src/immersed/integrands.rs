//! What is summed over a grain: its force on the fluid, and what it holds.

use super::component::{Integrand, Point};
use crate::vector::Real;
use pulp::Simd;

/// b (λ + (U − u)/dt): the force where it is carried from step to step.
pub(super) struct CarriedForce {
    /// 1/dt, 1/s.
    pub(super) rate: f64,
}

impl Integrand<2> for CarriedForce {
    #[inline(always)]
    fn value<S: Simd>(&self, point: Point<S, 2>) -> Real<S> {
        let [u, lambda] = point.fields;
        point.mask() * (lambda + (point.solid - u) * self.rate)
    }
}

/// b (U − u)/dt: eq. 7 (Izard et al. 2014).
pub(super) struct DirectForce {
    /// 1/dt, 1/s.
    pub(super) rate: f64,
}

impl Integrand<1> for DirectForce {
    #[inline(always)]
    fn value<S: Simd>(&self, point: Point<S, 1>) -> Real<S> {
        point.mask() * self.rate * (point.solid - point.fields[0])
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
