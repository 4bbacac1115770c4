//! The carried force, taken along by the grains (`fluid.immersed.carry = "with-grains"`).
//!
//! λⁿ stands where a grain was, and the step needs it where the grain will be. Left in its cells, it is made up for by
//! dt (λⁿ⁺¹ − λⁿ) only after the projection, and a grain that moves by U dt lets the fluid slip by some dt² U·∇λ: nothing
//! beside U, but much beside the slow flow through a dense bed that moves as a whole. So before the step
//! ```text
//! λ̂(x) = Σ_i b_i(x) ⟨b² λ/b⟩(x − U_i dt)/⟨b²⟩(x − U_i dt)
//! ```
//! with `b_i` at the predicted place and ⟨ ⟩ the cubic interpolation of what stands at the old one. λ/b is smooth where λ
//! is not, and weighs by b² where it is known best. Where too little of the support is in reach of the cubic, the linear
//! interpolation is taken. A rotation takes nothing along: what the fluid does to a sphere does not turn with it.

use super::body::{Motion, laboratory};
use super::component::{Bench, Component, Placed};
use super::layers::Layers;
use super::sheet::{Part, Span, first, words};
use crate::grid::Grid;
use crate::lanes::{Kernel, dispatch};
use pulp::Simd;
use rayon::prelude::*;

/// ⟨b²⟩ below which the cubic interpolation is not trusted.
const TRUSTED: f64 = 0.25;

/// ⟨b²⟩ below which there is nothing to take along.
const NOTHING: f64 = 1e-12;

/// Points of an interpolation along one axis.
const TAPS: usize = 4;

/// The four points about a place along one axis: how many cells from it the first one is, and their weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taps {
    low: isize,
    cubic: [f64; TAPS],
    linear: [f64; TAPS],
}

impl Taps {
    /// For a grain that moves so for `dt`, along each axis.
    pub(super) fn of<const D: usize>(grid: &Grid<D>, motion: &Motion, dt: f64) -> [Self; D] {
        std::array::from_fn(|a| {
            let (lab, axis) = (laboratory(grid.geometry, a), &grid.axes[a]);
            let above = axis.faces.partition_point(|face| *face <= motion.centre[lab]);
            let width = axis.widths[above.clamp(1, axis.widths.len()) - 1];
            Self::back(motion.velocity[lab] * dt / width)
        })
    }

    /// For a place `shift` cells back.
    fn back(shift: f64) -> Self {
        let low = (-shift).floor();
        let t = -shift - low;
        // Lagrange's polynomial through -1, 0, 1, 2
        let cubic = [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ];
        Self { low: low as isize - 1, cubic, linear: [0.0, 1.0 - t, t, 0.0] }
    }

    /// Cell of point `tap` from cell `at`, if there is one.
    #[inline(always)]
    fn cell(&self, at: usize, tap: usize, cells: usize, periodic: bool) -> Option<usize> {
        let cell = at as isize + self.low + tap as isize;
        let wrapped = wrap(cell, cells);
        (periodic || wrapped as isize == cell).then_some(wrapped)
    }
}

/// The cell that stands for `cell` in a box of `cells`. A division only where it is needed.
#[inline(always)]
fn wrap(cell: isize, cells: usize) -> usize {
    let inside = (0..cells as isize).contains(&cell);
    (if inside { cell } else { cell.rem_euclid(cells as isize) }) as usize
}

/// Sums over the rows about one row: of b λ and b², by cubic and by linear weights.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    sums: [Vec<f64>; 4],
    /// λ/b that comes to each place of the row.
    came: Vec<f64>,
}

impl Rows {
    /// Adds a row of λ and b to the places from `to` on.
    #[inline(always)]
    fn add(&mut self, [cubic, linear]: [f64; 2], [lambda, share]: [&[f64]; 2], to: usize) {
        let n = lambda.len();
        let share = &share[..n];
        let [a, b, c, d] = &mut self.sums;
        let (a, b) = (&mut a[to..][..n], &mut b[to..][..n]);
        for i in 0..n {
            a[i] += cubic * share[i] * lambda[i];
            b[i] += cubic * share[i] * share[i];
        }
        if linear > 0.0 {
            let (c, d) = (&mut c[to..][..n], &mut d[to..][..n]);
            for i in 0..n {
                c[i] += linear * share[i] * lambda[i];
                d[i] += linear * share[i] * share[i];
            }
        }
    }

