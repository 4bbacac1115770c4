//! Two axes: transform along one, solve along the other.
//!
//! `lines` holds blocks of eight lines of the transformed axis, `[block][place][8]`. Lines along
//! axis 1 are read from and written to the field itself, eight neighbours at a time; lines along
//! axis 0 pass through a transposition. One thread sweeps in place; several threads write the
//! solved columns to `modes`, so that each task owns what it writes. The arithmetic is the same.

use super::blocks::{Pool, block_length, blocks, pack, store};
use super::plane_columns::PlaneColumns;
use super::tiles::{LoadRows, StoreRows};
use super::unknown::Unknown;
use crate::grid::Grid;
use crate::lanes::{Kernel, Lanes, ZERO, aligned, dispatch};
use crate::threads::for_chunks;
use crate::transform::{Direction, Rows, RowsMut, Scratch, Transform, Write};
use pulp::Simd;

/// Solver for a grid of two axes.
pub(super) struct Plane {
    /// Transformed axis.
    along: usize,
    /// Index of the first value of the lines along each axis: along = 1 begins with the wall.
    first: [usize; 2],
    /// Number of lines.
    count: usize,
    transform: Transform,
    columns: PlaneColumns,
    lines: Vec<Lanes>,
    /// Solved columns `[block of modes][block of lines][8][8]`; empty with one thread.
    modes: Vec<Lanes>,
    memory: Pool<Memory>,
}

/// Working memory of one thread.
struct Memory {
    along: Scratch,
    across: Scratch,
    /// Two columns.
    columns: Vec<Lanes>,
    /// Eight lines.
    lines: Vec<Lanes>,
}

impl Plane {
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
        let mut first = std::array::from_fn(|a| unknown.first(grid, a));
        // A wall in front goes along as an idle line, so that blocks of eight are aligned.
        let before = if along == 1 { std::mem::take(&mut first[0]) } else { 0 };
        let count = grid.cells[across] - first[across];
        let scale = kind.scale(grid.cells[along]);
        let columns = PlaneColumns::new(unknown.across(grid, across).padded(before), lambda, scale);
        let (places, high) = (transform.values(), count.next_multiple_of(8));
        let modes = if rayon::current_num_threads() > 1 { columns.count() * high + 1 } else { 0 };
        Self {
            along,
            first,
            count,
            lines: blocks(count.div_ceil(8), places),
            modes: vec![ZERO; modes],
            memory: Pool::new(|| Memory {
                along: transform.scratch(),
                across: columns.across.scratch(),
                columns: vec![ZERO; 2 * high + 1],
                lines: vec![ZERO; places.next_multiple_of(8) + 1],
            }),
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
        let (mut lines, mut modes) = (std::mem::take(&mut self.lines), std::mem::take(&mut self.modes));
        {
            let lines = aligned(&mut lines);
            let start = grid.row(self.first[1]) + self.first[0];
            self.transform_lines(grid, &rhs[start..], lines);
            if modes.is_empty() {
                self.solve_in_place(factors, lines);
            } else {
                self.solve_apart(factors, lines, aligned(&mut modes));
            }
            let out = &mut out[start..];
            match (self.along, modes.is_empty()) {
                (1, true) => self.back_to_field(grid, lines, out, write),
                (1, false) => {
                    self.back_to_lines(aligned(&mut modes), lines);
                    self.write_rows(grid, lines, out, write);
                }
                (_, one) => {
                    let solved = if one { &*lines } else { &*aligned(&mut modes) };
                    self.back_to_rows(grid, solved, one, out, write);
                }
            }
        }
        (self.lines, self.modes) = (lines, modes);
    }

    /// Length of one block of `lines`.
    fn block(&self) -> usize {
        block_length(self.transform.values())
    }

    /// Length of one block of `modes`.
    fn mode_block(&self) -> usize {
        self.count.next_multiple_of(8)
    }

    /// `lines` ← transform of the field.
    fn transform_lines<const D: usize>(&self, grid: &Grid<D>, rhs: &[f64], lines: &mut [Lanes]) {
        let stride = grid.stride(1);
        for_chunks(lines, self.block(), |b, to| {
            self.memory.with(|m| {
                if self.along == 1 {
                    let rows = Rows::of_field(&rhs[8 * b..], stride);
                    self.transform.load(Direction::Forward, rows, &mut m.along);
                } else {
                    let line = &mut aligned(&mut m.lines)[..self.transform.values()];
                    let height = (self.count - 8 * b).min(8);
                    let field = &rhs[8 * b * stride..];
                    dispatch(LoadRows { field, stride, height, to: &mut *line });
                    self.transform.load(Direction::Forward, Rows::of(line), &mut m.along);
                }
                self.transform.store(Direction::Forward, RowsMut::of(to), &mut m.along);
            });
        });
    }

