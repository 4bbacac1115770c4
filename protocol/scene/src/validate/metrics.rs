//! What is measured: one rule for each key, whatever kinds have it.

use std::collections::HashSet;

use toml::Value;

use super::check::{Check, finite, not_negative, positive};
use crate::domain::{Axis, WallKind};
use crate::file_names::{FILE_NAME, is_file_name, is_taken};
use crate::metric::{MetricKind, SUPERFICIAL};
use crate::shared::Scene;
use crate::source::SceneSource;

/// What a number, or each of a list, must be.
type Rule = fn(&SceneSource, &str, f64) -> Check;
const POSITIVE: Rule = |source, key, value| positive(source, key, value.min(f64::MAX));
const PART: Rule = |source, key, value| {
    positive(source, key, value)?;
    source.refuse_if(value > 1.0, key, format_args!("is {value}; allowed: up to 1, the whole"), "give a part")
};
const FINITE: Rule = |source, key, value| finite(source, key, &[value]);

/// Keys of kinds of metrics that hold numbers.
const NUMBERS: [(&str, Rule); 11] = [
    ("gap", POSITIVE),
    ("from", not_negative),
    ("to", POSITIVE),
    ("level", FINITE),
    ("through", FINITE),
    ("half_length", POSITIVE),
    ("release", not_negative),
    ("surface", POSITIVE),
    ("speed", POSITIVE),
    ("share", PART),
    ("at", FINITE),
];

