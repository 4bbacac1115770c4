//! The runs of the cases: child processes, several at a time.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use protocol::output::{RunOptions, RunStatus, Summary};

use super::case::{Case, Run};
use super::{Validate, ValidateError};

/// What became of a run.
#[derive(Clone, Debug)]
pub(super) enum Outcome {
    /// It left a result.
    Done(Box<Summary>),
    /// It left none, and why.
    Failed(String),
    /// `--quick` left it out.
    LeftOut,
}

/// Runs every chosen run of every case; outcomes by case, in the order of its runs.
pub(super) fn run_all(cases: &[Case], options: &Validate) -> Result<Vec<Vec<Outcome>>, ValidateError> {
    let program = std::env::current_exe().map_err(ValidateError::file("find", Path::new("bedload")))?;
    let chosen: Vec<(usize, usize)> = cases
        .iter()
        .enumerate()
        .flat_map(|(c, case)| (0..case.runs.len()).map(move |r| (c, r)))
        .filter(|(c, r)| !options.quick || cases[*c].runs[*r].quick)
        .collect();
    for case in cases {
        let folder = options.out.join(&case.name);
        std::fs::create_dir_all(&folder).map_err(ValidateError::file("make", &folder))?;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = options.jobs.map_or(cores, usize::from).clamp(1, chosen.len().max(1));
    let threads = (cores / jobs).max(1);
    let left_out = cases.iter().map(|case| vec![Outcome::LeftOut; case.runs.len()]).collect();
    let outcomes: Mutex<Vec<Vec<Outcome>>> = Mutex::new(left_out);
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                while let Some(&(c, r)) = chosen.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let case = &cases[c];
                    let task =
                        Task { program: &program, case, run: &case.runs[r], out: &options.out, threads };
                    let outcome = task.outcome();
                    outcomes.lock().unwrap_or_else(std::sync::PoisonError::into_inner)[c][r] = outcome;
                }
            });
        }
    });
    Ok(outcomes.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
}

/// One run, about to be made.
struct Task<'a> {
    program: &'a Path,
    case: &'a Case,
    run: &'a Run,
    out: &'a Path,
    threads: usize,
}

impl Task<'_> {
    fn folder(&self) -> PathBuf {
        self.out.join(&self.case.name).join(&self.run.label)
    }

    fn outcome(&self) -> Outcome {
        let name = format!("{}/{}", self.case.name, self.run.label);
        match self.finished() {
            Ok(Some(summary)) => {
                protocol::say!("bedload: {name}: finished before");
                Outcome::Done(Box::new(summary))
            }
            Ok(None) => self.make(&name),
            Err(error) => Outcome::Failed(error),
        }
    }

    /// The summary of the same run of the same version, if it is there and complete.
    fn finished(&self) -> Result<Option<Summary>, String> {
        let scene = self.case.scene(self.run);
        let options = RunOptions { overrides: self.run.set.clone(), ..RunOptions::of_scene(&scene) };
        let sha256 = options.read_scene().map_err(|error| error.to_string())?.sha256();
        let summary = Summary::read(&self.folder().join("summary.json")).ok();
        Ok(summary.filter(|summary| {
            summary.status == RunStatus::Completed
                && summary.scene_sha256 == sha256
                && summary.version == env!("CARGO_PKG_VERSION")
        }))
    }

    /// Runs it; what it says goes to a file beside its folder.
    fn make(&self, name: &str) -> Outcome {
        protocol::say!("bedload: {name}: runs");
        let said = self.out.join(&self.case.name).join(format!("{}.log", self.run.label));
        let status = match self.start(&said) {
            Ok(status) => status,
            Err(error) => return Outcome::Failed(error.to_string()),
        };
        match Summary::read(&self.folder().join("summary.json")) {
            Ok(summary) if status.success() && summary.status == RunStatus::Completed => {
                protocol::say!("bedload: {name}: done in {:.1} s", summary.cost.wall_s);
                Outcome::Done(Box::new(summary))
            }
            _ => {
                protocol::say!("bedload: {name}: failed, see {}", said.display());
                Outcome::Failed(format!("the run ended with {status}, see {}", said.display()))
            }
        }
    }

    fn start(&self, said: &Path) -> Result<std::process::ExitStatus, ValidateError> {
        let log = std::fs::File::create(said).map_err(ValidateError::file("write", said))?;
        let mut command = Command::new(self.program);
        command.arg("run").arg(self.case.scene(self.run));
        for value in &self.run.set {
            command.arg("--set").arg(value);
        }
        command.arg("--threads").arg(self.threads.to_string()).arg("--out").arg(self.folder());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
        command.status().map_err(ValidateError::file("start", self.program))
    }
}
