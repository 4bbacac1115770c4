//! Many runs of one scene: which settings vary, and the runs as child processes that are never
//! repeated once finished. `bedload chart`, `bedload stability` and `bedload validate` share it.
//!
//! | file | what it holds |
//! |---|---|
//! | `vary` | varied keys as the scene writes them |
//! | `ladder` | all combinations, as runs with `--set` |
//! | `resolution` | D/Δx of a scene, and the grid that has another one |
//! | `runs` | child processes, several at a time, resumable |
//! | `table` | tables without quotes |

mod ladder;
pub(crate) mod resolution;
mod runs;
mod table;
mod vary;

use std::path::{Path, PathBuf};

pub use ladder::{Column, Ladder, Point};
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
