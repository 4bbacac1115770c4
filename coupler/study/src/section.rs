//! A study as it is written: the section `[chart]` or `[stability]` of a scene, or `[case]` of a file that
//! names scenes. All of them say which runs to make with the same keys (`set`, `vary`, `runs`); what is made
//! of the runs is said by the keys of each kind.

use std::path::PathBuf;

use bedload_program::RunOptions;
use bedload_scene::{Retired, SceneError, SceneSource};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::Kind;
use super::vary::{SingleRun, Vary};

/// Any bound that refuses, whichever is nearest.
pub const ANY: &str = "any";

/// Keys that have another name now.
const RETIRED: [Retired; 3] = [
    Retired::key("chart.seed", "chart.baseline"),
    Retired::dropped(
        "chart.reference.file",
        "chart a [[metrics]] of kind \"series-difference\" with that file, and chart.reference = 0.0",
    ),
    Retired::dropped("chart.reference.finer", "leave it out: cells and steps are finer where they are more"),
];

/// Keys that every kind has.
const COMMON: [&str; 7] = ["title", "about", "source", "set", "threads", "vary", "runs"];

impl Kind {
    /// Keys of the section besides those that every kind has.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Chart => &["metric", "metrics", "reference", "published", "baseline", "repeat", "x"],
            Self::Stability => &["signal", "scale", "bound", "x", "y", "limits"],
            Self::Case => {
                &["name", "scene", "quick", "checks", "figure", "figures", "pictures", "differences"]
            }
        }
    }

    /// Is `key` one of the section?
    fn takes(self, key: &str) -> bool {
        COMMON.contains(&key) || self.keys().contains(&key)
    }
}

/// The section of a study.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Title of page and figure; by default the scene's.
    #[serde(default)]
    pub title: String,
    /// What to know before reading the result.
    #[serde(default)]
    pub about: String,
    /// Where the reference comes from; of a case, the publication that it follows.
    pub source: Option<String>,
    /// Dotted keys that every run sets, before its own.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
    /// Threads of each solver, where `threads` is not varied.
    #[serde(default = "once")]
    #[schemars(range(min = 1))]
    pub threads: usize,
    /// How often each run is made, for the spread of its cost.
    #[serde(default = "once")]
    #[schemars(range(min = 1))]
    pub repeat: usize,
    /// Varied keys: all their combinations are run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vary: Vec<Vary>,
    /// Runs beside the combinations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<SingleRun>,

    /// Metric of the scene whose error is charted.
    pub metric: Option<String>,
    /// Several of them: the largest of their relative errors is charted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub metrics: Vec<String>,
    /// What the runs are compared with; by default the reference of the metric itself.
    pub reference: Option<Reference>,
    /// Points of others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published: Vec<Published>,
    /// Label of the run that has the paper's own setting: costs are given over its cost.
    pub baseline: Option<String>,

    /// Column of `series.csv` that is classified, such as `velocity_z[0]`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub signal: String,
    /// Size of the signal that counts as whole; by default its largest smooth value in the second
    /// half of the run.
    pub scale: Option<f64>,
    /// Name of the bound of `bedload check` that is drawn, or `any`: the one with the least margin.
    #[serde(default = "any")]
    pub bound: String,
    /// Name or key of the varied one along the horizontal axis; of a chart the cost by default.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub x: String,
    /// Name or key of the varied one along the vertical axis.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub y: String,
    /// What no run may leave.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<Limit>,

    /// Name of the case, also of its folder and figure.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Scene of the runs that name none, seen from this file.
    pub scene: Option<PathBuf>,
    /// Is it one of the `--quick` cases?
    #[serde(default)]
    pub quick: bool,
    /// Metrics to compare.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub checks: Vec<Check>,
    /// The figure of the case.
    pub figure: Option<Figure>,
    /// More figures, each with a name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<Figure>,
    /// Pictures of the grains of a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pictures: Vec<Pictures>,
    /// How far apart two runs are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub differences: Vec<Difference>,
}

fn once() -> usize {
    1
}

fn any() -> String {
    ANY.to_owned()
}

/// What the runs are compared with.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number, or { richardson = KEY }")]
pub enum Reference {
    /// A value of the metric.
    Number(f64),
    /// The refinement's own limit.
    Limit(LimitOf),
}

/// The limit of the three finest runs of one key (Richardson 1911).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitOf {
    /// Varied key, or name of bundles, with numbers as values.
    pub richardson: String,
    /// Values of other varied keys that pick the refinement, as they stand in `chart.csv`; by default the
    /// first refinement.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub with: toml::Table,
    /// Varied keys, or names of bundles, each value of which has a limit of its own: cases of the physics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub each: Vec<String>,
}

