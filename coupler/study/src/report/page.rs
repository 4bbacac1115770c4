//! The page of a run: what its template shows.

use std::path::{Path, PathBuf};

use bedload_output::{Summary, atomic_write};
use serde::Serialize;
use serde_json::Value;

use super::bed;
use super::panels::{self, Panel};
use super::player::{Film, film};
use super::plots;
use super::run_files::RunFiles;
use super::split::{Part, parts};
use crate::page::{Figure, render};
use coupler::failure::Failure;

/// What `templates/report.html` shows.
#[derive(Serialize)]
struct Page<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    title: &'a str,
    source: &'a str,
    name: &'a str,
    identity: &'a str,
    faults: &'a [String],
    curves: Vec<Figure>,
    player: Option<Film>,
    vorticity: Option<Panel>,
    grains: Option<Panel>,
    plan: Option<&'a Value>,
    parts: Vec<Part>,
    log: Option<&'a str>,
}

/// Makes `report.html` in the output folder of a run; returns it. What the run has not left (a log, fields, a
/// plan) is left out of the page, which says so; only the summary must be there.
///
/// # Errors
/// [`Failure`] if there is no summary, or the page cannot be written.
pub fn write(dir: &Path) -> Result<PathBuf, Failure> {
    let run = RunFiles::read(dir)?;
    let path = dir.join("report.html");
    atomic_write(&path, page(&run)?.as_bytes())?;
    Ok(path)
}

fn page(run: &RunFiles) -> Result<String, Failure> {
    let summary = &run.summary;
    let page = Page {
        summary,
        title: run.title(),
        source: run.scene.as_ref().map_or("", |scene| scene.scene.source.as_str()),
        name: &run.name,
        identity: summary.scene_sha256.get(..12).unwrap_or(&summary.scene_sha256),
        faults: &run.remarks,
        // The bed first, where there is one; the sub-steps last.
        curves: [bed::all(run), plots::all(run)].concat(),
        player: film(run)?,
        vorticity: panels::vorticity(run)?,
        grains: panels::grains(run)?,
        plan: run.plan.as_ref(),
        parts: parts(summary),
        log: run.log.as_deref(),
    };
    render("report.html", page)
}
