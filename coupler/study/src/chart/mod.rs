//! `bedload chart`: runs of one scene, error against cost.
//!
//! The scene's `[chart]` section says which keys vary and what the runs are compared with. Each run is
//! a `bedload run` of its own under `runs/`, and is not repeated once finished. One after the other
//! by default, so that they do not disturb each other's timing.
//!
//! | file | what it holds |
//! |---|---|
//! | `config` | the `[chart]` section |
//! | `runs` | the runs, made and measured |
//! | `reference`, `limit` | errors; Richardson's limit and order |
//! | `table` | `chart.csv`, Pareto front |
//! | `describe` | runs and results in words |
//! | `figure`, `page` | `chart.svg`, `chart.html` |

mod config;
mod describe;
mod figure;
mod limit;
mod page;
mod reference;
mod runs;
mod table;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bedload_output::atomic_write;
use bedload_program::RunOptions;
use bedload_scene::{Metric, SceneSource};
use serde::Deserialize;

use crate::folder::{self, Options, SCENE, content};
pub use config::{Chart, Curve, Finer, LimitOf, Published, Reference};
use coupler::failure::Failure;
use describe::Names;
use page::Page;
use table::{Table, columns};

/// Makes the runs that are missing, compares them, writes table, figure and page, and prints what was
/// found.
///
/// # Errors
/// [`Failure`]; a run that fails is none, unless all do.
pub fn chart(options: &Options) -> Result<(), Failure> {
    let scene = RunOptions::of_scene(&options.scene).read_scene()?;
    let chart = Chart::read(&scene)?;
    let sweep = runs::plan(&scene, &chart)?;
    let out = options.folder("chart");
    if out.join("summary.json").exists() {
        let what = "is the output folder of a run; name another with --out".to_owned();
        return Err(content(&out)(what));
    }
    let _claim = folder::open(&out, &scene)?;
    let jobs = options.jobs.map_or(1, NonZeroUsize::get);
    let mut table = runs::make(&sweep, &chart, &options.scene, &out, jobs)?;
    let known = reference::values(&chart, &scene.scene.metrics, &table);
    if !matches!(chart.reference, Some(Reference::Curve(_))) {
        reference::compare(&mut table, &known);
    }
    table.mark_front();
    let csv = out.join(TABLE);
    atomic_write(&csv, table.csv().as_bytes())?;
    let page = redraw(&out)?;
    print!("{}", Page::new(&chart, &table, &Names::new(&chart, &table), &known).words()?);
    println!("\n{}\n{}", csv.display(), page.display());
    let any = table.rows.iter().any(|row| row.point().is_some());
    if any {
        Ok(())
    } else {
        Err(Failure::Run(format!("no run gave an error; the remarks in {} say why", csv.display())))
    }
}

/// The table of a chart: what makes a folder one.
pub(crate) const TABLE: &str = "chart.csv";

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

/// Draws figure and page of a chart's folder from its table and scene; returns the page.
///
/// # Errors
/// [`Failure`] if one of both cannot be read, or the page not written.
pub(crate) fn redraw(dir: &Path) -> Result<PathBuf, Failure> {
    let source = SceneSource::read(&dir.join(SCENE), &[])?;
    let chart = Chart::of_text(&source)?;
    let shown: Shown = source.section()?;
    let path = dir.join(TABLE);
    let table = Table::parse(&folder::read(&path)?, &columns(&chart.metrics()))
        .map_err(|what| content(&path)(format!("{what}; chart again")))?;
    let names = Names::new(&chart, &table);
    let known = reference::values(&chart, &shown.metrics, &table);
    let title = [&chart.title, &shown.title].into_iter().find(|title| !title.is_empty());
    let title = title.map_or("Speed against accuracy", String::as_str);
    let figure = figure::draw(&table, &names, title, &chart.published, chart.baseline.as_deref())?;
    if let Some(svg) = &figure {
        atomic_write(&dir.join("chart.svg"), svg.as_bytes())?;
    }
    let html = Page::new(&chart, &table, &names, &known).html(title, &shown.source, figure.as_deref())?;
    let page = dir.join("chart.html");
    atomic_write(&page, html.as_bytes())?;
    Ok(page)
}
