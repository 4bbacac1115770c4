//! The `[case]` section of a file.

use std::cmp::Ordering::Less;
use std::collections::BTreeSet;

use bedload_scene::{SceneError, SceneSource};

use super::formula;
use crate::section::{Check, Expected, Rule, Section, matches};
use crate::sweep::is_folder_name;

pub(crate) fn check(section: &Section, source: &SceneSource) -> Result<(), SceneError> {
    let wrong = |key: &str, message: String, remedy: &str| Err(source.error(key, message, remedy));
    if section.title.is_empty() || section.source.is_none() || section.checks.is_empty() {
        let remedy = "give title, source (the publication) and [[case.checks]]";
        return wrong("case", "lacks its title, its source or its checks".to_owned(), remedy);
    }
    if !section.vary.is_empty() {
        let remedy = "list [[case.runs]], or make the scene a [chart]";
        return wrong("case.vary", "has no meaning: a case compares single runs".to_owned(), remedy);
    }
    names(section, source)?;
    for (number, check) in section.checks.iter().enumerate() {
        let remedy = "mend the check: run, metric, kind, reference, tolerance, known_error";
        let place = format!("case.checks[{number}]");
        one(section, check).or_else(|what| wrong(&place, what, remedy))?;
    }
    let is_run = |label: &String| section.runs.iter().any(|run| run.label == *label);
    if let Some(pictures) = section.pictures.iter().find(|pictures| !is_run(&pictures.run)) {
        let message = format!("is of no run {:?}", pictures.run);
        return wrong("case.pictures", message, "name the label of a run");
    }
    let differences = section.differences.iter().flat_map(|difference| &difference.runs);
    let differences = differences.map(|run| ("case.differences", run));
    let tables = section.drawn().flat_map(|figure| &figure.tables).map(|table| ("case.figures", &table.run));
    let series = section.drawn().flat_map(|figure| &figure.series);
    let series = series.map(|series| ("case.figures", &series.run));
    if let Some((key, run)) = differences.chain(tables).chain(series).find(|(_, run)| !is_meant(section, run))
    {
        let remedy = "name the label of a run, or the beginning of labels and a star";
        return wrong(key, format!("is of no run {run:?}"), remedy);
    }
    for difference in &section.differences {
        if let Some([from, to]) = difference.within.filter(|[from, to]| from.partial_cmp(to) != Some(Less)) {
            let what = format!("of {:?} counts within {from} to {to}", difference.name);
            return wrong("case.differences", what, "give the smaller one first");
        }
    }
    for figure in section.drawn() {
        for (name, axis, log) in [("x", &figure.x, figure.log_x), ("y", &figure.y, figure.log_y)] {
            let is_range = |[low, high]: [f64; 2]| low < high && (low > 0.0 || !log) && high.is_finite();
            if let Some([low, high]) = axis.range.filter(|range| !is_range(*range)) {
                let what = format!("of {:?} has the range {low} to {high} along {name}", figure.title);
                let remedy = "give the smaller one first, above 0 where it is logarithmic";
                return wrong("case.figures", what, remedy);
            }
        }
        let is_over = |over: f64| over != 0.0 && over.is_finite();
        if let Some(series) = figure.series.iter().find(|series| !is_over(series.over)) {
            let what = format!("of {:?} divides {:?} by {}", figure.title, series.name, series.over);
            return wrong("case.figures", what, "give a finite number other than 0");
        }
    }
    for curve in section.drawn().flat_map(|figure| &figure.curves) {
        let value = formula::evaluate(&curve.formula, &|name| (name == "x").then_some(1.0));
        value.map(|_| ()).or_else(|what| wrong("case.figure", what, "mend the formula of the curve"))?;
    }
    Ok(())
}

fn is_meant(section: &Section, pattern: &str) -> bool {
    section.runs.iter().any(|run| matches(pattern, &run.label))
}

/// Names that become folders and files.
fn names(section: &Section, source: &SceneSource) -> Result<(), SceneError> {
    let mut labels = BTreeSet::new();
    let runs = section.runs.iter().map(|run| ("case.runs", &run.label));
    for (key, name) in std::iter::once(("case.name", &section.name)).chain(runs) {
        if !is_folder_name(name) || (key == "case.runs" && !labels.insert(name)) {
            let remedy = "give each run a label of its own, of letters, digits, '-', '_' and '.'";
            return Err(source.error(key, format!("has the name {name:?}, which becomes a folder"), remedy));
        }
    }
    let mut files = BTreeSet::new();
    let named = section.drawn().map(|figure| &figure.name).chain(section.pictures.iter().map(|p| &p.name));
    for name in named {
        if !name.is_empty() && !is_folder_name(name) || !files.insert(name) {
            let (key, remedy) = ("case.figures", "give each its own, of letters, digits, '-', '_' and '.'");
            return Err(source.error(key, format!("has the name {name:?}, which becomes a file"), remedy));
        }
    }
    Ok(())
}

fn one(section: &Section, check: &Check) -> Result<(), String> {
    let what = format!("the check of {:?} in run {:?}", check.metric, check.run);
    if !is_meant(section, &check.run) {
        let labels: Vec<&str> = section.runs.iter().map(|run| run.label.as_str()).collect();
        return Err(format!("{what} names no run; there are {}", labels.join(", ")));
    }
    let kind = match check.kind {
        Rule::Agrees => "agrees",
        Rule::Misses => "misses",
        Rule::Reported => "reported",
    };
    if check.kind == Rule::Reported {
        if check.tolerance.is_some() {
            return Err(format!("{what} has a tolerance, so it is compared: kind \"agrees\" or \"misses\""));
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
    if check.known_error.is_some_and(beyond) != (check.kind == Rule::Misses) {
        return Err(format!(
            "{what}: kind \"misses\", and it alone, has a known_error beyond the tolerance, such as -0.045"
        ));
    }
    if let Some(Expected::Formula(text)) = &check.reference {
        formula::evaluate(text, &|_| Some(1.0)).map_err(|error| format!("{what}: {error}"))?;
    }
    Ok(())
}
