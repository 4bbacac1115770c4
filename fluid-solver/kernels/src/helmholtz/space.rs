//! Three axes: transforms within each plane of axes 0 and 1, then columns along axis 2, all in place.
//!
//! A plane is a slice of one plane stride from its row −1 on. The step in space calls the parts
//! one by one while a plane is in the cache; [`Space::solve`] puts them together.

use super::blocks::store;
use super::space_columns::{Solve, SpaceColumns};
use super::tiles::{LoadRows, StoreRows};
use super::unknown::Unknown;
use crate::grid::Grid;
use crate::lanes::{Lanes, ZERO, aligned, dispatch};
use crate::threads::{Chunks, share};
use crate::transform::{Direction, Rows, RowsMut, Scratch, Transform, Write};
use std::ops::Range;

/// Solver for a grid of three axes.
pub(crate) struct Space {
    first: [usize; 3],
    /// Values from row to row, from plane to plane, before plane −1.
    row: usize,
    plane: usize,
    lead: usize,
    transforms: [Transform; 2],
    columns: SpaceColumns,
    /// Room for references to parts of planes.
    parts: Vec<&'static mut [f64]>,
    memory: Vec<Memory>,
}

/// Working memory of one thread.
pub(crate) struct Memory {
    batch: Vec<Lanes>,
    transforms: [Scratch; 2],
    columns: super::space_columns::Memory,
}

