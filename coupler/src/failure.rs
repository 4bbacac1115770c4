//! How a command ends, besides well: one type, one exit code each. What a part fails with becomes a
//! [`Failure`] in the file of that part.

use bedload_scene::SceneError;

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
    #[error("{0}; make room: --resume then goes on from the last checkpoint, where there is one")]
    Full(String),
    /// The log of a replay breaks off; all that is there was replayed.
    #[error("{0}")]
    BreaksOff(String),
    /// Ctrl-C or SIGTERM; checkpoint and log are in order.
    #[error("interrupted: {0}")]
    Interrupted(String),
    /// A solver that ran alone has said all there is to say.
    #[error("the solver left with exit code {0}")]
    Passed(u8),
}

impl Failure {
    /// Exit code (docs/conventions.md).
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Run(_) => 1,
            Self::Scene(_) | Self::Bounds(_) | Self::Input(_) => 2,
            Self::Peer(_) => 3,
            Self::Unstable(_) => 4,
            Self::Full(_) => 5,
            Self::BreaksOff(_) => 6,
            Self::Interrupted(_) => 130,
            Self::Passed(code) => *code,
        }
    }

    /// Says it on stderr.
    pub fn explain(self) {
        match self {
            Self::Scene(error) => protocol::say!("{:?}", miette::Report::new(*error)),
            Self::Passed(_) => {}
            other => protocol::say!("bedload: {other}"),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}

impl From<bedload_output::OutputError> for Failure {
    fn from(error: bedload_output::OutputError) -> Self {
        use bedload_output::OutputError;
        match error {
            OutputError::Scene(error) => Self::Scene(error),
            OutputError::Foreign { .. }
            | OutputError::InUse(_)
            | OutputError::Finished(_)
            | OutputError::Link(_)
            | OutputError::Needed { .. }
            | OutputError::NoRun(_)
            | OutputError::NothingToResume(_) => Self::Input(error.to_string()),
            _ if error.is_full() => Self::Full(error.to_string()),
            OutputError::File { .. } | OutputError::Content { .. } | OutputError::Gone(_) => {
                Self::Run(error.to_string())
            }
        }
    }
}
