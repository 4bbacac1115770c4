//! `accuracy = "2%"`: resolution and step from the chart of a class of scenes.
//!
//! A chart (docs/charts) says what every setting cost and how far off it was, in several cases of its class.
//! A scene gets a promise where its numbers (Ar, St, Re, density ratio, distance of walls, solid fraction)
//! lie within those of the chart, else a refusal that names them. Of the cases beside it the worst counts.
//! The cheapest setting that is exact enough is transferred to the scene: D/Δx as it is, time steps in units
//! of the class's own time, keys of `[fluid]` and `[dem]` as they are. Half of the error asked for is kept
//! for what the scene and the charted ones do not share. What the user says by `--set` still wins.
//!
//! | file | what it holds |
//! |---|---|
//! | `class` | the classes: which scenes, which chart, which numbers and unit of time |
//! | `numbers` | a scene's numbers against the charted ones |
//! | `charted` | what a chart says of each of its runs, as `data/*.toml` |
//! | `pick` | the cheapest setting of a chart that is exact enough |
//! | `transfer` | a setting, transferred to another scene |
//! | `written` | settings of its own that a scene has, and those that it only writes out |

mod charted;
mod class;
mod numbers;
mod pick;
mod transfer;
mod written;

use bedload_program::RunOptions;
use bedload_scene::{CheckedScene, SceneError, SceneSource};
use serde::Deserialize;

use crate::failure::Failure;
use crate::number::Short;
pub use charted::{Charted, Run};
pub use class::Class;
pub(crate) use class::bounces;
pub use numbers::Number;

/// Part of the error asked for that the chart may have.
const FROM_CHART: f64 = 0.5;

/// What can be done about a scene that no chart serves.
const MEASURE: &str = "add --verify, which measures on grids of the scene itself";

/// The one key that is read here.
#[derive(Deserialize)]
struct Asked {
    accuracy: Option<String>,
}

/// What was chosen, and what is expected of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Relative error asked for.
    pub(crate) target: f64,
    /// Relative error that the chart has for this setting.
    pub(crate) error: f64,
    pub(crate) class: &'static str,
    /// File of the chart.
    pub(crate) chart: String,
    /// Label of the run in it.
    pub(crate) label: String,
    /// `KEY=VALUE` as applied.
    pub(crate) set: Vec<String>,
    /// Of these, what the user's own `--set` changes: then nothing is expected.
    pub(crate) changed: Vec<String>,
}

impl std::fmt::Display for Expected {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { class, label, chart, .. } = self;
        let (target, error) = (Short(100.0 * self.target), Short(100.0 * self.error));
        if self.changed.is_empty() {
            let set = self.set.join(", ");
            let of = format!("run {label} of {chart}, whose error is {error} %");
            return write!(f, "accuracy {target} %: as {class}, {of}: {set}");
        }
        let changed = self.changed.join(", ");
        write!(
            f,
            "accuracy {target} %: nothing is promised: --set changes {changed} of run {label} of {chart}"
        )
    }
}

impl Expected {
    /// The options with these settings before the user's own, and which of them those change.
    ///
    /// # Errors
    /// [`SceneError`] where a setting does not fit.
    pub(crate) fn before(mut self, options: &RunOptions) -> Result<(RunOptions, Self), SceneError> {
        let overrides = [&self.set[..], &options.overrides[..]].concat();
        let options = RunOptions { overrides, ..options.clone() };
        let source = SceneSource::read(&options.scene, &options.all_overrides())?;
        let values = |source: &SceneSource| source.text.parse::<toml::Table>().ok();
        let written = values(&source);
        for set in &self.set {
            if values(&source.clone().with_overrides(std::slice::from_ref(set))?) != written {
                self.changed.push(set.clone());
            }
        }
        Ok((options, self))
    }
}

/// The options with the settings that `accuracy` asks for before the user's own, if it is given.
///
/// # Errors
/// [`Failure`]: a scene that cannot be read, or an accuracy that no chart has for it.
pub fn resolve(options: &RunOptions) -> Result<(RunOptions, Option<Expected>), Failure> {
    let source = SceneSource::read(&options.scene, &options.all_overrides())?;
    let Some((target, text)) = asked(&source)? else { return Ok((options.clone(), None)) };
    let scene = CheckedScene::new(source)?;
    match choose(&scene, target, &text) {
        Ok(expected) => {
            let (options, expected) = expected.before(options)?;
            Ok((options, Some(expected)))
        }
        // Its settings are those with which it began, as its checkpoint sees to: those of --verify, say.
        Err(refused) if options.resume => {
            protocol::tell!("bedload: accuracy {}; the run goes on with what is set", refused.message);
            Ok((options.clone(), None))
        }
        Err(refused) => Err(refused.into()),
    }
}

