//! A case file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::formula;
use crate::failure::Failure;
use crate::study::folder::{cannot, content};

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
    /// It is only shown beside the reference.
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

impl Case {
    /// Reads and checks a case file.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path).map_err(cannot("read the case", path))?;
        Self::parse(&text, path.parent().unwrap_or(Path::new(""))).map_err(content(path))
    }

    /// A case from its text; `folder` is where its paths start.
    pub(super) fn parse(text: &str, folder: &Path) -> Result<Self, String> {
        let mut case: Self = toml::from_str(text).map_err(|error| error.to_string())?;
        case.folder = folder.to_owned();
        case.check_names()?;
        for check in &case.checks {
            case.check_check(check)?;
        }
        let pictured = case.pictures.iter().find(|p| !case.runs.iter().any(|run| run.label == p.run));
        if let Some(pictures) = pictured {
            return Err(format!("the pictures {:?} are of no run {:?}", pictures.name, pictures.run));
        }
        for label in case.differences.iter().flat_map(|difference| &difference.runs) {
            if !case.runs.iter().any(|run| run.label == *label) {
                return Err(format!("a difference is of no run {label:?}"));
            }
        }
        for table in case.drawn().flat_map(|figure| &figure.tables) {
            if !case.runs.iter().any(|run| run.label == table.run) {
                return Err(format!("the table {:?} of the figure is of no run {:?}", table.name, table.run));
            }
        }
        for curve in case.drawn().flat_map(|figure| &figure.curves) {
            formula::evaluate(&curve.formula, &|name| (name == "x").then_some(1.0))
                .map_err(|what| format!("formula {:?} of a curve: {what}", curve.formula))?;
        }
        Ok(case)
    }

    /// All figures.
    pub(super) fn drawn(&self) -> impl Iterator<Item = &Figure> {
        self.figure.iter().chain(&self.figures)
    }

    /// File of a figure or of pictures, by their name.
    pub(super) fn file(&self, name: &str) -> String {
        let dash = if name.is_empty() { "" } else { "-" };
        format!("{}{dash}{name}.svg", self.name)
    }

    /// Scene of a run, as a path without `..` after a name.
    pub(super) fn scene(&self, run: &Run) -> PathBuf {
        let mut path = PathBuf::new();
        for part in self.folder.join(&run.scene).components() {
            let named = matches!(path.components().next_back(), Some(std::path::Component::Normal(_)));
            if part == std::path::Component::ParentDir && named {
                path.pop();
            } else {
                path.push(part);
            }
        }
        path
    }

    fn check_names(&self) -> Result<(), String> {
        let plain = |name: &str| {
            !name.is_empty()
                && !name.starts_with(['.', '-'])
                && name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c))
        };
        let mut seen = BTreeSet::new();
        for name in std::iter::once(&self.name).chain(self.runs.iter().map(|run| &run.label)) {
            if !plain(name) {
                return Err(format!(
                    "the name {name:?} becomes a folder: use letters, digits, '-', '_' and '.' only"
                ));
            }
        }
        if let Some(run) = self.runs.iter().find(|run| !seen.insert(&run.label)) {
            return Err(format!("two runs have the label {:?}: give each its own", run.label));
        }
        let mut files = BTreeSet::new();
        let named = self.drawn().map(|figure| &figure.name).chain(self.pictures.iter().map(|p| &p.name));
        for name in named {
            if !name.is_empty() && !plain(name) || !files.insert(name) {
                return Err(format!(
                    "the figure's name {name:?} becomes a file: give each its own, of letters, digits, '-', '_' and '.'"
                ));
            }
        }
        Ok(())
    }

    fn check_check(&self, check: &Check) -> Result<(), String> {
        let what = format!("the check of {:?} in run {:?}", check.metric, check.run);
        if !self.runs.iter().any(|run| matches(&check.run, &run.label)) {
            let labels: Vec<&str> = self.runs.iter().map(|run| run.label.as_str()).collect();
            return Err(format!("{what} names no run; there are {}", labels.join(", ")));
        }
        if check.kind == Kind::Agrees {
            if check.reference.is_none() {
                return Err(format!("{what} has kind \"agrees\" but no reference to agree with"));
            }
            if !check.tolerance.is_some_and(|tolerance| tolerance > 0.0 && tolerance.is_finite()) {
                return Err(format!("{what} has kind \"agrees\" and so needs a tolerance above 0"));
            }
        }
        if let Some(Reference::Formula(text)) = &check.reference {
            formula::evaluate(text, &|_| Some(1.0)).map_err(|error| format!("{what}: {error}"))?;
        }
        Ok(())
    }
}

/// Does `pattern`, a label or the beginning of labels and a star, mean `label`?
pub(super) fn matches(pattern: &str, label: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(beginning) => label.starts_with(beginning),
        None => pattern == label,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
name = "fall"
title = "A fall"
source = "nobody, never"
quick = true
[[runs]]
label = "coarse-8"
scene = "../falling-sphere.toml"
set = ["domain.cells=[52, 320]"]
quick = true
at = 8
[[checks]]
run = "coarse-*"
metric = "terminal_reynolds"
reference = 19.6
tolerance = 0.01
kind = "agrees"
[[checks]]
run = "coarse-8"
metric = "e"
reference = "exp(-35/stokes)"
kind = "reported"
"#;

    fn refusal(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from));
        Case::parse(&GOOD.replacen(from, to, 1), Path::new("")).expect_err(to)
    }

    #[test]
    fn a_case_is_read_and_its_scene_found_from_its_folder() {
        let case = Case::parse(GOOD, Path::new("scenes/validation")).unwrap();
        assert_eq!(case.scene(&case.runs[0]), Path::new("scenes/falling-sphere.toml"));
        assert_eq!(case.runs[0].at, Some(8.0));
        assert_eq!(case.checks[1].reference, Some(Reference::Formula("exp(-35/stokes)".into())));
        let above = Case::parse(GOOD, Path::new("..")).unwrap();
        assert_eq!(above.scene(&above.runs[0]), Path::new("../../falling-sphere.toml"));
    }

    #[test]
    fn a_wrong_case_is_refused_with_what_is_wrong() {
        assert!(refusal("tolerance = 0.01", "").contains("needs a tolerance"));
        assert!(refusal("reference = 19.6", "").contains("no reference"));
        assert!(refusal("coarse-*", "fine-*").contains("there are coarse-8"));
        assert!(refusal("\"coarse-8\"", "\"../../x\"").contains("becomes a folder"));
        assert!(refusal("exp(-35/stokes)", "exp(-35/").contains("formula"));
        assert!(refusal("quick = true", "quik = true").contains("quik"));
        let axes = "title = \"\"\nx = { label = \"\" }\ny = { label = \"\" }\n";
        let figure = format!("[figure]\n{axes}[[figures]]\n{axes}");
        let twice = Case::parse(&format!("{GOOD}{figure}"), Path::new("")).expect_err("two without a name");
        assert!(twice.contains("give each its own"), "{twice}");
        let pictures = "[[pictures]]\nname = \"grains\"\ntitle = \"\"\nrun = \"fine-8\"\n";
        let of_none = Case::parse(&format!("{GOOD}{pictures}"), Path::new("")).expect_err("no such run");
        assert!(of_none.contains("of no run"), "{of_none}");
    }
}
