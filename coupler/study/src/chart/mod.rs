//! A chart: error against cost, with the Pareto front.
//!
//! | file | what it holds |
//! |---|---|
//! | `check` | the `[chart]` section against its scene |
//! | `reference`, `limit` | errors; Richardson's limit and order |
//! | `describe` | runs and results in words |
//! | `figure`, `page` | `chart.svg`, `chart.html` |

pub(crate) mod check;
mod describe;
mod figure;
mod limit;
mod page;
mod reference;

use std::path::{Path, PathBuf};

use bedload_output::atomic_write;
use bedload_scene::{Metric, SceneSource};
use serde::Deserialize;

use crate::folder::SCENE;
use crate::kind::Kind;
use crate::page::{context, render};
use crate::section::Section;
use crate::study::Study;
use crate::table::Table;
use coupler::failure::Failure;
use describe::Names;

/// Fills in errors and the Pareto front.
pub(crate) fn errors(study: &Study, table: &mut Table) {
    let known = reference::values(&study.section, &study.metrics, table);
    reference::compare(table, &known);
    table.mark_front();
}

/// The document as far as a page goes that is made again.
#[derive(Deserialize)]
struct Shown {
    #[serde(default)]
    title: String,
    #[serde(default)]
    source: String,
    #[serde(default)]
    metrics: Vec<Metric>,
}

/// Draws figure and page of a chart's folder from its table and scene; returns the page, and what it says in
/// words for the terminal.
pub(crate) fn draw(dir: &Path) -> Result<(PathBuf, String), Failure> {
    let source = SceneSource::read(&dir.join(SCENE), &[])?;
    let chart = Section::of_text(&source, Kind::Chart)?;
    let shown: Shown = source.section()?;
    let table = Table::read(&dir.join(Kind::Chart.table()))?;
    let names = Names::new(&chart, &table);
    let known = reference::values(&chart, &shown.metrics, &table);
    let title = [&chart.title, &shown.title].into_iter().find(|title| !title.is_empty());
    let title = title.map_or("Speed against accuracy", String::as_str);
    let figure = figure::draw(&table, &names, title, &chart)?;
    if let Some(svg) = &figure {
        atomic_write(&dir.join("chart.svg"), svg.as_bytes())?;
    }
    let found = page::shown(&chart, &table, &names, &known);
    let words = render("chart.txt", found.clone())?;
    let html = render("chart.html", context! { title, figure, source => shown.source, ..found })?;
    let page = dir.join("chart.html");
    atomic_write(&page, html.as_bytes())?;
    Ok((page, words))
}
