//! Convection, viscosity and forcing against the fluid's step (docs/numerics.md).

use protocol::facts::{FluidFacts, Forcing};
use protocol::scene::{CheckedScene, InitialVelocity};

use super::{Bound, Facts, Side, choice};
use crate::scheme::norm;

/// Solid fraction of the grains' bounding box from which a bed counts as dense.
const DENSE: f64 = 0.3;
/// Largest ν dt/Δx² at which a sphere with direct forcing settled no faster than 1.2 times Stokes' speed.
/// docs/maps/direct-forcing.csv
const DIRECT: f64 = 2.0;
/// Fewer grains than this are no bed.
const FEWEST_OF_A_BED: usize = 8;

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let (Some(fluid), Some(nu)) = (facts.fluid, facts.viscosity()) else { return };
    add_cfl(facts, fluid, bounds);
    if fluid.spacing > 0.0 && !facts.scene.grains.is_empty() {
        add_forcing(facts, fluid, nu * facts.ladder.dt_fluid / fluid.spacing.powi(2), bounds);
    }
    if !fluid.implicit_viscosity {
        add_viscosity(facts, nu, bounds);
    }
}

/// Largest U dt/Δx at which a stream past a held disc was stable, U its mean velocity: Adams–Bashforth,
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

/// The CFL number that an adaptive step keeps, or that the speeds written in the scene make.
fn add_cfl(facts: &Facts<'_>, fluid: &FluidFacts, bounds: &mut Vec<Bound>) {
    if fluid.cfl_limit <= 0.0 {
        return;
    }
    let time = |key| choice(&fluid.resolved, "time", key)?.as_str();
    let once = time("projections") == Some("once");
    let limit = match (fluid.adaptive, time("scheme")) {
        (true, _) if once => fluid.cfl_limit.min(ONCE),
        (false, Some("ab2")) => STREAM_AB2,
        (false, Some("rk3")) if once => STREAM_ONCE,
        (false, Some("rk3")) => STREAM_RK3,
        // Of a foreign solver only its own number is known.
        _ => fluid.cfl_limit,
    };
    let known = known_speed(facts.scene) * facts.ladder.dt_fluid / fluid.spacing;
    let value = if fluid.adaptive { fluid.cfl.max(0.0) } else { known };
    bounds.push(Bound::new("cfl", "u dt/Δx", value, Side::AtMost, limit).because(
        "the time scheme of the convection is unstable beyond it; with a fixed dt only the speeds that the scene names are known yet",
        "docs/maps/courant-plane.csv",
        "lower the fluid's cfl or dt, or let dt be adaptive",
    ));
}

/// Largest speed that the scene itself names, m/s.
fn known_speed(scene: &CheckedScene) -> f64 {
    let domain = &scene.scene.domain;
    let grains = scene
        .grains
        .iter()
        .map(|grain| norm(&grain.velocity) + grain.oscillation.map_or(0.0, |swing| norm(&swing.amplitude)));
    let faces = (0..domain.dimensions()).filter_map(|axis| domain.boundary(axis)).flat_map(|faces| {
        [faces.lower.map_or(0.0, |lower| norm(&lower.velocity)), norm(&faces.upper.velocity)]
    });
    let start = match scene.scene.medium.as_ref().map(|medium| &medium.initial) {
        Some(InitialVelocity::Uniform { velocity }) => norm(velocity),
        Some(InitialVelocity::TaylorGreen { amplitude }) => amplitude.abs(),
        Some(InitialVelocity::Shear { gradient, rate, origin, .. }) => {
            let axis = domain.geometry.axes().iter().position(|axis| axis == gradient).unwrap_or(0);
            let reach = (domain.upper[axis] - origin).abs().max((domain.lower[axis] - origin).abs());
            rate.abs() * reach
        }
        Some(InitialVelocity::Rest) | None => 0.0,
    };
    grains.chain(faces).fold(start, f64::max)
}

fn add_forcing(facts: &Facts<'_>, fluid: &FluidFacts, number: f64, bounds: &mut Vec<Bound>) {
    const QUANTITY: &str = "ν dt/Δx²";
    match fluid.forcing {
        Forcing::Direct => {
            bounds.push(Bound::new("direct-forcing", QUANTITY, number, Side::AtMost, DIRECT).because(
                "direct forcing (eq. 7) fails: viscosity undoes it within the step",
                "docs/maps/direct-forcing.csv",
                "use the carried forcing, or a smaller dt",
            ));
            bounds.push(
                Bound::new("direct-forcing-accuracy", QUANTITY, number, Side::AtMost, 1.0).warning().because(
                    "direct forcing (eq. 7) is wrong by tens of per cent in the settling speed",
                    "docs/numerics.md, Forcing and viscosity (Ar = 9: +40 %, Ar = 0.9: +90 %)",
                    "use the carried forcing, or a smaller dt",
                ),
            );
        }
        Forcing::Carried if is_dense(facts.scene) => {
            bounds
                .push(Bound::new("dense-bed-forcing", QUANTITY, number, Side::AtMost, 2.0).warning().because(
                "the carried forcing of a dense bed converges slowly (340 steps to 1 % at φ = 0.52 and 16)",
                "docs/numerics.md, Forcing and viscosity",
                "lower the fluid's dt",
            ));
        }
        Forcing::Carried => {}
    }
}

/// Is the box around the grains filled as in a bed?
fn is_dense(scene: &CheckedScene) -> bool {
    if scene.grains.len() < FEWEST_OF_A_BED {
        return false;
    }
    let domain = &scene.scene.domain;
    let extent = |axis: usize| {
        let component = domain.geometry.component(axis);
        let lower = scene.grains.iter().map(|grain| grain.position[component] - grain.radius);
        let upper = scene.grains.iter().map(|grain| grain.position[component] + grain.radius);
        upper.fold(f64::NEG_INFINITY, f64::max) - lower.fold(f64::INFINITY, f64::min)
    };
    let room: f64 = (0..domain.dimensions()).map(extent).product();
    scene.grains.iter().map(protocol::scene::Grain::volume).sum::<f64>() > DENSE * room
}

/// Explicit viscosity: the eigenvalue −4 ν Σ 1/Δx² must lie in the time scheme's region of stability.
fn add_viscosity(facts: &Facts<'_>, nu: f64, bounds: &mut Vec<Bound>) {
    const QUANTITY: &str = "ν dt Σ 1/Δx²";
    let domain = &facts.scene.scene.domain;
    if domain.cells.is_empty() {
        return;
    }
    let sum: f64 = (0..domain.dimensions()).map(|axis| domain.spacing(axis).powi(-2)).sum();
    let number = nu * facts.ladder.dt_fluid * sum;
    // −2.5127 is where the stability region of third-order Runge–Kutta ends on the real axis.
    bounds.push(Bound::new("explicit-viscosity", QUANTITY, number, Side::AtMost, 2.5127 / 4.0).because(
        "explicit viscosity is unstable, whatever explicit scheme is used",
        "stability region of third-order Runge–Kutta (Wray 1986)",
        "make the fluid's viscosity implicit, or lower dt",
    ));
    bounds.push(
        Bound::new("explicit-viscosity-ab2", QUANTITY, number, Side::AtMost, 0.25).warning().because(
            "second-order Adams–Bashforth is unstable beyond it (Runge–Kutta is not)",
            "stability region of AB2 on the real axis: −1",
            "make the fluid's viscosity implicit, lower dt, or use Runge–Kutta",
        ),
    );
}
