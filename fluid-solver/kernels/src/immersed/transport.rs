//! The carried force, taken along by the grains (docs/equations-immersed.md, section 7).
//!
//! λⁿ stands where a grain was, and the step needs it where the grain will be. Left in its cells, it is made
//! up for by dt (λⁿ⁺¹ − λⁿ) only after the projection, and a grain that moves by U dt lets the fluid slip by
//! some dt² U·∇λ: a few per cent of U where U is small, and much beside the slow flow through a dense bed
//! that moves as a whole.
//! So before the step
//! ```text
//! λ̂(x) = Σ_i b_i(x) ⟨b² λ/b⟩(x − U_i dt)/⟨b²⟩(x − U_i dt)
//! ```
//! with `b_i` at the predicted place and ⟨ ⟩ the cubic interpolation of what stands at the old one. λ/b is
//! smooth where λ is not, and weighs by b² where it is known best. Where too little of the support is in
//! reach of the cubic, the linear interpolation is taken. A rotation takes nothing along: what the fluid does
//! to a sphere does not turn with it.

mod interpolation;
pub(super) mod rows;
mod sums;

use super::by_layer::Placed;
use super::component::{Component, Share, Workspace};
use super::layer::{Part, Span};
use super::layer_sums::{bits_of, first as place_of, words};
use super::piece::PIECES;
use crate::ghosts::{Ghosts, Side};
use crate::grid::Grid;
use crate::lanes::{Kernel, Lanes, ZERO, dispatch, lanes_at_mut};
use crate::threads::by_layers;
use interpolation::{POINTS, Weights};
use pulp::Simd;
use rows::{Ring, Rows};
use std::ops::Range;
use sums::{Sums, lane_count};

pub(super) use interpolation::Interpolation;

/// The cell that stands for `cell` in a box of `cells`. A division only where it is needed.
#[inline(always)]
pub(super) fn wrap(cell: isize, cells: usize) -> usize {
    let inside = (0..cells as isize).contains(&cell);
    (if inside { cell } else { cell.rem_euclid(cells as isize) }) as usize
}

/// The four rows of a field that are met along the last axis: where the first row of each layer begins, and
/// weights.
struct Over {
    begins: [usize; POINTS],
    weights: Weights,
    /// Whether what is met beyond the ends of a row stands in its [`pads`].
    near: bool,
}

/// Places met beyond either end of a row by a grain that moves by less than a cell.
const BEYOND: usize = 2;

/// Whether there is room for so many between two rows.
fn pads<const D: usize>(grid: &Grid<D>) -> bool {
    grid.stride(1) - grid.cells[0] >= 2 * BEYOND
}

/// What is taken along, and whither.
#[derive(Clone, Copy)]
struct Path<'a, const D: usize> {
    grid: &'a Grid<D>,
    /// b λ and b², where they stood.
    from: [&'a [f64]; 2],
    points: &'a [[Interpolation; D]],
}

/// Places that the rows of a grain in a layer hold at most, of one piece each.
type Reach = [Range<usize>; PIECES];

/// None yet.
const EMPTY: Range<usize> = Range { start: usize::MAX, end: 0 };

