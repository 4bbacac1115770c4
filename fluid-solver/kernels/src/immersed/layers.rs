//! Grains on one set of nodes with what they cover of each layer, kept until they move where that pays.

use super::by_layer::GrainsByLayer;
use super::by_layer::Placed;
use super::layer::Layer;
use crate::grid::Grid;

/// All grains on one set of nodes, by layers.
#[derive(Clone, Debug)]
pub struct Layers<const D: usize> {
    pub(crate) grains: GrainsByLayer<D>,
    /// What they hold: every layer, or room for as many as are worked on at once.
    cache: Vec<Layer>,
}

impl<const D: usize> Layers<D> {
    /// Room for grains at the nodes of component `d` (`d = D`: at cell centres). `caches`: whether what they
    /// hold is kept until they move.
    pub(crate) fn new(grid: &Grid<D>, d: usize, caches: bool) -> Self {
        Self { grains: GrainsByLayer::new(grid, d, caches), cache: Vec::new() }
    }

    /// Finds the layers of every grain.
    pub fn place(&mut self, placed: Placed<'_, D>) {
        if !self.grains.place(placed) {
            self.cache.iter_mut().for_each(|layer| layer.fresh = false);
        }
    }

    /// For groups of `each` layers: the grains, what they hold, and how many entries of that belong to a
    /// group. Entry `k % entries` is for its `k`th layer. Groups begin at the first layer of this process.
    pub(super) fn shared(&mut self, grid: &Grid<D>, each: usize) -> (&GrainsByLayer<D>, &mut [Layer], usize) {
        let layers = grid.division.own().len();
        let (entries, count) = if self.grains.caches { (each, layers) } else { (1, layers.div_ceil(each)) };
        if self.cache.len() < count {
            self.cache.resize_with(count, Layer::default);
        }
        (&self.grains, &mut self.cache[..count], entries)
    }
}
