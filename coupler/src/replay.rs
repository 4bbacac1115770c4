//! `bedload replay`: one solver driven by a log.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use protocol::log::LogReader;
use protocol::participant::Role;
use rustix::process::Signal;

use crate::failure::Failure;
use crate::session::start;
use crate::solvers::Solver;
use crate::supervise::{Interrupts, Supervisor, Words};

/// What `bedload replay` was asked.
#[derive(Clone, Debug)]
pub(crate) struct Replay {
    /// The log.
    pub(crate) log: PathBuf,
    /// Which solver to drive.
    pub(crate) drive: Role,
    /// Compare bit for bit.
    pub(crate) verify: bool,
    /// Checkpoint that the log begins at, where it is not the start of the run.
    pub(crate) checkpoint: Option<PathBuf>,
    /// Output folder.
    pub(crate) out: Option<PathBuf>,
}

/// Starts the solver on the log and passes its verdict on: 0 the same, 1 different.
///
/// Our own solver is started whatever command the log names: a log is data, and may come from anyone.
///
/// # Errors
/// [`Failure`].
pub(crate) fn replay(replay: &Replay) -> Result<(), Failure> {
    let reader = LogReader::open(&replay.log).map_err(|error| Failure::Input(error.to_string()))?;
    let manifest = reader.manifest();
    if !manifest.has(replay.drive) {
        return Err(Failure::Input(format!(
            "{}: no {} took part in this run; drive the other solver",
            replay.log.display(),
            replay.drive
        )));
    }
    if manifest.first_step > 0 && replay.checkpoint.is_none() {
        return Err(Failure::Input(format!(
            "{} begins at window {}, a resumed run: name the checkpoint it went on from with --checkpoint DIR",
            replay.log.display(),
            manifest.first_step
        )));
    }
    let solver = Solver::ours(replay.drive);
    let interrupts =
        Interrupts::listen().map_err(|error| Failure::Run(format!("cannot handle signals: {error}")))?;
    let mut supervisor = Supervisor::default();
    start(&mut supervisor, &solver, &arguments(replay), Words::Own)?;
    while !supervisor.wait_all(Duration::from_millis(20)) {
        if interrupts.count() > 0 {
            // Nothing to save: a replay can be done again.
            supervisor.signal(Signal::TERM);
        }
    }
    match supervisor.exits().pop() {
        Some(exit) => match exit.code() {
            Some(0) => Ok(()),
            Some(code) => Err(Failure::Passed(u8::try_from(code).unwrap_or(1))),
            None if interrupts.count() > 0 => Err(Failure::Interrupted("the replay was not finished".into())),
            None => Err(Failure::Peer(exit.to_string())),
        },
        None => Err(Failure::Peer(format!("the {} solver is gone", replay.drive))),
    }
}

fn arguments(replay: &Replay) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["replay".into(), replay.log.clone().into()];
    if replay.verify {
        arguments.push("--verify".into());
    }
    if let Some(checkpoint) = &replay.checkpoint {
        arguments.extend(["--checkpoint".into(), checkpoint.into()]);
    }
    if let Some(out) = &replay.out {
        arguments.extend(["--out".into(), out.into()]);
    }
    arguments
}
