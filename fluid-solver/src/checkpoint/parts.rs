//! The files of the ranks, `fluid-<steps>-<rank>-of-<ranks>.checkpoint`: their planes of every field.
//!
//! The head of the checkpoint has the digest of each, so that a file of the same name from elsewhere is
//! refused.

use super::part::{Part, place, role};
use crate::field::own_planes;
use crate::solver::Solver;
use protocol::checkpoint::{Digest, Payload};
use protocol::participant::SolverError;
use std::ops::Range;
use std::path::Path;

/// Every rank writes its file; the first one gets what the head says of them.
pub(super) fn write<const D: usize>(
    solver: &Solver<D>,
    scene: &str,
    folder: &Path,
) -> Result<Vec<Part>, SolverError> {
    let grid = solver.grid();
    let (division, own) = (&grid.division, own_planes(grid));
    let ranks = division.ranks();
    let planes = |rank: usize| [division.of(rank).start as u64, division.of(rank).end as u64];
    let mut fields = solver.fields();
    fields
        .iter_mut()
        .filter(|field| field.len() == grid.len())
        .for_each(|field| *field = &field[own.clone()]);
    let role = role(solver.stepper().state().steps, ranks.rank(), ranks.size());
    let written = protocol::checkpoint::write_part(folder, &role, scene, &(planes(ranks.rank()), fields));
    let digests = ranks.report(written.map(|digest| digest.to_vec()))?;
    let part = |(rank, digest): (usize, &Vec<u8>)| {
        let digest = Digest::try_from(&digest[..]).map_err(|_| {
            SolverError::Failed(format!("rank {rank} of the fluid: told no digest of its part"))
        })?;
        Ok(Part { planes: planes(rank), digest })
    };
    digests.iter().enumerate().map(part).collect()
}

/// Takes the planes of this process from the files that have them; the others are not opened.
pub(super) fn read<const D: usize>(
    solver: &mut Solver<D>,
    scene: &str,
    folder: &Path,
    steps: u64,
    parts: &[Part],
) -> Result<(), SolverError> {
    let (grid, own) = (solver.grid(), own_planes(solver.grid()));
    let mut opened: Vec<(Payload, Range<usize>, Range<usize>)> = Vec::new();
    for (rank, part) in parts.iter().enumerate() {
        let stored = place(grid, part.planes);
        let wanted = stored.start.max(own.start)..stored.end.min(own.end);
        if wanted.is_empty() {
            continue;
        }
        let mut payload = protocol::checkpoint::open(folder, &role(steps, rank, parts.len()), scene)?;
        if *payload.digest() != part.digest {
            return Err(payload.refuse(
                "belongs to another checkpoint than the fluid.checkpoint beside it: put back the files that were \
                 written together, or start anew without --resume",
            ));
        }
        let (planes, fields): ([u64; 2], u64) = payload.part()?;
        if planes != part.planes || fields != solver.fields().len() as u64 {
            return Err(payload.refuse("holds other planes or fields than its head says: start anew"));
        }
        opened.push((payload, stored, wanted));
    }
    let whole = grid.len();
    for field in solver.fields_mut() {
        let is_whole = field.len() == whole;
        for (payload, stored, wanted) in &mut opened {
            if is_whole {
                payload.fill(&mut field[wanted.clone()], stored.len(), wanted.start - stored.start)?;
            } else {
                payload.fill(field, field.len(), 0)?;
            }
        }
    }
    opened.iter().try_for_each(|(payload, ..)| payload.end())
}

/// Removes the files of other checkpoints than that of `steps` and `size` files; what cannot be removed costs
/// room on the disk, nothing else.
pub(super) fn remove_others(folder: &Path, steps: u64, size: usize) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(stem) = name.to_str().and_then(|name| name.rsplit_once('.')).map(|(stem, _)| stem) else {
            continue;
        };
        if numbers(stem).is_some_and(|[of, _, all]| of != steps || all != size as u64) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Steps, rank and number of ranks of such a file.
fn numbers(stem: &str) -> Option<[u64; 3]> {
    let (steps, rest) = stem.strip_prefix("fluid-")?.split_once('-')?;
    let (rank, size) = rest.split_once("-of-")?;
    Some([steps.parse().ok()?, rank.parse().ok()?, size.parse().ok()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_its_name() {
        assert_eq!(numbers(&role(120, 3, 4)), Some([120, 3, 4]));
        for other in ["fluid", "fluid-notes", "dem-120-3-of-4", "fluid-120-3", "fluid-120-x-of-4"] {
            assert_eq!(numbers(other), None, "{other}");
        }
    }
}
