//! Sums over the grains of one layer of nodes.

use super::body::Motion;
use super::by_layer::Placed;
use super::layer::{Layer, Room, Span};
use super::layers::Layers;
use super::nodes::Nodes;
use crate::grid::Grid;
use crate::lanes::ZERO;
use crate::vector::Real;
use pulp::Simd;
use std::ops::Range;

/// A layer being worked on.
#[derive(Clone, Debug, Default)]
pub struct LayerSums {
    pub(super) room: Room,
    /// Sums of mask ratios over all grains, one entry per place of the layer.
    pub totals: Vec<f64>,
    /// Sums of mask ratios times velocity.
    pub(super) targets: Vec<f64>,
    /// A bit for each eight places of a row that a grain covers some of, [`words`] per row.
    pub(super) covered: Vec<u64>,
}

/// Place of the first value of layer `k` in a field.
pub fn first<const D: usize>(grid: &Grid<D>, k: usize) -> usize {
    grid.row(k * grid.rows() / grid.cells[D - 1])
}

/// Number of words in which the eights of a row have a bit each.
pub(super) fn words<const D: usize>(grid: &Grid<D>) -> usize {
    grid.stride(1).div_ceil(8 * 64)
}

/// Where the bits of the eights of row `row` stand.
pub(super) fn bits_of<const D: usize>(grid: &Grid<D>, row: usize) -> Range<usize> {
    let per_layer = grid.rows() / grid.cells[D - 1];
    let row = row / per_layer * (grid.stride(D - 1) / grid.stride(1)) + row % per_layer;
    row * words(grid)..(row + 1) * words(grid)
}

impl LayerSums {
    /// Room for the layers of a grid.
    pub(crate) fn fit<const D: usize>(&mut self, grid: &Grid<D>) {
        let size = grid.stride(D - 1);
        if self.totals.len() != size {
            self.totals = vec![0.0; size];
            self.targets = vec![0.0; size];
            self.covered = vec![0; size / grid.stride(1) * words(grid)];
        }
    }

    /// Marks the groups of eight a layer that grains cover some of.
    #[inline(always)]
    pub(super) fn mark_covered<const D: usize>(&mut self, grid: &Grid<D>, layer: &Layer) {
        let words = words(grid);
        for Span { row, first, count, .. } in layer.parts().flat_map(|(_, spans, _)| spans) {
            let (mut eight, end) = (first / 8, (first + count - 1) / 8 + 1);
            // Word by word.
            while eight < end {
                let bits = (end - eight).min(64 - eight % 64);
                self.covered[row * words + eight / 64] |= (u64::MAX >> (64 - bits)) << (eight % 64);
                eight += bits;
            }
        }
    }

    /// Sums the mask ratios of all grains.
    #[inline(always)]
    pub(crate) fn gather(&mut self, layer: &Layer) {
        for (_, spans, ratios) in layer.parts() {
            let mut rest = ratios.as_chunks::<8>().0;
            for span in spans {
                let (ratios, after) = rest.split_at(span.count / 8);
                rest = after;
                let totals = self.totals[span.at..][..span.count].as_chunks_mut::<8>().0;
                for (total, ratios) in totals.iter_mut().zip(ratios) {
                    for l in 0..8 {
                        total[l] += ratios[l];
                    }
                }
            }
        }
    }

    /// Sums mask ratios, and mask ratios times the velocity of component `c`, over all grains.
    #[inline(always)]
    pub(super) fn gather_velocity<S: Simd>(
        &mut self,
        simd: S,
        layer: &Layer,
        along: &[f64],
        c: usize,
        motions: &[Motion],
    ) {
        for (part, spans, ratios) in layer.parts() {
            let motion = &motions[part.grain];
            let mut rest = ratios.as_chunks::<8>().0;
            for span in spans {
                let (ratios, after) = rest.split_at(span.count / 8);
                rest = after;
                let [base, slope] = span.velocity(motion, c, part.arm);
                let range = span.at..span.at + span.count;
                let totals = self.totals[range.clone()].as_chunks_mut::<8>().0;
                let targets = self.targets[range].as_chunks_mut::<8>().0;
                let along = along[span.first..][..span.count].as_chunks::<8>().0;
                for (((total, target), ratios), x) in totals.iter_mut().zip(targets).zip(ratios).zip(along) {
                    for t in 0..8 / S::F64_LANES {
                        let (ratio, x) = (Real::of(simd, ratios, t), Real::of(simd, x, t));
                        let sum = Real::of(simd, total, t) + ratio;
                        let share = Real::of(simd, target, t) + ratio * (x * slope + base);
                        sum.put(total, t);
                        share.put(target, t);
                    }
                }
            }
        }
    }

    /// Forgets the sums of the layer.
    #[inline(always)]
    pub(crate) fn clear(&mut self, layer: &Layer) {
        for span in layer.parts().flat_map(|(_, spans, _)| spans) {
            // In eights, which spares a call of memset.
            self.totals[span.at..][..span.count].as_chunks_mut().0.iter_mut().for_each(|eight| *eight = ZERO);
        }
        self.covered.fill(0);
    }
}

/// Calls `visit` with each of the `wanted` layers of the cell centres in turn, the mask ratios of all grains
/// summed.
pub fn for_each_layer<const D: usize>(
    placed: Placed<'_, D>,
    wanted: Range<usize>,
    mut visit: impl FnMut(usize, &LayerSums, &Layer, &Nodes<D>),
) {
    let Placed { grid, model, .. } = placed;
    let mut layers = Layers::new(grid, D, false);
    layers.place(placed);
    let (mut layer_sums, mut layer) = (LayerSums::default(), Layer::default());
    layer_sums.fit(grid);
    for k in wanted {
        layer.fill(grid, &layers.grains, model, k, &mut layer_sums.room);
        layer_sums.gather(&layer);
        visit(k, &layer_sums, &layer, &layers.grains.nodes);
        layer_sums.clear(&layer);
    }
}
