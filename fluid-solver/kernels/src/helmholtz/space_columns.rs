//! Columns along the last axis of a grid in space: four blocks of eight modes side by side.
//! Inverse eigenvalues are computed on the way, as the pivots of a sweep are.

use super::block_columns::{self, BlockColumns, Modes};
use super::block_sweep::{Eliminate, GROUP, Group, Substitute, WHOLE};
use super::blocks::{SIDE, store};
use super::unknown::LastAxis;
use crate::lanes::{Kernel, Lanes, ZERO, aligned, dispatch, load};
use crate::transform::{Scratch, Write};
use crate::tridiagonal::Sweep;
use pulp::Simd;
use std::ops::Range;

/// All columns of a solve.
pub(super) struct SpaceColumns {
    pub(super) across: LastAxis,
    /// Where the last axis is cut into blocks.
    blocks: Option<BlockColumns>,
    /// Eigenvalues along axis 0, in blocks of eight, padded to whole groups, and along axis 1.
    lambda: [Vec<f64>; 2],
    /// Eigenvalues along the last axis, if it is transformed.
    own: Vec<f64>,
    /// Modes along axis 0.
    pub(super) modes: usize,
    pub(super) scale: f64,
}

/// Working memory of one thread.
#[derive(Default)]
pub(super) struct Memory {
    columns: Vec<Lanes>,
    scratch: Scratch,
    pub(super) blocks: block_columns::Memory,
}

/// What is to be solved: lines `lines` of all planes.
pub(super) struct Solve<'a, 'b> {
    pub(super) operator: [f64; 2],
    pub(super) lines: Range<usize>,
    /// Values from line to line.
    pub(super) row: usize,
    /// For each unknown along the column, the lines of its plane, from the first mode on.
    pub(super) planes: &'a mut [&'b mut [f64]],
    pub(super) memory: &'a mut Memory,
}

impl SpaceColumns {
    /// `lambda` are the eigenvalues of the transformed axes, `scale` normalises their transforms.
    pub(super) fn new(
        across: LastAxis,
        blocks: Option<BlockColumns>,
        [mut x, y]: [Vec<f64>; 2],
        scale: f64,
    ) -> Self {
        let modes = x.len();
        // A harmless eigenvalue.
        x.resize(modes.next_multiple_of(8 * SIDE), -1.0);
        let (mut own, mut scale) = (Vec::new(), scale);
        if let LastAxis::Transform(transform, width2) = &across {
            let (kind, cells) = (transform.kind, transform.cells);
            own = (0..transform.values()).map(|k| kind.eigenvalue(k, cells) / width2).collect();
            scale *= kind.scale(cells);
        }
        Self { across, blocks, lambda: [x, y], own, modes, scale }
    }

    /// Unknowns along a column that this process works on.
    pub(super) fn own(&self) -> Range<usize> {
        self.blocks.as_ref().map_or(0..self.across.len(), BlockColumns::own_unknowns)
    }

    /// The blocks, if several ranks share them.
    pub(super) fn shared(&self) -> Option<&BlockColumns> {
        self.blocks.as_ref().filter(|blocks| !blocks.ranks.is_alone())
    }

    /// Working memory for one thread.
    pub(super) fn memory(&self) -> Memory {
        if let Some(blocks) = &self.blocks {
            return Memory { blocks: blocks.memory(), ..Memory::default() };
        }
        let each = if matches!(self.across, LastAxis::Sweep(_)) { WHOLE } else { 1 };
        let columns = vec![ZERO; each * SIDE * self.across.len() + 1];
        Memory { columns, scratch: self.across.scratch(), ..Memory::default() }
    }

    /// Solves `(σ − c (L + λ)) x = b` in place.
    pub(super) fn solve(&self, task: Solve<'_, '_>) {
        let Solve { operator, lines, row, planes, memory } = task;
        for (line, j) in lines.enumerate() {
            for i in (0..self.modes).step_by(8 * SIDE) {
                self.solve_group(operator, [i, j], line * row, planes, memory);
            }
        }
    }

    /// Eigenvalues of the group from mode `[i, j]` on.
    pub(super) fn lambda(&self, [i, j]: [usize; 2]) -> [f64; 8 * SIDE] {
        let mut lambda = [0.0; 8 * SIDE];
        for (to, x) in lambda.iter_mut().zip(&self.lambda[0][i..]) {
            *to = x + self.lambda[1][j];
        }
        lambda
    }

