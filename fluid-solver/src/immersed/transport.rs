//! The carried force, taken along by the grains (`fluid.immersed.force_transport = "advected"`).
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

pub(super) mod rows;
mod sums;
mod taps;

use super::by_layer::GrainsByLayer;
use super::component::{Bench, Component, Placed};
use super::layer::{Layer, Part, Span};
use super::piece::PIECES;
use super::sheet::{first as place_of, words};
use crate::grid::Grid;
use crate::lanes::{Kernel, Lanes, dispatch};
use pulp::Simd;
use rayon::prelude::*;
use rows::{Ring, Rows};
use std::ops::Range;
use sums::{Sums, eights};
use taps::{TAPS, Weights};

pub(super) use taps::Taps;

/// The cell that stands for `cell` in a box of `cells`. A division only where it is needed.
#[inline(always)]
fn wrap(cell: isize, cells: usize) -> usize {
    let inside = (0..cells as isize).contains(&cell);
    (if inside { cell } else { cell.rem_euclid(cells as isize) }) as usize
}

/// The four rows of a field that are met along the last axis: where the first row of each layer begins, and weights.
struct Over {
    begins: [usize; TAPS],
    weights: Weights,
}

/// What is taken along, and whither.
#[derive(Clone, Copy)]
struct Way<'a, const D: usize> {
    grid: &'a Grid<D>,
    /// λ and b, where they stood.
    from: [&'a [f64]; 2],
    taps: &'a [[Taps; D]],
}

/// Places that the rows of a grain in a layer hold at most, of one piece each.
type Reach = [Range<usize>; PIECES];

/// None yet.
const EMPTY: Range<usize> = Range { start: usize::MAX, end: 0 };

impl<const D: usize> Way<'_, D> {
    /// Adds what comes with the grain of `part` to its rows in layer `k`: axis after axis, so that a place of a
    /// row is met once by each.
    #[inline(always)]
    fn part(
        &self,
        (part, spans, mut odds): (&Part, &[Span], &[f64]),
        totals: &[f64],
        k: usize,
        rows: &mut Rows,
        to: &mut [f64],
    ) {
        let taps = &self.taps[part.grain];
        let mut reach: Reach = [EMPTY; PIECES];
        for span in spans {
            let reach = &mut reach[span.piece];
            *reach = reach.start.min(span.first)..reach.end.max(span.first + span.count);
        }
        for (ring, reach) in rows.rings.iter_mut().zip(&reach) {
            ring.rows = [None; TAPS];
            ring.sums.iter_mut().for_each(|sums| sums.fit(eights(reach.len())));
            rows.sums.fit(eights(reach.len()));
        }
        let over = self.over(&taps[D - 1], k);
        // counted on over a periodic face
        let (mut turn, mut before) = (0, 0);
        for span in spans {
            if span.row < before {
                turn += self.grid.cells[1] as isize;
            }
            before = span.row;
            self.gather(taps, span, turn + span.row as isize, &reach[span.piece], &over, rows);
            let (mine, rest) = odds.split_at(span.count);
            odds = rest;
            let range = span.at..span.at + span.count;
            rows.sums.bring(&taps[0].weights, mine, &totals[range.clone()], &mut to[range]);
        }
    }

    /// The layers about layer `k`.
    #[inline(always)]
    fn over(&self, taps: &Taps, k: usize) -> Over {
        let Self { grid, .. } = self;
        let mut over = Over { begins: [0; TAPS], weights: taps.weights };
        for up in 0..TAPS {
            let above = k as isize + taps.low + up as isize;
            let layer = wrap(above, grid.cells[D - 1]);
            over.begins[up] = place_of(grid, layer);
            if !(grid.periodic(D - 1) || layer as isize == above) {
                (over.weights.cubic[up], over.weights.linear[up]) = (0.0, 0.0);
            }
        }
        over
    }

    /// Sums over the rows about that of `span`, which is `row`.
    #[inline(always)]
    fn gather(
        &self,
        taps: &[Taps; D],
        span: &Span,
        row: isize,
        reach: &Range<usize>,
        over: &Over,
        rows: &mut Rows,
    ) {
        let Rows { rings, sums, cut } = rows;
        let low = taps[0].low;
        if D == 2 {
            self.layers(over, 0, (span.first as isize + low, span.count), (sums, cut));
            return;
        }
        let Ring { rows, sums: held } = &mut rings[span.piece];
        let (mut weights, mut slots) = (taps[1].weights, [0; TAPS]);
        for (side, at) in slots.iter_mut().enumerate() {
            let beside = row + taps[1].low + side as isize;
            let cell = wrap(beside, self.grid.cells[1]);
            let slot = beside.rem_euclid(TAPS as isize) as usize;
            *at = slot;
            if rows[slot] != Some(beside) {
                rows[slot] = Some(beside);
                self.layers(over, cell, (reach.start as isize + low, reach.len()), (&mut held[slot], cut));
            }
            if !(self.grid.periodic(1) || cell as isize == beside) {
                (weights.cubic[side], weights.linear[side]) = (0.0, 0.0);
            }
        }
        let [p, q, r, s] = slots;
        let rows = [&held[p], &held[q], &held[r], &held[s]];
        sums.of_sums(&weights, rows, span.first - reach.start, eights(span.count));
    }

    /// Sums over the rows `row` of the layers `over`, for all that `count` places ask for whose first point is `first`.
    #[inline(always)]
    fn layers(
        &self,
        over: &Over,
        row: usize,
        (first, count): (isize, usize),
        (sums, cut): (&mut Sums, &mut [[Vec<f64>; TAPS]; 2]),
    ) {
        let Self { grid, from, .. } = self;
        let (n, start) = (grid.cells[0], row * grid.stride(1));
        let eights = eights(count);
        // what follows the row may be read, too: nobody asks for it
        let last = over.begins.iter().max().expect("four") + start;
        let inside = first >= 0 && first as usize + count + TAPS - 1 <= n;
        let whole = inside && last + first as usize + 8 * eights <= from[0].len();
        let mut rows: [[&[Lanes]; TAPS]; 2] = [[&[]; TAPS]; 2];
        for ((rows, cut), field) in rows.iter_mut().zip(cut).zip(from) {
            for ((row, cut), begin) in rows.iter_mut().zip(cut).zip(over.begins) {
                let begin = begin + start;
                *row = if whole {
                    field[begin + first as usize..][..8 * eights].as_chunks().0
                } else {
                    put_together(cut, &field[begin..][..n], first, 8 * eights, grid.periodic(0));
                    cut.as_chunks().0
                };
            }
        }
        sums.of_fields(&over.weights, rows, eights);
    }
}

