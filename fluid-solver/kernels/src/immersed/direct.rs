//! Direct forcing (Izard et al. 2014, eq. 7): `f = α (U − V) / dt`, `u = V + dt f`.

use super::component::Rule;
use crate::vector::Real;
use pulp::Simd;

/// Imposes the grains' motion on the predicted velocity.
pub(super) struct ImposeDirectly;

impl Rule<1> for ImposeDirectly {
    #[inline(always)]
    fn change<S: Simd>(&self, ratio: Real<S>, target: Real<S>, [u]: [Real<S>; 1]) -> [Real<S>; 1] {
        [u + (target - ratio * u) / (ratio + 1.0)]
    }
}
