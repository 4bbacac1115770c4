//! The file of a rank: its name, its planes, and what the head of the checkpoint says of it.

use crate::grid::Grid;
use protocol::checkpoint::Digest;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Role of the head in its file's name: `fluid.checkpoint`.
pub(super) const ROLE: &str = "fluid";

/// What the head says of the file of a rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Part {
    /// First plane, and the one after the last.
    pub(super) planes: [u64; 2],
    pub(super) digest: Digest,
}

/// Such a file's role, which is its name up to the ending.
pub(super) fn role(steps: u64, rank: usize, size: usize) -> String {
    format!("fluid-{steps}-{rank}-of-{size}")
}

/// Where planes lie in a field.
pub(super) fn place<const D: usize>(grid: &Grid<D>, [from, to]: [u64; 2]) -> Range<usize> {
    grid.planes(from as isize, to as isize)
}