    /// λ/b that comes to `count` places, the first of whose points stand at the beginning.
    #[inline(always)]
    fn along(&mut self, taps: &Taps, count: usize) {
        let [a, b, c, d] = &self.sums;
        let (a, b, c, d) = (wide(a, count), wide(b, count), wide(c, count), wide(d, count));
        let ([p, q, r, s], [_, t, u, _]) = (taps.cubic, taps.linear);
        self.came.resize(count, 0.0);
        for (i, came) in self.came.iter_mut().enumerate() {
            let cubic = p * b[i] + q * b[i + 1] + r * b[i + 2] + s * b[i + 3];
            let linear = t * d[i + 1] + u * d[i + 2];
            let trusted = cubic > TRUSTED;
            let share = if trusted { cubic } else { linear };
            let cubic = p * a[i] + q * a[i + 1] + r * a[i + 2] + s * a[i + 3];
            let linear = t * c[i + 1] + u * c[i + 2];
            let force = if trusted { cubic } else { linear };
            *came = if share > NOTHING { force / share } else { 0.0 };
        }
    }
}

/// The values that `count` places ask for.
#[inline(always)]
fn wide(values: &[f64], count: usize) -> &[f64] {
    &values[..count + TAPS - 1]
}

/// What is taken along, and whither.
#[derive(Clone, Copy)]
struct Way<'a, const D: usize> {
    grid: &'a Grid<D>,
    /// λ and b, where they stood.
    from: [&'a [f64]; 2],
    taps: &'a [[Taps; D]],
}

impl<const D: usize> Way<'_, D> {
    /// Adds what comes with the grain of `part` to the cells of `span`, a row of layer `k`.
    #[inline(always)]
    fn span(
        &self,
        part: &Part,
        span: &Span,
        (odds, totals): (&[f64], &[f64]),
        k: usize,
        rows: &mut Rows,
        to: &mut [f64],
    ) {
        let Self { grid, from, taps } = self;
        let taps = &taps[part.grain];
        let stride = grid.stride(1);
        let wide = span.count + TAPS - 1;
        for sums in &mut rows.sums {
            sums.clear();
            sums.resize(wide, 0.0);
        }
        let row = span.at / stride;
        let across = if D == 3 { TAPS } else { 1 };
        for up in 0..TAPS {
            let Some(layer) = taps[D - 1].cell(k, up, grid.cells[D - 1], grid.periodic(D - 1)) else {
                continue;
            };
            for side in 0..across {
                let (mut weights, mut begin) =
                    ([taps[D - 1].cubic[up], taps[D - 1].linear[up]], first(grid, layer));
                if D == 3 {
                    let Some(beside) = taps[1].cell(row, side, grid.cells[1], grid.periodic(1)) else {
                        continue;
                    };
                    weights = [weights[0] * taps[1].cubic[side], weights[1] * taps[1].linear[side]];
                    begin += beside * stride;
                }
                // All but one of a grain that stands.
                if weights == [0.0; 2] {
                    continue;
                }
                self.row(
                    weights,
                    from.map(|field| &field[begin..][..grid.cells[0]]),
                    span.first,
                    wide,
                    taps[0].low,
                    rows,
                );
            }
        }
        rows.along(&taps[0], span.count);
        let to = &mut to[span.at..][..span.count];
        let (odds, totals) = (&odds[..span.count], &totals[..span.count]);
        for (i, (to, came)) in to.iter_mut().zip(&rows.came).enumerate() {
            *to += odds[i] / (1.0 + totals[i]) * came;
        }
    }

    /// Adds a row of λ and b, `wide` cells of it from `first + low` on.
    #[inline(always)]
    fn row(
        &self,
        weights: [f64; 2],
        fields: [&[f64]; 2],
        first: usize,
        wide: usize,
        low: isize,
        rows: &mut Rows,
    ) {
        let n = self.grid.cells[0];
        let mut done = 0;
        while done < wide {
            let cell = first as isize + low + done as isize;
            let wrapped = wrap(cell, n);
            let count = (n - wrapped).min(wide - done);
            if self.grid.periodic(0) || wrapped as isize == cell {
                rows.add(weights, fields.map(|field| &field[wrapped..][..count]), done);
            }
            done += count;
        }
    }
}

