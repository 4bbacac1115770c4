//! The command line of `bedload`.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bedload_program::{Loudness, RunOptions};
use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use protocol::new_file::is_full;

use crate::new::New;
use crate::pack::Pack;
use coupler::export::Viewer;
use coupler::failure::{Failure, explain};
use coupler::log_command::{self, CatOptions, LogCommandError};
use coupler::replay::{self, Replay};
use coupler::{check, conformance};
use study::ensemble::Ensemble;
use study::film::Film;
use study::{commands, evidence};

/// Release, and the commit of this build.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("BEDLOAD_COMMIT"), ")");

/// Grains in a flow: fluid and DEM solvers coupled.
///
/// Exit codes: 0 done; 1 a run failed or a comparison differs; 2 bad input or a broken bound; 3 a
/// solver died or timed out; 4 the run was unstable; 5 no room on the disk; 6 a log breaks off or is
/// damaged; 7 another process writes there; 130 interrupted (checkpoint and log are in order).
#[derive(Debug, Parser)]
#[command(name = "bedload", version = VERSION, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    loudness: Loudness,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a folder with a commented scene to start from, and print the commands that come next
    New(New),
    /// Validate a scene and print its plan: steps, bounds, cost
    Check {
        /// Scene file (TOML)
        scene: PathBuf,
        /// Override any key of the scene, such as --set grains[0].density=2.0; may be repeated
        #[arg(long = "set", value_name = "KEY=VALUE")]
        overrides: Vec<String>,
        /// End of the run, s, instead of the scene's `until`
        #[arg(long, value_name = "T", allow_negative_numbers = true)]
        until: Option<f64>,
        /// Error that is good enough, such as 2%: settings from the chart of this class of scenes
        #[arg(long, value_name = "PART")]
        accuracy: Option<String>,
        /// Print the plan as JSON
        #[arg(long)]
        json: bool,
        /// Start the solvers that the scene names with `command`, to ask them; without it only those of this
        /// build
        #[arg(long)]
        allow_commands: bool,
        /// Print the scene of one of the cheaper models that are proposed
        #[arg(long, value_name = "NAME", conflicts_with = "json")]
        cheaper: Option<String>,
    },
    /// Run a scene
    Run {
        #[command(flatten)]
        options: RunOptions,
        /// Error that is good enough, such as 2%: settings from the chart of this class of scenes
        #[arg(long, value_name = "PART")]
        accuracy: Option<String>,
        /// Measure the error by coarser grids of the scene itself, and refine until it is small enough: also
        /// for scenes without a chart
        #[arg(long)]
        verify: bool,
    },
    /// Drive one solver from a log, at full speed; with other values of the scene, or another solver
    Replay(Replay),
    /// Read a log without any solver
    Log {
        #[command(subcommand)]
        command: LogWord,
    },
    /// Run the sweep of a scene's [chart] section: error against cost, with the Pareto front
    Chart {
        /// Scene file (TOML) with a [chart] section
        scene: PathBuf,
        /// Folder of runs, table, figure and page; finished runs in it are not repeated. By default
        /// out/SCENE-chart
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Runs at a time, where errors alone matter: costs are timings only of runs one by one
        #[arg(long, value_name = "N")]
        jobs: Option<NonZeroUsize>,
    },
    /// Run published cases and compare with their references; exit 1 if a check fails
    Validate {
        /// Names (falling-sphere) or files (*.toml) of cases; by default all in scenes/validation
        cases: Vec<String>,
        /// Only quick runs of quick cases: minutes in all
        #[arg(long)]
        quick: bool,
        /// Runs at a time; by default as many as there are cores
        #[arg(long, value_name = "N")]
        jobs: Option<NonZeroUsize>,
        /// Folder of runs, page and figures; finished runs in it are not repeated
        #[arg(long, value_name = "DIR", default_value = "out/validation")]
        out: PathBuf,
    },
    /// Run a scene's [stability] sweep and draw where each method fails, beside the bound; exit 1 if
    /// `check` accepts a run that failed
    Stability {
        /// Scene file (TOML) with a [stability] section
        scene: PathBuf,
        /// Folder of runs, stability.csv, .svg and .html; by default out/SCENE-stability; finished runs
        /// in it are not repeated
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Runs at a time; by default as many as there are cores
        #[arg(long, value_name = "N")]
        jobs: Option<NonZeroUsize>,
    },
    /// Run a scene once per seed: mean and standard error of every metric, column and profile. Exit 1 if a
    /// seed failed; the table is then of the others
    Ensemble {
        #[command(flatten)]
        asked: Ensemble,
        /// Folder of runs, ensemble.csv and ensemble.svg; by default out/SCENE-ensemble; finished runs in it
        /// are not repeated
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Runs at a time; by default as many as there are cores
        #[arg(long, value_name = "N")]
        jobs: Option<NonZeroUsize>,
    },
    /// Make a random packing of a solid fraction: a table of grains for [[grain_files]]; exit 1 where grains
    /// do not reach it
    Pack(Pack),
    /// Make studies: the charts, maps and cases of these files, or of the whole repository
    Study {
        /// Files with a section `chart`, `stability` or `case`
        #[arg(required_unless_present_any = ["all", "sample", "mark"])]
        files: Vec<PathBuf>,
        /// All studies of the repository, in their order, into docs; finished runs are not repeated
        #[arg(long, conflicts_with = "files")]
        all: bool,
        /// Only print what --all would make, and the time it takes
        #[arg(long, requires = "all")]
        list: bool,
        /// Make a sample of every table again; exit 1 if docs/evidence.csv does not say what it gives
        #[arg(long, conflicts_with_all = ["files", "all"])]
        sample: bool,
        /// The same, and write which tables are stale into docs/evidence.csv and the pages
        #[arg(long, conflicts_with_all = ["files", "all", "sample"])]
        mark: bool,
        /// Folder of runs, tables, figures and pages
        #[arg(long, value_name = "DIR", conflicts_with = "all")]
        out: Option<PathBuf>,
        /// Runs at a time
        #[arg(long, value_name = "N")]
        jobs: Option<NonZeroUsize>,
    },
    /// Test any solver command against the protocol, role by role; exit 1 if it fails
    Conformance(conformance::Options),
    /// Make report.html in the output folder of each run, chart.html and stability.html in those of sweeps
    Report {
        /// Output folders of runs, charts and maps
        #[arg(required = true)]
        dirs: Vec<PathBuf>,
    },
    /// Draw a plane of a run's fields, with the grains in it, frame by frame: film/*.png and film.gif, and
    /// film.mp4 where ffmpeg is
    Film(Film),
    /// Print the JSON Schema of a whole scene
    Schema,
    /// Print what a shell needs to complete the commands, such as: bedload completions bash >
    /// ~/.local/share/bash-completion/completions/bedload
    Completions {
        /// Shell
        shell: Shell,
    },
    /// Write a manual page of each command, such as into ~/.local/share/man/man1
    Man {
        /// Folder
        dir: PathBuf,
    },
    /// Name a run's files for viewers and tables
    Export {
        /// Output folder of a run
        dir: PathBuf,
        #[command(flatten)]
        viewer: Viewer,
    },
}

