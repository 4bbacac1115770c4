//! How solvers are run: one loop over windows, and the command line that both solvers share.
//!
//! The loop ([`run()`], [`replay::drive`]) is the same for a coupled run, a solver alone, a replay, and the
//! way back after a failure. A [`Link`] says where the solvers are (other processes over shared memory, or
//! this process), a [`Schedule`] which windows there are and whether one stands. Log, checkpoints, series,
//! progress, signals and summary stand here once.
//!
//! | command | does |
//! |---|---|
//! | `check SCENE [--set …] [--json]` | reads the scene, prints the facts the coupler plans with |
//! | `schema` | prints the JSON Schema of the solver's section |
//! | `run SCENE [options]` | runs alone, with the same options and output folder as `bedload run` |
//! | `serve SCENE --connect TOKEN --out DIR` | joins a coupled run |
//! | `replay LOG [--verify] [--out DIR]` | does again what the log says it did |

pub mod alone;
pub mod alternation;
mod checkpoint;
mod clock;
mod command;
mod disk;
mod failure;
mod heartbeat;
mod in_process;
mod interrupts;
mod job;
mod link;
mod log;
mod loudness;
mod options;
mod orphan;
mod printing;
mod progress;
pub mod replay;
mod run;
mod run_loop;
mod serve;
mod solver;
mod stand_in;
mod threads;
pub mod unstable;

pub use command::main;
pub use disk::fail_at_file_limit;
pub use failure::Failure;
pub use heartbeat::Heartbeats;
pub use interrupts::{Interrupts, ignores_hangups};
pub use job::{Job, LogKind};
pub use link::{Attempt, End, Link, Messages, Ordered, Schedule};
pub use log::log_bytes;
pub use loudness::{Loudness, done};
pub use options::{RunOptions, until_as_set};
pub use orphan::{PARENT, end_with_parent, parent_name};
pub use printing::end_where_nothing_is_printed;
pub use run::{Setup, VERSION, run, summarise};
pub use solver::Solver;
