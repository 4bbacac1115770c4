//! The page of a chart: what its template shows.

use serde::Serialize;

use super::config::{Chart, Published};
use super::describe::{self, Names, rounded};
use super::reference::Compared;
use super::table::{Row, Spread, Table};
use crate::failure::Failure;
use crate::study::numbers::{number, percent};
use crate::study::page::{Cell, Listing, or_dash, render};

/// All that a page tells of.
pub(super) struct Findings<'a> {
    pub(super) title: &'a str,
    pub(super) source: &'a str,
    pub(super) chart: &'a Chart,
    pub(super) table: &'a Table,
    pub(super) names: &'a Names,
    pub(super) known: &'a Result<Vec<Compared>, String>,
    pub(super) figure: Option<&'a str>,
}

/// What `templates/chart.html` shows.
#[derive(Serialize)]
struct Page<'a> {
    title: &'a str,
    source: &'a str,
    about: &'a str,
    references: Vec<String>,
    timings: String,
    figure: Option<&'a str>,
    cheapest: Option<Listing>,
    orders: Option<Listing>,
    runs: Listing,
    published: Option<Listing>,
}

/// The whole page.
pub(super) fn page(of: &Findings<'_>) -> Result<String, Failure> {
    let Findings { title, source, chart, table, names, known, figure } = *of;
    render(
        "chart.html",
        Page {
            title,
            source,
            about: chart.about.trim(),
            references: describe::references(chart, names, known),
            timings: timings(chart, table),
            figure,
            cheapest: cheapest(of),
            orders: orders(of),
            runs: runs(of),
            published: published(chart),
        },
    )
}

/// How the costs were taken.
pub(super) fn timings(chart: &Chart, table: &Table) -> String {
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

fn cheapest(of: &Findings<'_>) -> Option<Listing> {
    let Findings { chart, table, names, .. } = of;
    let row = |cheapest: &describe::Cheapest| {
        let found = cheapest.row.map(|row| &table.rows[row]);
        let (cost, error) = found.and_then(Row::point).unzip();
        vec![
            percent(cheapest.tolerance).into(),
            found.map_or("no run".to_owned(), |row| names.of(row)).into(),
            or_dash(error, percent).into(),
            or_dash(cost, |cost| format!("{} s", number(cost))).into(),
            or_dash(cheapest.over_baseline, |ratio| format!("{} ×", number(ratio))).into(),
        ]
    };
    let head = ["error within", "cheapest setting", "its error", "CPU time", "over the paper's own setting"];
    let any = table.rows.iter().any(|row| row.point().is_some());
    any.then(|| Listing::new(&head, describe::cheapest(chart, table).iter().map(row).collect()))
}

fn orders(of: &Findings<'_>) -> Option<Listing> {
    let orders = describe::orders(of.chart, of.table, of.names);
    let row = |order: &describe::Order| {
        let limit = order.of_values.as_ref();
        let seen = limit.and_then(|limit| limit.order);
        vec![
            order.key.as_str().into(),
            order.with.as_str().into(),
            order.runs.to_string().into(),
            or_dash(order.of_errors, |p| number(rounded(p))).into(),
            seen.map_or("none seen".into(), |p| number(rounded(p))).into(),
            or_dash(limit, |limit| number(limit.value)).into(),
            or_dash(limit, |limit| percent(limit.relative_uncertainty())).into(),
        ]
    };
    let head = ["key", "with", "runs", "order of the errors", "order of the values", "limit", "uncertainty"];
    Listing::new(&head, orders.iter().map(row).collect()).any()
}

fn runs(of: &Findings<'_>) -> Listing {
    let Findings { chart, table, names, .. } = of;
    let mut head: Vec<&str> = names.all().iter().map(String::as_str).collect();
    head.extend(["CPU time", "wall time"]);
    head.extend(chart.metrics());
    head.extend(["error", "front", "remark"]);
    let front = table.front();
    let row = |(number_of, row): (usize, &Row)| {
        let shown = |value: &String| if value.is_empty() { "default" } else { value }.into();
        let mut cells: Vec<Cell> = row.values.iter().map(shown).collect();
        cells.extend([spread(row.cpu).into(), spread(row.wall).into()]);
        cells.extend(row.measured.iter().map(|value| or_dash(*value, number).into()));
        cells.push(or_dash(row.error, percent).into());
        let place = front.iter().position(|other| *other == number_of);
        cells.push(Cell::classed(place.map_or(String::new(), |place| (place + 1).to_string()), "strong"));
        cells.push(row.note.as_str().into());
        cells
    };
    Listing::new(&head, table.rows.iter().enumerate().map(row).collect())
}

fn spread(spread: Option<Spread>) -> String {
    or_dash(spread, |spread| {
        let median = format!("{} s", number(spread.median));
        if spread.min == spread.max {
            return median;
        }
        format!("{median} ({}–{})", number(spread.min), number(spread.max))
    })
}

fn published(chart: &Chart) -> Option<Listing> {
    let row = |point: &Published| {
        let cost = format!("{} s", number(point.cost));
        vec![
            point.name.as_str().into(),
            cost.into(),
            percent(point.error).into(),
            point.source.as_str().into(),
        ]
    };
    Listing::new(&["who", "CPU time", "error", "source"], chart.published.iter().map(row).collect()).any()
}
