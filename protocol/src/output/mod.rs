//! What every run leaves behind, whoever conducts it: options, the output folder, `series.csv`,
//! metrics and `summary.json`. `bedload run`, `bedload-fluid run` and `bedload-dem run` share it.
//!
//! [`Observer::record`] takes each accepted window once and feeds them all. Its parts stand alone
//! too: [`Columns::fill`] makes the row, [`SeriesWriter`] writes it, [`Metrics`] measures it,
//! [`Tally`] counts.

mod accumulator;
mod claim;
mod columns;
mod deposit;
mod folder;
mod last;
mod line;
mod metrics;
mod oblique;
mod observer;
mod options;
pub mod planes;
mod points;
mod progress;
mod series;
mod subject;
mod summary;
mod touching;
mod trajectory;

pub use accumulator::{Accumulator, Passages};
pub use claim::Claim;
pub use columns::{Columns, Extra, Sample, Sides, energy_columns};
pub use folder::{OutputFolder, atomic_write, resolved_scene};
pub use line::Line;
pub use metrics::{Metrics, MetricsState};
pub use observer::{Observer, ObserverState};
pub use options::RunOptions;
pub use points::points;
pub use progress::Progress;
pub use series::{Series, SeriesWriter};
pub use summary::{
    Cost, MetricValue, PeakRss, RunStatus, Size, SubstepRange, Summary, Tally, Time, peak_rss_bytes,
};
pub use trajectory::{Crossing, Trajectory};

use std::path::{Path, PathBuf};

/// Why the output could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// On which path.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The folder holds something else.
    #[error(
        "{} is not empty and not an output folder of Bedload (its scene.toml does not begin with \
         `{marker}`): nothing was changed; name an empty or new folder with --out",
        path.display()
    )]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// First words of a `scene.toml` that Bedload wrote.
        marker: &'static str,
    },
    /// Another process writes there.
    #[error("{} is in use by another process of Bedload: nothing was changed; wait until it ends, or name another \
             folder with --out", .0.display())]
    InUse(PathBuf),
    /// There is nothing to resume.
    #[error("{} holds no run to resume: leave out --resume, or name the folder of the run with --out", .0.display())]
    NothingToResume(PathBuf),
    /// The scene asks for something that the run cannot observe.
    #[error(transparent)]
    Scene(#[from] Box<crate::scene::SceneError>),
    /// A file does not hold what it should.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, what was expected, what to do.
        what: String,
    },
}

impl OutputError {
    /// Wraps an error of the system.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { action, path, source }
    }
}
