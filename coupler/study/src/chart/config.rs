//! The `[chart]` section of the scene.

use std::path::PathBuf;

use bedload_scene::{CheckedScene, Retired, SceneError, SceneSource};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{SingleRun, Vary};

/// Keys of the section that have another name now.
const RETIRED: [Retired; 1] = [Retired::key("chart.seed", "chart.baseline")];

/// `[chart]`: speed against accuracy over a refinement of runs.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Chart {
    /// Title of page and figure; by default the scene's.
    #[serde(default)]
    pub title: String,
    /// What to know before reading the figure.
    #[serde(default)]
    pub about: String,
    /// Metric of the scene whose error is charted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metric: Option<String>,
    /// Several of them: the largest of their relative errors is charted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub metrics: Vec<String>,
    /// What the runs are compared with; by default the reference of the metric itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Where the reference comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// How often each run is made, for the spread of its cost.
    #[serde(default = "once")]
    #[schemars(range(min = 1))]
    pub repeat: usize,
    /// Threads of each solver, where `threads` is not varied.
    #[serde(default = "once")]
    #[schemars(range(min = 1))]
    pub threads: usize,
    /// Points of others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published: Vec<Published>,
    /// Label of the run that has the paper's own setting: costs are told over its cost.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<String>,
    /// Dotted keys that every run sets, before its own.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
    /// Varied keys: all their combinations are run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vary: Vec<Vary>,
    /// Runs beside the combinations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<SingleRun>,
}

fn once() -> usize {
    1
}

/// What the runs are compared with.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, { richardson = KEY } or { file = FILE, x = COLUMN, y = COLUMN, column = COLUMN }"
)]
pub enum Reference {
    /// A value of the metric.
    Number(f64),
    /// The refinement's own limit.
    Limit(LimitOf),
    /// A curve against which a column of `series.csv` is held.
    Curve(Curve),
}

/// The limit of the three finest runs of one key (Richardson 1911).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitOf {
    /// Varied key, or name of bundles, with numbers as values.
    pub richardson: String,
    /// Are finer runs those of `larger` or of `smaller` numbers? By default larger for D/Δx, cells
    /// and steps, smaller for the rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finer: Option<Finer>,
    /// Values of other varied keys that pick the refinement, as they stand in `chart.csv`; by default the first refinement.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub with: toml::Table,
    /// Varied keys, or names of bundles, each value of which has a limit of its own: cases of the physics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub each: Vec<String>,
}

/// Which way a key refines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Finer {
    /// Cells, steps: h = 1/value.
    Larger,
    /// Widths, time steps: h = value.
    Smaller,
}

/// Two columns of a CSV file and the column of `series.csv` that should follow them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// CSV file with a header, from the scene's folder.
    pub file: PathBuf,
    /// Its column of times, s.
    pub x: String,
    /// Its column of values.
    pub y: String,
    /// Column of `series.csv`.
    pub column: String,
}

/// A point of somebody else.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Who, with what.
    pub name: String,
    /// CPU time, s.
    pub cost: f64,
    /// Relative error.
    pub error: f64,
    /// Where both stand, and on what machine.
    pub source: String,
}

/// The document as far as the chart goes.
#[derive(Deserialize)]
struct Owned {
    chart: Option<Chart>,
}

impl Chart {
    /// Reads and checks the section.
    ///
    /// # Errors
    /// [`SceneError`] at the key that is missing, unknown, of the wrong type or out of range.
    pub fn read(scene: &CheckedScene) -> Result<Self, SceneError> {
        let chart = Self::of_text(&scene.source)?;
        chart.check_numbers(&scene.source)?;
        chart.check_metrics(scene)?;
        chart.check_reference(&scene.source)?;
        Ok(chart)
    }

