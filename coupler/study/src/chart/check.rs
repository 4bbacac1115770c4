//! The `[chart]` section against its scene.

use bedload_scene::{CheckedScene, SUPERFICIAL, SceneError, SceneSource};

use crate::section::{Reference, Section};
use crate::vary::{Choice, Vary, text};

/// Fewest runs that a limit can be seen in.
const LEAST: usize = 3;

pub(crate) fn check(section: &Section, scene: &CheckedScene) -> Result<(), SceneError> {
    published(section, &scene.source)?;
    axis(section, &scene.source)?;
    metrics(section, scene)?;
    reference(section, &scene.source)
}

/// The run that the baseline names is one of these.
pub(crate) fn baseline(section: &Section, labels: &[&str], source: &SceneSource) -> Result<(), SceneError> {
    match &section.baseline {
        Some(baseline) if !labels.contains(&baseline.as_str()) => Err(source.error(
            "chart.baseline",
            format!("is {baseline:?}, but no run has that label; there are {}", labels.join(", ")),
            "name the run that has the paper's own setting, or leave the key out",
        )),
        _ => Ok(()),
    }
}

fn published(section: &Section, source: &SceneSource) -> Result<(), SceneError> {
    for (index, point) in section.published.iter().enumerate() {
        let place = format!("chart.published[{index}]");
        for (key, value) in [("cost", point.cost), ("error", point.error)] {
            if !(value > 0.0 && value.is_finite()) {
                let message = format!("is {value}; allowed: a positive number, for a logarithmic axis");
                return Err(source.error(&format!("{place}.{key}"), message, "give what was published"));
            }
        }
    }
    Ok(())
}

/// The key along the horizontal axis is a varied one, with values that have a place there.
fn axis(section: &Section, source: &SceneSource) -> Result<(), SceneError> {
    let headers: Vec<&str> = section.vary.iter().map(Vary::header).collect();
    if section.x.is_empty() {
        return Ok(());
    }
    if let Some(place) = headers.iter().position(|header| *header == section.x) {
        let choices = section.vary[place].choices(&format!("chart.vary[{place}]"), source)?;
        let number = |choice: &Choice| choice.text.parse().is_ok_and(|value: f64| value > 0.0);
        return match choices.iter().find(|choice| !number(choice)) {
            None => Ok(()),
            Some(choice) => Err(source.error(
                "chart.x",
                format!("names {:?}, which has the value {}", section.x, choice.text),
                "name a key whose values are numbers above 0: the axis is logarithmic",
            )),
        };
    }
    let message = format!("names {:?}, which is not varied; varied are {}", section.x, headers.join(", "));
    Err(source.error("chart.x", message, "name a key of [[chart.vary]], or leave x out for the cost"))
}

fn metrics(section: &Section, scene: &CheckedScene) -> Result<(), SceneError> {
    let wrong = |key: &str, message: &str, remedy: &str| Err(scene.source.error(key, message, remedy));
    let names = section.metrics();
    if names.is_empty() {
        let remedy = "add metric = \"...\", one of the scene's [[metrics]]";
        return wrong("chart", "has no `metric`, so there is nothing to chart", remedy);
    }
    let metrics = &scene.scene.metrics;
    let key = if section.metric.is_some() { "chart.metric" } else { "chart.metrics" };
    // A fluid alone reports these without being asked, along its periodic axes.
    let domain = &scene.scene.domain;
    let axes = domain.geometry.axes().iter().enumerate().filter(|(axis, _)| domain.is_periodic(*axis));
    let superficial: Vec<String> = axes
        .filter(|_| scene.scene.medium.is_some() && section.reference.is_some())
        .map(|(_, axis)| format!("{SUPERFICIAL}{}", axis.name()))
        .collect();
    let is_given = |name: &str| superficial.iter().any(|given| given == name);
    for name in names.into_iter().filter(|name| !is_given(name)) {
        let Some(metric) = metrics.iter().find(|metric| metric.name == name) else {
            let there: Vec<&str> = metrics.iter().map(|metric| metric.name.as_str()).collect();
            let message = format!("names {name:?}; the scene's metrics are {}", there.join(", "));
            return wrong(key, &message, "name one of them, or add it to [[metrics]]");
        };
        if section.reference.is_none() && metric.reference.is_none() {
            let message = format!("names {name}, which has no reference, and chart.reference is not given");
            return wrong(key, &message, "add reference = NUMBER or { richardson = KEY } to [chart]");
        }
    }
    Ok(())
}

/// What the runs are compared with.
fn reference(section: &Section, source: &SceneSource) -> Result<(), SceneError> {
    let wrong = |key: &str, message: String, remedy: &str| Err(source.error(key, message, remedy));
    match &section.reference {
        Some(Reference::Number(value)) if !value.is_finite() || section.metrics().len() > 1 => wrong(
            "chart.reference",
            format!("is {value}: one finite number for one metric is allowed"),
            "leave it out where each metric has its own reference",
        ),
        Some(Reference::Limit(limit)) => {
            let named = section.vary.iter().filter(|vary| vary.key.is_some() || vary.name.is_some());
            let headers: Vec<&str> = named.map(Vary::header).collect();
            let key = &limit.richardson;
            if !headers.contains(&key.as_str()) {
                let message =
                    format!("names {key:?}, which is not varied; varied are {}", headers.join(", "));
                return wrong("chart.reference.richardson", message, "name a key of [[chart.vary]]");
            }
            let refined = section.vary.iter().find(|vary| vary.header() == key);
            let settings = section.runs.iter().flat_map(|run| run.set.settings(""));
            let single = settings.filter(|setting| setting.key == *key).count();
            let values = refined.map_or(0, |vary| vary.values.len()) + single;
            if values < LEAST {
                let message = format!("names {key:?}, which has {values} values; a limit needs {LEAST}");
                return wrong("chart.reference.richardson", message, "list more values of it");
            }
            let twice = |other: &&String| *other == key || limit.each.contains(*other);
            if let Some(other) = limit.with.keys().find(twice) {
                let why = "which is refined, or has a limit for each of its values";
                return wrong("chart.reference.with", format!("holds {other:?}, {why}"), "take it out");
            }
            let unknown = |key: &&String| !headers.contains(&key.as_str());
            if let Some(key) = limit.with.keys().find(unknown) {
                let message = format!("has the key {key:?}, which is not varied");
                let remedy = "name keys of [[chart.vary]], in quotes: { \"fluid.time.dt\" = 0.01 }";
                return wrong("chart.reference.with", message, remedy);
            }
            for (place, vary) in section.vary.iter().enumerate() {
                let choices = vary.choices(&format!("chart.vary[{place}]"), source)?;
                let known: Vec<&str> = choices.iter().map(|choice| choice.text.as_str()).collect();
                let value = limit.with.get(vary.header()).map(text);
                if let Some(value) = value.filter(|value| !known.contains(&value.as_str())) {
                    let (key, known) = (vary.header(), known.join(", "));
                    let message = format!("has {key} = {value:?}; its values are {known}");
                    let remedy = "give one of them: the refinement of its runs is the reference";
                    return wrong("chart.reference.with", message, remedy);
                }
            }
            match limit.each.iter().find(|each| unknown(each) || *each == key) {
                Some(each) => wrong(
                    "chart.reference.each",
                    format!("names {each:?}, which is not varied, or is refined"),
                    "name other keys of [[chart.vary]], such as the name of bundles",
                ),
                None => Ok(()),
            }
        }
        _ => Ok(()),
    }
}
