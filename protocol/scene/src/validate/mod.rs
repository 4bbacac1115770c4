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

use super::domain::InitialVelocity;
use super::open;
use super::shared::Scene;
use super::source::SceneSource;
use crate::over_time::acts_along;
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
            missing::in_geometry(&(*velocity).into(), geometry, "medium.initial.velocity", source)
        }
        InitialVelocity::Shear { direction, gradient, rate, origin } => {
            finite(source, "medium.initial", &[*rate, *origin])?;
            let axes = scene.domain.geometry.axes();
            source.refuse_if(
                direction == gradient || !axes.contains(direction) || !axes.contains(gradient),
                "medium.initial",
                format_args!("shears {direction:?} along {gradient:?}; the axes are {axes:?}"),
                "name two different axes of this geometry",
            )?;
            Ok(())
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
    if scene.gravity.is_zero() {
        return Err(source.error(
            "stop_when",
            "measures energy in m g R, but the scene has no gravity",
            "give gravity, or leave it out",
        ));
    }
    Ok(())
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
        source.refuse_if(
            !(wall.from.is_finite() && wall.until > wall.from),
            &key("until"),
            format_args!("is {}, from {}", wall.until, wall.from),
            "give times from < until between which the wall is there, or leave them out",
        )?;
    }
    Ok(())
}