/// The relative error that a scene asks for, as a part and as it is written. It reads the key alone: most
/// scenes have none, and to lay out many grains twice takes its time.
pub(crate) fn asked(source: &SceneSource) -> Result<Option<(f64, String)>, SceneError> {
    let Asked { accuracy } = source.section()?;
    let Some(text) = accuracy else { return Ok(None) };
    let target = fraction(&text).ok_or_else(|| {
        let message = format!("is {text:?}; allowed: a part of the value, 0.01 % to 50 %");
        source.error("accuracy", message, "write accuracy = \"2%\"")
    })?;
    Ok(Some((target, text)))
}

/// What a scene that asks for no accuracy would get for `target`, if its class has a chart that knows.
pub(crate) fn offered(scene: &CheckedScene, target: f64) -> Option<Expected> {
    let Asked { accuracy } = scene.source.section().ok()?;
    accuracy.is_none().then(|| choose(scene, target, "").ok())?
}

/// What the chart of a scene's class has for `target`; `text`: the target as the user wrote it.
pub(crate) fn choose(scene: &CheckedScene, target: f64, text: &str) -> Result<Expected, SceneError> {
    let refuse = |message: String, remedy: &str| scene.source.error("accuracy", message, remedy);
    let none = |why: String| {
        let names: Vec<&str> = Class::ALL.iter().map(|class| class.name()).collect();
        let keys = "domain.cells, fluid.time and dem.steps_per_contact";
        refuse(
            format!("has no chart for this scene: {why}; there are charts for {}", names.join(", ")),
            &format!("{MEASURE}; or leave accuracy out and set {keys}"),
        )
    };
    let class = Class::of_problem(scene).map_err(none)?;
    let chart = class.charted().map_err(|what| refuse(what, "mend the chart"))?;
    let numbers = class.numbers(scene);
    let charted: Vec<Vec<f64>> = chart.runs.iter().map(|run| run.numbers.clone()).collect();
    let outside = numbers::outside(&numbers, &charted);
    if !outside.is_empty() {
        let (name, outside, chart) = (class.name(), outside.join("; "), class.chart_file());
        return Err(refuse(
            format!("cannot be promised as {name}: {outside} ({chart})"),
            &format!("{MEASURE}; or bring the scene into the charted range"),
        ));
    }
    let beside = beside(&numbers, &chart.runs);
    let setting = pick::cheapest(&beside, FROM_CHART * target).map_err(|best| {
        refuse(
            format!(
                "is {text}, but the best of {} is {} %, and half of what is asked for is kept for what differs",
                class.chart_file(),
                Short(100.0 * best)
            ),
            &format!("ask for less; or {MEASURE}"),
        )
    })?;
    let set = transfer::transferred(setting.worst, class, scene);
    if let Some(other) = written::own(scene, &class.uncharted(scene), &set) {
        return Err(none(class::nothing_with(other)));
    }
    if let Some(stale) = &chart.stale {
        let table = &chart.table;
        return Err(refuse(
            format!(
                "rests on {table}, which is stale: the build gives other values for its sample ({stale})"
            ),
            &format!("make the table again: bedload study {}; or {MEASURE}", chart.scene),
        ));
    }
    Ok(Expected {
        target,
        error: setting.worst.error,
        class: class.name(),
        chart: class.chart_file(),
        label: setting.worst.label.clone(),
        set,
        changed: Vec::new(),
    })
}

/// The runs of the cases beside a scene: those next to it in the first of its numbers, at any of the others.
fn beside<'a>(numbers: &[Number], runs: &'a [Run]) -> Vec<&'a Run> {
    let first = |run: &Run| run.numbers.first().copied();
    let Some(number) = numbers.first() else { return runs.iter().collect() };
    let range = numbers::beside(number.value, runs.iter().filter_map(first));
    runs.iter().filter(|run| first(run).is_some_and(|value| range.contains(&value))).collect()
}

/// `2%`, `2 %` or `0.02` as 0.02.
fn fraction(text: &str) -> Option<f64> {
    let text = text.trim();
    let value = match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse::<f64>().ok()? / 100.0,
        None => text.parse().ok()?,
    };
    (1e-4..=0.5).contains(&value).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_accuracy_is_a_part() {
        assert_eq!(
            [fraction("2%"), fraction(" 0.5 % "), fraction("0.02")],
            [Some(0.02), Some(0.005), Some(0.02)]
        );
        assert_eq!([fraction("two"), fraction("0"), fraction("200%"), fraction("nan")], [None; 4]);
    }
}
