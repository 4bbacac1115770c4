//! The coupler behind `bedload`: it plans, starts the solvers, is their master of time, watches,
//! records. It never stands in the path of the data.
//!
//! Where to start:
//!
//! | item | for |
//! |---|---|
//! | [`prepare::Prepared`] | from a scene file to its plan, with what the solvers say of themselves |
//! | [`plan::Plan`], [`bounds`] | who takes part, time steps, cost; every bound with its source and remedy |
//! | [`run::run`] | a run, from the scene to the output folder |
//! | [`failure::Failure`] | how all of them fail |
//!
//! Behind these: [`config`], the `[coupling]` section; [`scheme`], which window comes next; [`keys`], what
//! rules name of the solvers. The command line and the studies are crates above this one.
//!
//! | inside | what it holds |
//! |---|---|
//! | `check`, `proposals`, `accuracy` | what `bedload check` prints; cheaper models; settings from the charts |
//! | `conduct`, `judge`, `iterate` | a run window by window, and its attempts |
//! | `supervise`, `solvers`, `session` | solvers as commands and child processes |
//! | `record`, `resume`, `rewind`, `replay` | log, checkpoints, a log driving a solver |
//! | `log_command`, `export`, `conformance` | logs read; files for viewers; any solver against the protocol |
//! | `stage` | the coupler and the other solver, played to one solver |

pub mod accuracy;
pub mod bounds;
pub mod check;
mod conduct;
pub mod config;
pub mod conformance;
pub mod export;
pub mod failure;
mod iterate;
mod judge;
pub mod keys;
pub mod log_command;
mod notices;
pub mod number;
pub mod plan;
pub mod prepare;
mod proposals;
mod record;
pub mod replay;
pub mod resolution;
mod resume;
mod rewind;
pub mod run;
pub mod scheme;
mod scratch;
mod session;
mod solvers;
mod speeds;
mod stage;
mod supervise;
mod unstable;