#[derive(Debug, Subcommand)]
enum LogWord {
    /// What a log holds
    Info {
        /// Log (MCAP)
        log: PathBuf,
    },
    /// Print its messages
    Cat {
        /// Log (MCAP)
        log: PathBuf,
        /// Only this topic; its last part is enough (`loads`)
        #[arg(long)]
        topic: Option<String>,
        /// Only these windows: A..B, A.., ..B or A
        #[arg(long, value_name = "RANGE")]
        step: Option<String>,
        /// JSON, one object per line
        #[arg(long)]
        json: bool,
    },
    /// Rewrite a log that breaks off or is damaged, complete and indexed
    Repair {
        /// Log (MCAP)
        log: PathBuf,
        /// New log; by default the log itself is replaced
        out: Option<PathBuf>,
    },
    /// Write a small log for viewers: some of the frames, and none of the messages that a replay needs
    Thin {
        /// Log (MCAP)
        log: PathBuf,
        /// New log
        out: PathBuf,
        /// Keep every N-th frame
        #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        every: u64,
    },
}

/// The whole program.
pub(crate) fn main() -> ExitCode {
    bedload_program::end_where_nothing_is_printed();
    bedload_program::fail_at_file_limit();
    let Arguments { command, loudness } = Arguments::parse();
    loudness.set();
    match dispatch(command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let code = failure.exit_code();
            explain(failure);
            ExitCode::from(code)
        }
    }
}

