//! What is written down and measured.

use super::check::{Check, finite, not_negative, positive};
use crate::domain::{Axis, Geometry};
use crate::shared::Scene;
use crate::source::SceneSource;

pub(super) fn observe(scene: &Scene, source: &SceneSource) -> Check {
    not_negative(source, "observe.every", scene.observe.every)?;
    not_negative(source, "observe.fields_every", scene.observe.fields_every)?;
    finite(source, "observe.fields_at", &scene.observe.fields_at)?;
    source.refuse_if(
        scene.observe.energy && scene.medium.is_some(),
        "observe.energy",
        "is for dry scenes: the work of the fluid is not counted",
        "leave it out, or remove [medium]",
    )?;
    observed_planes(scene, source)?;
    observed_substeps(scene, source)?;
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

fn observed_substeps(scene: &Scene, source: &SceneSource) -> Check {
    let Some(asked) = &scene.observe.substeps else { return Ok(()) };
    not_negative(source, "observe.substeps.from", asked.from)?;
    span(source, "observe.substeps.to", asked.from, asked.to)?;
    let repeated = asked.grains.iter().enumerate().find(|(i, grain)| asked.grains[..*i].contains(grain));
    if let Some((_, grain)) = repeated {
        let what = format!("holds {grain} twice");
        return Err(source.error("observe.substeps.grains", what, "name every grain once"));
    }
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
    finite(source, "observe.planes.at", &planes.at)?;
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
    )
}