impl<const D: usize> Path<'_, D> {
    /// Adds what comes with the grain of `part` to its rows in layer `k`: axis after axis, so that a place of
    /// a row is met once by each.
    #[inline(always)]
    fn part(
        &self,
        (part, spans, mut ratios): (&Part, &[Span], &[f64]),
        totals: &[f64],
        k: usize,
        rows: &mut Rows,
        to: &mut [f64],
    ) {
        let points = &self.points[part.grain];
        if points.iter().all(Interpolation::stays) {
            return self.stay(spans, ratios, totals, place_of(self.grid, k), to);
        }
        let mut reach: Reach = [EMPTY; PIECES];
        for span in spans {
            let reach = &mut reach[span.piece];
            *reach = reach.start.min(span.first)..reach.end.max(span.first + span.count);
        }
        for (ring, reach) in rows.rings.iter_mut().zip(&reach) {
            ring.rows = [None; POINTS];
            ring.sums.iter_mut().for_each(|sums| sums.fit(lane_count(reach.len())));
            rows.sums.fit(lane_count(reach.len()));
        }
        let near = pads(self.grid) && (-(BEYOND as isize)..0).contains(&points[0].low);
        let over = Over { near, ..self.over(&points[D - 1], k) };
        // counted on over a periodic face
        let (mut turn, mut before) = (0, 0);
        for span in spans {
            if span.row < before {
                turn += self.grid.cells[1] as isize;
            }
            before = span.row;
            self.gather(points, span, turn + span.row as isize, &reach[span.piece], &over, rows);
            let (mine, rest) = ratios.split_at(span.count);
            ratios = rest;
            let range = span.at..span.at + span.count;
            rows.sums.bring(&points[0].weights, mine, &totals[range.clone()], &mut to[range]);
        }
    }

    /// The same with a grain that stands still; layer `k` begins at `begin`.
    #[inline(always)]
    fn stay(&self, spans: &[Span], mut ratios: &[f64], totals: &[f64], begin: usize, to: &mut [f64]) {
        for span in spans {
            let (mine, rest) = ratios.split_at(span.count);
            ratios = rest;
            let range = span.at..span.at + span.count;
            let [force, square] = self.from.map(|from| &from[begin + span.at..][..span.count]);
            sums::keep([force, square], mine, &totals[range.clone()], &mut to[range]);
        }
    }

    /// The layers about layer `k`.
    #[inline(always)]
    fn over(&self, points: &Interpolation, k: usize) -> Over {
        let Self { grid, .. } = self;
        let mut over = Over { begins: [0; POINTS], weights: points.weights, near: false };
        for up in 0..POINTS {
            let above = k as isize + points.low + up as isize;
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
        points: &[Interpolation; D],
        span: &Span,
        row: isize,
        reach: &Range<usize>,
        over: &Over,
        rows: &mut Rows,
    ) {
        let Rows { rings, sums, cut } = rows;
        let low = points[0].low;
        if D == 2 {
            self.layers(over, 0, (span.first as isize + low, span.count), (sums, cut));
            return;
        }
        let Ring { rows, sums: kept } = &mut rings[span.piece];
        let (mut weights, mut slots) = (points[1].weights, [0; POINTS]);
        for (side, at) in slots.iter_mut().enumerate() {
            let beside = row + points[1].low + side as isize;
            let cell = wrap(beside, self.grid.cells[1]);
            let slot = beside.rem_euclid(POINTS as isize) as usize;
            *at = slot;
            if rows[slot] != Some(beside) {
                rows[slot] = Some(beside);
                self.layers(over, cell, (reach.start as isize + low, reach.len()), (&mut kept[slot], cut));
            }
            if !(self.grid.periodic(1) || cell as isize == beside) {
                (weights.cubic[side], weights.linear[side]) = (0.0, 0.0);
            }
        }
        let [p, q, r, s] = slots;
        let rows = [&kept[p], &kept[q], &kept[r], &kept[s]];
        sums.of_sums(&weights, rows, span.first - reach.start, lane_count(span.count));
    }

    /// Sums over the rows `row` of the layers `over`, for all that `count` places ask for whose first point
    /// is `first`.
    #[inline(always)]
    fn layers(
        &self,
        over: &Over,
        row: usize,
        (first, count): (isize, usize),
        (sums, cut): (&mut Sums, &mut [[Vec<f64>; POINTS]; 2]),
    ) {
        let Self { grid, from, .. } = self;
        let (n, start) = (grid.cells[0], row * grid.stride(1));
        let groups = lane_count(count);
        // what follows the row may be read, too: nobody asks for it
        let last = (over.begins.iter().max().expect("four") + start).saturating_add_signed(first);
        let inside = first >= 0 && first as usize + count + POINTS - 1 <= n;
        let whole = (inside || over.near) && last + 8 * groups <= from[0].len();
        let mut rows: [[&[Lanes]; POINTS]; 2] = [[&[]; POINTS]; 2];
        for ((rows, cut), field) in rows.iter_mut().zip(cut).zip(from) {
            for ((row, cut), begin) in rows.iter_mut().zip(cut).zip(over.begins) {
                let begin = begin + start;
                *row = if whole {
                    field[begin.saturating_add_signed(first)..][..8 * groups].as_chunks().0
                } else {
                    put_together(cut, &field[begin..][..n], first, 8 * groups, grid.periodic(0));
                    cut[..8 * groups].as_chunks().0
                };
            }
        }
        sums.of_fields(&over.weights, rows, groups);
    }
}

/// `cut` ← `count` places of a row from `first` on, over its ends if they are `periodic`, else zero there.
fn put_together(cut: &mut Vec<f64>, row: &[f64], first: isize, count: usize, periodic: bool) {
    cut.resize(cut.len().max(count), 0.0);
    let mut done = 0;
    while done < count {
        let cell = first + done as isize;
        let wrapped = wrap(cell, row.len());
        let piece = (row.len() - wrapped).min(count - done);
        let to = &mut cut[done..][..piece];
        if periodic || wrapped as isize == cell {
            to.copy_from_slice(&row[wrapped..][..piece]);
        } else {
            to.fill(0.0);
        }
        done += piece;
    }
}

