//! Checkpoints: everything that decides the next window, bit for bit. The file's frame, with its
//! checks for other scenes, truncation and damage, is [`protocol::checkpoint`].
//!
//! The file is the same for any number of ranks: the first one writes it, plane by plane as the others send theirs,
//! and each reads from it what is its own.

use crate::field::own_planes;
use crate::gather::{self, Gathered};
use crate::solver::{Memory, Solver};
use protocol::participant::SolverError;
use serde::Serialize;
use std::path::Path;

/// Role in the file's name: `fluid.checkpoint`.
const ROLE: &str = "fluid";

/// What decides the next window, as stored; [`read`] takes the same parts one by one.
#[derive(Serialize)]
struct Stored<'a, const D: usize> {
    cells: Vec<u64>,
    time: f64,
    previous_dt: f64,
    steps: u64,
    memory: &'a Memory,
    /// See [`Solver::fields`].
    fields: Vec<Gathered<'a, D>>,
}

/// Writes the checkpoint of `solver` to `folder`.
///
/// # Errors
/// [`SolverError::File`].
pub fn write<const D: usize>(solver: &Solver<D>, scene: &str, folder: &Path) -> Result<(), SolverError> {
    let (state, grid) = (solver.stepper().state(), solver.grid());
    let ranks = grid.division.ranks();
    if !ranks.is_first() {
        gather::send_to_first(grid, solver.fields().into_iter());
        return ranks.check();
    }
    let stored = Stored {
        cells: cells(solver),
        time: state.time,
        previous_dt: state.previous_dt,
        steps: state.steps,
        memory: solver.memory(),
        fields: solver.fields().into_iter().map(|field| Gathered { grid, field }).collect(),
    };
    protocol::checkpoint::write(folder, ROLE, scene, &stored)
}

/// Reads the checkpoint in `folder` into `solver`.
///
/// # Errors
/// If the file is missing, damaged, or of another scene or version: then `solver` is as it was. If the disk
/// fails on the way: then it is of no further use.
pub fn read<const D: usize>(solver: &mut Solver<D>, scene: &str, folder: &Path) -> Result<(), SolverError> {
    let mut payload = protocol::checkpoint::open(folder, ROLE, scene)?;
    let grid: Vec<u64> = payload.part()?;
    let (time, previous_dt, steps) = payload.part()?;
    let memory: Memory = payload.part()?;
    let fields: u64 = payload.part()?;
    let fits = grid == cells(solver)
        && fields == solver.fields().len() as u64
        && memory.grains() == solver.memory().grains();
    if !fits {
        return Err(SolverError::Failed(format!(
            "{}: holds another grid, method or number of grains than the scene asks for: start anew",
            protocol::checkpoint::path(folder, ROLE).display()
        )));
    }
    let own = own_planes(solver.grid());
    let length = solver.grid().len();
    for field in solver.fields_mut() {
        let part = if field.len() == length { own.clone() } else { 0..field.len() };
        payload.fill_part(field, part)?;
    }
    payload.end()?;
    solver.restart((time, previous_dt, steps), memory);
    Ok(())
}

fn cells<const D: usize>(solver: &Solver<D>) -> Vec<u64> {
    solver.grid().cells.iter().map(|n| *n as u64).collect()
}
