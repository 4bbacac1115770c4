//! Sums over the grains of one layer of nodes.

use super::body::{Motion, Shape};
use super::layer::{Layer, Profiles, Span};
use super::layers::Layers;
use super::mask::Kernel;
use super::nodes::Nodes;
use crate::grid::Grid;

/// A layer being worked on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheet {
    pub(super) profiles: Profiles,
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
    /// Room for the layers of a grid.
    pub(crate) fn fit<const D: usize>(&mut self, grid: &Grid<D>) {
        let size = grid.stride(D - 1);
        if self.totals.len() != size {
            self.totals = vec![0.0; size];
            self.targets = vec![0.0; size];
            self.marks = vec![0; size / grid.stride(1) * words(grid)];
        }
    }

    /// Sums of odds over all grains, one entry per place of the layer.
    pub(crate) fn totals(&self) -> &[f64] {
        &self.totals
    }

    /// Marks the eights of a layer that grains hold some of.
    #[inline(always)]
    pub(super) fn mark<const D: usize>(&mut self, grid: &Grid<D>, layer: &Layer) {
        let words = words(grid);
        for Span { row, first, count, .. } in layer.rows().0 {
            for eight in first / 8..=(first + count - 1) / 8 {
                self.marks[row * words + eight / 64] |= 1 << (eight % 64);
            }
        }
    }

    /// Sums the odds of all grains.
    #[inline(always)]
    pub(crate) fn gather(&mut self, layer: &Layer) {
        let (spans, odds) = layer.rows();
        let mut rest = odds.as_chunks::<8>().0;
        for span in spans {
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
    pub(super) fn gather_velocity(&mut self, layer: &Layer, along: &[f64], c: usize, motions: &[Motion]) {
        for (part, spans, odds) in layer.parts() {
            let motion = &motions[part.grain];
            let mut rest = odds.as_chunks::<8>().0;
            for span in spans {
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
    pub(crate) fn clear(&mut self, layer: &Layer) {
        for span in layer.rows().0 {
            self.totals[span.at..][..span.count].fill(0.0);
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
    mut visit: impl FnMut(usize, &Sheet, &Layer, &Nodes<D>),
) {
    let mut layers = Layers::new(grid, D, false);
    layers.place(grid, kernel, shapes, motions);
    let (mut sheet, mut layer) = (Sheet::default(), Layer::default());
    sheet.fit(grid);
    for k in 0..grid.cells[D - 1] {
        layer.fill(grid, &layers.grains, kernel, k, &mut sheet.profiles);
        sheet.gather(&layer);
        visit(k, &sheet, &layer, &layers.grains.nodes);
        sheet.clear(&layer);
    }
}