impl<const D: usize> Component<D> {
    /// Takes `from` along with the grains to where `placed` has them, by `points` from where they were, into
    /// `to`, which is zero and stays so elsewhere. `mask`: b where the grains were. Both `from` and `mask`
    /// become zero.
    pub(super) fn advect_force(
        &mut self,
        placed: Placed<'_, D>,
        workspaces: &mut Vec<Workspace>,
        points: &[[Interpolation; D]],
        [from, mask, to]: [&mut [f64]; 3],
    ) {
        let grid = placed.grid;
        // The planes of other ranks come as products.
        self.change_forced(grid, [&mut *from, &mut *mask], |force, mask| {
            for l in 0..8 {
                (force[l], mask[l]) = (mask[l] * force[l], mask[l] * mask[l]);
            }
        });
        let end = grid.cells[0];
        self.change_pads(grid, [&mut *from, &mut *mask], |field, row| {
            field.copy_within(row..row + BEYOND, row + end);
            field.copy_within(row + end - BEYOND..row + end, row - BEYOND);
        });
        fetch(grid, points, [&mut *from, &mut *mask]);
        let path = Path { grid, from: [&*from, &*mask], points };
        let mut next = std::mem::take(&mut self.next);
        next.resize(self.forced.len(), 0);
        self.share(placed, workspaces, &mut next, [to], &|share| dispatch(Advect { path, share }));
        self.change_forced(grid, [&mut *from, &mut *mask], |force, mask| (*force, *mask) = (ZERO, ZERO));
        self.change_pads(grid, [from, mask], |field, row| {
            field[row + end..row + end + BEYOND].fill(0.0);
            field[row - BEYOND..row].fill(0.0);
        });
        self.next = std::mem::replace(&mut self.forced, next);
    }

    /// Changes what stands beyond the ends of the rows where there may be force, where the box goes on there
    /// and there is room for it. `change` is given a field and the first place of a row.
    fn change_pads(&self, grid: &Grid<D>, mut fields: [&mut [f64]; 2], change: impl Fn(&mut [f64], usize)) {
        if !(grid.periodic(0) && pads(grid)) {
            return;
        }
        let rows = self.forced.chunks_exact(words(grid)).enumerate();
        let rows_each = grid.stride(D - 1) / grid.stride(1);
        let rows = rows
            .filter(|(_, bits)| bits.iter().any(|bits| *bits != 0))
            .map(|(row, _)| place_of(grid, row / rows_each) + row % rows_each * grid.stride(1));
        rows.for_each(|row| fields.iter_mut().for_each(|field| change(field, row)));
    }

    /// Changes two fields where there may be force, eight places at a time.
    fn change_forced(
        &self,
        grid: &Grid<D>,
        fields: [&mut [f64]; 2],
        change: impl Fn(&mut Lanes, &mut Lanes) + Sync,
    ) {
        let rows = grid.rows() / grid.cells[D - 1];
        by_layers(grid, fields, |first, [one, other]| {
            for (j, row) in (first..first + rows).enumerate() {
                for (word, bits) in self.forced[bits_of(grid, row)].iter().enumerate() {
                    let mut bits = *bits;
                    while bits != 0 {
                        let at = j * grid.stride(1) + 512 * word + 8 * bits.trailing_zeros() as usize;
                        change(lanes_at_mut(one, at), lanes_at_mut(other, at));
                        bits &= bits - 1;
                    }
                }
            }
        });
    }
}

/// Fetches the planes of other ranks from which a grain may take something along.
fn fetch<const D: usize>(grid: &Grid<D>, points: &[[Interpolation; D]], [from, mask]: [&mut [f64]; 2]) {
    let ranks = grid.division.ranks();
    if ranks.is_alone() {
        return;
    }
    let reach = |point: &[Interpolation; D]| {
        let low = point[D - 1].low;
        low.unsigned_abs().max((low + POINTS as isize - 1).unsigned_abs())
    };
    let (width, least) = (points.iter().map(reach).max().unwrap_or(0), grid.division.least());
    if width > least {
        ranks.fail(format!(
            "a grain takes its force along over {width} planes in a window, and a rank has {least} planes: take \
             fewer ranks or a shorter step"
        ));
        return;
    }
    Ghosts::new(grid).fetch(width, &mut [(from, Side::Both), (mask, Side::Both)]);
}

/// [`Component::advect_force`] in some layers.
struct Advect<'a, const D: usize> {
    path: Path<'a, D>,
    share: Share<'a, 1, D>,
}

impl<const D: usize> Kernel for Advect<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Share { placed, grains, cache, first, workspace, forced, words_each, fields: [to] } = self.share;
        let Placed { grid, model, .. } = placed;
        let Workspace { layer_sums, rows, .. } = workspace;
        let entries = cache.len();
        let layers = to.chunks_mut(grid.stride(D - 1)).zip(forced.chunks_mut(words_each));
        for (k, (to, forced)) in layers.enumerate() {
            let layer = &mut cache[k % entries];
            layer.fill(grid, grains, model, first + k, &mut layer_sums.room);
            layer_sums.gather(layer);
            layer_sums.mark_covered(grid, layer);
            for part in layer.parts() {
                self.path.part(part, &layer_sums.totals, first + k, rows, to);
            }
            forced.copy_from_slice(&layer_sums.covered);
            layer_sums.clear(layer);
        }
    }
}
