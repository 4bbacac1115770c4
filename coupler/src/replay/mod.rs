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
use std::path::Path;

use bedload_program::Interrupts;
use protocol::log::{LogReader, Manifest};
use rustix::process::Signal;

pub use request::{Figure, Replay};

use crate::by_itself::{self, Silence};
use crate::config::Coupling;
use crate::failure::Failure;
use crate::solvers::Solver;

/// Replays a log. Our own solver is started whatever command the log names: a log is data, and may come from
/// anyone.
pub fn replay(replay: &Replay, figure: Figure) -> Result<(), Failure> {
    let reader = LogReader::open(&replay.log).map_err(|error| Failure::Input(error.to_string()))?;
    let manifest = reader.manifest().clone();
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
    if let Some(out) = &replay.out {
        refuse_run(out)?;
    }
    let interrupts = Interrupts::listen(3)?;
    if replay.compare || !replay.overrides.is_empty() {
        return drive::compare(replay, figure, reader, &interrupts);
    }
    alone(replay, &manifest, &interrupts)
}

/// A folder with a run in it would be emptied, perhaps of the log itself, or mixed with the replay.
fn refuse_run(folder: &Path) -> Result<(), Failure> {
    let of_run =
        ["exchange.mcap", "series.csv", "summary.json"].into_iter().find(|name| folder.join(name).exists());
    of_run.map_or(Ok(()), |name| {
        let folder = folder.display();
        Err(Failure::Input(format!(
            "{folder} holds a run ({name}): name a new folder for the replay with --out"
        )))
    })
}

/// Starts the solver on the log and passes its exit code on: 0 the same, 1 different, 6 the log breaks off.
fn alone(replay: &Replay, manifest: &Manifest, interrupts: &Interrupts) -> Result<(), Failure> {
    let solver = Solver::ours(replay.drive);
    let scene = changed::logged(replay, manifest);
    // The solver says what is wrong with it; a log of a former release may have other keys.
    let coupling = scene.as_ref().ok().and_then(|scene| Coupling::read(scene).ok()).unwrap_or_default();
    let silence = Silence::of(&coupling, manifest.grains());
    let exit = by_itself::run(&solver, &arguments(replay), silence, |supervisor| {
        if interrupts.count() > 0 {
            // Nothing to save: a replay can be done again.
            supervisor.signal(Signal::TERM);
        }
    })?;
    let exit = exit.map_err(Failure::Peer)?;
    match exit.code() {
        Some(0) => Ok(()),
        Some(code) => Err(Failure::Passed(u8::try_from(code).unwrap_or(1))),
        None if interrupts.count() > 0 => Err(Failure::Interrupted("the replay was not finished".into())),
        None => Err(Failure::Peer(exit.to_string())),
    }
}

fn arguments(replay: &Replay) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["replay".into(), replay.log.clone().into()];
    arguments.extend(replay.verify.then(|| "--verify".into()));
    for (option, value) in [("--checkpoint", &replay.checkpoint), ("--out", &replay.out)] {
        arguments.extend(value.iter().flat_map(|value| [option.into(), value.into()]));
    }
    arguments
}
