//! After a failure: a checkpoint of the window before it.
//!
//! A solver that fails in the middle of a window has lost the state at its start, and a copy in every
//! window would cost every run. What led there is done again instead, bit for bit, from the last whole
//! checkpoint or from the start: at most `coupling.checkpoint_every` of work, and only after a failure.

use std::time::Instant;

use bedload_output::{OutputFolder, Summary};
use bedload_program::RunOptions;

use crate::conduct::End;
use crate::failure::Failure;
use crate::prepare::Prepared;
use crate::resume;
use crate::session::{Job, conduct};
use crate::supervise::Interrupts;

/// Writes the checkpoint at the start of window `step`, which failed, and says so; says why where that
/// does not work: then the last regular one stands.
pub(crate) fn rewind(
    options: &RunOptions,
    prepared: &Prepared,
    folder: &OutputFolder,
    interrupts: Interrupts,
    step: u64,
) {
    match again(options, prepared, folder, interrupts, step) {
        Ok(()) => protocol::say!(
            "bedload: checkpoint of window {step}, before the failure, in {}",
            folder.checkpoint().display()
        ),
        Err(failure) => protocol::say!("bedload: no checkpoint of the window before the failure: {failure}"),
    }
}

fn again(
    options: &RunOptions,
    prepared: &Prepared,
    folder: &OutputFolder,
    interrupts: Interrupts,
    step: u64,
) -> Result<(), Failure> {
    let from = resume::latest(folder, &prepared.scene.state_sha256()).ok();
    let start = from.as_ref().map_or(0, |(_, state)| state.observer.tally.windows);
    if from.is_some() && start == step {
        return Ok(());
    }
    protocol::say!("bedload: doing windows {start} to {step} again for a checkpoint before the failure");
    // What was measured stands in the summary of the run that failed.
    let mut summary = Summary::new(&prepared.scene, "");
    let job = Job { options, prepared, folder, begin: Instant::now(), last: Some(step) };
    let mut done = None;
    match conduct(&job, interrupts, from, &mut summary, &mut done)? {
        End::Reached => Ok(()),
        End::Interrupted => Err(Failure::Interrupted("the last regular checkpoint stands".into())),
    }
}
