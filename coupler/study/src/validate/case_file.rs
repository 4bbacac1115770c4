//! A case file, read and checked.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use super::case::{Case, Check, Figure, Kind, Reference, Run, matches};
use super::formula;
use crate::folder::{cannot, content};
use coupler::failure::Failure;

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
        let pictures = case.pictures.iter().map(|p| (format!("the pictures {:?} are", p.name), &p.run));
        let differences = case.differences.iter().flat_map(|difference| &difference.runs);
        let differences = differences.map(|run| ("a difference is".to_owned(), run));
        let tables = case.drawn().flat_map(|figure| &figure.tables);
        let tables = tables.map(|t| (format!("the table {:?} of the figure is", t.name), &t.run));
        let is_run = |label: &String| case.runs.iter().any(|run| run.label == *label);
        if let Some((what, run)) = pictures.chain(differences).chain(tables).find(|(_, label)| !is_run(label))
        {
            return Err(format!("{what} of no run {run:?}"));
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
            let named = matches!(path.components().next_back(), Some(Component::Normal(_)));
            if part == Component::ParentDir && named {
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
        let kind = match check.kind {
            Kind::Agrees => "agrees",
            Kind::Misses => "misses",
            Kind::Reported => "reported",
        };
        if check.kind == Kind::Reported {
            if check.tolerance.is_some() {
                return Err(format!(
                    "{what} has a tolerance, so it is judged: kind \"agrees\" or \"misses\""
                ));
            }
        } else {
            if check.reference.is_none() {
                return Err(format!("{what} has kind \"{kind}\" but no reference to agree with"));
            }
            if !check.tolerance.is_some_and(|tolerance| tolerance > 0.0 && tolerance.is_finite()) {
                return Err(format!("{what} has kind \"{kind}\" and so needs a tolerance above 0"));
            }
        }
        let beyond = |error: f64| check.tolerance.is_some_and(|tolerance| error.abs() > tolerance);
        if check.known_error.is_some_and(beyond) != (check.kind == Kind::Misses) {
            return Err(format!(
                "{what}: kind \"misses\", and it alone, has a known_error beyond the tolerance, such as -0.045"
            ));
        }
        if let Some(Reference::Formula(text)) = &check.reference {
            formula::evaluate(text, &|_| Some(1.0)).map_err(|error| format!("{what}: {error}"))?;
        }
        Ok(())
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