    /// Solves all columns of `lines`, in place.
    fn solve_in_place(&self, factors: usize, lines: &mut [Lanes]) {
        self.memory.with(|m| {
            let columns = aligned(&mut m.columns);
            for q in (0..self.columns.count()).step_by(2) {
                self.columns.eliminate(q, factors, lines, self.block(), columns, &mut m.across);
                let places = [8 * q, 8 * q + 8];
                self.columns.substitute(q, factors, columns, lines, places, self.block());
            }
        });
    }

    /// `modes` ← solution of all columns of `lines`.
    fn solve_apart(&self, factors: usize, lines: &[Lanes], modes: &mut [Lanes]) {
        let length = self.mode_block();
        for_chunks(modes, 2 * length, |pair, to| {
            self.memory.with(|m| {
                let columns = aligned(&mut m.columns);
                let q = 2 * pair;
                self.columns.eliminate(q, factors, lines, self.block(), columns, &mut m.across);
                self.columns.substitute(q, factors, columns, to, [0, length], 8);
            });
        });
    }

    /// Adds or sets the field, from solved lines along axis 1.
    fn back_to_field<const D: usize>(&self, g: &Grid<D>, lines: &[Lanes], out: &mut [f64], write: Write) {
        self.memory.with(|m| {
            for (b, line) in lines.chunks(self.block()).enumerate() {
                self.transform.load(Direction::Inverse, Rows::of(line), &mut m.along);
                let rows = RowsMut::of_field(&mut out[8 * b..], g.stride(1), write);
                self.transform.store(Direction::Inverse, rows, &mut m.along);
            }
        });
    }

    /// Block `b` of the lines out of the solved columns.
    fn collect(&self, modes: &[Lanes], b: usize, line: &mut [Lanes]) {
        for (to, from) in line.chunks_mut(8).zip(modes.chunks(self.mode_block())) {
            to.copy_from_slice(&from[8 * b..][..to.len()]);
        }
    }

    /// `lines` ← `modes` transformed back.
    fn back_to_lines(&self, modes: &[Lanes], lines: &mut [Lanes]) {
        for_chunks(lines, self.block(), |b, line| {
            let line = &mut line[..self.transform.values()];
            self.collect(modes, b, line);
            self.memory.with(|m| self.transform.inverse(line, &mut m.along));
        });
    }

    /// Adds or sets the field row by row, from transformed lines along axis 1.
    fn write_rows<const D: usize>(&self, grid: &Grid<D>, lines: &[Lanes], out: &mut [f64], write: Write) {
        let (block, stride) = (self.block(), grid.stride(1));
        let end = (self.transform.values() - 1) * stride + self.count;
        for_chunks(&mut out[..end], stride, |j, row| {
            dispatch(WriteRow { lines: &lines[j..], block, write, row: &mut row[..self.count] });
        });
    }

    /// Adds or sets the field from solved lines along axis 0, eight rows at a time; `place` tells
    /// whether they stand in `lines` or in `modes`.
    fn back_to_rows<const D: usize>(
        &self,
        grid: &Grid<D>,
        solved: &[Lanes],
        in_lines: bool,
        out: &mut [f64],
        write: Write,
    ) {
        let (stride, places) = (grid.stride(1), self.transform.values());
        let end = (self.count - 1) * stride + places;
        for_chunks(&mut out[..end], 8 * stride, |b, field| {
            self.memory.with(|m| {
                let line = &mut aligned(&mut m.lines)[..places];
                let from = if in_lines {
                    &solved[b * self.block()..][..places]
                } else {
                    self.collect(solved, b, line);
                    &*line
                };
                self.transform.load(Direction::Inverse, Rows::of(from), &mut m.along);
                self.transform.store(Direction::Inverse, RowsMut::of(line), &mut m.along);
                let height = (self.count - 8 * b).min(8);
                dispatch(StoreRows { from: line, field, stride, height, write });
            });
        });
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
    fn run<S: Simd>(self, _: S) {
        for (to, from) in self.row.chunks_mut(8).zip(self.lines.chunks(self.block)) {
            store(to, &from[0], self.write);
        }
    }
}
