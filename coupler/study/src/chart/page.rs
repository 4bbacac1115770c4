//! What the templates of a chart show: its page, and its words for the terminal.

use serde::Serialize;

use super::describe::{self, Cheapest, Names, Order};
use super::reference::Compared;
use crate::page::render;
use crate::section::{Published, Section};
use crate::table::{Row, Table};
use coupler::failure::Failure;

/// What `templates/chart.html` and `chart.txt` show.
#[derive(Serialize)]
pub(super) struct Page<'a> {
    title: &'a str,
    source: &'a str,
    about: &'a str,
    references: Vec<String>,
    timings: String,
    figure: Option<&'a str>,
    cheapest: Vec<Cheapest>,
    orders: Vec<Order>,
    /// Of the varied keys.
    names: &'a [String],
    metrics: Vec<&'a str>,
    runs: &'a [Row],
    /// Of the runs: what each is called, and its number on the front.
    labels: Vec<String>,
    places: Vec<String>,
    /// Has any run both a cost and an error?
    any: bool,
    published: &'a [Published],
}

impl<'a> Page<'a> {
    pub(super) fn new(
        chart: &'a Section,
        table: &'a Table,
        names: &'a Names,
        known: &Result<Vec<Compared>, String>,
    ) -> Self {
        let front = table.front();
        let place = |row: usize| {
            let place = front.iter().position(|other| *other == row);
            place.map_or(String::new(), |place| (place + 1).to_string())
        };
        Self {
            title: &chart.title,
            source: "",
            about: chart.about.trim(),
            references: describe::references(chart, names, known),
            timings: timings(chart, table),
            figure: None,
            cheapest: describe::cheapest(chart, table, names),
            orders: describe::orders(chart, table, names),
            names: names.all(),
            metrics: chart.metrics(),
            runs: &table.rows,
            labels: table.rows.iter().map(|row| names.of(row)).collect(),
            places: (0..table.rows.len()).map(place).collect(),
            any: table.rows.iter().any(|row| row.point().is_some()),
            published: &chart.published,
        }
    }

    pub(super) fn html(self, title: &str, source: &str, figure: Option<&str>) -> Result<String, Failure> {
        render("chart.html", Page { title, source, figure, ..self })
    }

    /// What was found, for the terminal.
    pub(super) fn words(&self) -> Result<String, Failure> {
        render("chart.txt", self)
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
