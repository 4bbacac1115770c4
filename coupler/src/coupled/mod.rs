//! A coupled run: two solvers as processes, which this process orders, watches and examines.
//!
//! Data go from solver to solver; what is read here is a second copy. With the iterated scheme a window is
//! ordered again, from its start, until the motion stays the same ([`crate::iterate`]). The loop over windows
//! is that of `bedload-program`.
//!
//! | file | what it holds |
//! |---|---|
//! | `setup` | from the plan to solvers that are ready |
//! | `link` | the solvers behind shared memory, and what has come of each window |
//! | `collect` | what the solvers send, put where it belongs |
//! | `schedule` | which window comes next; one that is done: accepted, repeated, or the end of the run |
//! | `kinematics_check` | what a foreign DEM sends, against what the coupler computes |
//! | `diagnosis` | why a run ends early |

mod collect;
mod diagnosis;
mod kinematics_check;
mod link;
mod schedule;
mod setup;

pub(crate) use collect::FILES_TAKE;
pub use setup::Report;
pub(crate) use setup::{Coupled, draw, serve_arguments, start, write_scene};
