//! What every run leaves behind, whoever conducts it: the output folder, `series.csv`, metrics,
//! `summary.json`, VTK files. `bedload run`, `bedload-fluid run` and `bedload-dem run` share it.
//!
//! Where to start:
//!
//! | to | see |
//! |---|---|
//! | write all of it, window by window | [`Observer::record`] |
//! | make a row, write it, measure it, count | [`Columns::fill`], [`SeriesWriter`], [`Metrics`], [`Tally`] |
//! | read a run back | [`OutputFolder::open`], [`Series::read`], [`Summary`] |
//! | write and read files of VTK | [`mod@vtk`] |
//! | read columns of a table, of a published one | [`points()`], [`published_points`] |

mod balance;
mod claim;
mod columns;
mod error;
mod file;
mod folder;
mod grains_table;
pub mod metrics;
mod observer;
pub mod planes;
mod points;
mod sample;
mod series;
mod summary;
pub mod totals;
pub mod vtk;

pub use claim::Claim;
pub use columns::{Columns, energy_columns, observed_grains};
pub use error::OutputError;
pub use file::atomic_write;
pub use folder::{OutputFolder, Sections, in_full, refuse_changed_files, resolved_scene, state_of};
pub use grains_table::{GrainRow, grains_table};
pub use metrics::{Metrics, MetricsState};
pub use observer::{Observer, ObserverState};
pub use points::{points, published_points};
pub use sample::{Extra, Sample, Sides, When};
pub use series::{Series, SeriesMark, SeriesWriter};
pub use summary::{Cost, MetricValue, PeakRss, RunStatus, Size, SubstepRange, Summary, Tally, Time};
pub use summary::{Verification, VerifiedGrid, VerifiedMetric};
