//! The page of a run: what its template shows.

use std::path::{Path, PathBuf};

use bedload_output::{Summary, atomic_write};
use serde::Serialize;
use serde_json::Value;

use super::plots;
use super::run_files::RunFiles;
use super::split::{Part, parts};
use super::vorticity::{self, Vorticity};
use crate::grain_pictures;
use crate::page::{Figure, render};
use crate::snapshot::Snapshot;
use coupler::failure::Failure;
use coupler::number::number;

/// Pictures of the grains on a page.
const MOST_SNAPSHOTS: usize = 12;

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
    vorticity: Option<Vorticity>,
    grains: Option<Grains>,
    plan: Option<&'a Value>,
    parts: Vec<Part>,
    log: Option<&'a str>,
}

/// The pictures of the grains.
#[derive(Serialize)]
struct Grains {
    /// SVG; none if there is no grain to draw.
    pictures: Option<String>,
    about: String,
    /// Files that could not be read, and why.
    faults: Vec<String>,
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
        curves: plots::all(run),
        vorticity: vorticity::panel(run)?,
        grains: grains(run)?,
        plan: run.plan.as_ref(),
        parts: parts(summary),
        log: run.log.as_deref(),
    };
    render("report.html", page)
}

/// The grains at up to [`MOST_SNAPSHOTS`] of the times at which they were written.
fn grains(run: &RunFiles) -> Result<Option<Grains>, Failure> {
    let files = &run.grain_files;
    let step = files.len().div_ceil(MOST_SNAPSHOTS).max(1);
    // From the last backwards: the final state is always there.
    let chosen = files.iter().rev().step_by(step).collect::<Vec<_>>().into_iter().rev();
    let (read, faults): (Vec<_>, Vec<_>) = chosen.map(|path| Snapshot::read(path)).partition(Result::is_ok);
    let snapshots: Vec<Snapshot> = read.into_iter().filter_map(Result::ok).collect();
    let faults: Vec<String> = faults.into_iter().filter_map(Result::err).collect();
    let pictures = grain_pictures::draw(&snapshots)?;
    let cut = snapshots.iter().find_map(|snapshot| snapshot.cut);
    let cut = cut.map_or(String::new(), |y| format!(" Spheres are cut by the plane y = {} m.", number(y)));
    let about = format!(
        "Coloured by speed, to scale; held grains are grey, single ones far away are left out.{cut} {} of {} files \
         of grains.",
        snapshots.len(),
        files.len()
    );
    Ok((pictures.is_some() || !faults.is_empty()).then_some(Grains { pictures, about, faults }))
}
