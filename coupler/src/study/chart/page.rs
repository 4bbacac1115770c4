//! The page of a chart: `chart.html`, which needs nothing but itself.

use super::config::Chart;
use super::describe::{self, Names, percent, rounded};
use super::reference::Known;
use super::table::{Row, Spread, Table};
use crate::study::report::page::{escape, frame, number};
use crate::study::report::tables::table as html_table;

/// All that a page shows.
pub(super) struct Sheet<'a> {
    pub(super) title: &'a str,
    pub(super) source: &'a str,
    pub(super) chart: &'a Chart,
    pub(super) table: &'a Table,
    pub(super) names: &'a Names,
    pub(super) known: &'a Result<Vec<Known>, String>,
    pub(super) figure: Option<&'a str>,
}

/// The whole page.
pub(super) fn page(sheet: &Sheet<'_>) -> String {
    let Sheet { chart, table, names, .. } = sheet;
    let mut body = String::new();
    if !sheet.source.is_empty() {
        body += &format!("<p class=\"note\">After {}</p>\n", escape(sheet.source));
    }
    if !chart.about.trim().is_empty() {
        body += &format!("<p>{}</p>\n", escape(chart.about.trim()));
    }
    for line in describe::references(chart, names, sheet.known) {
        body += &format!("<p>{}</p>\n", escape(&line));
    }
    body += &format!("<p class=\"note\">{}</p>\n", escape(&timings(chart, table)));
    let sections = [
        ("Figure", sheet.figure.map(|svg| format!("<figure>{svg}</figure>\n"))),
        ("Cheapest", cheapest(sheet)),
        ("Order", orders(sheet)),
        ("Runs", Some(runs(sheet))),
        ("Published", published(chart)),
    ];
    for (name, html) in sections {
        if let Some(html) = html {
            body += &format!("<section id=\"{}\">\n<h2>{name}</h2>\n{html}</section>\n", name.to_lowercase());
        }
    }
    frame(sheet.title, &body)
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

fn cheapest(sheet: &Sheet<'_>) -> Option<String> {
    let Sheet { chart, table, names, .. } = sheet;
    let row = |cheapest: &describe::Cheapest| {
        let of = cheapest.row.map(|row| &table.rows[row]);
        let (cost, error) = of.and_then(Row::point).unzip();
        vec![
            percent(cheapest.tolerance),
            of.map_or("no run".to_owned(), |row| escape(&names.of(row))),
            error.map_or("–".into(), percent),
            cost.map_or("–".into(), |cost| format!("{} s", number(cost))),
            cheapest.over_seed.map_or("–".into(), |ratio| format!("{} ×", number(ratio))),
        ]
    };
    let head = ["error within", "cheapest setting", "its error", "CPU time", "over the paper's own setting"];
    let rows: Vec<Vec<String>> = describe::cheapest(chart, table).iter().map(row).collect();
    let any = table.rows.iter().any(|row| row.point().is_some());
    any.then(|| html_table(&head, &rows))
}

fn orders(sheet: &Sheet<'_>) -> Option<String> {
    let orders = describe::orders(sheet.chart, sheet.table, sheet.names);
    let row = |order: &describe::Order| {
        let limit = order.of_values.as_ref();
        let size = limit.map_or(1.0, |limit| if limit.value == 0.0 { 1.0 } else { limit.value.abs() });
        vec![
            escape(&order.key),
            escape(&order.with),
            order.runs.to_string(),
            order.of_errors.map_or("–".into(), |p| number(rounded(p))),
            limit.and_then(|limit| limit.order).map_or("none seen".into(), |p| number(rounded(p))),
            limit.map_or("–".into(), |limit| number(limit.value)),
            limit.map_or("–".into(), |limit| percent(limit.uncertainty / size)),
        ]
    };
    let head = ["key", "with", "runs", "order of the errors", "order of the values", "limit", "uncertainty"];
    let rows: Vec<Vec<String>> = orders.iter().map(row).collect();
    (!rows.is_empty()).then(|| {
        html_table(&head, &rows)
            + "<p class=\"note\">Order of the errors: slope over all runs, least squares. Order of the values, limit and \
               uncertainty (grid convergence index, Roache 1994): Richardson's, of the three finest; none is seen where the values do not \
               approach one another from one side.</p>\n"
    })
}

fn runs(sheet: &Sheet<'_>) -> String {
    let Sheet { table, names, .. } = sheet;
    let mut head: Vec<&str> = names.all().iter().map(String::as_str).collect();
    head.extend(["CPU time", "wall time"]);
    head.extend(table.metrics.iter().map(String::as_str));
    head.extend(["error", "front", "remark"]);
    let front = table.front();
    let row = |(number_of, row): (usize, &Row)| {
        let mut cells: Vec<String> = row
            .values
            .iter()
            .map(|value| if value.is_empty() { "default".into() } else { escape(value) })
            .collect();
        cells.extend([spread(row.cpu), spread(row.wall)]);
        cells.extend(row.measured.iter().map(|value| value.map_or("–".into(), number)));
        cells.push(row.error.map_or("–".into(), percent));
        let place = front.iter().position(|other| *other == number_of);
        cells.push(place.map_or(String::new(), |place| format!("<b>{}</b>", place + 1)));
        cells.push(escape(&row.note));
        cells
    };
    html_table(&head, &table.rows.iter().enumerate().map(row).collect::<Vec<_>>())
}

fn spread(spread: Option<Spread>) -> String {
    let Some(spread) = spread else { return "–".into() };
    let median = format!("{} s", number(spread.median));
    if spread.min == spread.max {
        return median;
    }
    format!("{median} ({}–{})", number(spread.min), number(spread.max))
}

fn published(chart: &Chart) -> Option<String> {
    let row = |point: &super::config::Published| {
        vec![
            escape(&point.name),
            format!("{} s", number(point.cost)),
            percent(point.error),
            escape(&point.source),
        ]
    };
    let rows: Vec<Vec<String>> = chart.published.iter().map(row).collect();
    let note = "<p class=\"note\">Crosses in the figure: not measured here, on other machines.</p>\n";
    (!rows.is_empty()).then(|| html_table(&["who", "CPU time", "error", "source"], &rows) + note)
}
