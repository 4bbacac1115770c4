//! Time schemes as coefficients, and the choices of a run; the step itself is in [`crate::step`].

/// How convection and viscosity are integrated in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Three-stage low-storage Runge–Kutta for convection, Crank–Nicolson per stage for viscosity
    /// (Spalart, Moser & Rogers 1991; Le & Moin 1991).
    RungeKutta3,
    /// Adams–Bashforth for convection, Crank–Nicolson for viscosity, one projection: the cheap one.
    AdamsBashforth2,
}

/// How viscosity is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viscous {
    /// Crank–Nicolson: stable for any ν dt/Δx².
    Implicit,
    /// With convection: for small ν dt/Δx² (Σ over the axes below about 0.25 for Adams–Bashforth,
    /// 0.6 for Runge–Kutta).
    Explicit,
}

/// Choices of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options<const D: usize> {
    /// Kinematic viscosity, m²/s.
    pub viscosity: f64,
    /// Time scheme.
    pub scheme: Scheme,
    /// Implicit or explicit viscosity.
    pub viscous: Viscous,
    /// Whether there is convection (off: Stokes flow).
    pub convection: bool,
    /// Uniform body force per unit mass, mean pressure gradient −∇P/ρ included, m/s².
    pub body_force: [f64; D],
}

/// Coefficients of one stage: `u' = u + dt (γ N + ζ N_old) + α ν dt ∇²(u' + u) + 2 α dt (f − ∇p)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Weight of the convection of this stage.
    pub gamma: f64,
    /// Weight of the convection of the stage (or step) before.
    pub zeta: f64,
    /// Half of the stage's share of the time step.
    pub alpha: f64,
}

/// Runge–Kutta stages: γ, ζ of Spalart, Moser & Rogers (1991), α = (γ + ζ)/2.
const RUNGE_KUTTA: [Stage; 3] = [
    Stage { gamma: 8.0 / 15.0, zeta: 0.0, alpha: 4.0 / 15.0 },
    Stage { gamma: 5.0 / 12.0, zeta: -17.0 / 60.0, alpha: 1.0 / 15.0 },
    Stage { gamma: 3.0 / 4.0, zeta: -5.0 / 12.0, alpha: 1.0 / 6.0 },
];

impl Scheme {
    /// Number of stages.
    pub fn stages(self) -> usize {
        match self {
            Self::RungeKutta3 => 3,
            Self::AdamsBashforth2 => 1,
        }
    }

    /// Stage `k` of a step of length `dt` after one of length `previous` (zero: there was none).
    pub fn stage(self, k: usize, dt: f64, previous: f64) -> Stage {
        match self {
            Self::RungeKutta3 => RUNGE_KUTTA[k],
            Self::AdamsBashforth2 => {
                // Linear extrapolation to the middle of a step of another length.
                let half = if previous > 0.0 { 0.5 * dt / previous } else { 0.0 };
                Stage { gamma: 1.0 + half, zeta: -half, alpha: 0.5 }
            }
        }
    }
}
