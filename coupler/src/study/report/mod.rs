//! `bedload report`: one self-contained HTML page per run, from the files in its output folder, or
//! per chart.
//!
//! The page needs nothing but itself: no script, no outside style, font or picture.
//!
//! | file | what it holds |
//! |---|---|
//! | `run_files` | what is read of a run, and the scales of its pictures |
//! | `page`, `tables` | HTML: frame, style, numbers, tables |
//! | `chart`, `plots` | lines against time |
//! | `vtr`, `contour`, `pictures` | fields, their contours, the panel of vorticity |
//! | `snapshot`, `sheet` | grains at an instant, and their pictures coloured by speed |
//! | `appended` | the form of both kinds of file |

mod appended;
pub(crate) mod chart;
mod contour;
pub(crate) mod page;
mod pictures;
mod plots;
mod run_files;
pub(crate) mod sheet;
pub(crate) mod snapshot;
pub(crate) mod tables;
pub mod vtr;

use std::path::{Path, PathBuf};

use bedload_output::{OutputError, atomic_write};

use crate::study::chart::ChartError;
use crate::study::stability::{self, StabilityError};
use run_files::RunFiles;

/// Why a report could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file of the run cannot be read, or the page not written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The folder of a chart cannot be used.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// The folder of a map cannot be used.
    #[error(transparent)]
    Stability(Box<StabilityError>),
    /// No folder was named.
    #[error("no folder was named: give the output folder of at least one run")]
    Nothing,
}

/// Makes `report.html` in each of `dirs`, the output folders of runs, or `chart.html` in those of
/// charts; returns the pages.
///
/// What a run has not left (a log, fields, a plan) is left out of its page, which says so; only the
/// summary must be there.
///
/// # Errors
/// [`ReportError`] at the first folder that holds no run or cannot be written.
pub fn report(dirs: &[&Path]) -> Result<Vec<PathBuf>, ReportError> {
    if dirs.is_empty() {
        return Err(ReportError::Nothing);
    }
    dirs.iter().map(|dir| report_one(dir)).collect()
}

fn report_one(dir: &Path) -> Result<PathBuf, ReportError> {
    if dir.join(crate::study::chart::TABLE).exists() {
        return Ok(crate::study::chart::again(dir)?);
    }
    if dir.join(stability::TABLE).exists() {
        return stability::report(dir).map_err(|error| ReportError::Stability(Box::new(error)));
    }
    let run = RunFiles::read(dir)?;
    let page = dir.join("report.html");
    atomic_write(&page, page::page(&run).as_bytes())?;
    Ok(page)
}
