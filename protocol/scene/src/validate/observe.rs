//! What is written down and measured.

use super::check::{Check, finite, not_negative, positive};
use crate::domain::{Axis, Geometry, WallKind};
use crate::observe::Total;
use crate::shared::Scene;
use crate::source::SceneSource;

pub(super) fn observe(scene: &Scene, source: &SceneSource) -> Check {
    not_negative(source, "observe.every", scene.observe.every)?;
    not_negative(source, "observe.fields_every", scene.observe.fields_every.unwrap_or(0.0))?;
    scene.observe.fields_at.iter().try_for_each(|at| not_negative(source, "observe.fields_at", *at))?;
    source.refuse_if(
        scene.observe.energy && scene.medium.is_some(),
        "observe.energy",
        "is for dry scenes: the work of the fluid is not counted",
        "leave it out, or remove [medium]",
    )?;
    named_once(source, "observe.grains", scene.observe.grains.as_deref().unwrap_or_default())?;
    observed_planes(scene, source)?;
    observed_substeps(scene, source)?;
    observed_totals(scene, source)?;
    let Some(profile) = &scene.observe.profile else { return Ok(()) };
    finite(source, "observe.profile.lower", &profile.lower)?;
    finite(source, "observe.profile.upper", &profile.upper)?;
    let flat = scene.domain.geometry == Geometry::Plane;
    let empty = (0..3).any(|c| !(flat && c == 1) && profile.upper[c] <= profile.lower[c]);
    source.refuse_if(
        empty || profile.slabs == 0 || profile.axis == Axis::R || (flat && profile.axis == Axis::Y),
        "observe.profile",
        format_args!(
            "spans {:?} to {:?} in {} slabs along {:?}",
            profile.lower, profile.upper, profile.slabs, profile.axis
        ),
        "give a box of positive size, one slab at least, and an axis x, y or z of this geometry",
    )?;
    if let Some(what) = scene.domain.no_part([profile.lower, profile.upper]) {
        return Err(source.error("observe.profile", what, "keep the region in the box"));
    }
    source.refuse_if(
        profile.slabs > MOST_SLABS,
        "observe.profile.slabs",
        format_args!("is {}; allowed: 1 to {MOST_SLABS}", profile.slabs),
        "take fewer slabs: one has to hold some grains to mean anything",
    )
}

/// Most slabs of a profile.
const MOST_SLABS: usize = 100_000;

/// Times of which the first is before the last.
fn span(source: &SceneSource, key: &str, from: f64, to: f64) -> Check {
    if from < to {
        return Ok(());
    }
    Err(source.error(key, format!("is {to}, from {from}"), "give times from < to, or leave them out"))
}

/// A list names no grain twice.
fn named_once(source: &SceneSource, key: &str, grains: &[usize]) -> Check {
    let repeated = grains.iter().enumerate().find(|(i, grain)| grains[..*i].contains(grain));
    let Some((_, grain)) = repeated else { return Ok(()) };
    Err(source.error(key, format!("holds {grain} twice"), "name every grain once"))
}

fn observed_substeps(scene: &Scene, source: &SceneSource) -> Check {
    let Some(asked) = &scene.observe.substeps else { return Ok(()) };
    not_negative(source, "observe.substeps.from", asked.from)?;
    span(source, "observe.substeps.to", asked.from, asked.to)?;
    named_once(source, "observe.substeps.grains", &asked.grains)?;
    if asked.grains.is_empty() {
        let what = "is empty: no grain is chosen";
        return Err(source.error("observe.substeps.grains", what, "name one grain at least, from 0"));
    }
    Ok(())
}

fn observed_planes(scene: &Scene, source: &SceneSource) -> Check {
    let Some(planes) = &scene.observe.planes else { return Ok(()) };
    positive(source, "observe.planes.every", planes.every)?;
    not_negative(source, "observe.planes.from", planes.from)?;
    planes.at.iter().try_for_each(|at| not_negative(source, "observe.planes.at", *at))?;
    span(source, "observe.planes.to", planes.from, planes.to)?;
    source.refuse_if(
        scene.medium.is_none(),
        "observe.planes",
        "averages the fluid, and the scene has none",
        "give [observe.profile] for the grains alone, or add [medium]",
    )?;
    let axes = scene.domain.geometry.axes();
    source.refuse_if(
        !axes.contains(&planes.axis),
        "observe.planes.axis",
        format_args!("is {:?}; the axes of this geometry are {axes:?}", planes.axis),
        "name one of them",
    )?;
    let otherwise = ", or leave out observe.planes.stress";
    if planes.stress {
        across_walls(scene, source, ("observe.planes.axis", planes.axis), otherwise)
    } else {
        Ok(())
    }
}

/// Planes whose stresses are counted from the upper face end at a wall on both sides.
fn across_walls(scene: &Scene, source: &SceneSource, (key, axis): (&str, Axis), otherwise: &str) -> Check {
    let domain = &scene.domain;
    source.refuse_if(
        domain.geometry == Geometry::Axisymmetric,
        key,
        "counts from wall to wall across an axis, which an axisymmetric scene does not",
        &format!("take a plane or space{otherwise}"),
    )?;
    let place = domain.geometry.axes().iter().position(|known| *known == axis);
    let faces = place.and_then(|place| domain.boundary(place));
    let is_wall = |kind| matches!(kind, WallKind::NoSlip | WallKind::FreeSlip);
    let walls = faces.is_some_and(|faces| {
        is_wall(faces.upper.kind) && faces.lower.is_none_or(|lower| is_wall(lower.kind))
    });
    source.refuse_if(
        !walls,
        key,
        format_args!("is \"{}\", where there is no wall on both sides", axis.name()),
        &format!("name an axis of a plane or of space whose faces are no-slip or free-slip{otherwise}"),
    )
}

fn observed_totals(scene: &Scene, source: &SceneSource) -> Check {
    let Some(totals) = &scene.observe.totals else { return Ok(()) };
    let columns = &totals.columns;
    let repeated = columns.iter().enumerate().any(|(i, column)| columns[..i].contains(column));
    source.refuse_if(
        columns.is_empty() || repeated,
        "observe.totals.columns",
        if repeated { "holds a column twice" } else { "is empty: no column is chosen" },
        "name each column that is wanted once",
    )?;
    across_walls(scene, source, ("observe.totals.axis", totals.axis), "")?;
    source.refuse_if(
        !(totals.surface > 0.0 && totals.surface < 1.0),
        "observe.totals.surface",
        format_args!("is {}; allowed: a solid fraction between 0 and 1", totals.surface),
        "take 0.3, or 0.05 for the last grains",
    )?;
    match totals.speed {
        Some(speed) => positive(source, "observe.totals.speed", speed)?,
        None => source.refuse_if(
            totals.has(&[Total::MovingGrains]),
            "observe.totals.speed",
            "is not given",
            "say from which speed on, m/s, a grain counts as moving",
        )?,
    }
    source.refuse_if(
        totals.has(&[Total::FluidFlux, Total::Shields]) && scene.medium.is_none(),
        "observe.totals.columns",
        "asks for a flux or a stress of the fluid, and the scene has none",
        "leave out \"fluid-flux\" and \"shields\", or add [medium]",
    )?;
    source.refuse_if(
        totals.has(&[Total::Shields]) && scene.gravity == [0.0; 3],
        "observe.totals.columns",
        "asks for the Shields number, and nothing has a weight",
        "leave out \"shields\", or give gravity",
    )
}
