//! `bedload report`: which page a folder gets.

use std::path::{Path, PathBuf};

use super::page;
use crate::commands::redraw;
use coupler::failure::Failure;

/// Makes `report.html` in each of `dirs`, the output folders of runs, `chart.html` in those of charts and
/// `stability.html` in those of maps; returns the pages.
///
/// # Errors
/// [`Failure::Input`] at the first folder that holds none of these or cannot be written, [`Failure::Full`]
/// where there is no room.
pub fn report(dirs: &[&Path]) -> Result<Vec<PathBuf>, Failure> {
    if dirs.is_empty() {
        let what = "no folder was named: give the output folder of at least one run";
        return Err(Failure::Input(what.into()));
    }
    // Whatever is wrong with a folder: it was the wrong one to name, unless the disk is full.
    let page = |dir: &&Path| {
        report_one(dir).map_err(|failure| match failure {
            Failure::Full(what) => Failure::Full(what),
            other => Failure::Input(other.to_string()),
        })
    };
    dirs.iter().map(page).collect()
}

fn report_one(dir: &Path) -> Result<PathBuf, Failure> {
    redraw(dir).unwrap_or_else(|| page::write(dir))
}
