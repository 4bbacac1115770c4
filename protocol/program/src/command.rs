//! The commands of a solver, as typed.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use protocol::channel::Wire;

use crate::disk::fail_at_file_limit;
use crate::failure::Failure;
use crate::loudness::{Loudness, done};
use crate::options::RunOptions;
use crate::orphan::{PARENT, end_with_parent};
use crate::printing::end_where_nothing_is_printed;
use crate::solver::Solver;
use crate::threads::with_threads;
use crate::{alone, replay, serve};

#[derive(Parser)]
#[command(propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    loudness: Loudness,
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
        /// Compare every message bit for bit; exit 1 at the first difference, 6 if the log breaks off
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

/// The whole program.
pub fn main<S>() -> ExitCode
where
    S: Solver,
    S::Incoming: Wire<Answer = S::Outgoing>,
{
    end_where_nothing_is_printed();
    fail_at_file_limit();
    let Arguments { command, loudness } = arguments(S::PROGRAM, S::ABOUT);
    loudness.set();
    match bedload_vectors::check().map_err(Failure::Input).and_then(|()| dispatch::<S>(command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            error.explain(S::PROGRAM);
            ExitCode::from(error.exit_code())
        }
    }
}

/// What was typed, in the name of the program: all of them are of one build and have its version.
fn arguments(program: &'static str, about: &'static str) -> Arguments {
    let command = Arguments::command().name(program).version(env!("CARGO_PKG_VERSION")).about(about);
    let found = Arguments::from_arg_matches(&command.get_matches());
    found.unwrap_or_else(|error| error.exit())
}

fn dispatch<S>(command: Command) -> Result<(), Failure>
where
    S: Solver,
    S::Incoming: Wire<Answer = S::Outgoing>,
{
    match command {
        Command::Check { options, json } => check::<S>(&options, json),
        Command::Schema => {
            println!("{:#}", S::schema());
            Ok(())
        }
        Command::Run { options } => {
            end_with_parent()?;
            alone::run::<S>(&options)?;
            // `bedload` says it itself.
            if std::env::var_os(PARENT).is_none() {
                done(S::PROGRAM, &options.out_path(), "");
            }
            Ok(())
        }
        Command::Serve { options, connect, checkpoint } => {
            serve::serve::<S>(&options, connect.as_deref(), checkpoint.as_deref())
        }
        Command::Replay { log, verify, checkpoint, threads, out } => {
            end_with_parent()?;
            replay::command::<S>(&log, verify, checkpoint.as_deref(), out.as_deref(), threads)
        }
    }
}

fn check<S: Solver>(options: &RunOptions, json: bool) -> Result<(), Failure> {
    let scene = options.read_scene()?;
    // The facts are measured by the kernels, which work in a pool.
    let facts = with_threads(options.threads(), || S::facts(&scene))??;
    if json {
        let text = serde_json::to_string(&facts).map_err(|error| Failure::Run(error.to_string()))?;
        println!("{text}");
    } else {
        let table = toml::Table::try_from(&facts).map_err(|error| Failure::Run(error.to_string()))?;
        print!("{table}");
    }
    Ok(())
}