/// `cut` ← `count` places of a row from `first` on, over its ends if they are `periodic`, else zero there.
fn put_together(cut: &mut Vec<f64>, row: &[f64], first: isize, count: usize, periodic: bool) {
    cut.clear();
    while cut.len() < count {
        let cell = first + cut.len() as isize;
        let wrapped = wrap(cell, row.len());
        let piece = (row.len() - wrapped).min(count - cut.len());
        if periodic || wrapped as isize == cell {
            cut.extend_from_slice(&row[wrapped..][..piece]);
        } else {
            cut.resize(cut.len() + piece, 0.0);
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
        let (benches, per_share) = self.split(grid, benches);
        let mut next = std::mem::take(&mut self.next);
        next.resize(self.held().len(), 0);
        let marks = next.len() / grid.cells[D - 1];
        let (grains, held, entries) = self.layers.shared(grid, per_share);
        let (n, size) = (grid.cells[D - 1], grid.stride(D - 1));
        let begin = place_of(grid, 0);
        let to = to[begin..begin + n * size].chunks_mut(per_share * size);
        let parts = benches.iter_mut().zip(held.chunks_mut(entries));
        let parts = parts.zip(to).zip(next.chunks_mut(per_share * marks)).enumerate();
        let along = parts.map(|(t, (((bench, held), to), marked))| Along {
            way,
            placed,
            grains,
            held,
            first: t * per_share,
            bench,
            marked,
            marks,
            to,
        });
        if per_share < n {
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
            let place = place_of(grid, k) + word / words(grid) * grid.stride(1) + word % words(grid) * 512;
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
    grains: &'a GrainsByLayer<D>,
    held: &'a mut [Layer],
    /// First of its layers.
    first: usize,
    bench: &'a mut Bench,
    marked: &'a mut [u64],
    /// Words of `marked` per layer.
    marks: usize,
    to: &'a mut [f64],
}

impl<const D: usize> Kernel for Along<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Placed { grid, kernel, .. } = self.placed;
        let Bench { sheet, rows, .. } = self.bench;
        let entries = self.held.len();
        let layers = self.to.chunks_mut(grid.stride(D - 1)).zip(self.marked.chunks_mut(self.marks));
        for (k, (to, marked)) in layers.enumerate() {
            let layer = &mut self.held[k % entries];
            layer.fill(grid, self.grains, kernel, self.first + k, &mut sheet.profiles);
            sheet.gather(layer);
            sheet.mark(grid, layer);
            for part in layer.parts() {
                self.way.part(part, sheet.totals(), self.first + k, rows, to);
            }
            marked.copy_from_slice(&sheet.marks);
            sheet.clear(layer);
        }
    }
}
