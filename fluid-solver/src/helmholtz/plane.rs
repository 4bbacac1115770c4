//! Two axes: transform along one, solve along the other.
//!
//! Working arrays hold blocks of eight lines, `[block][place][8]`, so each task writes one chunk:
//! `lines` has lines of the transformed axis (eight neighbours of the other axis per block),
//! `modes` has columns of the other axis (eight modes per block).

use super::columns::Columns;
use super::{Pool, Unknown, Write, block_length, blocks, pack, store};
use crate::grid::Grid;
use crate::lanes::{Kernel, Lanes, dispatch, load, tile, transpose};
use crate::threads::for_chunks;
use crate::transform::{Scratch, Transform};

/// Solver for a grid of two axes.
pub(super) struct Plane {
    /// Transformed axis.
    along: usize,
    /// Index of the first unknown along each axis.
    first: [usize; 2],
    transform: Transform,
    columns: Columns,
    lines: Vec<Lanes>,
    modes: Vec<Lanes>,
    scratch: Pool<(Scratch, Scratch)>,
}

impl Plane {
    /// Plans the solver.
    pub(super) fn new<const D: usize>(grid: &Grid<D>, unknown: Unknown) -> Self {
        // Lines along axis 1 need no transposition: sweep axis 0 unless axis 1 has to be swept.
        let along = match grid.swept_axis() {
            Some(axis) => 1 - axis,
            None => usize::from(!grid.periodic(0) || grid.periodic(1)),
        };
        let across = 1 - along;
        let kind = unknown.kind(grid, along);
        let transform = Transform::new(kind, grid.cells[along]);
        let lambda = pack(&unknown.eigenvalues(grid, along));
        let columns = Columns::new(unknown.across(grid, across), lambda, kind.scale(grid.cells[along]));
        let (places, others) = (transform.values(), columns.len());
        Self {
            along,
            first: std::array::from_fn(|a| unknown.first(grid, a)),
            lines: blocks(others.div_ceil(8), places),
            modes: blocks(places.div_ceil(8), others),
            scratch: Pool::new(|| (transform.scratch(), columns.scratch())),
            transform,
            columns,
        }
    }

