//! `bedload replay`: one solver driven by a log.
//!
//! As it was run, our own solver reads the log itself. With other values, with another solver, or to say how
//! far the messages are apart, this process plays the coupler and the other side.
//!
//! | file | what it holds |
//! |---|---|
//! | `request` | what was asked |
//! | `changed` | the scene with other values, and the solver that reads it |
//! | `substeps` | what a DEM with another sub-step is ordered |
//! | `drive` | the solver driven window by window |
//! | `divergence` | how far its messages are from the logged ones |

mod changed;
mod divergence;
mod drive;
mod request;
mod substeps;

use std::ffi::OsString;
use std::time::Duration;

use bedload_program::Interrupts;
use protocol::log::LogReader;
use rustix::process::Signal;

pub use request::{Figure, Replay};

use crate::coupled::start;
use crate::failure::Failure;
use crate::solvers::Solver;
use crate::supervise::{StderrMode, Supervisor};

/// Replays a log. Our own solver is started whatever command the log names: a log is data, and may come from
/// anyone.
///
/// # Errors
/// [`Failure`].
pub fn replay(replay: &Replay) -> Result<(), Failure> {
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
    let interrupts = Interrupts::listen(3)?;
    if replay.compare || !replay.overrides.is_empty() {
        return drive::compare(replay, reader, &interrupts);
    }
    by_itself(replay, &interrupts)
}

/// Starts the solver on the log and passes its exit code on: 0 the same, 1 different, 6 the log breaks off.
fn by_itself(replay: &Replay, interrupts: &Interrupts) -> Result<(), Failure> {
    let solver = Solver::ours(replay.drive);
    let mut supervisor = Supervisor::default();
    start(&mut supervisor, &solver, &arguments(replay), StderrMode::Own)?;
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
