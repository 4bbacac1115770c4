//! What is made of a state: contacts, averages over them, files.

pub mod coarse_grain;
pub mod finish;
pub mod flow;
pub mod grain_files;
pub mod janssen;
pub mod partition;
pub mod profile;
pub(crate) mod substeps;
pub(crate) mod totals;
