//! Direct forcing (Izard et al. 2014, eq. 7): `f = α (U − V) / dt`, `u = V + dt f`.

use super::component::Rule;
use crate::lanes::Lanes;

/// Imposes the grains' motion on the predicted velocity.
pub(super) struct ImposeDirectly;

impl Rule<1> for ImposeDirectly {
    #[inline(always)]
    fn change(&self, ratio: &Lanes, target: &Lanes, [u]: [&mut Lanes; 1]) {
        for l in 0..8 {
            u[l] += (target[l] - ratio[l] * u[l]) / (1.0 + ratio[l]);
        }
    }
}
