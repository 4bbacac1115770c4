//! Bounds on the step that this solver knows of itself; the coupler puts the step in and enforces them.

use crate::config::{Choices, SchemeKey};
use crate::methods;
use crate::plan::Plan;
use crate::scheme::Viscous;
use crate::speed;
use bedload_scene::{CheckedScene, Geometry, Grain, Medium};
use protocol::facts::{Measure, Side, SolverBound};
use protocol::scheme::Iterations;

/// Largest U dt/Δx at which a stream past a fixed disc was stable, U its mean velocity: Adams–Bashforth, and
/// three-stage Runge–Kutta. docs/maps/courant-plane.csv
const STREAM_AB2: f64 = 0.4;
/// docs/maps/courant-plane.csv
const STREAM_RK3: f64 = 1.2;
/// Past a sphere, which a stream goes round less fast; 0.6 was stable. docs/maps/courant-space.csv
const STREAM_AB2_SPHERE: f64 = 0.5;
/// Where the stability region of third-order Runge–Kutta ends on the real axis.
const REAL_AXIS_RK3: f64 = 2.5127;

/// Every bound that applies to the scene.
pub(crate) fn of(
    scene: &CheckedScene,
    medium: &Medium,
    choices: &Choices,
    iterations: &Iterations,
    plan: &Plan,
) -> Vec<SolverBound> {
    let mut bounds = methods::bounds(scene, medium, choices.method, iterations, plan.spacing);
    // A fixed step without convection bears any speed of what does not move.
    let stays = |grain: &Grain| grain.stays(scene.scene.domain.geometry);
    if plan.fixed.is_none() || choices.time.convection || !scene.grains.iter().all(stays) {
        bounds.push(cfl(scene, choices, plan));
    }
    if plan.viscous == Viscous::Explicit && !scene.scene.domain.cells.is_empty() {
        bounds.push(explicit_viscosity(scene, medium.kinematic_viscosity(), choices.scheme));
    }
    bounds
}

/// The CFL number that an adaptive step keeps, or that the speeds written in the scene make.
fn cfl(scene: &CheckedScene, choices: &Choices, plan: &Plan) -> SolverBound {
    let adaptive = plan.fixed.is_none();
    let limit = match (adaptive, choices.scheme) {
        (true, scheme) => scheme.cfl_limit(),
        (false, SchemeKey::Ab2) if scene.scene.domain.geometry == Geometry::Plane => STREAM_AB2,
        (false, SchemeKey::Ab2) => STREAM_AB2_SPHERE,
        (false, SchemeKey::Rk3) => STREAM_RK3,
    };
    let value = match adaptive {
        true => (choices.time.cfl, Measure::One),
        false => (speed::named(scene).max(plan.start) / plan.spacing, Measure::Window),
    };
    SolverBound::new("cfl", "u dt/Δx", value, Side::AtMost, limit).because(
        "the time scheme of the convection is unstable beyond it; with a fixed dt only the speeds that the \
         scene names are known yet",
        "docs/maps/courant-plane.csv",
        "lower the fluid's cfl or dt, or let dt be adaptive",
    )
}

/// Explicit viscosity: the eigenvalue −4 ν Σ 1/Δx² must lie in the time scheme's region of stability.
fn explicit_viscosity(scene: &CheckedScene, nu: f64, scheme: SchemeKey) -> SolverBound {
    let domain = &scene.scene.domain;
    let sum: f64 = (0..domain.dimensions()).map(|axis| domain.spacing(axis).powi(-2)).sum();
    let (limit, source) = match scheme {
        SchemeKey::Rk3 => (REAL_AXIS_RK3, "stability region of third-order Runge–Kutta (Wray 1986)"),
        SchemeKey::Ab2 => (1.0, "stability region of second-order Adams–Bashforth on the real axis: −1"),
    };
    let value = (nu * sum, Measure::Window);
    SolverBound::new("explicit-viscosity", "ν dt Σ 1/Δx²", value, Side::AtMost, limit / 4.0).because(
        "explicit viscosity is unstable in this time scheme",
        source,
        "make the fluid's viscosity implicit, or lower dt",
    )
}