impl Space {
    /// Plans the solver. Working memory is sized for the current rayon pool.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>, unknown: Unknown) -> Self {
        let transforms: [Transform; 2] =
            std::array::from_fn(|a| Transform::new(unknown.kind(grid, a), grid.cells[a]));
        let lambda = [0, 1].map(|a| unknown.eigenvalues(grid, a));
        let scale = transforms[0].kind.scale(grid.cells[0]) * transforms[1].kind.scale(grid.cells[1]);
        let mut origin = [-1; D];
        origin[0] = 0;
        let mut space = Self {
            first: std::array::from_fn(|a| unknown.first(grid, a)),
            row: grid.stride(1),
            plane: grid.stride(D - 1),
            lead: grid.index(origin),
            columns: SpaceColumns::new(unknown.across(grid, D - 1), unknown.blocks(grid), lambda, scale),
            transforms,
            parts: Vec::new(),
            memory: Vec::new(),
        };
        let threads = rayon::current_num_threads();
        space.parts.reserve(threads * space.columns.across.len());
        space.memory = (0..threads).map(|_| space.new_memory()).collect();
        space
    }

    /// Working memory for the transforms of one thread.
    pub(crate) fn new_memory(&self) -> Memory {
        let longest = self.transforms[0].values().max(self.transforms[1].values());
        Memory {
            batch: vec![ZERO; longest.next_multiple_of(8) + 1],
            transforms: [self.transforms[0].scratch(), self.transforms[1].scratch()],
            columns: self.columns.memory(),
        }
    }

    /// See [`super::Helmholtz::solve`].
    pub(super) fn solve(&mut self, operator: [f64; 2], rhs: &mut [f64], out: &mut [f64], write: Write) {
        let range = self.own_planes();
        self.transform(&mut rhs[range.clone()], Direction::Forward);
        self.solve_columns(operator, rhs);
        self.transform(&mut rhs[range.clone()], Direction::Inverse);
        let [nx, ny] = self.values();
        let planes = out[range.clone()].chunks_exact_mut(self.plane);
        for (out, solution) in planes.zip(rhs[range].chunks_exact(self.plane)) {
            for j in 0..ny {
                let at = self.at(j);
                store(&mut out[at..at + nx], &solution[at..at + nx], write);
            }
        }
    }

    /// Where the planes of the unknowns that this process works on lie in a field.
    fn own_planes(&self) -> Range<usize> {
        let own = self.columns.own();
        let first = self.lead + (self.first[2] + 1) * self.plane;
        first + own.start * self.plane..first + own.end * self.plane
    }

    fn transform(&mut self, planes: &mut [f64], direction: Direction) {
        let mut memory = std::mem::take(&mut self.memory);
        for plane in planes.chunks_exact_mut(self.plane) {
            self.transform_plane(direction, plane, &mut memory[0]);
        }
        self.memory = memory;
    }

    /// Unknowns along the first two axes.
    fn values(&self) -> [usize; 2] {
        [0, 1].map(|a| self.transforms[a].values())
    }

    /// Place of the first unknown of line `j` of unknowns in its plane.
    fn at(&self, j: usize) -> usize {
        (self.first[1] + 1 + j) * self.row + self.first[0]
    }

    /// Transforms one plane along axes 0 and 1, in place.
    pub(crate) fn transform_plane(&self, direction: Direction, plane: &mut [f64], memory: &mut Memory) {
        if direction == Direction::Forward {
            self.transform_rows(direction, plane, memory);
            self.transform_across(direction, plane, memory);
        } else {
            self.transform_across(direction, plane, memory);
            self.transform_rows(direction, plane, memory);
        }
    }

    /// Along axis 0: eight rows at a time, transposed.
    fn transform_rows(&self, direction: Direction, plane: &mut [f64], memory: &mut Memory) {
        let Memory { batch, transforms: [scratch, _], .. } = memory;
        let [nx, ny] = self.values();
        let batch = &mut aligned(batch)[..nx];
        let stride = self.row;
        for j in (0..ny).step_by(8) {
            let (height, rows) = ((ny - j).min(8), &mut plane[self.at(j)..]);
            dispatch(LoadRows { field: rows, stride, height, to: &mut *batch });
            self.transforms[0].load(direction, Rows::of(batch), scratch);
            self.transforms[0].store(direction, RowsMut::of(batch), scratch);
            dispatch(StoreRows { from: batch, field: rows, stride, height, write: Write::Set });
        }
    }

    /// Along axis 1: eight neighbours at a time, as they stand. Beyond the end of a row are pads.
    fn transform_across(&self, direction: Direction, plane: &mut [f64], memory: &mut Memory) {
        let scratch = &mut memory.transforms[1];
        let at = self.at(0);
        for i in (0..self.values()[0]).step_by(8) {
            let lines = &mut plane[at + i..];
            self.transforms[1].load(direction, Rows::of_field(lines, self.row), scratch);
            let to = RowsMut::of_field(lines, self.row, Write::Set);
            self.transforms[1].store(direction, to, scratch);
        }
    }

    /// Solves `(σ − c L) x = b` for all columns of a transformed field, in place.
    ///
    /// Each thread takes its share of the lines of every plane.
    pub(crate) fn solve_columns(&mut self, operator: [f64; 2], field: &mut [f64]) {
        let [nx, ny] = self.values();
        let (planes, count) = (&mut field[self.own_planes()], self.columns.own().len());
        let shares = self.memory.len().min((nx * ny * count).div_ceil(WORTH_A_SHARE)).clamp(1, ny);
        let mut parts = recycle(std::mem::take(&mut self.parts));
        parts.extend((0..shares * count).map(|_| <&mut [f64]>::default()));
        for (k, plane) in planes.chunks_exact_mut(self.plane).enumerate() {
            let mut rest = &mut plane[self.at(0)..];
            for share in 0..shares {
                let lines = ny * (share + 1) / shares - ny * share / shares;
                let length = if share + 1 < shares { lines * self.row } else { rest.len() };
                let (part, after) = rest.split_at_mut(length);
                parts[share * count + k] = part;
                rest = after;
            }
        }
        let (columns, split) = (&self.columns, Split { operator, lines: ny, shares, row: self.row });
        if let Some(blocks) = columns.shared() {
            let cut = parts.chunks_exact_mut(count).zip(&mut self.memory).enumerate();
            let mut shares: Vec<_> = cut.map(|(share, part)| split.share(share, part)).collect();
            columns.solve_shared(blocks, &mut shares, ny);
            drop(shares);
            self.parts = recycle(parts);
            return;
        }
        let cut = (Chunks { fields: [&mut parts[..]], size: count }, &mut self.memory[..shares]);
        share(cut, 0..shares, 1, &|numbers, (Chunks { fields: [planes], .. }, memory)| {
            let cut = numbers.zip(planes.chunks_exact_mut(count)).zip(memory);
            cut.for_each(|((number, planes), memory)| columns.solve(split.share(number, (planes, memory))));
        });
        self.parts = recycle(parts);
    }
}

/// How the lines of all columns are shared among threads.
#[derive(Clone, Copy)]
struct Split {
    operator: [f64; 2],
    lines: usize,
    shares: usize,
    row: usize,
}

impl Split {
    /// What share `share` is to solve.
    fn share<'a, 'b>(
        self,
        share: usize,
        (planes, memory): (&'a mut [&'b mut [f64]], &'a mut Memory),
    ) -> Solve<'a, 'b> {
        let Self { operator, lines, shares, row } = self;
        let lines = lines * share / shares..lines * (share + 1) / shares;
        Solve { operator, lines, row, planes, memory: &mut memory.columns }
    }
}

/// Values per thread below which a second thread costs more than it brings.
const WORTH_A_SHARE: usize = 16_384;

/// The memory of a list of references, emptied, for references of another life.
fn recycle<'a>(mut list: Vec<&mut [f64]>) -> Vec<&'a mut [f64]> {
    list.clear();
    // Nothing is left to convert; the standard library keeps the allocation.
    list.into_iter().map(|_| <&mut [f64]>::default()).collect()
}
