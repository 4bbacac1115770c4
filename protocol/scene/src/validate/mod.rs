//! Checks of the shared part: once, at the edge; behind it the types are trusted.
//!
//! | file | what it holds |
//! |---|---|
//! | this one | all of them in order; the medium, walls, the end |
//! | `check` | single numbers |
//! | `domain` | box, grid and faces |
//! | `beds` | grains that are made: groups, rough walls, insertions |
//! | `grains` | grains as they begin: alone, in the grid, and from each other |
//! | `observe` | what is written down |
//! | `missing` | components that a geometry does not have |
//! | `metrics` | what is measured |

mod beds;
mod check;
mod domain;
mod grains;
mod metrics;
mod missing;
mod observe;

use super::domain::{Geometry, InitialVelocity};
use super::open;
use super::shared::Scene;
use super::source::SceneSource;
use crate::over_time::acts_along;
use bedload_over_time::{cross, length};
use check::{Check, finite, not_negative, positive};
pub(super) use grains::grains;
pub(super) use metrics::metrics;

/// Everything but the grains themselves.
pub(super) fn shared(scene: &Scene, source: &SceneSource) -> Check {
    positive(source, "until", scene.until)?;
    domain::domain(scene, source)?;
    medium(scene, source)?;
    beds::rough_walls(scene, source)?;
    beds::groups(scene, source)?;
    beds::insertions(scene, source)?;
    walls(scene, source)?;
    stop(scene, source)?;
    observe::observe(scene, source)
}

fn medium(scene: &Scene, source: &SceneSource) -> Check {
    let Some(medium) = &scene.medium else { return Ok(()) };
    positive(source, "medium.density", medium.density)?;
    positive(source, "medium.viscosity", medium.viscosity)?;
    let geometry = scene.domain.geometry;
    missing::along_axis(&medium.body_force, geometry, "medium.body_force", source)?;
    missing::along_axis(&medium.pressure_gradient, geometry, "medium.pressure_gradient", source)?;
    for axis in 0..scene.domain.dimensions() {
        let component = scene.domain.geometry.component(axis);
        source.refuse_if(
            acts_along(&medium.body_force, component) && !scene.domain.is_periodic(axis),
            "medium.body_force",
            "drives along an axis with walls or open faces, where the pressure balances it and nothing moves",
            "make that axis periodic, set this component to 0, or give gravity, which grains weigh in",
        )?;
        source.refuse_if(
            acts_along(&medium.pressure_gradient, component) && !scene.domain.is_periodic(axis),
            "medium.pressure_gradient",
            "drives along an axis with walls, where the pressure balances it",
            "make that axis periodic, or remove the gradient",
        )?;
    }
    open::flow_rate(scene, source)?;
    match &medium.initial {
        // The fluid looks into the folder of a run.
        InitialVelocity::Rest | InitialVelocity::Run { .. } => Ok(()),
        InitialVelocity::Uniform { velocity } => {
            finite(source, "medium.initial.velocity", velocity)?;
            missing::along_axis(&(*velocity).into(), geometry, "medium.initial.velocity", source)
        }
        InitialVelocity::Shear { direction, gradient, rate, origin } => {
            finite(source, "medium.initial", &[*rate, *origin])?;
            let axes = scene.domain.geometry.axes();
            source.refuse_if(
                direction == gradient || !axes.contains(direction) || !axes.contains(gradient),
                "medium.initial",
                format_args!("shears {direction:?} along {gradient:?}; the axes are {axes:?}"),
                "name two different axes of this geometry",
            )
        }
        InitialVelocity::TaylorGreen { amplitude } => {
            finite(source, "medium.initial.amplitude", &[*amplitude])
        }
    }
}

/// A dry run alone stops by itself.
fn stop(scene: &Scene, source: &SceneSource) -> Check {
    let Some(stop) = &scene.stop_when else { return Ok(()) };
    positive(source, "stop_when.kinetic_energy_per_grain_below", stop.kinetic_energy_per_grain_below)?;
    not_negative(source, "stop_when.after", stop.after)?;
    source.refuse_if(
        scene.medium.is_some(),
        "stop_when",
        "ends dry runs only",
        "leave it out, and let `until` end the run",
    )?;
    source.refuse_if(
        scene.gravity.is_zero(),
        "stop_when",
        "measures energy in m g R, but the scene has no gravity",
        "give gravity, or leave it out",
    )
}

