//! What a stage asks of the momentum equation.

/// What multiplies each term in one stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    /// Viscosity within N, m²/s.
    pub(super) explicit: f64,
    /// Viscosity of the increment, times 2 α dt, m².
    pub(super) implicit: f64,
    /// Whether there is convection.
    pub(super) convection: bool,
    /// dt γ, s.
    pub(super) now: f64,
    /// dt ζ, s; zero: N_old is not read.
    pub(super) old: f64,
    /// Whether N is kept for a later stage.
    pub(super) keep: bool,
    /// 2 α dt, s.
    pub(super) length: f64,
    /// Body force, m/s².
    pub(super) body: [f64; 3],
}