    /// Reads the section alone: what a page needs that is made again.
    ///
    /// # Errors
    /// As [`read`](Self::read), as far as the text goes.
    pub fn of_text(source: &SceneSource) -> Result<Self, SceneError> {
        source.refuse_retired(&RETIRED)?;
        source.section::<Owned>()?.chart.ok_or_else(|| {
            source.error(
                "chart",
                "is missing: the scene does not say what to chart",
                "add [chart] with `metric` and [[chart.vary]]; docs/scene.md has an example",
            )
        })
    }

    /// The metrics charted; none where a curve is.
    #[must_use]
    pub fn metrics(&self) -> Vec<&str> {
        self.metric.iter().chain(&self.metrics).map(String::as_str).collect()
    }

    fn check_numbers(&self, source: &SceneSource) -> Result<(), SceneError> {
        for (key, count) in [("chart.repeat", self.repeat), ("chart.threads", self.threads)] {
            if !(1..=1000).contains(&count) {
                let message = format!("is {count}; allowed: 1 to 1000");
                return Err(source.error(key, message, "give a whole number"));
            }
        }
        for (index, point) in self.published.iter().enumerate() {
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

    fn check_metrics(&self, scene: &CheckedScene) -> Result<(), SceneError> {
        let wrong = |key: &str, message: &str, remedy: &str| Err(scene.source.error(key, message, remedy));
        let names = self.metrics();
        let is_curve = matches!(self.reference, Some(Reference::Curve(_)));
        if names.is_empty() && !is_curve {
            let remedy = "add metric = \"...\", one of the scene's [[metrics]], or a reference with a file";
            return wrong("chart", "has no `metric`, so there is nothing to chart", remedy);
        }
        if is_curve && !names.is_empty() {
            let message = "is a curve, so its column is charted, but a metric is named too";
            return wrong("chart.reference", message, "remove chart.metric, or give a number");
        }
        let metrics = &scene.scene.metrics;
        let key = if self.metric.is_some() { "chart.metric" } else { "chart.metrics" };
        // A fluid alone reports these without being asked.
        let is_given = |name: &str| name.starts_with("superficial_velocity_") && self.reference.is_some();
        for name in names.into_iter().filter(|name| !is_given(name)) {
            let Some(metric) = metrics.iter().find(|metric| metric.name == name) else {
                let there: Vec<&str> = metrics.iter().map(|metric| metric.name.as_str()).collect();
                let message = format!("names {name:?}; the scene's metrics are {}", there.join(", "));
                return wrong(key, &message, "name one of them, or add it to [[metrics]]");
            };
            if self.reference.is_none() && metric.reference.is_none() {
                let message =
                    format!("names {name}, which has no reference, and chart.reference is not given");
                return wrong(key, &message, "add reference = NUMBER or { richardson = KEY } to [chart]");
            }
        }
        Ok(())
    }

    fn check_reference(&self, source: &SceneSource) -> Result<(), SceneError> {
        let wrong = |key: &str, message: String, remedy: &str| Err(source.error(key, message, remedy));
        match &self.reference {
            Some(Reference::Number(value)) if !value.is_finite() || self.metrics().len() > 1 => wrong(
                "chart.reference",
                format!("is {value}: one finite number for one metric is allowed"),
                "leave it out where each metric has its own reference",
            ),
            Some(Reference::Limit(limit)) => {
                let named = self.vary.iter().filter(|vary| vary.key.is_some() || vary.name.is_some());
                let headers: Vec<&str> = named.map(Vary::header).collect();
                let key = &limit.richardson;
                if !headers.contains(&key.as_str()) {
                    let message =
                        format!("names {key:?}, which is not varied; varied are {}", headers.join(", "));
                    return wrong("chart.reference.richardson", message, "name a key of [[chart.vary]]");
                }
                let unknown = |key: &&String| !headers.contains(&key.as_str());
                if let Some(key) = limit.with.keys().find(unknown) {
                    return wrong(
                        "chart.reference.with",
                        format!("has the key {key:?}, which is not varied"),
                        "name keys of [[chart.vary]], in quotes: { \"fluid.time.dt\" = 0.01 }",
                    );
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
}
