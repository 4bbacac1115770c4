//! The coupler behind `bedload`: it plans, starts the solvers, is their master of time, watches,
//! records. It never stands in the path of the data.
//!
//! | file | what it holds |
//! |---|---|
//! | [`bounds`] | every stability and accuracy bound, with its source and remedy |
//! | [`config`] | the `[coupling]` section |
//! | [`plan`] | who takes part, time steps, cost |
//! | [`prepare`], [`check`] | from a scene file to a plan |
//! | [`proposals`] | cheaper models of a scene |
//! | [`accuracy`] | settings from the charts |
//! | [`scheme`] | which window comes next, and its sub-steps |
//! | [`run`], [`conduct`], [`judge`], [`iterate`] | a run, window by window, and its attempts |
//! | [`supervise`], [`solvers`] | solvers as commands and child processes |
//! | [`record`], [`resume`] | log, checkpoints |
//! | [`replay`], [`log_command`], [`export`] | a log driving a solver, or read; files for viewers |
//! | [`conformance`] | any solver against the protocol |
//! | [`study`] | `chart`, `stability`, `validate`, `report`: runs of a scene with varied keys, judged, as tables, figures, pages |
//! | [`cli`], [`failure`] | command line and exit codes |

pub mod accuracy;
pub mod bounds;
pub mod check;
pub mod cli;
pub mod conduct;
pub mod config;
pub mod conformance;
pub mod export;
pub mod failure;
pub mod iterate;
pub mod judge;
pub mod keys;
pub mod log_command;
pub(crate) mod number;
pub mod plan;
pub mod prepare;
pub mod proposals;
pub mod record;
pub mod replay;
mod resolution;
pub mod resume;
mod rewind;
pub mod run;
pub mod scheme;
mod session;
pub mod solvers;
pub mod study;
pub mod supervise;
