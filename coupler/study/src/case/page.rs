//! The Markdown page of the cases: what `templates/validation.md` shows.

use serde::Serialize;

use super::compare::Line as Compared;
use super::differences::Measured;
use crate::folder::cores;
use crate::make::Made;
use crate::page::{Value, context, or_dash, render};
use crate::section::Section;
use crate::sweep::Point;
use coupler::failure::Failure;

/// A figure or pictures, as they were drawn.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Drawing {
    pub(super) title: String,
    pub(super) file: String,
    #[serde(skip)]
    pub(super) svg: String,
}

pub(super) fn page(quick: bool, cases: &[Value]) -> Result<String, Failure> {
    let command = if quick { "bedload validate --quick" } else { "bedload validate" };
    let version = env!("CARGO_PKG_VERSION");
    render("validation.md", context! { command, version, cores => cores(), cases })
}

/// A case as the page shows it.
pub(super) fn case(
    made: &Made<'_>,
    rows: &[Compared<'_>],
    apart: &[Measured<'_>],
    drawings: Vec<Drawing>,
) -> Value {
    let section = &made.study.section;
    let is_made = |label: &&String| made.study.points.iter().any(|point| point.label == **label);
    let labels = section.runs.iter().map(|run| &run.label);
    context! {
        drawings,
        name => section.name,
        title => section.title,
        source => section.source.as_deref().unwrap_or(""),
        about => section.about.trim(),
        rows => rows.iter().map(line).collect::<Vec<_>>(),
        apart => apart.iter().map(difference).collect::<Vec<_>>(),
        references => references(section),
        left_out => labels.filter(|label| !is_made(label)).collect::<Vec<_>>(),
        commands =>
            made.study.points.iter().map(|point| command(&section.name, point)).collect::<Vec<_>>(),
    }
}

/// A check of a run.
fn line(row: &Compared<'_>) -> Value {
    let absolute = row.reference == Some(0.0);
    let has_unit = !(row.unit.is_empty() || row.unit == "-");
    context! {
        label => row.label,
        metric => row.check.metric,
        value => row.value,
        standard_error =>
            row.standard_error.map_or(String::new(), |error| format!(" ± {}", two_digits(error))),
        unit => if has_unit { format!(" {}", row.unit) } else { String::new() },
        reference => row.reference,
        error => deviation(row.error, absolute, true),
        tolerance => deviation(row.check.tolerance, absolute, false),
        comparison => row.comparison.word(),
        note => row.note.as_ref().map_or(String::new(), |note| format!("; {}", note.replace('|', "/"))),
        cost => or_dash(row.wall_s, |wall| format!("{wall:.1}")),
    }
}

/// Runs against each other.
fn difference(measured: &Measured<'_>) -> Value {
    let Measured { wanted, value } = *measured;
    let published = or_dash(wanted.reference, |part| format!("{} %", (1e4 * part).round() / 1e2));
    context! { name => wanted.name, runs => wanted.runs, value, published, source => wanted.source }
}

/// Where the references come from, each once.
fn references(case: &Section) -> Vec<String> {
    let checks = case.checks.iter().filter_map(|c| Some(format!("`{}`: {}", c.metric, c.source.as_ref()?)));
    let drawn = case.drawn().flat_map(|figure| {
        let curves = figure.curves.iter().map(|curve| (&curve.name, &curve.source));
        let points = figure.points.iter().map(|points| (&points.name, &points.source));
        curves.chain(points).chain(figure.marks.iter().map(|mark| (&mark.name, &mark.source)))
    });
    let mut lines: Vec<String> = Vec::new();
    for line in checks.chain(drawn.map(|(name, source)| format!("{name} in the figure: {source}"))) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    lines
}

/// The command that makes one run again, for a shell.
fn command(case: &str, run: &Point) -> String {
    let mut text = format!("bedload run {}", run.scene.display());
    for value in &run.set {
        let plain = value.chars().all(|c| c.is_ascii_alphanumeric() || "-_.=".contains(c));
        let quoted = if plain { value.clone() } else { format!("'{}'", value.replace('\'', r"'\''")) };
        text += &format!(" --set {quoted}");
    }
    text + &format!(" --out out/{case}/{}", run.label)
}

/// To two digits, as an error is written.
fn two_digits(value: f64) -> String {
    let places = if value > 0.0 { (1.0 - value.log10().floor()).max(0.0) as usize } else { 0 };
    format!("{value:.places$}")
}

fn deviation(value: Option<f64>, absolute: bool, signed: bool) -> String {
    match (value, absolute, signed) {
        (None, ..) => "–".into(),
        (Some(value), true, true) => format!("{value:+.3}"),
        (Some(value), true, false) => format!("{value}"),
        (Some(value), false, true) => format!("{:+.2} %", 100.0 * value),
        // A tolerance as it was written, without the last bits of the multiplication.
        (Some(value), false, false) => format!("{} %", (1e4 * value).round() / 1e2),
    }
}
#[cfg(test)]
mod tests {
    use bedload_output::{MetricValue, RunStatus, Size, Summary};
    use bedload_scene::{Geometry, SceneSource};

    use super::super::compare;
    use super::*;
    use crate::kind::Kind;
    use crate::runs::Outcome;
    use crate::study::Study;
    use crate::vary::SingleRun;

    const CASE: &str = r#"
[case]
name = "fall"
title = "A fall"
source = "Nobody, never"
runs = [
  { label = "good", scene = "a.toml", set = ["a.b=[1, 2]", "c=d"] },
  { label = "bad", scene = "a.toml" },
  { label = "dead", scene = "a.toml" },
  { label = "later", scene = "a.toml" },
]
checks = [{ run = "*", metric = "Re", reference = 20.0, tolerance = 0.01, source = "a book", kind = "agrees" }]
"#;

    fn done(reynolds: f64) -> Outcome {
        let summary = Summary {
            status: RunStatus::Completed,
            error: None,
            version: String::new(),
            scene_sha256: String::new(),
            time: Default::default(),
            size: Size { cells: 1, grains: 1, geometry: Geometry::Axisymmetric },
            cost: Default::default(),
            metrics: [("Re".to_owned(), MetricValue::measured(reynolds, "-", None, None))].into(),
            verification: None,
        };
        Outcome::Done(Box::new(summary))
    }

    #[test]
    fn the_section_has_a_line_per_check_and_the_commands_of_what_ran() {
        let source = SceneSource { file: "case.toml".into(), text: CASE.to_owned() };
        let section = Section::of_text(&source, Kind::Case).unwrap();
        let point = |run: &SingleRun| Point {
            label: run.label.clone(),
            values: Vec::new(),
            set: run.set.settings("").iter().map(ToString::to_string).collect(),
            threads: None,
            scene: "s/a.toml".into(),
            at: None,
        };
        let points = section.runs[..3].iter().map(point).collect();
        let (metrics, columns) = (Vec::new(), Vec::new());
        let study = Study { kind: Kind::Case, source, section, metrics, columns, points };
        let outcomes = vec![done(19.9), done(20.3), Outcome::Failed("it died".into())];
        let made = Made::of(&study, outcomes);
        let rows = compare::lines(&made);
        let text = page(false, &[case(&made, &rows, &[], vec![])]).unwrap();
        let expected = [
            "| fall | good | `Re` | 19.90 | 20.00 | -0.50 % | 1 % | agrees | 0.0 |",
            "| fall | bad | `Re` | 20.30 | 20.00 | +1.50 % | 1 % | **DIFFERS** | 0.0 |",
            "| fall | dead | `Re` | – | – | – | 1 % | **NO VALUE**; it died | – |",
            "Not run (not quick): later.",
            "bedload run s/a.toml --set 'a.b=[1, 2]' --set 'c=\"d\"' --out out/fall/good",
        ];
        for line in expected {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
        assert_eq!(text.matches("bedload run").count(), 3);
        assert_eq!(rows.iter().filter(|row| row.comparison.is_failure()).count(), 2);
        let mut section = study.section.clone();
        section.checks[0].mean = true;
        let points = study.points[..2].to_vec();
        let study = Study { section, points, ..study.clone() };
        let made = Made::of(&study, vec![done(19.9), done(20.3)]);
        let rows = compare::lines(&made);
        let mean = page(false, &[case(&made, &rows, &[], vec![])]).unwrap();
        let line = "| fall | * | `Re` | 20.10 ± 0.20 | 20.00 | +0.50 % | 1 % | agrees | 0.0 |";
        assert!(mean.contains(line) && rows.len() == 1, "{line} is not in\n{mean}");
    }
}
