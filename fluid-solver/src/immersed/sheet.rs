//! One layer of nodes with the grains in it: rows of cells, the odds of each, their sums over grains.
//!
//! Rows are taken in whole vectors of eight places: those that a grain does not hold have no odds, and
//! nothing that is done with them changes anything.

use super::body::{Motion, Shape};
use super::layers::{Layers, Slice};
use super::mask::Kernel;
use super::nodes::Nodes;
use super::odds::{Law, Profile, Sums};
use crate::grid::Grid;
use crate::lanes::{self, dispatch};
use pulp::Simd;
use std::ops::Range;

/// Neighbouring places along axis 0 of which one grain holds some.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// Place of the first in the layer.
    pub(crate) at: usize,
    /// Index of the first along axis 0.
    pub(crate) first: usize,
    /// Number of places, a multiple of eight.
    pub(crate) count: usize,
    /// Control volume of a cell over its factor along axis 0.
    pub(crate) weight: f64,
    /// Arm along axis 0: this and the position of the node.
    pub(crate) shift: f64,
    /// Arm along axis 1 in space, m; else 0.
    pub(crate) middle: f64,
}

/// What one grain holds of a layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) grain: usize,
    /// Arm along the last axis, m.
    pub(crate) arm: f64,
    /// Number of its spans.
    spans: usize,
}

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

/// What is the same for all places of a row.
#[derive(Clone, Copy)]
struct Row {
    /// Index along axis 1 in space, else 0.
    index: usize,
    /// Arm along axis 1 in space, else 0, m.
    arm: f64,
    weight: f64,
}

/// A layer being worked on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheet {
    parts: Vec<Part>,
    spans: Vec<Span>,
    odds: Vec<f64>,
    profiles: [Profile; PIECES],
    /// Sums of odds over all grains.
    pub(super) totals: Vec<f64>,
    /// Sums of odds times velocity.
    pub(super) targets: Vec<f64>,
    /// A bit for each eight places of a row that a grain holds some of, [`words`] per row.
    pub(super) marks: Vec<u64>,
}

/// Place of the first value of layer `k` in a field.
pub(crate) fn first<const D: usize>(grid: &Grid<D>, k: usize) -> usize {
    grid.row(k * grid.rows() / grid.cells[D - 1])
}

/// Number of words in which the eights of a row have a bit each.
pub(super) fn words<const D: usize>(grid: &Grid<D>) -> usize {
    grid.stride(1).div_ceil(8 * 64)
}

impl Sheet {
    /// Finds the rows of layer `k` and the odds of their cells; forgets those that were there before.
    pub(crate) fn fill<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        layers: &Layers<D>,
        kernel: &Kernel,
        k: usize,
    ) {
        self.parts.clear();
        self.spans.clear();
        self.odds.clear();
        let size = grid.stride(D - 1);
        if self.totals.len() != size {
            self.totals = vec![0.0; size];
            self.targets = vec![0.0; size];
            self.marks = vec![0; size / grid.stride(1) * words(grid)];
        }
        dispatch(Fill { sheet: self, grid, layers, kernel, k });
    }

    /// Adds what the grain of `slice` holds of layer `k`.
    #[inline(always)]
    fn part<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        layers: &Layers<D>,
        slice: &Slice,
        kernel: &Kernel,
        k: usize,
    ) {
        let (nodes, extent) = (&layers.nodes, &layers.extents[slice.grain]);
        let first = self.spans.len();
        let chord = extent.outer * extent.outer - slice.arm * slice.arm;
        if chord <= 0.0 {
            return;
        }
        let pieces = Piece::of(grid, nodes, extent.at[0], chord.sqrt());
        let pieces = &pieces[..pieces.iter().filter(|piece| piece.count > 0).count()];
        for (piece, profile) in pieces.iter().zip(&mut self.profiles) {
            profile.set(&nodes.row, piece, extent.outer);
        }
        let mut sums = Sums::default();
        sums.add(slice.arm, nodes.spacing[D - 1][k]);
        let law = Law::new(kernel, extent.radius, extent.inner, nodes.even);
        let weight = grid.turn() * grid.volumes(nodes.component(), D - 1)[k];
        if D == 2 {
            self.row(grid, pieces, chord, &law, sums, Row { index: 0, arm: 0.0, weight });
        } else {
            let (low, high) = nodes.range(grid, 1, extent.at[1], chord.sqrt());
            for m in low..high {
                let near = nodes.node(grid, 1, extent.at[1], m);
                let chord = chord - near.arm * near.arm;
                if chord <= 0.0 {
                    continue;
                }
                let mut sums = sums;
                sums.add(near.arm, nodes.spacing[1][near.index]);
                let weight = weight * grid.volumes(nodes.component(), 1)[near.index];
                self.row(grid, pieces, chord, &law, sums, Row { index: near.index, arm: near.arm, weight });
            }
        }
        self.parts.push(Part { grain: slice.grain, arm: slice.arm, spans: self.spans.len() - first });
    }

    /// Adds the places of one row of which the grain holds some, `chord` being its squared half.
    #[inline(always)]
    fn row<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        pieces: &[Piece],
        chord: f64,
        law: &Law,
        sums: Sums,
        row: Row,
    ) {
        let (stride, words) = (grid.stride(1), words(grid));
        for (piece, profile) in pieces.iter().zip(&self.profiles) {
            let window = piece.window(chord.sqrt());
            if window.is_empty() {
                continue;
            }
            let first = piece.first + window.start;
            let (at, count) = (row.index * stride + first, window.len());
            self.spans.push(Span {
                at,
                first,
                count,
                weight: row.weight,
                shift: piece.shift,
                middle: row.arm,
            });
            law.row(profile, window, &sums, &mut self.odds);
            for eight in first / 8..=(first + count - 1) / 8 {
                self.marks[row.index * words + eight / 64] |= 1 << (eight % 64);
            }
        }
    }

    /// Sums of odds over all grains, one entry per place of the layer.
    pub(crate) fn totals(&self) -> &[f64] {
        &self.totals
    }

    /// What each grain holds: its rows with their odds, in the order of the grains.
    #[inline(always)]
    pub(crate) fn parts(&self) -> impl Iterator<Item = (&Part, &[Span], &[f64])> {
        let (mut spans, mut odds) = (self.spans.as_slice(), self.odds.as_slice());
        self.parts.iter().map(move |part| {
            let (mine, rest) = spans.split_at(part.spans);
            let cells = mine.iter().map(|span| span.count).sum::<usize>();
            let (held, left) = odds.split_at(cells);
            (spans, odds) = (rest, left);
            (part, mine, held)
        })
    }

    /// Sums the odds of all grains.
    #[inline(always)]
    pub(crate) fn gather(&mut self) {
        let mut rest = self.odds.as_chunks::<8>().0;
        for span in &self.spans {
            let (odds, after) = rest.split_at(span.count / 8);
            rest = after;
            let totals = self.totals[span.at..][..span.count].as_chunks_mut::<8>().0;
            for (total, odds) in totals.iter_mut().zip(odds) {
                for l in 0..8 {
                    total[l] += odds[l];
                }
            }
        }
    }

    /// Sums odds, and odds times the velocity of component `c`, over all grains.
    #[inline(always)]
    pub(super) fn gather_velocity(&mut self, along: &[f64], c: usize, motions: &[Motion]) {
        let mut spans = self.spans.as_slice();
        let mut rest = self.odds.as_chunks::<8>().0;
        for part in &self.parts {
            let motion = &motions[part.grain];
            let (mine, others) = spans.split_at(part.spans);
            spans = others;
            for span in mine {
                let (odds, after) = rest.split_at(span.count / 8);
                rest = after;
                let [base, slope] = span.velocity(motion, c, part.arm);
                let range = span.at..span.at + span.count;
                let totals = self.totals[range.clone()].as_chunks_mut::<8>().0;
                let targets = self.targets[range].as_chunks_mut::<8>().0;
                let along = along[span.first..][..span.count].as_chunks::<8>().0;
                for (((total, target), odds), x) in totals.iter_mut().zip(targets).zip(odds).zip(along) {
                    for l in 0..8 {
                        total[l] += odds[l];
                        target[l] += odds[l] * (base + slope * x[l]);
                    }
                }
            }
        }
    }

    /// Forgets the sums of the layer.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        for span in &self.spans {
            let range = span.at..span.at + span.count;
            self.totals[range].fill(0.0);
        }
        self.marks.fill(0);
    }
}

