//! What a case file holds.

use std::path::PathBuf;

use serde::Deserialize;

/// A case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Case {
    /// Name, also of its folder and figure.
    pub(super) name: String,
    pub(super) title: String,
    /// Publication that the case follows.
    pub(super) source: String,
    /// What to know before reading the numbers.
    #[serde(default)]
    pub(super) about: String,
    /// Is it one of the `--quick` cases?
    #[serde(default)]
    pub(super) quick: bool,
    pub(super) runs: Vec<Run>,
    pub(super) checks: Vec<Check>,
    pub(super) figure: Option<Figure>,
    /// More figures, each with a name.
    #[serde(default)]
    pub(super) figures: Vec<Figure>,
    /// Pictures of the grains of a run.
    #[serde(default)]
    pub(super) pictures: Vec<Pictures>,
    /// How far apart two runs are.
    #[serde(default)]
    pub(super) differences: Vec<Difference>,
    /// Folder of the case file: paths in it start there.
    #[serde(skip)]
    pub(super) folder: PathBuf,
}

/// One run of a scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Run {
    /// Name of the run within the case, also of its folder.
    pub(super) label: String,
    /// Scene file, seen from the case file.
    pub(super) scene: PathBuf,
    /// Overrides of the scene, as `--set` takes them.
    #[serde(default)]
    pub(super) set: Vec<String>,
    /// Part of `--quick`?
    #[serde(default)]
    pub(super) quick: bool,
    /// Abscissa in a figure whose `x` is not a metric.
    pub(super) at: Option<f64>,
}

/// A metric to compare, in one run or, with a star at the end of `run`, in several.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Check {
    pub(super) run: String,
    pub(super) metric: String,
    pub(super) reference: Option<Reference>,
    /// Largest relative error; absolute where the reference is 0.
    pub(super) tolerance: Option<f64>,
    pub(super) source: Option<String>,
    pub(super) kind: Kind,
    /// The error of a miss that is known, as it was measured.
    pub(super) known_error: Option<f64>,
}

/// A number, or a formula of the other metrics of the run.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub(super) enum Reference {
    Number(f64),
    Formula(String),
}

/// Is the value judged?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Kind {
    /// It must agree within the tolerance.
    Agrees,
    /// It is known to lie outside the tolerance, by `known_error`; it fails when that error changes.
    Misses,
    /// It is only shown beside the reference, and has no tolerance.
    Reported,
}

/// A figure of a case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Figure {
    /// What follows the case's name in the file's.
    #[serde(default)]
    pub(super) name: String,
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    #[serde(default)]
    pub(super) log_x: bool,
    #[serde(default)]
    pub(super) log_y: bool,
    #[serde(default)]
    pub(super) series: Vec<Series>,
    /// Curves by formula.
    #[serde(default)]
    pub(super) curves: Vec<Curve>,
    /// Published points, by file.
    #[serde(default)]
    pub(super) points: Vec<Points>,
    /// Curves and points that the runs left as tables.
    #[serde(default)]
    pub(super) tables: Vec<Table>,
    /// Upright lines at known bounds.
    #[serde(default)]
    pub(super) marks: Vec<Mark>,
}

/// The grains of a run at some of the times at which it wrote them, coloured by speed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Pictures {
    /// What follows the case's name in the file's.
    pub(super) name: String,
    pub(super) title: String,
    /// Label of the run.
    pub(super) run: String,
    /// Files of grains, counted from 0 in order of time; by default all.
    pub(super) files: Option<Vec<usize>>,
}

/// Largest difference between two runs in a column that both left, over the largest value of the second.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Difference {
    pub(super) name: String,
    /// Labels of two runs, the finer one last.
    pub(super) runs: [String; 2],
    /// File in their folders.
    pub(super) file: PathBuf,
    /// Names of two columns.
    pub(super) x: String,
    pub(super) y: String,
    /// Part of x that counts; by default all.
    pub(super) within: Option<[f64; 2]>,
    /// What was published.
    pub(super) reference: Option<f64>,
    pub(super) source: Option<String>,
}

/// Two columns of a table in the output folder of a run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Table {
    pub(super) name: String,
    /// Label of the run.
    pub(super) run: String,
    /// File in its folder, such as `profile.csv`.
    pub(super) file: PathBuf,
    /// Names of two columns.
    pub(super) x: String,
    pub(super) y: String,
    /// A line instead of points?
    #[serde(default)]
    pub(super) line: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Axis {
    pub(super) label: String,
    /// Metric along the axis; for x without one, `at` of each run.
    pub(super) metric: Option<String>,
    /// Ends of the axis; by default they follow from what is drawn.
    pub(super) range: Option<[f64; 2]>,
}

/// Runs that share a marker.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Series {
    pub(super) name: String,
    /// As in [`Check`].
    pub(super) run: String,
    /// Metric along y, instead of the axis's.
    pub(super) metric: Option<String>,
    /// Divides the metric.
    #[serde(default = "one")]
    pub(super) over: f64,
}

fn one() -> f64 {
    1.0
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Curve {
    pub(super) name: String,
    /// Formula of `x`.
    pub(super) formula: String,
    pub(super) source: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Points {
    pub(super) name: String,
    /// CSV with a header, seen from the case file; lines that begin with # are remarks.
    pub(super) file: PathBuf,
    /// Names of two columns.
    pub(super) x: String,
    pub(super) y: String,
    pub(super) source: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mark {
    pub(super) at: f64,
    pub(super) name: String,
    pub(super) source: String,
}

/// Does `pattern`, a label or the beginning of labels and a star, mean `label`?
pub(super) fn matches(pattern: &str, label: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(beginning) => label.starts_with(beginning),
        None => pattern == label,
    }
}
