//! The page of a map: counts, map, where each method ends, every run.

use serde::Serialize;

use super::ends;
use super::map::Frame;
use super::table::{Counts, Row, Table};
use super::verdict::Verdict;
use crate::failure::Failure;
use crate::study::numbers::number;
use crate::study::page::{Cell, Listing, or_dash, render};

/// What `templates/stability.html` shows.
#[derive(Serialize)]
struct Page<'a> {
    title: &'a str,
    about: &'a str,
    map: &'a str,
    counts: Listing,
    limits: Option<Listing>,
    runs: Listing,
}

/// The page.
pub(super) fn page(table: &Table, frame: &Frame<'_>, about: &str, map: &str) -> Result<String, Failure> {
    let counts = counted(&Counts::of(&table.rows));
    let (limits, runs) = (limits(table, frame), runs(table));
    render("stability.html", Page { title: frame.title, about, map, counts, limits, runs })
}

fn counted(counts: &Counts) -> Listing {
    let refused = counts.rightly_refused + counts.stable_refused;
    let line = |name: &str, count: usize, class: &'static str| vec![name.into(), Cell::classed(count, class)];
    let wrong = |name: &str, count: usize| line(name, count, if count == 0 { "good" } else { "bad" });
    let lines = vec![
        line("runs", counts.runs, ""),
        line("refused by check", refused, ""),
        line("right: failed or oscillating, and refused", counts.rightly_refused, "good"),
        line("right: stable, and accepted", counts.rightly_accepted, "good"),
        wrong("wrong: failed, and accepted", counts.failed_accepted),
        wrong("wrong: oscillating, and accepted", counts.oscillating_accepted),
        wrong("wrong: stable, and refused", counts.stable_refused),
    ];
    Listing::new::<&str>(&[], lines)
}

/// Per panel and x: up to which y it fails, and from which on everything is stable. None where y has names.
fn limits(table: &Table, frame: &Frame<'_>) -> Option<Listing> {
    let line = |end: &ends::End| {
        let [bad, good] = [end.last_bad, end.first_good].map(|value| or_dash(value, number).into());
        vec![end.panel.as_str().into(), end.x.as_str().into(), bad, good]
    };
    let name = frame.y.1;
    let (bad, good) = (format!("largest {name} that is not stable"), format!("stable from {name}"));
    let ends = ends::of(table, frame.x.0, frame.y.0);
    Listing::new(&["", frame.x.1, &bad, &good], ends.iter().map(line).collect()).any()
}

fn runs(table: &Table) -> Listing {
    let head =
        table.keys.iter().map(String::as_str).chain(["verdict", "growth", "margin", "refused", "note"]);
    let line = |row: &Row| {
        let value = |value: f64| or_dash(Some(value).filter(|value| !value.is_nan()), number).into();
        let mut cells: Vec<Cell> = row.values.iter().map(|value| value.as_str().into()).collect();
        let wrong = row.refused == (row.verdict == Verdict::Stable);
        let refused = if row.refused { "refused" } else { "accepted" };
        cells.extend([row.verdict.to_string().into(), value(row.growth), value(row.margin)]);
        cells.extend([Cell::classed(refused, if wrong { "bad" } else { "" }), row.note.as_str().into()]);
        cells
    };
    Listing::new(&head.collect::<Vec<_>>(), table.rows.iter().map(line).collect())
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
        let table = Table { keys: vec!["x".into(), "y".into()], columns: Vec::new(), rows };
        let frame = Frame { title: "T", x: (0, "x"), y: (1, "y"), bound: "any" };
        let page = super::page(&table, &frame, "Read this.", "<svg></svg>").unwrap();
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