    /// Solves up to [`SIDE`] blocks from mode `[i, j]` on, which stands at `at` + i.
    fn solve_group(
        &self,
        operator: [f64; 2],
        [i, j]: [usize; 2],
        at: usize,
        planes: &mut [&mut [f64]],
        memory: &mut Memory,
    ) {
        let n = self.across.len();
        let width = (self.modes - i).min(8 * SIDE);
        let at = at + i..at + i + width;
        let lambda = self.lambda([i, j]);
        let singular = operator[0] == 0.0 && lambda[0] == 0.0;
        if let Some(blocks) = &self.blocks {
            let modes = Modes { operator, scale: self.scale, lambda: &lambda, at: at.clone(), singular };
            blocks.solve(&modes, planes, &mut memory.blocks);
            if singular {
                remove_mean(&blocks.sweep, planes, at.start);
            }
            return;
        }
        let columns = aligned(&mut memory.columns);
        match &self.across {
            LastAxis::Sweep(sweep) => {
                let rows = columns.as_chunks_mut::<SIDE>().0.as_chunks_mut::<WHOLE>().0;
                let group = Group { sweep, operator, scale: self.scale, lambda: &lambda };
                let first = at.start;
                dispatch(Eliminate { group, block: 0..n, at: at.clone(), source: planes, rows, edge: None });
                if singular {
                    rows[n - 1].iter_mut().for_each(|values| values[0][0] = 0.0);
                }
                dispatch(Substitute { rows, beside: &[[0.0; GROUP]; 2], at, target: planes });
                if singular {
                    remove_mean(sweep, planes, first);
                }
            }
            LastAxis::Transform(transform, _) => {
                dispatch(Gather { at: at.clone(), source: &*planes, columns: &mut *columns });
                for (b, column) in columns.chunks_exact_mut(n).enumerate().take(width.div_ceil(8)) {
                    let lambda = &lambda.as_chunks::<8>().0[b];
                    transform.forward(column, &mut memory.scratch);
                    let scale = self.scale;
                    dispatch(Divide { own: &self.own, operator, scale, lambda, column });
                    if singular && b == 0 {
                        column[0][0] = 0.0;
                    }
                    transform.inverse(column, &mut memory.scratch);
                }
                dispatch(Scatter { at, columns, target: planes });
            }
        }
    }
}

/// Removes the mean of the first mode, which stands at `at`.
fn remove_mean(sweep: &Sweep, planes: &mut [&mut [f64]], at: usize) {
    let mean = mean(sweep, planes.iter().map(|x| &x[at]));
    for x in planes {
        x[at] -= mean;
    }
}

/// The mean of one value for each unknown of a column.
pub(super) fn mean<'a>(sweep: &Sweep, values: impl Iterator<Item = &'a f64>) -> f64 {
    let total: f64 = sweep.volume.iter().sum();
    let sum: f64 = values.zip(&sweep.volume).map(|(x, v)| x * v).sum();
    sum / total
}

/// Columns from the planes, block by block; each plane is visited once.
struct Gather<'a, 'b> {
    /// Where the group stands in each plane.
    at: Range<usize>,
    source: &'a [&'b mut [f64]],
    columns: &'a mut [Lanes],
}

impl Kernel for Gather<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let n = self.source.len();
        for (k, plane) in self.source.iter().enumerate() {
            for (b, block) in plane[self.at.clone()].chunks(8).enumerate() {
                self.columns[b * n + k] = load(block);
            }
        }
    }
}

/// Columns to the planes, see [`Gather`].
struct Scatter<'a, 'b> {
    at: Range<usize>,
    columns: &'a [Lanes],
    target: &'a mut [&'b mut [f64]],
}

impl Kernel for Scatter<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let n = self.target.len();
        for (k, plane) in self.target.iter_mut().enumerate() {
            for (b, block) in plane[self.at.clone()].chunks_mut(8).enumerate() {
                store(block, &self.columns[b * n + k], Write::Set);
            }
        }
    }
}

/// Division by σ − c (own eigenvalue + λ).
struct Divide<'a> {
    own: &'a [f64],
    operator: [f64; 2],
    scale: f64,
    lambda: &'a Lanes,
    column: &'a mut [Lanes],
}

impl Kernel for Divide<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { own, operator: [sigma, c], scale, lambda, column } = self;
        let lambda = S::as_simd_f64s(lambda).0;
        let (scale, weight) = (simd.splat_f64s(scale), simd.splat_f64s(c));
        for (x, own) in column.iter_mut().zip(own) {
            let (own, sigma) = (simd.splat_f64s(*own), simd.splat_f64s(sigma));
            for (x, lambda) in S::as_mut_simd_f64s(x).0.iter_mut().zip(lambda) {
                let d = simd.sub_f64s(sigma, simd.mul_f64s(weight, simd.add_f64s(own, *lambda)));
                *x = simd.div_f64s(simd.mul_f64s(scale, *x), d);
            }
        }
    }
}
