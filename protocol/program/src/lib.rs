//! The command line that both solvers share: `check`, `schema`, `run` (alone), `serve` (in a coupled
//! run) and `replay` (driven by a log).
//!
//! | command | does |
//! |---|---|
//! | `check SCENE [--set …] [--json]` | reads the scene, prints the facts the coupler plans with |
//! | `schema` | prints the JSON Schema of the solver's section |
//! | `run SCENE [options]` | runs alone, with the same options and output folder as `bedload run` |
//! | `serve SCENE --connect TOKEN --out DIR` | joins a coupled run |
//! | `replay LOG [--verify] [--out DIR]` | does again what the log says it did |

pub mod alone;
mod alone_log;
mod alone_run;
mod command;
mod coupled;
mod disk;
mod error;
mod options;
mod orphan;
mod pipe;
mod progress;
mod solver;
mod threads;

pub use command::main;
pub use disk::fail_at_file_limit;
pub use error::{ProgramError, explain};
pub use options::RunOptions;
pub use orphan::PARENT;
pub use pipe::end_at_closed_pipe;
pub use progress::Progress;
pub use solver::Solver;
