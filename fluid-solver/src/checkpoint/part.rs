//! The head of a checkpoint, and what it says of the files of the ranks.

use crate::grid::Grid;
use crate::methods::grains::Memory;
use protocol::checkpoint::Digest;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Role of the head in its file's name: `fluid.checkpoint`.
pub(super) const ROLE: &str = "fluid";

/// What a checkpoint says before its fields: those of [`crate::solver::Solver::fields`], none where files of
/// their own hold them.
#[derive(Serialize, Deserialize)]
pub(crate) struct Head {
    pub(super) cells: Vec<u64>,
    /// Time, s.
    pub(crate) time: f64,
    /// Length of the last step, s; zero: there was none.
    pub(crate) previous_dt: f64,
    pub(super) steps: u64,
    /// Whether viscosity is part of the history.
    pub(crate) explicit: bool,
    pub(crate) memory: Memory,
    /// Files that hold the fields, from the lowest planes on.
    pub(super) parts: Vec<Part>,
}

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