impl<const D: usize> Component<D> {
    /// Takes `from` along with the grains to where `placed` has them, by `taps` from where they were, into `to`,
    /// which is zero and stays so elsewhere. `share`: b where the grains were. Both `from` and `share` become zero.
    pub(super) fn take_along(
        &mut self,
        placed: Placed<'_, D>,
        benches: &mut Vec<Bench>,
        taps: &[[Taps; D]],
        [from, share, to]: [&mut [f64]; 3],
    ) {
        let grid = placed.grid;
        let way = Way { grid, from: [&*from, &*share], taps };
        self.place(placed);
        let (benches, layers) = self.split(grid, benches);
        let mut next = std::mem::take(&mut self.next);
        next.resize(self.held().len(), 0);
        let marks = next.len() / grid.cells[D - 1];
        let (n, size) = (grid.cells[D - 1], grid.stride(D - 1));
        let begin = first(grid, 0);
        let to = to[begin..begin + n * size].chunks_mut(layers * size);
        let parts = benches.iter_mut().zip(to).zip(next.chunks_mut(layers * marks));
        let along = parts.enumerate().map(|(t, ((bench, to), held))| Along {
            way,
            placed,
            layers: self.layers(),
            first: t * layers,
            bench,
            held,
            marks,
            to,
        });
        if layers < n {
            along.par_bridge().for_each(dispatch);
        } else {
            along.for_each(dispatch);
        }
        self.forget(grid, [from, share]);
        self.next = std::mem::replace(self.held_mut(), next);
    }

    /// Sets fields to zero where there may be force.
    fn forget(&self, grid: &Grid<D>, mut fields: [&mut [f64]; 2]) {
        let marks = self.held().len() / grid.cells[D - 1];
        for (word, bits) in self.held().iter().enumerate() {
            let (k, word, mut bits) = (word / marks, word % marks, *bits);
            let place = first(grid, k) + word / words(grid) * grid.stride(1) + word % words(grid) * 512;
            while bits != 0 {
                let at = place + 8 * bits.trailing_zeros() as usize;
                bits &= bits - 1;
                fields.iter_mut().for_each(|field| field[at..at + 8].fill(0.0));
            }
        }
    }
}

/// [`Component::take_along`] in some layers.
struct Along<'a, const D: usize> {
    way: Way<'a, D>,
    placed: Placed<'a, D>,
    layers: &'a Layers<D>,
    /// First of its layers.
    first: usize,
    bench: &'a mut Bench,
    held: &'a mut [u64],
    /// Words of `held` per layer.
    marks: usize,
    to: &'a mut [f64],
}

impl<const D: usize> Kernel for Along<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Placed { grid, kernel, .. } = self.placed;
        let Bench { sheet, rows, .. } = self.bench;
        let layers = self.to.chunks_mut(grid.stride(D - 1)).zip(self.held.chunks_mut(self.marks));
        for (k, (to, held)) in layers.enumerate() {
            sheet.fill(grid, self.layers, kernel, self.first + k);
            sheet.gather();
            for (part, spans, mut odds) in sheet.parts() {
                for span in spans {
                    let (mine, rest) = odds.split_at(span.count);
                    odds = rest;
                    self.way.span(part, span, (mine, &sheet.totals()[span.at..]), self.first + k, rows, to);
                }
            }
            held.copy_from_slice(&sheet.marks);
            sheet.clear();
        }
    }
}
