//! How a program ends, besides well, and how it says so.

use bedload_output::OutputError;
use bedload_scene::SceneError;
use protocol::log::LogError;
use protocol::participant::{ExchangeError, SolverError};

/// How a program ends, besides well.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// Bad input: exit 2.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// The folder cannot be used: exit 2; a file of it could not be written: exit 1, or 5 where the disk is full.
    #[error(transparent)]
    Folder(#[from] bedload_output::OutputError),
    /// The solver failed: exit 1; or its peer did: exit 3.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// The log could not be written: exit 1, or 5 where the disk is full.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A comparison differs: exit 1.
    #[error("{0}")]
    Different(String),
    /// The log of a replay breaks off, and all that is there is well: exit 6.
    #[error("{0}")]
    BreaksOff(String),
    /// Interrupted, with a usable checkpoint: exit 130.
    #[error("interrupted")]
    Interrupted,
}

impl From<SceneError> for ProgramError {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}

impl ProgramError {
    /// Exit code of `docs/conventions.md`: 1 failed or different, 2 bad input, 3 peer lost, 5 no room on the disk,
    /// 6 the log of a replay breaks off, 130 interrupted.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Folder(error) if error.is_full() => 5,
            Self::Solver(SolverError::File { source, .. }) if protocol::new_file::is_full(source) => 5,
            Self::Log(LogError::File { source, .. }) if protocol::new_file::is_full(source) => 5,
            Self::Folder(OutputError::File { .. } | OutputError::Gone(_)) => 1,
            Self::Scene(_) | Self::Folder(_) => 2,
            Self::Solver(SolverError::Exchange(
                ExchangeError::PeerDied { .. } | ExchangeError::Deadline { .. },
            )) => 3,
            Self::Solver(_) | Self::Log(_) | Self::Different(_) => 1,
            Self::BreaksOff(_) => 6,
            Self::Interrupted => 130,
        }
    }
}

/// Prints an error, with the marked place where it has one.
pub fn explain(program: &str, error: &ProgramError) {
    match error {
        ProgramError::Scene(scene) => {
            protocol::say!("{program}: {scene}");
            protocol::say!("  remedy: {}", scene.remedy);
        }
        other => protocol::say!("{program}: {other}"),
    }
}
