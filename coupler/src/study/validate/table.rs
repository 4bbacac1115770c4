//! The Markdown page of a validation.

use std::fmt::Write;

use super::case::{Case, Check, Run};
use super::differences::Measured;
use super::runs::Made;
use super::verdict::Row;
use crate::study::folder::cores;
use crate::study::page::or_dash;

/// A figure or pictures, as they were drawn.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    pub(super) title: String,
    /// Name of its file.
    pub(super) file: String,
    pub(super) svg: String,
}

/// Begin of the page.
pub(super) fn heading(quick: bool) -> String {
    let cores = cores();
    let how = if quick { "bedload validate --quick" } else { "bedload validate" };
    format!(
        "# Validation\n\nWritten by `{how}`, version {}, on {cores} cores. A run's cost is its wall time with the \
         others beside it.\nError: (value − reference) / |reference|; where the reference is 0, the difference. \
         Verdict: *agrees* or *differs*\nwithin the tolerance; *reported* is shown and not judged.\n",
        env!("CARGO_PKG_VERSION")
    )
}

/// A case: its table, figure, and commands.
pub(super) fn section(made: &Made<'_>, rows: &[Row], apart: &[Measured], drawings: &[Drawing]) -> String {
    let case = made.case;
    let mut text = format!("\n## {}\n\n`{}`. {}.\n", case.title, case.name, case.source);
    if !case.about.is_empty() {
        let _ = write!(text, "\n{}\n", case.about.trim());
    }
    text += &table(case, rows);
    text += &differences(apart);
    text += &sources(case);
    for drawing in drawings {
        let _ = write!(text, "\n![{}](figures/{})\n", drawing.title, drawing.file);
    }
    let left_out = made.runs().filter(|(_, outcome)| outcome.is_none());
    let left_out: Vec<&str> = left_out.map(|(run, _)| run.label.as_str()).collect();
    if !left_out.is_empty() {
        let _ = write!(text, "\nNot run (not quick): {}.\n", left_out.join(", "));
    }
    text + &commands(made)
}

fn table(case: &Case, rows: &[Row]) -> String {
    let mut text = String::from(
        "\n| case | run | metric | value | reference | error | tolerance | verdict | cost, s |\n\
         |---|---|---|---:|---:|---:|---:|---|---:|\n",
    );
    for row in rows {
        let unit =
            if row.unit.is_empty() || row.unit == "-" { String::new() } else { format!(" {}", row.unit) };
        let note = row.note.as_ref().map_or(String::new(), |note| format!("; {}", note.replace('|', "/")));
        let absolute = row.reference == Some(0.0);
        let _ = writeln!(
            text,
            "| {} | {} | `{}` | {}{unit} | {} | {} | {} | {}{note} | {} |",
            case.name,
            row.label,
            row.check.metric,
            number(row.value),
            number(row.reference),
            deviation(row.error, absolute, true),
            deviation(row.check.tolerance, absolute, false),
            row.verdict.word(),
            or_dash(row.wall_s, |wall| format!("{wall:.1}")),
        );
    }
    text
}

/// Runs against each other.
fn differences(apart: &[Measured]) -> String {
    if apart.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "\n| difference | runs | largest, over the largest value | published | source |\n|---|---|---:|---:|---|\n",
    );
    for Measured { wanted, value } in apart {
        let published = or_dash(wanted.reference, |part| format!("{} %", (1e4 * part).round() / 1e2));
        let source = wanted.source.as_deref().unwrap_or("–");
        let [a, b] = &wanted.runs;
        let _ = writeln!(
            text,
            "| {} | {a}, {b} | {:.2} % | {published} | {source} |",
            wanted.name,
            100.0 * value
        );
    }
    text
}

/// Where the references come from, each once.
fn sources(case: &Case) -> String {
    let mut lines: Vec<String> = Vec::new();
    let of = |check: &Check| Some(format!("- `{}`: {}\n", check.metric, check.source.as_ref()?));
    for line in case.checks.iter().filter_map(of) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    let drawn = case.drawn().flat_map(|figure| {
        let curves = figure.curves.iter().map(|curve| (&curve.name, &curve.source));
        let points = figure.points.iter().map(|points| (&points.name, &points.source));
        curves.chain(points).chain(figure.marks.iter().map(|mark| (&mark.name, &mark.source)))
    });
    for line in drawn.map(|(name, source)| format!("- {name} in the figure: {source}\n")) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    if lines.is_empty() { String::new() } else { format!("\nReferences:\n\n{}", lines.concat()) }
}

/// The command of each run that was made.
fn commands(made: &Made<'_>) -> String {
    let lines = made.runs().filter(|(_, outcome)| outcome.is_some());
    let lines: String = lines.map(|(run, _)| format!("{}\n", command(made.case, run))).collect();
    if lines.is_empty() {
        return lines;
    }
    format!("\n<details><summary>Commands of single runs</summary>\n\n```sh\n{lines}```\n\n</details>\n")
}

/// The command that makes one run again, for a shell.
fn command(case: &Case, run: &Run) -> String {
    let mut text = format!("bedload run {}", case.scene(run).display());
    for value in &run.set {
        let plain = value.chars().all(|c| c.is_ascii_alphanumeric() || "-_.=".contains(c));
        let quoted = if plain { value.clone() } else { format!("'{}'", value.replace('\'', r"'\''")) };
        let _ = write!(text, " --set {quoted}");
    }
    text + &format!(" --out out/{}/{}", case.name, run.label)
}

fn number(value: Option<f64>) -> String {
    let Some(value) = value else { return "–".into() };
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = if value.abs() >= 100.0 {
            1
        } else if value.abs() >= 10.0 {
            2
        } else {
            4
        };
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
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
    use std::path::Path;

    use bedload_output::{MetricValue, RunStatus, Size, Summary};
    use protocol::scene::Geometry;

    use super::super::verdict;
    use super::*;
    use crate::study::runs::Outcome;

    const CASE: &str = r#"
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
        };
        Outcome::Done(Box::new(summary))
    }

    #[test]
    fn the_section_has_a_line_per_check_and_the_commands_of_what_ran() {
        let case = Case::parse(CASE, Path::new("s")).unwrap();
        let outcomes =
            vec![Some(done(19.9)), Some(done(20.3)), Some(Outcome::Failed("it died".into())), None];
        let made = Made { case: &case, outcomes, folder: "out".into() };
        let rows = verdict::rows(&made);
        let text = section(&made, &rows, &[], &[]);
        let expected = [
            "| fall | good | `Re` | 19.90 | 20.00 | -0.50 % | 1 % | agrees | 0.0 |",
            "| fall | bad | `Re` | 20.30 | 20.00 | +1.50 % | 1 % | **DIFFERS** | 0.0 |",
            "| fall | dead | `Re` | – | – | – | 1 % | **NO VALUE**; it died | – |",
            "Not run (not quick): later.",
            "bedload run s/a.toml --set 'a.b=[1, 2]' --set c=d --out out/fall/good",
        ];
        for line in expected {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
        assert_eq!(text.matches("bedload run").count(), 3);
        assert_eq!(rows.iter().filter(|row| row.verdict.is_failure()).count(), 2);
    }

    #[test]
    fn numbers_keep_four_digits_or_so() {
        let written = [0.0, 0.1234567, 19.7412, 862.287, 2e-5].map(|value| number(Some(value)));
        assert_eq!(written, ["0.0000", "0.1235", "19.74", "862.3", "2.000e-5"]);
    }
}
