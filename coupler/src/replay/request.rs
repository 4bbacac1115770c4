//! What `bedload replay` was asked.

use std::path::PathBuf;

use protocol::participant::Role;

/// What `bedload replay` was asked.
#[derive(Clone, Debug)]
pub(crate) struct Replay {
    /// The log.
    pub(crate) log: PathBuf,
    /// Which solver to drive.
    pub(crate) drive: Role,
    /// Compare bit for bit.
    pub(crate) verify: bool,
    /// Say how far the messages are from the logged ones.
    pub(crate) compare: bool,
    /// `KEY=VALUE` for the scene in the log.
    pub(crate) overrides: Vec<String>,
    /// May a command that `overrides` name be started?
    pub(crate) allow_commands: bool,
    /// Checkpoint that the log begins at, where it is not the start of the run.
    pub(crate) checkpoint: Option<PathBuf>,
    /// Output folder.
    pub(crate) out: Option<PathBuf>,
}
