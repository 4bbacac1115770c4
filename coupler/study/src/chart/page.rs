//! What the templates of a chart show: its page, and its words for the terminal.

use super::describe::{self, Names};
use super::reference::Compared;
use crate::page::{Value, context};
use crate::section::Section;
use crate::table::Table;

/// What `templates/chart.html` and `chart.txt` show.
pub(super) fn shown(
    chart: &Section,
    table: &Table,
    names: &Names,
    known: &Result<Vec<Compared>, String>,
) -> Value {
    let front = table.front();
    let place = |row: usize| {
        let place = front.iter().position(|other| *other == row);
        place.map_or(String::new(), |place| (place + 1).to_string())
    };
    context! {
        about => chart.about.trim(),
        references => describe::references(chart, names, known),
        timings => timings(chart, table),
        cheapest => describe::cheapest(chart, table, names),
        orders => describe::orders(chart, table, names),
        // Of the varied keys.
        names => names.all(),
        metrics => chart.metrics(),
        runs => table.rows,
        // Of the runs: what each is called, and its number on the front.
        labels => table.rows.iter().map(|row| names.of(row)).collect::<Vec<_>>(),
        places => (0..table.rows.len()).map(place).collect::<Vec<_>>(),
        // Has any run both a cost and an error?
        any => table.rows.iter().any(|row| row.point().is_some()),
        published => chart.published,
    }
}

/// How the costs were taken.
fn timings(chart: &Section, table: &Table) -> String {
    let repeats = table.rows.iter().map(|row| row.repeats).max().unwrap_or(1);
    let threads = chart.threads;
    let mut text = match repeats {
        0 | 1 => "Each run was made once".to_owned(),
        many => format!("Each run was made {many} times; costs are medians, with their span behind"),
    };
    text += &format!(", with {threads} thread{} per solver", if threads == 1 { "" } else { "s" });
    if table.keys.iter().any(|key| key == "threads") {
        text += " where none are given";
    }
    text += ". CPU time is that of fluid, DEM and coupler.";
    match table.rows.iter().map(|row| row.beside).max().unwrap_or(0) {
        0 => text + " The runs were made one after the other.",
        beside => format!(
            "{text} Runs were made up to {} at a time: their costs were taken beside other runs and are no timings; to time \
             them, remove the folder `runs` and chart again without --jobs.",
            beside + 1
        ),
    }
}
