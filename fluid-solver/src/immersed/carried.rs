//! The force carried from step to step (numerics §1, F5b; F5 for comparison).
//!
//! ```text
//! λ' = β (λ + (U − u*) / dt)
//! u  = u* + dt (λ' − λ)        F5b: λ is a true fixed point, whatever dt
//! u  = u* + β (U − u*)         F5 (Yu & Shao 2007): holds (2 − β) λ at steady state
//! ```
//! With several grains `β(λ + (U − u*)/dt)` is `Σ b_i (λ + (U_i − u*)/dt)`. Where no grain is any
//! more, λ' = 0 and the fluid gets its share back.

use super::component::Component;

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
    let rate = 1.0 / dt;
    component.change(true, |index, odds, target| {
        let (now, before) = (u[index], lambda[index]);
        let inverse = 1.0 / (1.0 + odds);
        let pull = (target - odds * now) * inverse;
        let after = odds * inverse * before + rate * pull;
        lambda[index] = after;
        u[index] = match imposed {
            Imposed::ByForce => now + dt * (after - before),
            Imposed::ByVelocity => now + pull,
        };
    });
    component.swap();
}
