//! Three axes: transforms within each plane of axes 0 and 1, then columns along axis 2.
//!
//! Plane tasks work in place on the right-hand side (a plane is contiguous); column tasks own the
//! modes of one row `j`: `columns[j][block of 8 in i][k][8]`.

use super::columns::Columns;
use super::tiles::{LoadRows, StoreRows};
use super::{Pool, Unknown, Write, block_length, blocks, store};
use crate::grid::Grid;
use crate::lanes::{Lanes, ZERO, aligned, dispatch, load};
use crate::threads::for_chunks;
use crate::transform::{Scratch, Transform};

/// Solver for a grid of three axes.
pub(super) struct Space {
    first: [usize; 3],
    transforms: [Transform; 2],
    columns: Columns,
    modes: Vec<Lanes>,
    scratch: Pool<Memory>,
}

/// Working memory of one thread.
struct Memory {
    batch: Vec<Lanes>,
    transforms: [Scratch; 2],
    columns: Scratch,
}

impl Space {
    /// Plans the solver.
    pub(super) fn new<const D: usize>(grid: &Grid<D>, unknown: Unknown) -> Self {
        let transforms: [Transform; 2] =
            std::array::from_fn(|a| Transform::new(unknown.kind(grid, a), grid.cells[a]));
        let [x, y] = [0, 1].map(|a| unknown.eigenvalues(grid, a));
        let lambda: Vec<Lanes> =
            y.iter().flat_map(|y| super::pack(&x).into_iter().map(move |x| x.map(|x| x + y))).collect();
        let scale = transforms[0].kind().scale(grid.cells[0]) * transforms[1].kind().scale(grid.cells[1]);
        let columns = Columns::new(unknown.across(grid, D - 1), lambda, scale);
        let longest = transforms[0].values().max(transforms[1].values());
        Self {
            first: std::array::from_fn(|a| unknown.first(grid, a)),
            modes: blocks(columns.count(), columns.len()),
            scratch: Pool::new(|| Memory {
                batch: vec![ZERO; longest.next_multiple_of(8) + 1],
                transforms: [transforms[0].scratch(), transforms[1].scratch()],
                columns: columns.scratch(),
            }),
            transforms,
            columns,
        }
    }

    /// See [`super::Helmholtz::solve`].
    pub(super) fn solve<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        [sigma, c]: [f64; 2],
        rhs: &mut [f64],
        out: &mut [f64],
        write: Write,
    ) {
        let factors = self.columns.prepare(sigma, c);
        let stride = grid.stride(D - 1);
        let planes = self.planes(grid);
        for_chunks(&mut rhs[planes.clone()], stride, |_, plane| {
            self.scratch.with(|m| self.transform_plane(grid, plane, m, Transform::forward));
        });
        self.solve_columns(grid, factors, &rhs[planes.clone()]);
        let mut modes = std::mem::take(&mut self.modes);
        let solved = &*aligned(&mut modes);
        for_chunks(&mut rhs[planes.clone()], stride, |k, plane| {
            self.gather_plane(grid, solved, k, plane);
            self.scratch.with(|m| self.transform_plane(grid, plane, m, Transform::inverse));
        });
        self.modes = modes;
        let solution = &rhs[planes.clone()];
        let [nx, ny] = [0, 1].map(|a| self.transforms[a].values());
        for_chunks(&mut out[planes], stride, |k, plane| {
            for j in 0..ny {
                let at = j * grid.stride(1);
                store(&mut plane[at..at + nx], &solution[k * stride + at..], write);
            }
        });
    }

    /// Where the unknowns lie in a field: chunks of one plane stride, each starting at its first unknown.
    fn planes<const D: usize>(&self, grid: &Grid<D>) -> std::ops::Range<usize> {
        let start = grid.index(std::array::from_fn(|a| self.first[a] as isize));
        let [nx, ny] = [0, 1].map(|a| self.transforms[a].values());
        let last = (self.columns.len() - 1) * grid.stride(D - 1);
        start..start + last + (ny - 1) * grid.stride(1) + nx
    }

    /// Transforms a plane along axes 0 and 1, in place.
    fn transform_plane<const D: usize>(
        &self,
        grid: &Grid<D>,
        plane: &mut [f64],
        memory: &mut Memory,
        apply: impl Fn(&Transform, &mut [Lanes], &mut Scratch),
    ) {
        let Memory { batch, transforms, .. } = memory;
        let batch = aligned(batch);
        let stride = grid.stride(1);
        let [nx, ny] = [0, 1].map(|a| self.transforms[a].values());
        for j in (0..ny).step_by(8) {
            let (height, rows) = ((ny - j).min(8), &mut plane[j * stride..]);
            dispatch(LoadRows { field: rows, stride, height, to: &mut batch[..nx] });
            apply(&self.transforms[0], &mut batch[..nx], &mut transforms[0]);
            dispatch(StoreRows { from: &batch[..nx], field: rows, stride, height, write: Write::Set });
        }
        for i in (0..nx).step_by(8) {
            let width = (nx - i).min(8);
            for (j, to) in batch[..ny].iter_mut().enumerate() {
                *to = load(&plane[j * stride + i..][..width]);
            }
            apply(&self.transforms[1], &mut batch[..ny], &mut transforms[1]);
            for (j, from) in batch[..ny].iter().enumerate() {
                store(&mut plane[j * stride + i..][..width], from, Write::Set);
            }
        }
    }

    /// `modes` ← solution of every column of the transformed right-hand side.
    fn solve_columns<const D: usize>(&mut self, grid: &Grid<D>, factors: usize, rhs: &[f64]) {
        let mut modes = std::mem::take(&mut self.modes);
        let (nx, nz) = (self.transforms[0].values(), self.columns.len());
        let height = block_length(nz);
        let per_row = nx.div_ceil(8);
        for_chunks(aligned(&mut modes), per_row * height, |j, row| {
            for (b, data) in row.chunks_exact_mut(height).enumerate() {
                let column = &mut data[..nz];
                let width = (nx - 8 * b).min(8);
                for (k, to) in column.iter_mut().enumerate() {
                    let at = k * grid.stride(D - 1) + j * grid.stride(1) + 8 * b;
                    *to = load(&rhs[at..at + width]);
                }
                let q = j * per_row + b;
                self.scratch.with(|m| self.columns.solve(q, factors, column, &mut m.columns));
            }
        });
        self.modes = modes;
    }

    /// Copies plane `k` of the solved modes back.
    fn gather_plane<const D: usize>(&self, grid: &Grid<D>, modes: &[Lanes], k: usize, plane: &mut [f64]) {
        let [nx, ny] = [0, 1].map(|a| self.transforms[a].values());
        let height = block_length(self.columns.len());
        let per_row = nx.div_ceil(8);
        for j in 0..ny {
            let row = &mut plane[j * grid.stride(1)..][..nx];
            for (b, to) in row.chunks_mut(8).enumerate() {
                let from = &modes[(j * per_row + b) * height + k];
                store(to, from, Write::Set);
            }
        }
    }
}
