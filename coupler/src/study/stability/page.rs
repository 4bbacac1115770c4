//! The page of a sweep: counts, map, where each method ends, every run. Self-contained.

use super::map::{self, Frame};
use super::table::{Counts, Row, Table};
use super::verdict::Verdict;
use crate::study::report::page::{self, escape, number};
use crate::study::report::tables;

/// The page.
pub(super) fn page(table: &Table, frame: &Frame<'_>, about: &str) -> String {
    let counts = Counts::of(&table.rows);
    let about = if about.is_empty() { String::new() } else { format!("<p>{}</p>\n", escape(about)) };
    let body = format!(
        "{about}\
         <section id=\"map\">\n<h2>Map</h2>\n<figure class=\"wide\">{map}</figure>\n\
         <p class=\"note\">Ticks are the sampled values. Point at a marker to read its run.</p>\n</section>\n\
         <section id=\"counts\">\n<h2>Verdicts and refusals</h2>\n{counts}</section>\n\
         <section id=\"limits\">\n<h2>Where each method ends</h2>\n{limits}</section>\n\
         <section id=\"runs\">\n<h2>Runs</h2>\n<details><summary>All {runs} runs</summary>\n{rows}</details>\n</section>\n",
        map = map::draw(table, frame),
        runs = counts.runs,
        counts = counted(&counts),
        limits = limits(table, frame),
        rows = rows(table),
    );
    page::frame(frame.title, &body)
}

fn counted(counts: &Counts) -> String {
    let refused = counts.rightly_refused + counts.stable_refused;
    let line = |name: &str, count: usize, good: bool| {
        let class = if good || count == 0 { "good" } else { "bad" };
        vec![escape(name), format!("<span class=\"{class}\">{count}</span>")]
    };
    let lines = [
        vec!["runs".to_owned(), counts.runs.to_string()],
        vec![escape("refused by check"), refused.to_string()],
        line("right: failed or oscillating, and refused", counts.rightly_refused, true),
        line("right: stable, and accepted", counts.rightly_accepted, true),
        line("wrong: failed, and accepted", counts.failed_accepted, false),
        line("wrong: oscillating, and accepted", counts.oscillating_accepted, false),
        line("wrong: stable, and refused", counts.stable_refused, false),
    ];
    tables::table(&[], &lines)
}

/// Per panel and x: up to which y it fails, and from which on everything is stable.
fn limits(table: &Table, frame: &Frame<'_>) -> String {
    let ends = super::ends::of(table, frame.x.0, frame.y.0);
    let lines: Vec<Vec<String>> = ends
        .iter()
        .map(|end| {
            let value = |value: Option<f64>| value.map_or("–".to_owned(), number);
            vec![escape(&end.panel), escape(&end.x), value(end.last_bad), value(end.first_good)]
        })
        .collect();
    if lines.is_empty() {
        return "<p class=\"note\">The vertical axis has names, no numbers.</p>\n".to_owned();
    }
    let name = frame.y.1;
    let (bad, good) = (format!("largest {name} that is not stable"), format!("stable from {name}"));
    tables::table(&["", frame.x.1, &bad, &good], &lines)
}

fn rows(table: &Table) -> String {
    let head =
        table.keys.iter().map(String::as_str).chain(["verdict", "growth", "margin", "refused", "note"]);
    let head: Vec<&str> = head.collect();
    let line = |row: &Row| {
        let value = |value: f64| if value.is_nan() { "–".to_owned() } else { number(value) };
        let mut cells: Vec<String> = row.values.iter().map(|value| escape(value)).collect();
        cells.push(row.verdict.to_string());
        let wrong = row.refused == (row.verdict == Verdict::Stable);
        let refused = if row.refused { "refused" } else { "accepted" };
        let class = if wrong { " class=\"bad\"" } else { "" };
        cells.extend([value(row.growth), value(row.margin), format!("<span{class}>{refused}</span>")]);
        cells.push(escape(&row.note));
        cells
    };
    tables::table(&head, &table.rows.iter().map(line).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_whole_by_itself_and_says_what_is_wrong() {
        let row = |verdict, refused| Row {
            values: ["0.1", "<b>"].map(str::to_owned).to_vec(),
            verdict,
            growth: f64::NAN,
            margin: 0.5,
            label: "run".into(),
            note: "a \"note\"".into(),
            refused,
        };
        let rows = vec![row(Verdict::Failed, false), row(Verdict::Stable, true)];
        let table = Table { keys: vec!["x".into(), "y".into()], rows };
        let frame = Frame { title: "T", x: (0, "x"), y: (1, "y"), bound: "any" };
        let page = super::page(&table, &frame, "Read this.");
        assert!(page.contains("Read this.") && page.contains("<svg") && page.contains("&lt;b&gt;"));
        let wrong = page.split("wrong: failed, and accepted").nth(1).expect("the line of what is wrong");
        assert!(wrong.split("</tr>").next().is_some_and(|line| line.contains("class=\"bad\">1<")), "{page}");
        for outside in ["http://", "https://", "<script", "<link rel=\"stylesheet\""] {
            assert_eq!(
                page.replace("http://www.w3.org/2000/svg", "").matches(outside).count(),
                0,
                "{outside}"
            );
        }
        assert_eq!(page.matches("<section").count(), page.matches("</section>").count());
    }
}
