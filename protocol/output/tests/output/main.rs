//! The output of a run: folder, series, metrics, summary. Trajectories here are analytic and stand
//! for no simulation.

mod folder;
mod metrics;
mod series;
mod stage;
mod summary;
mod totals;
mod vtk;
