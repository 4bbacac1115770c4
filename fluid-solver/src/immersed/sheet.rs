//! One layer of nodes with the grains in it: rows of cells, the odds of each, their sums over grains.
//!
//! Rows are taken in whole vectors of eight places: those that a grain does not hold have no odds, and
//! nothing that is done with them changes anything.

use super::body::{Motion, Shape};
use super::layers::Layers;
use super::mask::Kernel;
use super::nodes::Nodes;
use super::odds::{Batch, Sums};
use crate::grid::Grid;

/// Neighbouring places along axis 0 of which one grain holds some.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// Place of the first in the layer.
    pub(crate) at: usize,
    /// Index of the first along axis 0.
    pub(crate) first: usize,
    /// Index of the row along axis 1 (in the plane: of the layer).
    pub(crate) row: usize,
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

/// A layer being worked on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheet {
    parts: Vec<Part>,
    spans: Vec<Span>,
    odds: Vec<f64>,
    batch: Batch,
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
    /// Finds the rows of layer `k`, and the odds of their cells if the mask is given; forgets what was there
    /// before.
    pub(crate) fn fill<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        layers: &Layers<D>,
        kernel: Option<&Kernel>,
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
        let Layers { nodes, extents, .. } = layers;
        for slice in layers.of(k) {
            let extent = &extents[slice.grain];
            let first = self.spans.len();
            let chord = extent.outer * extent.outer - slice.arm * slice.arm;
            if chord <= 0.0 {
                continue;
            }
            if D == 2 {
                self.row(grid, layers, slice.grain, chord, [(k, slice.arm); 2], kernel.is_some());
            } else {
                let (low, high) = nodes.range(grid, 1, extent.at[1], chord.sqrt());
                for m in low..high {
                    let near = nodes.node(grid, 1, extent.at[1], m);
                    let chord = chord - near.arm * near.arm;
                    let across = [(near.index, near.arm), (k, slice.arm)];
                    self.row(grid, layers, slice.grain, chord, across, kernel.is_some());
                }
            }
            if let Some(kernel) = kernel {
                self.batch.flush(kernel, extent.radius, extent.inner, &mut self.odds);
            }
            let spans = self.spans.len() - first;
            self.parts.push(Part { grain: slice.grain, arm: slice.arm, spans });
        }
    }

    /// Adds the cells of one row: `chord` is the squared half of it that the grain holds, `across` are index
    /// and arm along the other axes.
    fn row<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        layers: &Layers<D>,
        grain: usize,
        chord: f64,
        across: [(usize, f64); 2],
        odds: bool,
    ) {
        if chord <= 0.0 {
            return;
        }
        let nodes = &layers.nodes;
        let (centre, stride) = (layers.extents[grain].at[0], grid.stride(1));
        let mut sums = Sums::default();
        let mut weight = grid.turn();
        for a in 1..D {
            let (index, arm) = across[a - 1];
            sums.add(arm, nodes.spacing[a][index]);
            weight *= grid.volumes(nodes.component(), a)[index];
        }
        let away = 1e3 * layers.extents[grain].outer.powi(2);
        let (low, high) = nodes.range(grid, 0, centre, chord.sqrt());
        let n = grid.cells[0] as isize;
        let mut m = low;
        while m < high {
            // A row that crosses a periodic face is cut there.
            let end = if grid.periodic(0) { high.min((m.div_euclid(n) + 1) * n) } else { high };
            let near = nodes.node(grid, 0, centre, m);
            let cells = near.index..near.index + (end - m) as usize;
            let count = cells.len().next_multiple_of(8);
            let first = cells.start.min(stride - count);
            let row = if D == 2 { 0 } else { across[0].0 };
            let span = Span {
                at: row * stride + first,
                first,
                row: across[0].0,
                count,
                weight,
                shift: near.arm - nodes.row.at[near.index],
                middle: if D == 2 { 0.0 } else { across[0].1 },
            };
            let word = row * words(grid);
            for eight in cells.start / 8..=(cells.end - 1) / 8 {
                self.marks[word + eight / 64] |= 1 << (eight % 64);
            }
            self.spans.push(span);
            if odds {
                self.batch.row(&nodes.row, &span, cells, &sums, away);
            }
            m = end;
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
        sheet.fill(grid, &layers, Some(kernel), k);
        sheet.gather();
        visit(k, &sheet, &layers.nodes);
        sheet.clear();
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
