//! The DEM in a run: the scene's `[dem]` ([`config::Config`]), the participant
//! ([`participant::DemParticipant`]), averages and files.
//!
//! The method stands in [`dem_kernels`], which knows no scene: start there.

mod bounds;
pub mod command;
pub mod config;
mod facts;
mod initial;
pub mod insertion;
pub mod output;
mod outside;
pub mod participant;

pub use dem_kernels::*;
