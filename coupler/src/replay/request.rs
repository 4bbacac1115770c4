//! What `bedload replay` was asked.

use std::path::PathBuf;

use protocol::participant::Role;

/// Draws curves as SVG.
pub type Figure = fn(&str, Vec<(String, Vec<(f64, f64)>)>) -> String;

/// What `bedload replay` was asked.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The log.
    pub log: PathBuf,
    /// Which solver to drive.
    pub drive: Role,
    /// Compare bit for bit.
    pub verify: bool,
    /// Say how far the messages are from the logged ones.
    pub compare: bool,
    /// `KEY=VALUE` for the scene in the log.
    pub overrides: Vec<String>,
    /// May a command that `overrides` name be started?
    pub allow_commands: bool,
    /// Checkpoint that the log begins at, where it is not the start of the run.
    pub checkpoint: Option<PathBuf>,
    /// Output folder.
    pub out: Option<PathBuf>,
    /// Draws the differences: title, and for each curve its name and points of time (s) and relative
    /// difference.
    pub figure: Figure,
}
