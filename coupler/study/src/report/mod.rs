//! `bedload report`: one self-contained HTML page per run, chart or map, from the files in its folder.
//!
//! | file | what it holds |
//! |---|---|
//! | `page` | the page of a run |
//! | `run_files` | what is read of a run, and the scales of its pictures |
//! | `plots`, `curves` | what is drawn against time, and how |
//! | `bed` | totals of a bed, and profiles over its height |
//! | `panels` | pictures of vorticity and of grains |
//! | `player` | the film of the page: grains and a plane of the flow over time |

mod bed;
mod curves;
pub mod page;
mod panels;
mod player;
mod plots;
mod run_files;

use std::path::{Path, PathBuf};

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
        redraw(dir).unwrap_or_else(|| page::write(dir)).map_err(|failure| match failure {
            Failure::Full(what) => Failure::Full(what),
            other => Failure::Input(other.to_string()),
        })
    };
    dirs.iter().map(page).collect()
}