    /// See [`super::Helmholtz::solve`].
    pub(super) fn solve<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        [sigma, c]: [f64; 2],
        rhs: &[f64],
        out: &mut [f64],
        write: Write,
    ) {
        let factors = self.columns.prepare(sigma, c);
        self.transform_lines(grid, rhs);
        self.solve_columns(factors);
        self.transform_back();
        if self.along == 1 {
            self.write_rows(grid, out, write);
        } else {
            self.write_row_blocks(grid, out, write);
        }
    }

    /// Length of one block of `lines`.
    fn line_block(&self) -> usize {
        block_length(self.transform.values())
    }

    /// Length of one block of `modes`.
    fn mode_block(&self) -> usize {
        block_length(self.columns.len())
    }

    /// `lines` ← transform of `rhs`.
    fn transform_lines<const D: usize>(&mut self, grid: &Grid<D>, rhs: &[f64]) {
        let mut lines = std::mem::take(&mut self.lines);
        for_chunks(&mut lines, self.line_block(), |block, data| {
            let data = &mut data[..self.transform.values()];
            if self.along == 1 {
                self.load_columns(grid, rhs, block, data);
            } else {
                self.load_rows(grid, rhs, block, data);
            }
            self.scratch.with(|s| self.transform.forward(data, &mut s.0));
        });
        self.lines = lines;
    }

    /// Eight neighbours of axis 0, all places of axis 1.
    fn load_columns<const D: usize>(&self, g: &Grid<D>, rhs: &[f64], block: usize, to: &mut [Lanes]) {
        let width = (self.columns.len() - 8 * block).min(8);
        let start = g.row(self.first[1]) + self.first[0] + 8 * block;
        dispatch(Gather { rhs: &rhs[start..], stride: g.stride(1), width, to });
    }

    /// Eight rows, all places of axis 0.
    fn load_rows<const D: usize>(&self, g: &Grid<D>, rhs: &[f64], block: usize, to: &mut [Lanes]) {
        let height = (self.columns.len() - 8 * block).min(8);
        let start = g.row(self.first[1] + 8 * block) + self.first[0];
        for (t, to) in to.chunks_mut(8).enumerate() {
            let at = |l: usize| start + l * g.stride(1) + 8 * t;
            let rows =
                std::array::from_fn(
                    |l| {
                        if l < height { load(&rhs[at(l)..at(l) + to.len()]) } else { [0.0; 8] }
                    },
                );
            to.copy_from_slice(&transpose(&rows)[..to.len()]);
        }
    }

    /// `modes` ← solution of every column.
    fn solve_columns(&mut self, factors: usize) {
        let mut modes = std::mem::take(&mut self.modes);
        let (from, to) = (self.line_block(), self.mode_block());
        let n = self.columns.len();
        for_chunks(&mut modes, 2 * to, |pair, data| {
            for (k, data) in data.chunks_exact_mut(to).enumerate() {
                dispatch(Exchange { from: &self.lines, length: from, block: 2 * pair + k, to: data });
            }
            self.scratch.with(|s| match data.split_at_mut_checked(to) {
                Some((a, b)) if !b.is_empty() => {
                    self.columns.solve_two(2 * pair, factors, [&mut a[..n], &mut b[..n]], &mut s.1);
                }
                _ => self.columns.solve(2 * pair, factors, &mut data[..n], &mut s.1),
            });
        });
        self.modes = modes;
    }

    /// `lines` ← `modes` transformed back.
    fn transform_back(&mut self) {
        let mut lines = std::mem::take(&mut self.lines);
        let (to, from) = (self.line_block(), self.mode_block());
        for_chunks(&mut lines, to, |block, data| {
            dispatch(Exchange { from: &self.modes, length: from, block, to: &mut *data });
            let line = &mut data[..self.transform.values()];
            self.scratch.with(|s| self.transform.inverse(line, &mut s.0));
        });
        self.lines = lines;
    }

    /// Writes the solution where lines run along axis 1: row by row.
    fn write_rows<const D: usize>(&self, grid: &Grid<D>, out: &mut [f64], write: Write) {
        let (block, n) = (self.line_block(), self.columns.len());
        let start = grid.row(self.first[1]) + self.first[0];
        let end = start + self.transform.values() * grid.stride(1);
        for_chunks(&mut out[start..end], grid.stride(1), |j, row| {
            dispatch(WriteRow { lines: &self.lines[j..], block, write, row: &mut row[..n] });
        });
    }

    /// Writes the solution where lines run along axis 0: eight rows at a time.
    fn write_row_blocks<const D: usize>(&self, grid: &Grid<D>, out: &mut [f64], write: Write) {
        let (stride, n) = (grid.stride(1), self.transform.values());
        let start = grid.row(self.first[1]) + self.first[0];
        let end = start + self.columns.len() * stride;
        for_chunks(&mut out[start..end], 8 * stride, |block, rows| {
            for t in 0..n.div_ceil(8) {
                let values = transpose(&tile(&self.lines, block * self.line_block() + 8 * t));
                for (row, values) in rows.chunks_mut(stride).zip(&values) {
                    store(&mut row[8 * t..n.min(8 * t + 8)], values, write);
                }
            }
        });
    }
}

/// Eight neighbours of every row of a field, as one block.
struct Gather<'a> {
    rhs: &'a [f64],
    stride: usize,
    width: usize,
    to: &'a mut [Lanes],
}

impl Kernel for Gather<'_> {
    #[inline(always)]
    fn run(self) {
        for (row, to) in self.rhs.chunks(self.stride).zip(self.to) {
            *to = load(&row[..self.width]);
        }
    }
}

/// One row of a field from the first place of each block of `lines`.
struct WriteRow<'a> {
    lines: &'a [Lanes],
    block: usize,
    write: Write,
    row: &'a mut [f64],
}

impl Kernel for WriteRow<'_> {
    #[inline(always)]
    fn run(self) {
        for (to, from) in self.row.chunks_mut(8).zip(self.lines.chunks(self.block)) {
            store(to, &from[0], self.write);
        }
    }
}

/// Row blocks to column blocks: rows `8 block..` of every block of `from` (blocks of `length` rows)
/// become block `block` of the other array.
struct Exchange<'a> {
    from: &'a [Lanes],
    length: usize,
    block: usize,
    to: &'a mut [Lanes],
}

impl Kernel for Exchange<'_> {
    #[inline(always)]
    fn run(self) {
        for (from, to) in self.from.chunks_exact(self.length).zip(self.to.chunks_exact_mut(8)) {
            let from = &from[8 * self.block..8 * self.block + 8];
            for (lane, to) in to.iter_mut().enumerate() {
                for (place, row) in to.iter_mut().zip(from) {
                    *place = row[lane];
                }
            }
        }
    }
}