/// [`Sheet::fill`].
struct Fill<'a, const D: usize> {
    sheet: &'a mut Sheet,
    grid: &'a Grid<D>,
    layers: &'a Layers<D>,
    kernel: &'a Kernel,
    k: usize,
}

impl<const D: usize> lanes::Kernel for Fill<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        for slice in self.layers.of(self.k) {
            self.sheet.part(self.grid, self.layers, slice, self.kernel, self.k);
        }
    }
}

/// Calls `visit` with every layer of the cell centres in turn, the odds of all grains summed.
pub(crate) fn each_sheet<const D: usize>(
    grid: &Grid<D>,
    kernel: &Kernel,
    shapes: &[Shape],
    motions: &[Motion],
    mut visit: impl FnMut(usize, &Sheet, &Nodes<D>),
) {
    let mut layers = Layers::new(grid, D);
    layers.place(grid, kernel, shapes, motions);
    let mut sheet = Sheet::default();
    for k in 0..grid.cells[D - 1] {
        sheet.fill(grid, &layers, kernel, k);
        sheet.gather();
        visit(k, &sheet, &layers.nodes);
        sheet.clear();
    }
}

/// Pieces into which a periodic face may cut a row.
const PIECES: usize = 2;

impl Piece {
    /// The pieces of a row within `half` of `centre`; those that are not needed have no places.
    #[inline(always)]
    fn of<const D: usize>(grid: &Grid<D>, nodes: &Nodes<D>, centre: f64, half: f64) -> [Self; PIECES] {
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
    fn window(&self, half: f64) -> Range<usize> {
        if self.rate == 0.0 {
            return 0..self.count;
        }
        let low = (((-half - self.arm) * self.rate).ceil().max(0.0) as usize).max(self.begin - self.first);
        let high = ((half - self.arm) * self.rate).floor();
        if high < low as f64 {
            return 0..0;
        }
        let high = (high as usize).min(self.end - self.first - 1);
        let count = (high + 1).saturating_sub(low).next_multiple_of(8);
        let low = low.min(self.count - count);
        low..low + count
    }
}

impl Span {
    /// Rigid velocity of component `c` along the row, as a line: at the origin of axis 0, and per metre.
    #[inline(always)]
    pub(crate) fn velocity(&self, motion: &Motion, c: usize, arm: f64) -> [f64; 2] {
        let slope = motion.slope(c, 0);
        [motion.velocity_at(c, [self.shift, self.middle, arm]), slope]
    }
}
