//! Direct forcing (Izard et al. 2014, eq. 7): `f = α (U − V) / dt`, `u = V + dt f`.

use super::component::{Component, DONE, Rule};

/// Imposes the grains' motion on the predicted velocity `u`. The sums must have been gathered.
pub fn impose<const D: usize>(component: &mut Component<D>, u: &mut [f64]) {
    component.change(false, Pull { u });
}

/// The rule of [`impose`].
struct Pull<'a> {
    u: &'a mut [f64],
}

impl Rule for Pull<'_> {
    #[inline(always)]
    fn row(&mut self, start: usize, odds: &[f64], target: &[f64]) {
        for ((u, odds), target) in self.u[start..].iter_mut().zip(odds).zip(target) {
            let pull = (target - odds * *u) / (1.0 + odds.abs());
            *u += if *odds == DONE { 0.0 } else { pull };
        }
    }
}
