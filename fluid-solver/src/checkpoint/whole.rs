//! A checkpoint read whole, whatever the number of ranks that wrote it, and without a solver.

use super::part::{Head, Part, ROLE, place, role};
use crate::grid::Grid;
use protocol::participant::SolverError;
use std::path::Path;

/// A checkpoint with whole fields, whoever wrote it.
pub(crate) struct Whole {
    pub(crate) head: Head,
    /// See [`crate::solver::Solver::fields`]: velocity, history, force, pressure, open faces, points.
    pub(crate) fields: Vec<Vec<f64>>,
}

/// Reads the checkpoint in `folder` of a run on `grid`, with the identity of its scene, without a solver.
///
/// # Errors
/// If a file is missing, damaged, or of another grid or version.
pub(crate) fn read_whole<const D: usize>(
    grid: &Grid<D>,
    folder: &Path,
) -> Result<(String, Whole), SolverError> {
    let (scene, mut payload) = protocol::checkpoint::open_any(folder, ROLE)?;
    let (head, count): (Head, u64) = payload.part()?;
    let known = 3 * D as u64 + 1;
    let fits = if head.parts.is_empty() { count >= known } else { count == 0 };
    if !fits || head.cells != cells_of(grid) || head.memory.grains().is_none() {
        return Err(
            payload.refuse("holds another grid, or other fields, than the scene.toml of its run says")
        );
    }
    let fields = if head.parts.is_empty() {
        (0..count).map(|_| payload.list()).collect::<Result<_, _>>()?
    } else {
        read_parts(grid, &scene, folder, head.steps, &head.parts)?
    };
    payload.end()?;
    let whole = |at: usize, field: &Vec<f64>| {
        let empty = (2 * D..3 * D).contains(&at) && field.is_empty();
        empty || field.len() == grid.len()
    };
    if !fields.iter().enumerate().take(3 * D + 1).all(|(at, field)| whole(at, field)) {
        return Err(payload.refuse("holds fields of another length than the grid of its run"));
    }
    Ok((scene, Whole { head, fields }))
}

/// All planes of every field, from the files of all ranks.
fn read_parts<const D: usize>(
    grid: &Grid<D>,
    scene: &str,
    folder: &Path,
    steps: u64,
    parts: &[Part],
) -> Result<Vec<Vec<f64>>, SolverError> {
    let mut whole: Vec<Vec<f64>> = Vec::new();
    for (rank, part) in parts.iter().enumerate() {
        let mut payload = protocol::checkpoint::open(folder, &role(steps, rank, parts.len()), scene)?;
        let ([from, to], count): ([u64; 2], u64) = payload.part()?;
        let fits = *payload.digest() == part.digest
            && from < to
            && to <= grid.cells[D - 1] as u64
            && count > 3 * D as u64
            && (rank == 0 || count == whole.len() as u64);
        if !fits {
            return Err(payload.refuse("belongs to another checkpoint than the fluid.checkpoint beside it"));
        }
        let place = place(grid, [from, to]);
        whole.resize_with(count as usize, Vec::new);
        for (at, field) in whole.iter_mut().enumerate() {
            let values = payload.list()?;
            if at > 3 * D || values.is_empty() {
                *field = values;
                continue;
            }
            if values.len() != place.len() {
                return Err(payload.refuse("holds fields of another length than the grid of its run"));
            }
            field.resize(grid.len(), 0.0);
            field[place.clone()].copy_from_slice(&values);
        }
        payload.end()?;
    }
    Ok(whole)
}

pub(super) fn cells_of<const D: usize>(grid: &Grid<D>) -> Vec<u64> {
    grid.cells.iter().map(|n| *n as u64).collect()
}
