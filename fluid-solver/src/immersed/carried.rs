//! The force carried from step to step (numerics §1, F5b; F5 for comparison).
//!
//! ```text
//! λ' = β (λ + (U − u*) / dt)
//! u  = u* + dt (λ' − λ)        F5b: λ is a true fixed point, whatever dt
//! u  = u* + β (U − u*)         F5 (Yu & Shao 2007): holds (2 − β) λ at steady state
//! ```
//! With several grains `β(λ + (U − u*)/dt)` is `Σ b_i (λ + (U_i − u*)/dt)`. Where no grain is any
//! more, λ' = 0 and the fluid gets its share back.

use super::component::{Component, DONE, Rule};

/// Which velocity the force leaves behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Imposed {
    /// F5b.
    ByForce,
    /// F5.
    ByVelocity,
}

/// Imposes the grains' motion on `u` and updates `lambda`. The sums must have been gathered.
pub fn impose<const D: usize>(
    component: &mut Component<D>,
    imposed: Imposed,
    dt: f64,
    u: &mut [f64],
    lambda: &mut [f64],
) {
    component.change(true, Hold { by_force: imposed == Imposed::ByForce, dt, rate: 1.0 / dt, u, lambda });
    component.swap();
}

/// The rule of [`impose`].
struct Hold<'a> {
    by_force: bool,
    dt: f64,
    rate: f64,
    u: &'a mut [f64],
    lambda: &'a mut [f64],
}

impl Rule for Hold<'_> {
    #[inline(always)]
    fn row(&mut self, start: usize, odds: &[f64], target: &[f64]) {
        let cells = start..start + odds.len();
        let factors = [self.dt, self.rate];
        hold(self.by_force, factors, odds, target, &mut self.u[cells.clone()], &mut self.lambda[cells]);
    }
}

/// [`Hold`] on one row; only arguments tell that the results overlap nothing.
#[inline(always)]
fn hold(
    by_force: bool,
    [dt, rate]: [f64; 2],
    odds: &[f64],
    target: &[f64],
    u: &mut [f64],
    lambda: &mut [f64],
) {
    let n = odds.len();
    let (target, u, lambda) = (&target[..n], &mut u[..n], &mut lambda[..n]);
    for k in 0..n {
        let (now, before) = (u[k], lambda[k]);
        let inverse = 1.0 / (1.0 + odds[k].abs());
        let pull = (target[k] - odds[k] * now) * inverse;
        let after = odds[k] * inverse * before + rate * pull;
        let velocity = if by_force { now + dt * (after - before) } else { now + pull };
        let done = odds[k] == DONE;
        u[k] = if done { now } else { velocity };
        lambda[k] = if done { before } else { after };
    }
}
