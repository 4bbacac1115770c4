//! Runs of nodes along axis 0 that a grain covers.

use super::mask_model::ROUND;
use super::nodes::Nodes;
use crate::grid::Grid;
use std::ops::Range;

/// Pieces into which a periodic face may cut a row.
pub(super) const PIECES: usize = 2;

/// A run of places along axis 0 that a grain may hold in the rows of a layer. A periodic face cuts it in two.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Piece {
    /// Index of the first place, and number of them, a multiple of eight.
    pub(super) first: usize,
    pub(super) count: usize,
    /// Those among them that the grain holds.
    pub(super) begin: usize,
    pub(super) end: usize,
    /// Arm along axis 0: this and the position of the node, m.
    pub(super) shift: f64,
    /// Arm of the first place, m.
    pub(super) arm: f64,
    /// One over the cell width; zero where widths differ.
    pub(super) rate: f64,
}

impl Piece {
    /// The pieces of a row within `half` of `centre`; those that are not needed have no places.
    #[inline(always)]
    pub(super) fn of<const D: usize>(
        grid: &Grid<D>,
        nodes: &Nodes<D>,
        centre: f64,
        half: f64,
    ) -> [Self; PIECES] {
        let (low, high) = nodes.range(grid, 0, centre, half);
        let (n, stride) = (grid.cells[0] as isize, grid.stride(1));
        let mut pieces = [Self::default(); PIECES];
        let mut m = low;
        for piece in &mut pieces {
            if m >= high {
                break;
            }
            let near = nodes.node(grid, 0, centre, m);
            let cells = if grid.periodic(0) { (high - m).min(n - near.index as isize) } else { high - m };
            let (begin, end) = (near.index, near.index + cells as usize);
            let count = (end - begin).next_multiple_of(8);
            let first = begin.min(stride - count);
            let shift = near.arm - nodes.row.at[begin];
            let rate = grid.axes[0].uniform_width.map_or(0.0, f64::recip);
            *piece = Self { first, count, begin, end, shift, arm: nodes.row.at[first] + shift, rate };
            m += cells;
        }
        pieces
    }

    /// The places, counted from the first, that a row of half chord `half` needs, in whole vectors; all of
    /// them where the widths differ.
    #[inline(always)]
    pub(super) fn window(&self, half: f64) -> Range<usize> {
        if self.rate == 0.0 {
            return 0..self.count;
        }
        let low = ((-half - self.arm) * self.rate).ceil().max(0.0);
        let high = ((half - self.arm) * self.rate).floor();
        let begin = self.begin - self.first;
        if high < low.max(begin as f64) {
            return 0..0;
        }
        let low = small(low).max(begin);
        let high = small(high).min(self.end - self.first - 1);
        let count = (high + 1).saturating_sub(low).next_multiple_of(8);
        let low = low.min(self.count - count);
        low..low + count
    }
}

/// A whole number from 0 to 2³², in fewer steps than a cast that minds other numbers.
#[inline(always)]
fn small(whole: f64) -> usize {
    (whole + ROUND).to_bits() as u32 as usize
}