/// Which way a key refines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finer {
    /// Cells, steps: h = 1/value.
    Larger,
    /// Widths, time steps: h = value.
    Smaller,
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

/// Range of a column outside of which a run is impossible, and so has failed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Column of `series.csv`.
    pub column: String,
    /// Least possible value.
    pub least: Option<f64>,
    /// Largest possible value.
    pub most: Option<f64>,
    /// From this time on, s.
    #[serde(default)]
    pub from: f64,
}

/// A metric to compare, in one run or, with a star at the end of `run`, in several.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Label of the run, or the beginning of labels and a star.
    pub run: String,
    /// Metric.
    pub metric: String,
    /// What it is compared with.
    pub reference: Option<Expected>,
    /// Largest relative error; absolute where the reference is 0.
    pub tolerance: Option<f64>,
    /// Where it comes from.
    pub source: Option<String>,
    /// What the value must do.
    pub kind: Rule,
    /// The error of a miss that is known, as it was measured.
    pub known_error: Option<f64>,
    /// Is the mean over the runs compared, in place of each?
    #[serde(default)]
    pub mean: bool,
}

/// A number, or a formula of the other metrics of the run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Expected {
    /// A number.
    Number(f64),
    /// A formula of the other metrics of the run.
    Formula(String),
}

/// What a value must do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// It must agree within the tolerance.
    Agrees,
    /// It is known to lie outside the tolerance, by `known_error`; it fails when that error changes.
    Misses,
    /// It is only shown beside the reference, and has no tolerance.
    Reported,
}

/// A figure of a case.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// What follows the case's name in the file's.
    #[serde(default)]
    pub name: String,
    /// Its title.
    pub title: String,
    /// Column, or axis, along x.
    pub x: FigureAxis,
    /// Column, or axis, along y.
    pub y: FigureAxis,
    /// Is x logarithmic?
    #[serde(default)]
    pub log_x: bool,
    /// Is y logarithmic?
    #[serde(default)]
    pub log_y: bool,
    /// Points of the runs.
    #[serde(default)]
    pub series: Vec<Series>,
    /// Curves by formula.
    #[serde(default)]
    pub curves: Vec<FormulaCurve>,
    /// Published points, by file.
    #[serde(default)]
    pub points: Vec<Points>,
    /// Curves and points that the runs left as tables.
    #[serde(default)]
    pub tables: Vec<RunTable>,
    /// Upright lines at known bounds.
    #[serde(default)]
    pub marks: Vec<Mark>,
}

/// The grains of a run at some of the times at which it wrote them, coloured by speed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pictures {
    /// What follows the case's name in the file's.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Label of the run.
    pub run: String,
    /// Files of grains, counted from 0 in order of time; by default all.
    pub files: Option<Vec<usize>>,
}

/// Largest difference between two runs, or means over runs, in a column that they left, over the largest
/// value of the second.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    /// Its name.
    pub name: String,
    /// Labels of two runs, or beginnings of labels with a star for the mean over runs; the finer one last.
    pub runs: [String; 2],
    /// File in their folders.
    pub file: PathBuf,
    /// Names of two columns.
    pub x: String,
    /// Column, or axis, along y.
    pub y: String,
    /// Part of x that counts; by default all.
    pub within: Option<[f64; 2]>,
    /// What was published.
    pub reference: Option<f64>,
    /// Where it comes from.
    pub source: Option<String>,
}

/// Two columns of a table in the output folder of a run, or their mean over runs.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunTable {
    /// Its name.
    pub name: String,
    /// Label of the run; or the beginning of labels and a star: the mean over these runs, with its standard
    /// error.
    pub run: String,
    /// File in its folder, such as `profile.csv`.
    pub file: PathBuf,
    /// Names of two columns.
    pub x: String,
    /// Column, or axis, along y.
    pub y: String,
    /// A line instead of points?
    #[serde(default)]
    pub line: bool,
}

/// An axis of a figure.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FigureAxis {
    /// Its label.
    pub label: String,
    /// Metric along the axis; for x without one, `at` of each run.
    pub metric: Option<String>,
    /// Ends of the axis; by default they follow from what is drawn.
    pub range: Option<[f64; 2]>,
}

/// Runs that share a marker.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Its name.
    pub name: String,
    /// As in [`Check`].
    pub run: String,
    /// Metric along y, instead of the axis's.
    pub metric: Option<String>,
    /// Divides the metric.
    #[serde(default = "one")]
    pub over: f64,
    /// Is the mean over the runs at each x drawn, with its standard error, in place of each?
    #[serde(default)]
    pub mean: bool,
}

