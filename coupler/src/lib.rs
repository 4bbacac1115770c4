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
//! | [`verify::run`] | the same, on finer and finer grids until it is as exact as asked |
//! | [`failure::Failure`] | how all of them fail |
//!
//! Behind these: [`config`], the `[coupling]` section; [`scheme`], which window comes next; [`files`], fields
//! by default and sizes; [`keys`], what rules name of the solvers; [`limit`], where a refinement leads. The
//! command line and the studies are crates above this one.
//!
//! | inside | what it holds |
//! |---|---|
//! | `check`, `proposals`, `accuracy` | what `bedload check` prints; cheaper models; charts' settings |
//! | `coupled`, `message_checks`, `iterate` | the solvers of a coupled run, its windows, and their attempts |
//! | `supervise`, `by_itself`, `solvers` | solvers as children, by themselves, and as commands |
//! | `replay` | a log driving a solver |
//! | `log_command`, `export`, `conformance` | logs read; files for viewers; any solver against the protocol |
//! | `descriptors` | how many files a process may have open |
//! | `solo_run` | a run with one solver: this process is the coupler and the other solver |

pub mod accuracy;
pub mod bounds;
mod by_itself;
pub mod check;
pub mod config;
pub mod conformance;
mod coupled;
mod descriptors;
pub mod export;
pub mod failure;
pub mod files;
mod iterate;
pub mod keys;
pub mod limit;
pub mod log_command;
mod message_checks;
mod notices;
pub mod number;
pub mod plan;
pub mod prepare;
mod proposals;
pub mod replay;
pub mod resolution;
pub mod run;
pub mod scheme;
mod scratch;
mod solo_run;
mod solvers;
mod supervise;
#[cfg(test)]
mod test_scenes;
mod unstable;
pub mod verify;
