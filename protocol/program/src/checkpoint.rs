//! The loop's part of a checkpoint, and which checkpoint is whole.
//!
//! A checkpoint is a folder `checkpoint/<step>`: one file of each solver and, written last,
//! `loop.checkpoint`. A folder without that file was cut short and is never resumed from. Where a run ends
//! there is `motion.checkpoint`, too: what it leaves at its end is made of the last motion, also after a
//! resume there.

use std::path::{Path, PathBuf};

use bedload_output::{Cost, ObserverState, OutputFolder};
use protocol::message::Kinematics;
use protocol::serve::checkpoint_folder;
use protocol::{checkpoint, checkpoints};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// Everything besides the solvers that decides, or counts, what comes next.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct LoopState<S> {
    /// Series, metrics and counts.
    pub(crate) observer: ObserverState,
    pub(crate) cost: Cost,
    pub(crate) schedule: S,
}

/// Role of the file with the last motion.
const MOTION: &str = "motion";

/// End of the last window, s, and the motion of every grain there.
pub(crate) type LastMotion = (f64, Vec<Kinematics>);

/// Writes the last motion into the checkpoint of window `step`, before that is whole.
pub(crate) fn write_motion(
    folder: &OutputFolder,
    step: u64,
    identity: &str,
    motion: (f64, &[Kinematics]),
) -> Result<(), Failure> {
    Ok(checkpoint::write(&checkpoint_folder(folder.root(), step), MOTION, identity, &motion)?)
}

/// The last motion in a checkpoint, if a run ended there.
pub(crate) fn read_motion(path: &Path, identity: &str) -> Result<Option<LastMotion>, Failure> {
    if !checkpoint::path(path, MOTION).is_file() {
        return Ok(None);
    }
    checkpoint::read(path, MOTION, identity).map(Some).map_err(|error| Failure::Input(error.to_string()))
}

/// Writes the loop's file: the checkpoint of window `step` is whole from then on, and older ones go.
pub(crate) fn complete(
    folder: &OutputFolder,
    step: u64,
    identity: &str,
    state: &impl Serialize,
) -> Result<(), Failure> {
    let here = checkpoint_folder(folder.root(), step);
    checkpoint::write(&here, checkpoints::LAST, identity, state)?;
    checkpoints::remove_others(&folder.checkpoint(), Some(&here));
    Ok(())
}

/// Newest whole checkpoint: its folder and the state of the loop.
pub(crate) fn latest<S: DeserializeOwned>(
    folder: &OutputFolder,
    identity: &str,
) -> Result<(PathBuf, LoopState<S>), Failure> {
    let Some(path) = checkpoints::newest(&folder.checkpoint()) else {
        return Err(Failure::Input(format!(
            "{} holds no whole checkpoint to resume from: start anew without --resume",
            folder.checkpoint().display()
        )));
    };
    let state = checkpoint::read(&path, checkpoints::LAST, identity).map_err(|error| {
        Failure::Input(format!(
            "{error}; --resume needs the scene, the tables of grains and values that it names, and --set as they \
             were, --until alone may be later"
        ))
    })?;
    Ok((path, state))
}