/// Metrics have names of their own; they and `observe.grains` name grains that exist.
pub(crate) fn metrics(scene: &Scene, count: usize, source: &SceneSource) -> Check {
    let mut names = HashSet::new();
    for (index, metric) in scene.metrics.iter().enumerate() {
        let key = |name: &str| format!("metrics[{index}].{name}");
        source.refuse_if(
            !names.insert(&metric.name),
            &key("name"),
            format_args!("is `{}` a second time", metric.name),
            "give every metric a name of its own",
        )?;
        if let Some(table) = metric.kind.table(&metric.name) {
            source.refuse_if(
                !is_file_name(&metric.name),
                &key("name"),
                format_args!("is {:?}, which becomes the file <name>.csv; allowed: {FILE_NAME}", metric.name),
                "give a short name of plain signs, such as \"u_difference\"",
            )?;
            source.refuse_if(
                is_taken(&table),
                &key("name"),
                format_args!(
                    "is {:?}: {table} is a file of the output folder already; allowed: any other name",
                    metric.name
                ),
                "give another name, such as \"u_difference\"",
            )?;
        }
        source.refuse_if(
            metric.name.is_empty() || metric.name.starts_with(SUPERFICIAL),
            &key("name"),
            format_args!("is {:?}; allowed: a name that a run has not itself ({SUPERFICIAL}…)", metric.name),
            "give another name",
        )?;
        for (name, value) in [("reference", metric.reference), ("compared_with", metric.compared_with)] {
            finite(source, &key(name), &[value.unwrap_or(0.0)])?;
        }
        source.refuse_if(
            metric.reference.is_some() && metric.compared_with.is_some(),
            &key("compared_with"),
            "stands beside a reference: a metric has one of the two",
            "keep reference for a published or exact value, compared_with for any other",
        )?;
        let keys = metric.kind.keys();
        let number = |name: &str| keys.get(name).and_then(Value::as_float);
        for (name, rule) in &NUMBERS {
            let list = keys.get(*name).and_then(Value::as_array);
            let mut values: Vec<f64> = list.into_iter().flatten().filter_map(Value::as_float).collect();
            values.extend(number(name));
            for value in values {
                rule(source, &key(name), value)?;
            }
        }
        let planes = ["mean-fluid-velocity", "mean-grain-velocity", "shields", "fluid-shields"];
        let kind = keys.get("kind").and_then(Value::as_str).unwrap_or("");
        source.refuse_if(
            planes.contains(&kind) && scene.observe.planes.is_none(),
            &key("kind"),
            "is read from averages over planes, which the scene does not ask for",
            "add observe.planes = { every = ... }",
        )?;
        if kind == "shields" {
            whole_stress(scene, source, &key("kind"))?;
        }
        let between = keys.get("between").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
        let between: Vec<f64> = between.iter().filter_map(Value::as_float).collect();
        let [from, to] = ["from", "to"].map(number);
        for (name, list) in [("between", between), ("to", from.into_iter().chain(to).collect())] {
            if let [low, high] = list[..] {
                source.refuse_if(
                    low >= high,
                    &key(name),
                    format_args!("is from {low} to {high}; allowed: a smaller number before a larger one"),
                    "exchange the two",
                )?;
            }
        }
        if keys.contains_key("along") || keys.contains_key("component") {
            let axes: Vec<&str> = scene.domain.geometry.axes().iter().map(|axis| axis.name()).collect();
            let asked = ["component", "along"].map(|name| keys.get(name).and_then(Value::as_str));
            let [component, along] = asked.map(|axis| axis.unwrap_or("the stream"));
            source.refuse_if(
                asked[1].is_some() && scene.medium.is_none()
                    || asked.iter().flatten().any(|axis| !axes.contains(axis)),
                &key("kind"),
                format_args!("is about {component} along {along}; the axes are {axes:?}"),
                "name axes of this geometry, and of a fluid in a scene with [medium]",
            )?;
        }
        if let MetricKind::VelocityDifference { along, through, .. } = &metric.kind {
            within_box(scene, source, &key("through"), *along, through)?;
        }
        if let Some(centre) = number("centre") {
            heap(scene, source, &key, centre, number("bin").unwrap_or(0.0))?;
        }
        if let Some(grain) = metric.kind.grain().filter(|grain| *grain >= count) {
            let what = format!("is {grain}, but the scene has {count} grains");
            return Err(source.error(&key("grain"), what, "count grains from 0"));
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

/// A line along an axis of the fluid passes through the box.
fn within_box(scene: &Scene, source: &SceneSource, key: &str, along: Axis, through: &[f64; 3]) -> Check {
    let domain = &scene.domain;
    for (axis, name) in domain.geometry.axes().iter().enumerate().filter(|(_, name)| **name != along) {
        let (low, high) = (domain.lower[axis], domain.upper[axis]);
        let at = through[domain.geometry.component(axis)];
        source.refuse_if(
            !(low..=high).contains(&at),
            key,
            format_args!("is {at} along {}; allowed: a place in the box, {low} to {high}", name.name()),
            "name a point (x, y, z) that the line passes through",
        )?;
    }
    Ok(())
}

/// The whole stress follows from what stands above the bed: a lid whose stress is known, and known forces.
fn whole_stress(scene: &Scene, source: &SceneSource, key: &str) -> Check {
    let axis = scene.observe.planes.as_ref().map(|planes| planes.axis);
    let axis = axis.and_then(|axis| scene.domain.geometry.axes().iter().position(|other| *other == axis));
    let lid = axis.and_then(|axis| scene.domain.boundary(axis)).map(|faces| faces.upper.kind);
    let known = matches!(lid, Some(WallKind::NoSlip | WallKind::FreeSlip));
    let driven = scene.medium.as_ref().is_some_and(|medium| medium.flow_rate.is_some());
    source.refuse_if(
        !known || driven,
        key,
        if driven {
            "is the whole stress, which needs the force that drives the flow: a given flow rate hides it"
        } else {
            "is the whole stress, which needs a no-slip or free-slip face above the planes"
        },
        "use the fluid's part, kind = \"fluid-shields\"",
    )
}

/// Most bins that a profile of a heap may have over the length of the box.
const MOST_BINS: f64 = 1e5;

/// A profile of a heap: its middle in the box, and a number of bins that can be kept.
fn heap(scene: &Scene, source: &SceneSource, key: &dyn Fn(&str) -> String, centre: f64, bin: f64) -> Check {
    let (low, high) = (scene.domain.lower[0], scene.domain.upper[0]);
    source.refuse_if(
        !(low..=high).contains(&centre),
        &key("centre"),
        format_args!("is {centre}; allowed: a place in the box along x, {low} to {high}"),
        "give the middle of the heap",
    )?;
    let least = (high - low) / MOST_BINS;
    if bin == 0.0 || (bin >= least && bin.is_finite()) {
        return Ok(());
    }
    Err(source.error(
        &key("bin"),
        format!(
            "is {bin}; allowed: 0 (three mean radii), or {least:e} and more: {MOST_BINS:e} bins over the \
            length of the box"
        ),
        "give a width of a few radii",
    ))
}
