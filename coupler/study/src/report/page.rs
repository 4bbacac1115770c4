//! The page of a run: what its template shows.

use std::path::{Path, PathBuf};

use bedload_output::atomic_write;

use super::bed;
use super::panels;
use super::player::film;
use super::plots;
use super::run_files::RunFiles;
use crate::page::{Value, context, render};
use crate::plot::colour;
use coupler::failure::Failure;

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
    render(
        "report.html",
        context! {
            title => run.title(),
            source => run.scene.as_ref().map_or("", |scene| scene.scene.source.as_str()),
            name => run.name,
            identity => summary.scene_sha256.get(..12).unwrap_or(&summary.scene_sha256),
            faults => run.remarks,
            // The bed first, where there is one; the sub-steps last.
            curves => [bed::all(run), plots::all(run)].concat(),
            player => film(run)?,
            vorticity => panels::vorticity(run)?,
            grains => panels::grains(run)?,
            plan => run.plan,
            colours => std::array::from_fn::<_, 5, _>(colour),
            log => run.log,
            ..Value::from_serialize(summary)
        },
    )
}
