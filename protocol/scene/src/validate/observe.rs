//! What is written down and measured.

use super::check::{Check, finite, not_negative, positive};
use crate::domain::Geometry;
use crate::observe::MetricKind;
use crate::shared::Scene;
use crate::source::SceneSource;

pub(super) fn observe(scene: &Scene, source: &SceneSource) -> Check {
    not_negative(source, "observe.every", scene.observe.every)?;
    not_negative(source, "observe.fields_every", scene.observe.fields_every)?;
    finite(source, "observe.fields_at", &scene.observe.fields_at)?;
    if scene.observe.energy && scene.medium.is_some() {
        return Err(source.error(
            "observe.energy",
            "is for dry scenes: the work of the fluid is not counted".to_owned(),
            "leave it out, or remove [medium]",
        ));
    }
    observed_planes(scene, source)?;
    observed_substeps(scene, source)?;
    let Some(profile) = &scene.observe.profile else { return Ok(()) };
    finite(source, "observe.profile.lower", &profile.lower)?;
    finite(source, "observe.profile.upper", &profile.upper)?;
    let flat = scene.domain.geometry == Geometry::Plane;
    let empty = (0..3).any(|c| !(flat && c == 1) && profile.upper[c] <= profile.lower[c]);
    if empty || profile.slabs == 0 || profile.axis() > 2 || (flat && profile.axis() == 1) {
        return Err(source.error(
            "observe.profile",
            format!(
                "spans {:?} to {:?} in {} slabs along {:?}",
                profile.lower, profile.upper, profile.slabs, profile.axis
            ),
            "give a box of positive size, one slab at least, and an axis x, y or z of this geometry",
        ));
    }
    Ok(())
}

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
    if scene.medium.is_none() {
        return Err(source.error(
            "observe.planes",
            "averages the fluid, and the scene has none".to_owned(),
            "give [observe.profile] for the grains alone, or add [medium]",
        ));
    }
    let axes = scene.domain.geometry.axes();
    if !axes.contains(&planes.axis) {
        return Err(source.error(
            "observe.planes.axis",
            format!("is {:?}; the axes of this geometry are {axes:?}", planes.axis),
            "name one of them",
        ));
    }
    Ok(())
}

/// Metrics have names of their own; they and `observe.grains` name grains that exist.
pub(crate) fn metrics(scene: &Scene, count: usize, source: &SceneSource) -> Check {
    for (index, metric) in scene.metrics.iter().enumerate() {
        let key = |name: &str| format!("metrics[{index}].{name}");
        if scene.metrics[..index].iter().any(|other| other.name == metric.name) {
            return Err(source.error(
                &key("name"),
                format!("is `{}` a second time", metric.name),
                "give every metric a name of its own",
            ));
        }
        if metric.reference.is_some() && metric.compared_with.is_some() {
            return Err(source.error(
                &key("compared_with"),
                "stands beside a reference: a metric has one of the two",
                "keep reference for a published or exact value, compared_with for any other",
            ));
        }
        match &metric.kind {
            MetricKind::RestitutionAtGap { gap, .. } => positive(source, &key("gap"), *gap)?,
            MetricKind::Mean { from, .. }
            | MetricKind::Deviation { from, .. }
            | MetricKind::Max { from, .. } => {
                not_negative(source, &key("from"), *from)?;
            }
            MetricKind::Frequency { from, level, .. } => {
                not_negative(source, &key("from"), *from)?;
                finite(source, &key("level"), &[*level])?;
            }
            MetricKind::VelocityDifference { component, along, through, .. } => {
                let axes = scene.domain.geometry.axes();
                if scene.medium.is_none() || !axes.contains(component) || !axes.contains(along) {
                    return Err(source.error(
                        &key("kind"),
                        format!("is about {component:?} along {along:?} of a fluid; the axes are {axes:?}"),
                        "name axes of this geometry, in a scene with [medium]",
                    ));
                }
                finite(source, &key("through"), through)?;
            }
            MetricKind::WakeLength { along, .. } => {
                let axes = scene.domain.geometry.axes();
                if scene.medium.is_none() || !axes.contains(along) {
                    return Err(source.error(
                        &key("along"),
                        format!("is {along:?} of a fluid; the axes are {axes:?}"),
                        "name an axis of this geometry, in a scene with [medium]",
                    ));
                }
            }
            MetricKind::HaffTime(span) | MetricKind::HaffMisfit(span) => {
                not_negative(source, &key("from"), span.from)?;
                positive(source, &key("to"), span.to.min(f64::MAX))?;
            }
            MetricKind::MeanFluidVelocity { .. }
            | MetricKind::MeanGrainVelocity { .. }
            | MetricKind::Shields { .. }
                if scene.observe.planes.is_none() =>
            {
                return Err(source.error(
                    &key("kind"),
                    "is read from averages over planes, which the scene does not ask for".to_owned(),
                    "add observe.planes = { every = ... }",
                ));
            }
            MetricKind::Shields { surface, .. } => positive(source, &key("surface"), *surface)?,
            MetricKind::MobilisationTime { speed, share } => {
                positive(source, &key("speed"), *speed)?;
                positive(source, &key("share"), *share)?;
            }
            MetricKind::HeapAngle(slope) => heap(scene, source, &key, slope.centre, slope.bin)?,
            _ => {}
        }
        if let Some(column) = metric.kind.column() {
            positive(source, &key("half_length"), column.half_length)?;
            not_negative(source, &key("release"), column.release)?;
            heap(scene, source, &key, column.centre, column.bin)?;
        }
        if let Some(grain) = metric.kind.grain().filter(|grain| *grain >= count) {
            return Err(source.error(
                &key("grain"),
                format!("is {grain}, but the scene has {count} grains"),
                "count grains from 0",
            ));
        }
    }
    let chosen = scene.observe.substeps.as_ref().map(|asked| &asked.grains);
    for (key, grains) in
        [("observe.grains", scene.observe.grains.as_ref()), ("observe.substeps.grains", chosen)]
    {
        if let Some(grain) = grains.into_iter().flatten().find(|grain| **grain >= count) {
            let what = format!("holds {grain}, but the scene has {count} grains");
            return Err(source.error(key, what, "count grains from 0"));
        }
    }
    Ok(())
}

/// Most bins that a profile of a heap may have over the length of the box.
const MOST_BINS: f64 = 1e5;

/// A profile of a heap: its middle in the box, and a number of bins that can be kept.
fn heap(scene: &Scene, source: &SceneSource, key: &dyn Fn(&str) -> String, centre: f64, bin: f64) -> Check {
    let (low, high) = (scene.domain.lower[0], scene.domain.upper[0]);
    if !(low..=high).contains(&centre) {
        return Err(source.error(
            &key("centre"),
            format!("is {centre}; allowed: a place in the box along x, {low} to {high}"),
            "give the middle of the heap",
        ));
    }
    let least = (high - low) / MOST_BINS;
    if bin == 0.0 || (bin >= least && bin.is_finite()) {
        return Ok(());
    }
    Err(source.error(
        &key("bin"),
        format!("is {bin}; allowed: 0 (three mean radii), or {least:e} and more: {MOST_BINS:e} bins over the length of the box"),
        "give a width of a few radii",
    ))
}
