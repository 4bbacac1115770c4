//! Checkpoints: everything that decides the next window, bit for bit. The file's frame, with its
//! checks for other scenes, truncation and damage, is [`protocol::checkpoint`].

use crate::solver::{Memory, Snapshot, Solver};
use protocol::participant::SolverError;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Role in the file's name: `fluid.checkpoint`.
const ROLE: &str = "fluid";

/// A [`Snapshot`] as stored: fields in the order velocity, history, force (one per axis each),
/// pressure, then the velocity on each open face.
#[derive(Serialize, Deserialize)]
struct Stored {
    cells: Vec<u64>,
    time: f64,
    previous_dt: f64,
    steps: u64,
    memory: Memory,
    fields: Vec<Vec<f64>>,
}

/// Writes the checkpoint of `solver` to `folder`.
///
/// # Errors
/// [`SolverError::File`].
pub fn write<const D: usize>(solver: &Solver<D>, scene: &str, folder: &Path) -> Result<(), SolverError> {
    let Snapshot { state, lambda, memory } = solver.snapshot();
    let open: Vec<Vec<f64>> = state.open.fields().cloned().collect();
    let fields = state.velocity.into_iter().chain(state.history).chain(lambda).chain([state.pressure]);
    let stored = Stored {
        cells: cells(solver),
        time: state.time,
        previous_dt: state.previous_dt,
        steps: state.steps,
        memory,
        fields: fields.chain(open).collect(),
    };
    protocol::checkpoint::write(folder, ROLE, scene, &stored)
}

/// Reads the checkpoint in `folder` into `solver`, which is left as it was if that fails.
///
/// # Errors
/// If the file is missing, damaged, or of another scene or version.
pub fn read<const D: usize>(solver: &mut Solver<D>, scene: &str, folder: &Path) -> Result<(), SolverError> {
    let mut stored: Stored = protocol::checkpoint::read(folder, ROLE, scene)?;
    let mut snapshot = solver.snapshot();
    let grains = snapshot.memory.motions.len();
    let Snapshot { state, lambda, memory } = &mut snapshot;
    let targets = state.velocity.iter_mut().chain(&mut state.history).chain(lambda);
    let mut targets: Vec<&mut Vec<f64>> =
        targets.chain([&mut state.pressure]).chain(state.open.fields_mut()).collect();
    let lengths = |fields: &mut dyn Iterator<Item = usize>| fields.collect::<Vec<_>>();
    let fits = stored.cells == cells(solver)
        && lengths(&mut stored.fields.iter().map(Vec::len)) == lengths(&mut targets.iter().map(|f| f.len()))
        && stored.memory.grains() == Some(grains);
    if !fits {
        return Err(SolverError::Failed(format!(
            "{}: holds another grid, method or number of grains than the scene asks for: start anew",
            protocol::checkpoint::path(folder, ROLE).display()
        )));
    }
    for (target, field) in targets.iter_mut().zip(&mut stored.fields) {
        std::mem::swap(*target, field);
    }
    (state.time, state.previous_dt, state.steps) = (stored.time, stored.previous_dt, stored.steps);
    *memory = stored.memory;
    solver.resume(&snapshot);
    Ok(())
}

fn cells<const D: usize>(solver: &Solver<D>) -> Vec<u64> {
    solver.grid().cells.iter().map(|n| *n as u64).collect()
}
