//! How a command ends, besides well: one type, one exit code each.

use protocol::scene::SceneError;

use crate::bounds::Bound;
use crate::solvers::SolverCommandError;

/// Why a command did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Bad input in a scene: drawn with its place.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// Bounds that the plan breaks.
    #[error("{}", refusal(.0))]
    Bounds(Vec<Bound>),
    /// Bad input elsewhere.
    #[error("{0}")]
    Input(String),
    /// The run failed, or a comparison differs.
    #[error("{0}")]
    Run(String),
    /// A solver died or hangs.
    #[error("{0}")]
    Peer(String),
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

fn refusal(bounds: &[Bound]) -> String {
    let mut text = String::from("the plan breaks a stability bound");
    for bound in bounds {
        text += &format!(
            "\n  {}: {}\n    why: {} ({})\n    remedy: {}",
            bound.name,
            bound.relation(),
            bound.why,
            bound.source,
            bound.remedy
        );
    }
    let names: Vec<String> = bounds
        .iter()
        .filter(|bound| bound.name != crate::bounds::SINGULAR)
        .map(|bound| format!("{:?}", bound.name))
        .collect();
    if !names.is_empty() {
        text += &format!("\n  to run all the same: --set 'coupling.force=[{}]'", names.join(", "));
    }
    text
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}

impl From<SolverCommandError> for Failure {
    fn from(error: SolverCommandError) -> Self {
        match error {
            SolverCommandError::Scene(error) => Self::Scene(error),
            SolverCommandError::Start { .. } => Self::Peer(error.to_string()),
            SolverCommandError::Refused { code: 2, .. } => Self::Input(error.to_string()),
            SolverCommandError::Refused { .. } | SolverCommandError::Facts { .. } => {
                Self::Run(error.to_string())
            }
        }
    }
}

impl From<crate::log_command::LogCommandError> for Failure {
    fn from(error: crate::log_command::LogCommandError) -> Self {
        use crate::log_command::LogCommandError;
        use protocol::log::LogError;
        match &error {
            LogCommandError::Usage(_) => Self::Input(error.to_string()),
            LogCommandError::Log(
                LogError::File { .. } | LogError::NotALog { .. } | LogError::Layout { .. },
            ) => Self::Input(error.to_string()),
            LogCommandError::Log(_) | LogCommandError::Print(_) => Self::Run(error.to_string()),
        }
    }
}

impl From<bedload_output::OutputError> for Failure {
    fn from(error: bedload_output::OutputError) -> Self {
        use bedload_output::OutputError;
        match error {
            OutputError::Scene(error) => Self::Scene(error),
            OutputError::Foreign { .. } | OutputError::InUse(_) | OutputError::NothingToResume(_) => {
                Self::Input(error.to_string())
            }
            OutputError::File { .. } | OutputError::Content { .. } => Self::Run(error.to_string()),
        }
    }
}
