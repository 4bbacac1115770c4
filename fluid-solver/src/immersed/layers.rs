//! Grains on one set of nodes with what they cover of each layer, kept until they move where that pays.

use super::body::{Motion, Shape};
use super::by_layer::GrainsByLayer;
use super::layer::Layer;
use super::mask::Kernel;
use crate::grid::Grid;

/// All grains on one set of nodes, by layers.
#[derive(Clone, Debug)]
pub struct Layers<const D: usize> {
    pub(crate) grains: GrainsByLayer<D>,
    /// What they hold: every layer, or room for as many as are worked on at once.
    held: Vec<Layer>,
}

impl<const D: usize> Layers<D> {
    /// Room for grains at the nodes of component `d` (`d = D`: at cell centres). `keeps`: whether what they hold is
    /// kept until they move.
    pub(crate) fn new(grid: &Grid<D>, d: usize, keeps: bool) -> Self {
        Self { grains: GrainsByLayer::new(grid, d, keeps), held: Vec::new() }
    }

    /// Finds the layers of every grain.
    pub fn place(&mut self, grid: &Grid<D>, kernel: &Kernel, shapes: &[Shape], motions: &[Motion]) {
        if !self.grains.place(grid, kernel, shapes, motions) {
            self.held.iter_mut().for_each(|layer| layer.fresh = false);
        }
    }

    /// For shares of `share` layers each: the grains, what they hold, and how many entries of that belong to a
    /// share. Entry `k % entries` is for its `k`th layer.
    pub(super) fn shared(
        &mut self,
        grid: &Grid<D>,
        share: usize,
    ) -> (&GrainsByLayer<D>, &mut [Layer], usize) {
        let layers = grid.cells[D - 1];
        let (entries, count) = if self.grains.keeps { (share, layers) } else { (1, layers.div_ceil(share)) };
        if self.held.len() < count {
            self.held.resize_with(count, Layer::default);
        }
        (&self.grains, &mut self.held[..count], entries)
    }
}