fn one() -> f64 {
    1.0
}

/// A curve by formula.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FormulaCurve {
    /// Its name.
    pub name: String,
    /// Formula of `x`.
    pub formula: String,
    /// Where it comes from.
    pub source: String,
}

/// Published points.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Points {
    /// Its name.
    pub name: String,
    /// CSV with a header, seen from the case file; lines that begin with # are remarks.
    pub file: PathBuf,
    /// Names of two columns.
    pub x: String,
    /// Column, or axis, along y.
    pub y: String,
    /// Where it comes from.
    pub source: String,
}

/// An upright line at a known bound.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    /// Place along x.
    pub at: f64,
    /// Its name.
    pub name: String,
    /// Where it comes from.
    pub source: String,
}

/// The sections of studies in a file.
#[derive(Deserialize, Serialize)]
struct Document {
    chart: Option<Section>,
    stability: Option<Section>,
    case: Option<Section>,
}

impl Section {
    /// Reads the section of a file; none where the file has none of this kind.
    ///
    /// # Errors
    /// [`SceneError`] at a key that is unknown, retired, of the wrong type or of another kind of study.
    pub fn find(source: &SceneSource, kind: Kind) -> Result<Option<Self>, SceneError> {
        source.refuse_retired(&RETIRED)?;
        // The paths of a case lead to files of its runs, too: they stay as they are written.
        let whole: Document = source.section()?;
        source.refuse_longer_lists(&whole)?;
        let written: toml::Table = toml::from_str(&source.text).unwrap_or_default();
        let mut keys =
            written.get(kind.name()).and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::keys);
        if let Some(key) = keys.find(|key| !kind.takes(key)) {
            let owner = Kind::ALL.iter().find(|kind| kind.takes(key)).map_or("", |kind| kind.name());
            let message = format!("is a key of [{owner}], not of [{}]", kind.name());
            return Err(source.error(&format!("{}.{key}", kind.name()), message, "remove it"));
        }
        Ok(match kind {
            Kind::Chart => whole.chart,
            Kind::Stability => whole.stability,
            Kind::Case => toml::from_str(&source.text).ok().and_then(|document: Document| document.case),
        })
    }

    /// Checks the sections of studies that a scene has: what is wrong there is an error of every command.
    pub fn check_all(options: &RunOptions) -> Result<(), SceneError> {
        let source = SceneSource::read(&options.scene, &options.all_overrides())?;
        Kind::ALL.into_iter().try_for_each(|kind| Self::find(&source, kind).map(drop))
    }

    /// Reads the section of a file that must have one.
    pub fn of_text(source: &SceneSource, kind: Kind) -> Result<Self, SceneError> {
        let name = kind.name();
        let (message, remedy) = match kind {
            Kind::Chart => (
                "is missing: the scene does not say what to chart",
                "add [chart] with `metric` and [[chart.vary]]; docs/scene.md has an example",
            ),
            Kind::Stability => (
                "is missing: the scene says nothing about a sweep",
                "add [stability] with signal, x, y and [[stability.vary]] (docs/scene.md), or take a scene of scenes/stability",
            ),
            Kind::Case => (
                "is missing: the file holds no case",
                "add [case] with name, [[case.runs]] and [[case.checks]], as the files of scenes/validation do",
            ),
        };
        Self::find(source, kind)?.ok_or_else(|| source.error(name, message, remedy))
    }

    /// The JSON Schema of the section of this kind.
    pub fn schema(kind: Kind) -> serde_json::Value {
        let mut schema = bedload_scene::schema::<Self>();
        if let Some(properties) = schema["properties"].as_object_mut() {
            properties.retain(|key, _| kind.takes(key));
        }
        schema
    }

    /// The metrics charted, none where a curve is; or those that a case compares.
    pub fn metrics(&self) -> Vec<&str> {
        let mut all: Vec<&str> = self.metric.iter().chain(&self.metrics).map(String::as_str).collect();
        for check in &self.checks {
            if !all.contains(&check.metric.as_str()) {
                all.push(&check.metric);
            }
        }
        all
    }

    /// All figures of a case.
    pub(super) fn drawn(&self) -> impl Iterator<Item = &Figure> {
        self.figure.iter().chain(&self.figures)
    }

    /// File of a figure or of pictures of a case, by their name.
    pub(super) fn file(&self, name: &str) -> String {
        let dash = if name.is_empty() { "" } else { "-" };
        format!("{}{dash}{name}.svg", self.name)
    }
}

/// Does `pattern`, a label or the beginning of labels and a star, mean `label`?
pub(super) fn matches(pattern: &str, label: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(beginning) => label.starts_with(beginning),
        None => pattern == label,
    }
}
