//! Direct forcing (Izard et al. 2014, eq. 7): `f = α (U − V) / dt`, `u = V + dt f`.

use super::component::Component;

/// Imposes the grains' motion on the predicted velocity `u`. The sums must have been gathered.
pub fn impose<const D: usize>(component: &mut Component<D>, u: &mut [f64]) {
    component.change(false, |index, odds, target| {
        u[index] += (target - odds * u[index]) / (1.0 + odds);
    });
}
