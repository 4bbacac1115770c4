//! What `bedload replay` was asked.

use std::path::PathBuf;

use clap::Args;
use protocol::participant::Role;

use crate::supervise::role;

/// Draws differences as SVG: title, and of each curve its name and points of time (s) and difference.
pub type Figure = fn(&str, Vec<(String, Vec<(f64, f64)>)>) -> String;

/// What `bedload replay` was asked.
#[derive(Clone, Debug, Args)]
pub struct Replay {
    /// Log of a run (MCAP)
    pub log: PathBuf,
    /// Solver to drive
    #[arg(long, value_parser = role())]
    pub drive: Role,
    /// Compare every message bit for bit; exit 1 at the first difference, 6 if the log breaks off
    #[arg(long)]
    pub verify: bool,
    /// Change any key of the log's scene before the solver reads it, and say what differs then; may be
    /// repeated
    #[arg(long = "set", value_name = "KEY=VALUE", conflicts_with = "verify")]
    pub overrides: Vec<String>,
    /// Say how far each quantity is from the logged one: table; with --out also divergence.csv and .svg
    #[arg(long, conflicts_with = "verify")]
    pub compare: bool,
    /// Start the solver that --set names with `command`; one that the log names is never started
    #[arg(long)]
    pub allow_commands: bool,
    /// Checkpoint that the log of a resumed run begins at
    #[arg(long, value_name = "DIR")]
    pub checkpoint: Option<PathBuf>,
    /// Output folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}
