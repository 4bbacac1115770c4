//! What every run leaves behind, whoever conducts it: the output folder, `series.csv`, metrics,
//! `summary.json`, VTK files. `bedload run`, `bedload-fluid run` and `bedload-dem run` share it.
//!
//! [`Observer::record`] takes each accepted window once and feeds them all. Its parts stand alone
//! too: [`Columns::fill`] makes the row, [`SeriesWriter`] writes it, [`metrics::Metrics`] measures it,
//! [`Tally`] counts.

mod claim;
mod columns;
mod error;
mod file;
mod folder;
pub mod metrics;
mod observer;
pub mod planes;
mod points;
mod series;
mod summary;
pub mod vtk;

pub use claim::Claim;
pub use columns::{Columns, Extra, Sample, Sides, energy_columns};
pub use error::OutputError;
pub use file::atomic_write;
pub use folder::{OutputFolder, resolved_scene};
pub use metrics::{Metrics, MetricsState};
pub use observer::{Observer, ObserverState};
pub use points::points;
pub use series::{Series, SeriesWriter};
pub use summary::{Cost, MetricValue, PeakRss, RunStatus, Size, SubstepRange, Summary, Tally, Time};