/// `--accuracy` is the scene's key of that name.
fn with_accuracy(mut options: RunOptions, accuracy: Option<String>) -> RunOptions {
    options.overrides.extend(accuracy.map(|accuracy| format!("accuracy={accuracy:?}")));
    options
}

/// How a study is made: `--out`, `--jobs`, and the commit of this build.
fn studied(out: Option<PathBuf>, jobs: Option<NonZeroUsize>) -> commands::Options {
    commands::Options { out, jobs, commit: env!("BEDLOAD_COMMIT") }
}

fn log(word: &LogWord) -> Result<(), LogCommandError> {
    let mut out = std::io::stdout().lock();
    match word {
        LogWord::Info { log } => log_command::info(log, &mut out),
        LogWord::Cat { log, topic, step, json } => {
            let steps = step.as_deref().map(log_command::parse_steps).transpose()?;
            let options = CatOptions { topic: topic.clone(), steps, json: *json };
            log_command::cat(log, &options, &mut out)
        }
        LogWord::Repair { log, out: to } => log_command::repair(log, to.as_deref(), &mut out),
        LogWord::Thin { log, out: to, every } => log_command::thin(log, to, *every, &mut out),
    }
}

fn dispatch(command: Command) -> Result<(), Failure> {
    match command {
        Command::New(asked) => crate::new::new(&asked),
        Command::Check { scene, overrides, until, json, cheaper, accuracy, allow_commands } => {
            let options =
                RunOptions { overrides, until, no_commands: !allow_commands, ..RunOptions::of_scene(&scene) };
            study::section::Section::check_all(&options)?;
            let options = with_accuracy(options, accuracy);
            cheaper.map_or_else(|| check::check(&options, json), |name| check::cheaper(&options, &name))
        }
        Command::Run { options, accuracy, verify } => {
            bedload_program::end_with_parent()?;
            study::section::Section::check_all(&options)?;
            let run = if verify { coupler::verify::run } else { coupler::run::run };
            run(&with_accuracy(options, accuracy), study::report::page::write)
        }
        Command::Replay(asked) => replay::replay(&asked, study::divergence::figure),
        Command::Log { command } => Ok(log(&command)?),
        Command::Chart { scene, out, jobs } => commands::chart(&scene, &studied(out, jobs)),
        Command::Validate { cases, quick, jobs, out } => {
            commands::validate(&cases, quick, &studied(Some(out), jobs))
        }
        Command::Stability { scene, out, jobs } => commands::stability(&scene, &studied(out, jobs)),
        Command::Ensemble { asked, out, jobs } => study::ensemble::ensemble(&asked, &studied(out, jobs)),
        Command::Pack(pack) => crate::pack::pack(&pack),
        Command::Study { files, all, list, sample, mark, out, jobs } => {
            let options = studied(out, jobs);
            match (all && list, sample || mark) {
                (true, _) => evidence::list(),
                (_, true) => evidence::sample(mark, &options),
                _ => evidence::study(&files, &options),
            }
        }
        Command::Conformance(asked) => conformance::conformance(&asked),
        Command::Report { dirs } => {
            let dirs: Vec<&Path> = dirs.iter().map(PathBuf::as_path).collect();
            for page in study::report::report(&dirs)? {
                println!("{}", page.display());
            }
            Ok(())
        }
        Command::Film(asked) => {
            study::film::film(&asked)?.iter().for_each(|path| println!("{}", path.display()));
            Ok(())
        }
        Command::Schema => {
            println!("{:#}", crate::schema::schema());
            Ok(())
        }
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "bedload", &mut text);
            print!("{}", String::from_utf8_lossy(&text));
            Ok(())
        }
        Command::Man { dir } => {
            let made = std::fs::create_dir_all(&dir)
                .and_then(|()| clap_mangen::generate_to(Arguments::command(), &dir));
            made.map_err(|error| {
                let remedy = "remedy: name a folder that can be made and written";
                let what = format!("{}: cannot write manual pages: {error}; {remedy}", dir.display());
                if is_full(&error) { Failure::Full(what) } else { Failure::Input(what) }
            })
        }
        Command::Export { dir, viewer } => coupler::export::export(&dir, viewer),
    }
}
