//! How a command of any of the programs ends, besides well: one type, one table of exit codes.

use bedload_output::OutputError;
use bedload_scene::SceneError;
use protocol::log::LogError;
use protocol::new_file::is_full;
use protocol::participant::{ExchangeError, SolverError};

/// Why a command did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Bad input in a scene: drawn with its place.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// Bounds that the plan breaks.
    #[error("{0}")]
    Bounds(String),
    /// Bad input elsewhere.
    #[error("{0}")]
    Input(String),
    /// The run failed, or a comparison differs.
    #[error("{0}")]
    Run(String),
    /// The exchange alternated or grew from window to window.
    #[error("{0}")]
    Unstable(String),
    /// A solver died or hangs.
    #[error("{0}")]
    Peer(String),
    /// No room for a file: a full disk, a quota, a limit.
    #[error("{}", and_make_room(.0))]
    Full(String),
    /// A log breaks off or is damaged; all that is there was read or replayed.
    #[error("{0}")]
    BreaksOff(String),
    /// Another process writes into the folder.
    #[error("{0}")]
    InUse(String),
    /// Ctrl-C or SIGTERM; checkpoint and log are in order.
    #[error("interrupted: {0}")]
    Interrupted(String),
    /// A solver that ran alone has printed its own error.
    #[error("the solver left with exit code {0}")]
    Passed(u8),
}

/// What a solver says of it has the remedy already.
fn and_make_room(what: &str) -> String {
    const REMEDY: &str = "make room, and do it again";
    if what.contains(REMEDY) { what.to_owned() } else { format!("{what}; {REMEDY}") }
}

impl Failure {
    /// Exit code (docs/conventions.md).
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Run(_) => 1,
            Self::Scene(_) | Self::Bounds(_) | Self::Input(_) => 2,
            Self::Peer(_) => 3,
            Self::Unstable(_) => 4,
            Self::Full(_) => 5,
            Self::BreaksOff(_) => 6,
            Self::InUse(_) => 7,
            Self::Interrupted(_) => 130,
            Self::Passed(code) => *code,
        }
    }

    /// Prints the error on stderr, with the remedy where a scene has one.
    pub fn explain(&self, program: &str) {
        protocol::say!("{program}: {self}");
        if let Self::Scene(scene) = self {
            protocol::say!("  remedy: {}", scene.remedy);
        }
    }

    /// An error of a file: [`Failure::Full`] where the disk is full.
    fn of_file(error: &dyn std::fmt::Display, full: bool) -> Self {
        if full { Self::Full(error.to_string()) } else { Self::Run(error.to_string()) }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Scene(error) => Self::Scene(error),
            OutputError::Place { .. } if !error.is_full() => Self::Input(error.to_string()),
            OutputError::Foreign { .. }
            | OutputError::Finished(_)
            | OutputError::Begun(_)
            | OutputError::Link(_)
            | OutputError::Outside { .. }
            | OutputError::Needed { .. }
            | OutputError::NoRun(_)
            | OutputError::NotEnded(_)
            | OutputError::NothingToResume(_) => Self::Input(error.to_string()),
            OutputError::InUse(_) => Self::InUse(error.to_string()),
            OutputError::File { .. }
            | OutputError::Place { .. }
            | OutputError::Content { .. }
            | OutputError::Gone(_) => Self::of_file(&error, error.is_full()),
        }
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        match &error {
            LogError::Truncated { .. } | LogError::Damaged { .. } | LogError::Sequence { .. } => {
                Self::BreaksOff(error.to_string())
            }
            _ => Self::of_file(&error, matches!(&error, LogError::File { source, .. } if is_full(source))),
        }
    }
}

impl From<SolverError> for Failure {
    fn from(error: SolverError) -> Self {
        match &error {
            SolverError::Exchange(
                ExchangeError::PeerDied { .. }
                | ExchangeError::Deadline { .. }
                | ExchangeError::NotJoined { .. },
            ) => Self::Peer(error.to_string()),
            SolverError::File { source, .. } => Self::of_file(&error, is_full(source)),
            SolverError::Failed(_) | SolverError::Exchange(_) => Self::Run(error.to_string()),
        }
    }
}

impl From<ExchangeError> for Failure {
    fn from(error: ExchangeError) -> Self {
        SolverError::from(error).into()
    }
}
