//! Studies: a scene and keys that vary, runs that are never repeated once finished, a judgement of
//! each, and what comes of them as table, figure and page.
//!
//! | file | what it holds |
//! |---|---|
//! | [`chart`] | `bedload chart`: error against cost |
//! | [`stability`] | `bedload stability`: where each method fails, beside the bound |
//! | [`validate`] | `bedload validate`: published cases and their references |
//! | [`report`] | `bedload report`: the HTML page of a run |
//! | `vary`, `points` | varied keys as the scene writes them, and all their combinations as runs with `--set` |
//! | `resolution` | D/Δx of a scene, and the grid that has another one |
//! | `runs` | runs as child processes, several at a time, resumable |
//! | `table` | tables without quotes |

pub mod chart;
mod points;
pub mod report;
pub(crate) mod resolution;
mod runs;
pub mod stability;
mod table;
pub mod validate;
mod vary;

use std::path::{Path, PathBuf};

pub use points::{Column, Ladder, Point};
pub use runs::{Keep, Outcome, Task, run_all};
pub(crate) use table::interpolated;
pub use table::{cell, parse_csv};
pub use vary::{SingleRun, Vary};

/// Why runs could not be made.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A file or program cannot be used.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// On which path.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
}

impl SweepError {
    /// An error of the system at a path.
    pub fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { action, path, source }
    }
}
