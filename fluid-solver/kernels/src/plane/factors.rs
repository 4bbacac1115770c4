//! What multiplies the terms of the momentum equation on two axes.

use crate::scheme::{Options, Viscous};
use crate::stages::PlannedStage;

/// What multiplies each term in one stage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factors {
    /// dt γ, s.
    pub(crate) now: f64,
    /// dt ζ, s.
    pub(crate) old: f64,
    /// 2 α dt, s.
    pub(crate) length: f64,
    /// Viscosity that goes to N, m²/s.
    pub(crate) explicit: f64,
    /// Viscosity that goes to the increment, times 2 α dt, m².
    pub(crate) implicit: f64,
    /// Body force times 2 α dt, m/s.
    pub(crate) body: f64,
}

impl Factors {
    /// For component `d` in one stage.
    pub(crate) fn new<const D: usize>(options: &Options<D>, stage: &PlannedStage, d: usize) -> Self {
        let (length, dt) = (stage.length(), stage.dt);
        let [explicit, implicit] = match options.viscous {
            Viscous::Explicit => [options.viscosity, 0.0],
            Viscous::Implicit => [0.0, length * options.viscosity],
        };
        let body = length * options.body_force[d];
        let [now, old] = [stage.coefficients.gamma, stage.coefficients.zeta].map(|weight| dt * weight);
        Self { now, old, length, explicit, implicit, body }
    }
}
