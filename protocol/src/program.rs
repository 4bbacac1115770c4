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

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::alone::{Answer, Clock};
use crate::channel::Wire;
use crate::facts::{DemFacts, FluidFacts};
use crate::log::Logged;
use crate::message::{Kinematics, Loads};
use crate::output::{MetricValue, OutputFolder, RunOptions};
use crate::participant::{ExchangeError, Participant, SolverError};
use crate::scene::{CheckedScene, SceneError};

mod alone_run;
mod coupled;

/// What a solver adds to [`Participant`] to become a program.
pub trait Solver: Participant + Send + Sized {
    /// Name of the executable.
    const PROGRAM: &'static str;
    /// What it tells the coupler before a run.
    type Facts: serde::Serialize;

    /// Facts of a scene, without building the solver.
    ///
    /// # Errors
    /// [`SceneError`] if its section is wrong.
    fn facts(scene: &CheckedScene) -> Result<Self::Facts, SceneError>;

    /// The solver at time zero; files of its own go below `out`.
    ///
    /// # Errors
    /// [`SceneError`] if the scene does not make a solver.
    fn build(scene: &CheckedScene, out: &Path) -> Result<Self, SceneError>;

    /// JSON Schema of its section of the scene.
    fn schema() -> serde_json::Value;

    /// What stands in for the absent peer when it runs alone.
    ///
    /// # Errors
    /// [`SceneError`] if the scene needs the peer.
    fn stand_in(scene: &CheckedScene) -> Result<Answer<Self::Incoming>, SceneError>;

    /// Windows and sub-steps when it runs alone.
    fn clock(scene: &CheckedScene, facts: &Self::Facts) -> Clock;

    /// Splits what came and what went into loads and kinematics, for observers.
    fn sides<'a>(
        incoming: &'a [Self::Incoming],
        outgoing: &'a [Self::Outgoing],
    ) -> (&'a [Loads], &'a [Kinematics]);

    /// What it writes and measures at the end of a run alone that went well: files into `folder`,
    /// values of the metrics that only it can measure.
    ///
    /// # Errors
    /// [`SolverError`] if a file cannot be written.
    fn finish(
        &mut self,
        _scene: &CheckedScene,
        _folder: &OutputFolder,
    ) -> Result<BTreeMap<String, MetricValue>, SolverError> {
        Ok(BTreeMap::new())
    }

    /// Values of the columns that only it knows, in a run alone ([`crate::output::energy_columns`]).
    fn scalars(&self) -> Vec<f64> {
        Vec::new()
    }

    /// The facts under the role they belong to.
    fn facts_by_role(facts: &Self::Facts) -> (Option<&FluidFacts>, Option<&DemFacts>);
}

#[derive(Parser)]
#[command(version, about, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Read the scene and print what this solver makes of it
    Check {
        #[command(flatten)]
        options: RunOptions,
        /// As JSON, for the coupler
        #[arg(long)]
        json: bool,
    },
    /// Print the JSON Schema of this solver's section of the scene
    Schema,
    /// Run alone
    Run {
        #[command(flatten)]
        options: RunOptions,
    },
    /// Join a coupled run (started by `bedload run`)
    Serve {
        #[command(flatten)]
        options: RunOptions,
        /// Where to meet the coupler; by default from the environment
        #[arg(long, value_name = "TOKEN")]
        connect: Option<String>,
        /// Checkpoint folder to start from
        #[arg(long, value_name = "DIR")]
        checkpoint: Option<PathBuf>,
    },
    /// Do again what a log says it did
    Replay {
        /// Log of a coupled run (MCAP)
        log: PathBuf,
        /// Compare every message bit for bit; exit 1 at the first difference
        #[arg(long)]
        verify: bool,
        /// Checkpoint folder to start from, for the log of a resumed run
        #[arg(long, value_name = "DIR")]
        checkpoint: Option<PathBuf>,
        /// Threads; results do not depend on it
        #[arg(long, value_name = "N", default_value_t = 1)]
        threads: usize,
        /// Output folder
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// How a program ends, besides well.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// Bad input: exit 2.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// The folder cannot be used: exit 2.
    #[error(transparent)]
    Folder(#[from] crate::output::OutputError),
    /// The solver failed: exit 1; or its peer did: exit 3.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// A comparison differs: exit 1.
    #[error("{0}")]
    Different(String),
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
    /// Exit code of `docs/conventions.md`: 1 failed or different, 2 bad input, 3 peer lost,
    /// 130 interrupted.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Folder(_) => 2,
            Self::Solver(SolverError::Exchange(
                ExchangeError::PeerDied { .. } | ExchangeError::Deadline { .. },
            )) => 3,
            Self::Solver(_) | Self::Different(_) => 1,
            Self::Interrupted => 130,
        }
    }
}

/// The whole program.
#[must_use]
pub fn main<S>() -> ExitCode
where
    S: Solver,
    S::Incoming: Wire + Logged,
    S::Outgoing: Wire + Logged,
{
    match dispatch::<S>(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            explain(S::PROGRAM, &error);
            ExitCode::from(error.exit_code())
        }
    }
}

/// Prints an error, with the marked place where it has one.
pub fn explain(program: &str, error: &ProgramError) {
    match error {
        ProgramError::Scene(scene) => {
            crate::say!("{program}: {scene}");
            crate::say!("  remedy: {}", scene.remedy);
        }
        other => crate::say!("{program}: {other}"),
    }
}

fn dispatch<S>(command: Command) -> Result<(), ProgramError>
where
    S: Solver,
    S::Incoming: Wire + Logged,
    S::Outgoing: Wire + Logged,
{
    match command {
        Command::Check { options, json } => check::<S>(&options, json),
        Command::Schema => {
            println!("{:#}", S::schema());
            Ok(())
        }
        Command::Run { options } => alone_run::run::<S>(&options),
        Command::Serve { options, connect, checkpoint } => {
            coupled::serve::<S>(&options, connect.as_deref(), checkpoint.as_deref())
        }
        Command::Replay { log, verify, checkpoint, threads, out } => {
            coupled::replay::<S>(&log, verify, checkpoint.as_deref(), out.as_deref(), threads)
        }
    }
}

fn check<S: Solver>(options: &RunOptions, json: bool) -> Result<(), ProgramError> {
    let scene = options.read_scene()?;
    let facts = S::facts(&scene)?;
    if json {
        let text = serde_json::to_string(&facts).map_err(|error| SolverError::Failed(error.to_string()))?;
        println!("{text}");
    } else {
        let table = toml::Table::try_from(&facts).map_err(|error| SolverError::Failed(error.to_string()))?;
        print!("{table}");
    }
    Ok(())
}

/// Runs `work` in a pool of as many threads as asked.
fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T, ProgramError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| SolverError::Failed(format!("cannot start {threads} threads: {error}")))?;
    Ok(pool.install(work))
}
