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
//! | [`study`] | `chart`, `stability`, `validate`, `report`: runs of a scene with varied keys, judged, as tables, figures, pages |
//! | [`failure::Failure`] | how all of them fail |
//!
//! Behind these: [`config`], the `[coupling]` section; [`scheme`], which window comes next; [`keys`], what
//! rules name of the solvers; [`cli`], the command line.
//!
//! | inside | what it holds |
//! |---|---|
//! | `check`, `proposals`, `accuracy` | what `bedload check` prints; cheaper models; settings from the charts |
//! | `conduct`, `judge`, `iterate` | a run window by window, and its attempts |
//! | `supervise`, `solvers`, `session` | solvers as commands and child processes |
//! | `record`, `resume`, `rewind`, `replay` | log, checkpoints, a log driving a solver |
//! | `log_command`, `export`, `conformance` | logs read; files for viewers; any solver against the protocol |
//! | `stage` | the coupler and the other solver, played to one solver |

mod accuracy;
pub mod bounds;
mod check;
pub mod cli;
mod conduct;
pub mod config;
mod conformance;
mod export;
pub mod failure;
mod iterate;
mod judge;
pub mod keys;
mod log_command;
mod notices;
mod number;
pub mod plan;
pub mod prepare;
mod proposals;
mod record;
mod replay;
mod resolution;
mod resume;
mod rewind;
pub mod run;
pub mod scheme;
mod scratch;
mod session;
mod solvers;
mod speeds;
mod stage;
pub mod study;
mod supervise;
mod unstable;
