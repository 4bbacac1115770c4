//! Which grains reach into which layer of nodes, a layer being all nodes with one index along the last axis.
//!
//! All work of the grains on the grid goes layer by layer: what grains share, they share within a layer,
//! so that sums over grains need the memory of one layer only, and threads take layers.

use super::body::{Motion, Patch, Shape, Turned, along_axes};
use super::mask_model::MaskModel;
use super::nodes::{Extent, Nodes};
use crate::grid::Grid;

/// Grains, the mask and the places in which they are taken.
#[derive(Clone, Copy)]
pub struct Placed<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// The mask.
    pub model: &'a MaskModel,
    /// What never changes about the grains.
    pub shapes: &'a [Shape],
    /// Where they are and how they move.
    pub motions: &'a [Motion],
}

/// A grain in a layer.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slice {
    pub(super) grain: usize,
    /// Distance of the layer from the centre along the last axis, m.
    pub(super) arm: f64,
}

/// Which grains meet which layer of one set of nodes.
#[derive(Clone, Debug)]
pub(crate) struct GrainsByLayer<const D: usize> {
    pub(super) nodes: Nodes<D>,
    pub(super) extents: Vec<Extent<D>>,
    /// Outlines of the bodies that are not round, as they are turned.
    pub(super) turned: Vec<Option<Turned>>,
    /// Where grains have come to rest on something.
    pub(super) patches: Vec<Vec<Patch>>,
    /// For each grain, the count of placings when it was last moved.
    pub(super) stamps: Vec<u64>,
    placings: u64,
    /// Slices of layer k: `starts[k]..starts[k + 1]`, in the order of the grains.
    starts: Vec<usize>,
    slices: Vec<Slice>,
    /// The mask that they were placed with.
    model: Option<MaskModel>,
    /// Whether what the grains hold of each layer is kept until they move.
    pub(super) caches: bool,
}

impl<const D: usize> GrainsByLayer<D> {
    /// Room for grains at the nodes of component `d`, see [`Nodes::new`].
    pub(super) fn new(grid: &Grid<D>, d: usize, caches: bool) -> Self {
        let starts = vec![0; grid.cells[D - 1] + 1];
        Self {
            nodes: Nodes::new(grid, d),
            extents: Vec::new(),
            turned: Vec::new(),
            patches: Vec::new(),
            stamps: Vec::new(),
            placings: 0,
            starts,
            slices: Vec::new(),
            model: None,
            caches,
        }
    }

    /// Finds the layers of every grain; tells whether they are where they were.
    pub(super) fn place(&mut self, placed: Placed<'_, D>) -> bool {
        let Placed { grid, model, shapes, motions } = placed;
        let known = self.caches && self.model == Some(*model) && self.extents.len() == motions.len();
        let Self { nodes, extents, turned, patches, stamps, placings, starts, slices, .. } = self;
        if !known {
            extents.clear();
            stamps.clear();
        }
        turned.resize(shapes.len(), None);
        patches.resize_with(shapes.len(), Vec::new);
        *placings += 1;
        let mut stays = known;
        for (grain, (shape, motion)) in shapes.iter().zip(motions).enumerate() {
            let at = along_axes::<D>(grid.geometry, motion.centre);
            let same_angle = turned[grain].as_ref().is_none_or(|turned| turned.angle == motion.angle);
            let mask = (shape.mask_radius, shape.wave);
            let same_mask = |extent: &Extent<D>| (extent.radius, extent.wave) == mask;
            let same_patches = patches[grain] == shape.patches;
            if known && same_angle && same_patches && same_mask(&extents[grain]) && extents[grain].at == at {
                continue;
            }
            patches[grain].clone_from(&shape.patches);
            turned[grain] = shape.outline.as_ref().map(|outline| Turned::new(outline, motion.angle));
            stays = false;
            let extent = nodes.extent(grid, model, motion.centre, mask);
            if known {
                (extents[grain], stamps[grain]) = (extent, *placings);
            } else {
                extents.push(extent);
                stamps.push(*placings);
            }
        }
        if stays {
            return true;
        }
        self.model = Some(*model);
        let layers = |extent: &Extent<D>| nodes.range(grid, D - 1, extent.at[D - 1], extent.outer);
        let layer = |extent: &Extent<D>, m| nodes.node(grid, D - 1, extent.at[D - 1], m);
        starts.fill(0);
        for extent in &*extents {
            let (low, high) = layers(extent);
            (low..high).for_each(|m| starts[layer(extent, m).index + 1] += 1);
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        slices.clear();
        slices.resize(starts[starts.len() - 1], Slice::default());
        for (grain, extent) in extents.iter().enumerate() {
            let (low, high) = layers(extent);
            for m in low..high {
                let near = layer(extent, m);
                slices[starts[near.index]] = Slice { grain, arm: near.arm };
                starts[near.index] += 1;
            }
        }
        // each start has moved to the next one
        starts.rotate_right(1);
        starts[0] = 0;
        false
    }

    pub(super) fn of(&self, k: usize) -> &[Slice] {
        &self.slices[self.starts[k]..self.starts[k + 1]]
    }

    /// The lowest layer that a grain meets.
    pub(super) fn lowest(&self, grid: &Grid<D>, grain: usize) -> usize {
        let (extent, n) = (&self.extents[grain], grid.cells[D - 1] as isize);
        let (low, high) = self.nodes.range(grid, D - 1, extent.at[D - 1], extent.outer);
        // What goes on over a periodic face meets the first layer.
        let (from, to) = (low.rem_euclid(n), low.rem_euclid(n) + (high - low));
        if to > n { 0 } else { from as usize }
    }

    /// Cells that the grains hold, about.
    pub(super) fn cells(&self) -> f64 {
        let size = self.nodes.spacing.iter().map(|s| s[s.len() / 2]).product::<f64>();
        let volume = |e: &Extent<D>| (1.6 * e.outer).powi(D as i32);
        self.extents.iter().map(volume).sum::<f64>() / size
    }
}