/// A wall that turns: about an axis of the geometry, and into no periodic axis.
fn turning(scene: &Scene, index: usize, source: &SceneSource) -> Check {
    let (wall, geometry) = (&scene.walls[index], scene.domain.geometry);
    let key = format!("walls[{index}].spin");
    let about = format!("walls[{index}].about");
    finite(source, &about, &wall.about.unwrap_or_default())?;
    let turns = !wall.spin.is_zero();
    source.refuse_if(
        wall.about.is_some() && !turns,
        &about,
        "is a point of the axis of a wall that does not turn",
        "give `spin`, or leave it out",
    )?;
    match geometry {
        Geometry::Space => {}
        Geometry::Plane => {
            missing::refuse(&wall.spin, &[0, 2], &key, "out of the plane (x, z)", "along y alone", source)?;
        }
        Geometry::Axisymmetric => {
            let what = "a wall of an axisymmetric scene does not turn";
            missing::refuse(&wall.spin, &[0, 1, 2], &key, what, "as zero", source)?;
        }
    }
    for (c, name) in
        ["x", "y", "z"].into_iter().enumerate().filter(|(c, _)| scene.domain.periods()[*c].is_some())
    {
        let others = [(c + 1) % 3, (c + 2) % 3];
        if let Some(spin) = wall.spin.extremes().find(|spin| others.iter().any(|c| spin[*c] != 0.0)) {
            let what = format!("is {spin:?}: {name} is periodic, and the wall would not repeat along it");
            let remedy = format!("give it along {name} alone, or make {name} not periodic");
            return Err(source.error(&key, what, &remedy));
        }
    }
    Ok(())
}

/// A wall that follows a pressure along its normal.
fn servo(scene: &Scene, index: usize, source: &SceneSource) -> Check {
    let wall = &scene.walls[index];
    let Some(servo) = &wall.servo else { return Ok(()) };
    let key = |name: &str| format!("walls[{index}].{name}");
    source.refuse_if(
        scene.domain.geometry == Geometry::Axisymmetric,
        &key("servo"),
        "follows the pressure of a bed, and an axisymmetric scene has its grains on the axis",
        "use geometry = \"space\"",
    )?;
    positive(source, &key("servo.largest_speed"), servo.largest_speed)?;
    if let Some(pull) = servo.pressure.extremes().find(|pressure| *pressure < 0.0) {
        not_negative(source, &key("servo.pressure"), pull)?;
    }
    let Some(area) = wall.area(&scene.domain) else {
        let what = format!("has no area: the normal {:?} lies along no axis of the box", wall.normal);
        return Err(source.error(&key("servo"), what, "give `area` in m² (plane: m)"));
    };
    positive(source, &key("servo.area"), area)?;
    let size = length(&wall.normal);
    let along =
        |v: [f64; 3]| (0..3).map(|c| v[c] * wall.normal[c]).sum::<f64>().abs() > 1e-12 * size * length(&v);
    source.refuse_if(
        wall.velocity.extremes().any(along),
        &key("velocity"),
        "has a part along the normal, where the servo decides",
        "give the part along the plane alone, or leave `servo` out",
    )?;
    let tilts = |w: [f64; 3]| length(&cross(&w, &wall.normal)) > 1e-12 * size * length(&w);
    source.refuse_if(
        wall.spin.extremes().any(tilts),
        &key("spin"),
        "tilts a wall that follows a pressure along its normal",
        "turn it about its normal alone, or leave `servo` out",
    )
}

fn walls(scene: &Scene, source: &SceneSource) -> Check {
    for (index, wall) in scene.walls.iter().enumerate() {
        let key = |name: &str| format!("walls[{index}].{name}");
        finite(source, &key("point"), &wall.point)?;
        let length: f64 = wall.normal.iter().map(|n| n * n).sum();
        source.refuse_if(
            !(length.is_finite() && length > 0.0),
            &key("normal"),
            format_args!("is {:?}", wall.normal),
            "give a normal of non-zero length that points to the grains",
        )?;
        let geometry = scene.domain.geometry;
        missing::along_axis(&wall.normal.into(), geometry, &key("normal"), source)?;
        missing::along_axis(&wall.velocity, geometry, &key("velocity"), source)?;
        turning(scene, index, source)?;
        servo(scene, index, source)?;
        source.refuse_if(
            !(wall.from.is_finite() && wall.until > wall.from),
            &key("until"),
            format_args!("is {}, from {}", wall.until, wall.from),
            "give times from < until between which the wall is there, or leave them out",
        )?;
    }
    Ok(())
}
