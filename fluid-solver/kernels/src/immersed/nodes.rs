//! The nodes of one velocity component, or the cell centres, as grains meet them.

use super::body::along_axes;
use super::mask_model::MaskModel;
use crate::grid::Grid;

/// Nodes of one set along every axis, with what the masks need of them.
#[derive(Clone, Debug)]
pub struct Nodes<const D: usize> {
    /// The `d` that was given to [`Nodes::new`].
    pub(super) component: usize,
    /// Cell width at each node, m.
    pub(super) spacing: [Vec<f64>; D],
    /// Along axis 0, as long as a row of a field, so that whole vectors can be read at its end.
    pub(super) row: Row,
    /// The cell width, if it is the same everywhere and along all axes.
    pub(super) even: Option<f64>,
    least: f64,
    most: f64,
}

/// What is known of every place of a row, the values past its end repeating the last one.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Position, m.
    pub(super) at: Vec<f64>,
    /// Cell width, m, and one over its square, 1/m².
    pub(super) spacing: Vec<f64>,
    pub(super) inverse: Vec<f64>,
    /// Factor of the control volume.
    pub(super) volume: Vec<f64>,
}

/// A node along one axis: its index in the box, and its distance from the grain's centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) index: usize,
    pub(crate) arm: f64,
}

/// How far a grain reaches on one set of nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent<const D: usize> {
    /// Centre, axes of the grid.
    pub(super) at: [f64; D],
    /// Radius of the mask, m.
    pub(super) radius: f64,
    /// Part of the wave that the mask has.
    pub(super) wave: f64,
    /// Where it is solid, m from the centre.
    pub(super) inner: f64,
    /// Where it is no longer felt.
    pub(super) outer: f64,
}

impl<const D: usize> Nodes<D> {
    /// Nodes of component `d`, or of the cell centres if `d = D`.
    pub fn new(grid: &Grid<D>, d: usize) -> Self {
        let spacing: [Vec<f64>; D] = std::array::from_fn(|a| {
            let axis = &grid.axes[a];
            if a == d { axis.distances.clone() } else { axis.widths.clone() }
        });
        let length = grid.stride(1);
        let padded = |values: &[f64]| {
            let mut values = values.to_vec();
            values.resize(length, values[values.len() - 1]);
            values
        };
        let row = Row {
            at: padded(grid.nodes(d, 0)),
            spacing: padded(&spacing[0]),
            inverse: padded(&spacing[0].iter().map(|h| (h * h).recip()).collect::<Vec<_>>()),
            volume: padded(grid.volumes(d, 0)),
        };
        let most = grid.axes.iter().flat_map(|a| &a.widths).fold(0.0, |m: f64, &w| m.max(w));
        let least = grid.smallest_width();
        let even = (most - least < 1e-12 * most).then_some(most);
        Self { component: d, spacing, row, even, least, most }
    }

    /// Position along axis 0 of place `k` of a row, m.
    pub fn along(&self, k: usize) -> f64 {
        self.row.at[k]
    }

    /// Reach of a grain's mask of radius `radius` and `wave` at `centre` (laboratory axes, m).
    pub(super) fn extent(
        &self,
        grid: &Grid<D>,
        model: &MaskModel,
        centre: [f64; 3],
        (radius, wave): (f64, f64),
    ) -> Extent<D> {
        let at = along_axes(grid.geometry, centre);
        let [least, most] = self.bounds(grid, &at, radius);
        let [inner, outer] = MaskModel { wave, ..*model }.reach(radius, least, most);
        Extent { at, radius, wave, inner: inner.max(0.0), outer }
    }

    /// Spacings that a grain can meet: on a stretched axis, those within reach of its centre.
    fn bounds(&self, grid: &Grid<D>, centre: &[f64; D], radius: f64) -> [f64; 2] {
        if grid.axes.iter().all(|a| a.uniform_width.is_some()) {
            return [self.least, self.most];
        }
        let mut bounds = [f64::INFINITY, 0.0_f64];
        for (axis, centre) in grid.axes.iter().zip(centre) {
            // Wide enough for the band of the widest cells that a grain of this size may meet.
            let margin = 2.0 * radius + 4.0 * self.least;
            let n = axis.cells();
            let low = axis.faces.partition_point(|f| *f < centre - margin).clamp(1, n) - 1;
            let high = axis.faces.partition_point(|f| *f <= centre + margin).clamp(low + 1, n);
            for w in &axis.widths[low..high] {
                bounds = [bounds[0].min(*w), bounds[1].max(*w)];
            }
        }
        bounds
    }

    /// Unwrapped indices along `axis` of the unknowns within `half` of `centre`. On a periodic axis
    /// they may lie outside `0..n`, but never hold a cell twice: the nearest image counts.
    #[inline(always)]
    pub(crate) fn range(&self, grid: &Grid<D>, axis: usize, centre: f64, half: f64) -> (isize, isize) {
        let nodes = grid.nodes(self.component, axis);
        let n = grid.cells[axis];
        if grid.periodic(axis) {
            let h = grid.axes[axis].length() / n as f64;
            let half = half.min(0.5 * h * n as f64);
            let low = ((centre - half - nodes[0]) / h).ceil() as isize;
            let high = ((centre + half - nodes[0]) / h).floor() as isize + 1;
            return (low, high.clamp(low, low + n as isize));
        }
        let first = usize::from(axis == self.component);
        let (low, high) = match grid.axes[axis].uniform_width {
            Some(h) => {
                // one more at each end: round-off must not lose a node
                let low = ((centre - half - nodes[0]) / h).floor().max(0.0) as usize;
                let high = ((centre + half - nodes[0]) / h).ceil().max(-1.0) + 1.0;
                (low.min(n), (high.max(0.0) as usize).min(n))
            }
            None => (
                nodes[..n].partition_point(|x| *x < centre - half),
                nodes[..n].partition_point(|x| *x <= centre + half),
            ),
        };
        let low = low.clamp(first, n);
        (low as isize, high.clamp(low, n) as isize)
    }

    /// Index in the box and arm of unwrapped index `m` along `axis`, for a grain centred at `centre`.
    #[inline(always)]
    pub(crate) fn node(&self, grid: &Grid<D>, axis: usize, centre: f64, m: isize) -> Node {
        let nodes = grid.nodes(self.component, axis);
        let n = grid.cells[axis] as isize;
        if !grid.periodic(axis) {
            return Node { index: m as usize, arm: nodes[m as usize] - centre };
        }
        // a division takes as long as all the rest
        let turns = match m {
            m if (0..n).contains(&m) => 0,
            m if (-n..0).contains(&m) => -1,
            m if (n..2 * n).contains(&m) => 1,
            m => m.div_euclid(n),
        };
        let index = (m - turns * n) as usize;
        Node { index, arm: nodes[index] + turns as f64 * grid.axes[axis].length() - centre }
    }
}
