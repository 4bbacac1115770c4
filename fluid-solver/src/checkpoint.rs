//! Checkpoints: everything that decides the next window, bit for bit. The file's frame, with its
//! checks for other scenes, truncation and damage, is [`protocol::checkpoint`].
//!
//! One process writes one file. Of several ranks each writes the planes that it works on to a file of its own
//! (`checkpoint/parts.rs`); the first one then puts the head in place, which names them, so that a checkpoint
//! is whole from one moment on. Whoever reads takes the planes it needs, whatever the number of ranks that
//! wrote them.

pub(crate) mod part;
mod parts;
pub(crate) mod whole;

use crate::engines::HasEngine;
use crate::field::own_planes;
use crate::grid::Grid;
use crate::scheme::Viscous;
use crate::solver::Solver;
use part::{Head, ROLE};
use protocol::checkpoint::Payload;
use protocol::participant::SolverError;
use std::path::Path;
use whole::cells_of;

/// Writes the checkpoint of `solver` to `folder`.
///
/// # Errors
/// [`SolverError::File`], and what kept another rank from writing its part. The checkpoint before stands
/// then.
pub fn write<const D: usize>(solver: &Solver<D>, scene: &str, folder: &Path) -> Result<(), SolverError> {
    let (state, ranks) = (solver.stepper().state(), solver.grid().division.ranks());
    let alone = ranks.is_alone();
    let parts = if alone { Vec::new() } else { parts::write(solver, scene, folder)? };
    if !ranks.is_first() {
        return Ok(());
    }
    let head = Head {
        cells: cells_of(solver.grid()),
        time: state.time,
        previous_dt: state.previous_dt,
        steps: state.steps,
        explicit: solver.stepper().options().viscous == Viscous::Explicit,
        memory: solver.grains.memory.clone(),
        parts,
    };
    let fields = if alone { solver.fields() } else { Vec::new() };
    protocol::checkpoint::write(folder, ROLE, scene, &(&head, fields))?;
    parts::remove_others(folder, head.steps, head.parts.len());
    Ok(())
}

/// Reads the checkpoint in `folder` into `solver`.
///
/// # Errors
/// If a file is missing, damaged, or of another scene, checkpoint or version: then `solver` is as it was. If
/// the disk fails on the way: then it is of no further use.
pub fn read<const D: usize>(solver: &mut Solver<D>, scene: &str, folder: &Path) -> Result<(), SolverError>
where
    Grid<D>: HasEngine<D>,
{
    let mut payload = protocol::checkpoint::open(folder, ROLE, scene)?;
    let (Head { cells, time, previous_dt, steps, explicit, memory, parts }, fields): (_, u64) =
        payload.part()?;
    let stored = if parts.is_empty() { solver.fields().len() as u64 } else { 0 };
    let same_grains = memory.grains() == solver.grains.memory.grains();
    if cells != cells_of(solver.grid()) || fields != stored || !same_grains {
        return Err(payload
            .refuse("holds another grid, method or number of grains than the scene asks for: start anew"));
    }
    if parts.is_empty() {
        fill(solver, &mut payload)?;
    } else {
        parts::read(solver, scene, folder, steps, &parts)?;
    }
    payload.end()?;
    solver.treat_viscosity(if explicit { Viscous::Explicit } else { Viscous::Implicit });
    solver.restart((time, previous_dt, steps), memory);
    Ok(())
}

/// Takes the planes of this process from the fields of one file.
fn fill<const D: usize>(solver: &mut Solver<D>, payload: &mut Payload) -> Result<(), SolverError> {
    let (own, whole) = (own_planes(solver.grid()), solver.grid().len());
    for field in solver.fields_mut() {
        let count = field.len();
        let place = if count == whole { own.clone() } else { 0..count };
        payload.fill(&mut field[place.clone()], count, place.start)?;
    }
    Ok(())
}
