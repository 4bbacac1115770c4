//! The coupler's part of a checkpoint, and which checkpoint is whole.
//!
//! A checkpoint is a folder `checkpoint/<step>`: one file of each solver and, written last, one of the
//! coupler. A folder without the coupler's file was cut short and is never resumed from.

use std::path::PathBuf;

use bedload_output::{ObserverState, OutputFolder};
use protocol::checkpoint;
use protocol::checkpoints;
use protocol::new_file::is_full;
use protocol::participant::SolverError;
use protocol::serve::checkpoint_folder;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::iterate::WatchState;
use crate::scheme::PlannerState;
use crate::unstable::Seen;

const ROLE: &str = "coupler";

/// Costs of a run up to a checkpoint, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spent {
    /// Wall time.
    pub(crate) wall: f64,
    /// CPU time of the fluid.
    pub(crate) fluid: f64,
    /// CPU time of the DEM.
    pub(crate) dem: f64,
    /// CPU time of the coupler.
    pub(crate) coupler: f64,
    /// Sending and receiving.
    pub(crate) exchange: f64,
    /// Recording.
    pub(crate) record: f64,
}

/// Everything of the coupler that decides, or counts, what comes next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CouplerState {
    /// Windows.
    pub(crate) planner: PlannerState,
    /// Metrics and counts.
    pub(crate) observer: ObserverState,
    /// Costs.
    pub(crate) spent: Spent,
    /// Windows in which something began to touch against the sub-step rule.
    pub(crate) late: u64,
    /// Attempts at windows, where they are repeated.
    pub(crate) watch: WatchState,
    /// Whether the motion alternates.
    pub(crate) seen: Seen,
}

/// Writes the coupler's file: the checkpoint of window `step` is whole from then on, and older ones
/// go.
///
/// # Errors
/// [`Failure::Run`] if the disk refuses.
pub(crate) fn complete(
    folder: &OutputFolder,
    step: u64,
    identity: &str,
    state: &CouplerState,
) -> Result<(), Failure> {
    let here = checkpoint_folder(folder.root(), step);
    checkpoint::write(&here, ROLE, identity, state).map_err(|error| match &error {
        SolverError::File { source, .. } if is_full(source) => Failure::Full(error.to_string()),
        _ => Failure::Run(error.to_string()),
    })?;
    checkpoints::remove_others(&folder.checkpoint(), Some(&here));
    Ok(())
}

/// Newest whole checkpoint: its folder and the coupler's state.
///
/// # Errors
/// [`Failure::Input`] if there is none, or it is of another scene.
pub(crate) fn latest(folder: &OutputFolder, identity: &str) -> Result<(PathBuf, CouplerState), Failure> {
    let Some(path) = checkpoints::newest(&folder.checkpoint(), ROLE) else {
        return Err(Failure::Input(format!(
            "{} holds no whole checkpoint to resume from: start anew without --resume",
            folder.checkpoint().display()
        )));
    };
    let state = checkpoint::read(&path, ROLE, identity).map_err(|error| {
        Failure::Input(format!(
            "{error}; --resume needs the scene and --set as they were, --until alone may be later"
        ))
    })?;
    Ok((path, state))
}
