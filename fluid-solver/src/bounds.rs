//! Bounds on the step that this solver knows of itself; the coupler puts the step in and enforces them.

use crate::build;
use crate::config::{Choices, ForceTransport, ProjectionsKey, SchemeKey};
use crate::plan::Plan;
use crate::scheme::Viscous;
use crate::speed;
use bedload_scene::{CheckedScene, Medium};
use protocol::facts::{Forcing, Measure, Side, SolverBound};

/// Largest ν dt/Δx² at which a sphere with direct forcing settled no faster than 1.2 times Stokes' speed.
/// docs/maps/direct-forcing.csv
const DIRECT: f64 = 2.0;
/// Largest U dt/Δx at which a stream past a fixed disc was stable, U its mean velocity: Adams–Bashforth,
/// three-stage Runge–Kutta with a projection after each stage, and with one a step.
/// docs/maps/courant-plane.csv
const STREAM_AB2: f64 = 0.5;
/// docs/maps/courant-plane.csv
const STREAM_RK3: f64 = 1.2;
/// docs/maps/courant-plane.csv
const STREAM_ONCE: f64 = 0.5;
/// With one projection a step Runge–Kutta bore no more than Adams–Bashforth there, so an adaptive step
/// may keep no larger number than that one's.
const ONCE: f64 = 0.75;
/// Where the stability region of third-order Runge–Kutta ends on the real axis.
const REAL_AXIS_RK3: f64 = 2.5127;

/// Every bound that applies to the scene.
pub(crate) fn of(scene: &CheckedScene, medium: &Medium, choices: &Choices, plan: &Plan) -> Vec<SolverBound> {
    let nu = medium.kinematic_viscosity();
    let mut bounds = vec![cfl(scene, choices, plan)];
    if choices.method == Forcing::Direct && !scene.grains.is_empty() {
        bounds.extend(direct_forcing(nu / plan.spacing.powi(2)));
    }
    let longest = build::longest_local_step(scene, medium);
    if choices.force_transport == ForceTransport::Advected
        && build::tells_viscosity(choices)
        && longest.is_finite()
    {
        bounds.push(local_solve(longest));
    }
    if plan.viscous == Viscous::Explicit && !scene.scene.domain.cells.is_empty() {
        bounds.extend(explicit_viscosity(scene, nu));
    }
    bounds
}

/// The CFL number that an adaptive step keeps, or that the speeds written in the scene make.
fn cfl(scene: &CheckedScene, choices: &Choices, plan: &Plan) -> SolverBound {
    let once = choices.time.projections == ProjectionsKey::Once;
    let adaptive = plan.fixed.is_none();
    let limit = match (adaptive, choices.time.scheme) {
        (true, scheme) if once => scheme.cfl_limit().min(ONCE),
        (true, scheme) => scheme.cfl_limit(),
        (false, SchemeKey::Ab2) => STREAM_AB2,
        (false, SchemeKey::Rk3) if once => STREAM_ONCE,
        (false, SchemeKey::Rk3) => STREAM_RK3,
    };
    let value = match adaptive {
        true => (choices.time.cfl, Measure::One),
        false => (speed::named(scene).max(plan.start) / plan.spacing, Measure::Window),
    };
    SolverBound::new("cfl", "u dt/Δx", value, Side::AtMost, limit).because(
        "the time scheme of the convection is unstable beyond it; with a fixed dt only the speeds that the scene names are known yet",
        "docs/maps/courant-plane.csv",
        "lower the fluid's cfl or dt, or let dt be adaptive",
    )
}

/// `longest`: the longest step that the free grains bear, s.
fn local_solve(longest: f64) -> SolverBound {
    let value = (1.0 / longest, Measure::Window);
    SolverBound::new("local-viscosity", "dt over the longest that the lightest grain bears", value, Side::AtMost, 1.0)
        .because(
            "with the advected force and its local solve the torque is that of the spin at the start of the window: lighter grains oscillate and grow",
            "docs/stability.md, With the force that goes with the grains",
            "use fluid.immersed.force_transport = \"auto\", fluid.immersed.viscous_sweeps = 0, or a smaller dt",
        )
}

/// `number`: ν/Δx², 1/s.
fn direct_forcing(number: f64) -> [SolverBound; 2] {
    let bound =
        |name, limit| SolverBound::new(name, "ν dt/Δx²", (number, Measure::Window), Side::AtMost, limit);
    let remedy = "use the carried forcing, or a smaller dt";
    [
        bound("direct-forcing", DIRECT).because(
            "direct forcing (eq. 7) fails: viscosity undoes it within the step",
            "docs/maps/direct-forcing.csv",
            remedy,
        ),
        bound("direct-forcing-accuracy", 1.0).warning().because(
            "direct forcing (eq. 7) is wrong by tens of per cent in the settling speed",
            "docs/numerics.md, Forcing and viscosity (Ar = 9: +40 %, Ar = 0.9: +90 %)",
            remedy,
        ),
    ]
}

/// Explicit viscosity: the eigenvalue −4 ν Σ 1/Δx² must lie in the time scheme's region of stability.
fn explicit_viscosity(scene: &CheckedScene, nu: f64) -> [SolverBound; 2] {
    let domain = &scene.scene.domain;
    let sum: f64 = (0..domain.dimensions()).map(|axis| domain.spacing(axis).powi(-2)).sum();
    let bound = |name, limit| {
        SolverBound::new(name, "ν dt Σ 1/Δx²", (nu * sum, Measure::Window), Side::AtMost, limit)
    };
    [
        bound("explicit-viscosity", REAL_AXIS_RK3 / 4.0).because(
            "explicit viscosity is unstable, whatever explicit scheme is used",
            "stability region of third-order Runge–Kutta (Wray 1986)",
            "make the fluid's viscosity implicit, or lower dt",
        ),
        bound("explicit-viscosity-ab2", 0.25).warning().because(
            "second-order Adams–Bashforth is unstable beyond it (Runge–Kutta is not)",
            "stability region of AB2 on the real axis: −1",
            "make the fluid's viscosity implicit, lower dt, or use Runge–Kutta",
        ),
    ]
}
