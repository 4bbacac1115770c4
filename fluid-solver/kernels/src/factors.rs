//! What a stage asks of the momentum equation.

use crate::scheme::{Options, Viscous};
use crate::stages::PlannedStage;

/// What multiplies each term in one stage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factors {
    /// Viscosity within N, m²/s.
    pub(crate) explicit: f64,
    /// Viscosity of the increment, times 2 α dt, m².
    pub(crate) implicit: f64,
    /// Whether there is convection.
    pub(crate) convection: bool,
    /// dt γ, s.
    pub(crate) now: f64,
    /// dt ζ, s; zero: N_old need not be read.
    pub(crate) old: f64,
    /// Whether N is kept for a later stage.
    pub(crate) keep: bool,
    /// 2 α dt, s.
    pub(crate) length: f64,
    /// Body force times 2 α dt, m/s.
    pub(crate) body: [f64; 3],
}

impl Factors {
    /// Of one stage.
    pub(crate) fn new<const D: usize>(options: &Options<D>, stage: &PlannedStage) -> Self {
        let (nu, length) = (options.viscosity, stage.length());
        let [explicit, implicit] = match options.viscous {
            Viscous::Explicit => [nu, 0.0],
            Viscous::Implicit => [0.0, length * nu],
        };
        let mut body = [0.0; 3];
        body.iter_mut().zip(options.body_force).for_each(|(body, force)| *body = length * force);
        Self {
            explicit,
            implicit,
            convection: options.convection,
            now: stage.dt * stage.coefficients.gamma,
            old: stage.dt * stage.coefficients.zeta,
            keep: stage.keeps_n,
            length,
            body,
        }
    }
}
