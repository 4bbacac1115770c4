//! The cells that one grain holds, for one set of nodes: rows of cells with the odds of each.
//!
//! Odds are evaluated only in the band around the surface (numerics §4); cells outside it are not even
//! listed.

use super::body::laboratory;
use super::mask::Kernel;
use super::odds::{Batch, Sums};
use crate::grid::Grid;

/// Neighbouring cells along axis 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Place of the first cell in the field.
    pub start: usize,
    /// Index of the first cell along axis 0.
    pub first: usize,
    /// Indices along the other axes.
    pub across: [usize; 2],
    /// Number of cells.
    pub count: usize,
    /// Control volume of a cell over its factor along axis 0.
    pub weight: f64,
    /// Arm from the grain's centre to the node, laboratory axes, m; along grid axis 0 it is this
    /// value plus the position of the node.
    pub arm: [f64; 3],
}

/// What a cover was made for: it need not be made again for the same.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    centre: [f64; 3],
    radius: f64,
    kernel: Kernel,
}

/// The cells of one grain at the nodes of component `d` (`d = D`: at cell centres).
#[derive(Clone, Debug, Default)]
pub struct Cover {
    spans: Vec<Span>,
    odds: Vec<f64>,
    key: Option<Key>,
}

/// A node along one axis: its index in the box, and its distance from the grain's centre.
#[derive(Clone, Copy, Debug)]
struct Near {
    index: usize,
    arm: f64,
}

/// Nodes of one set along every axis, with what the masks need of them.
#[derive(Clone, Debug)]
pub struct Nodes<const D: usize> {
    d: usize,
    /// Cell width at each node, m.
    spacing: [Vec<f64>; D],
    least: f64,
    most: f64,
}

impl<const D: usize> Nodes<D> {
    /// Nodes of component `d`, or of the cell centres if `d = D`.
    pub fn new(grid: &Grid<D>, d: usize) -> Self {
        let spacing: [Vec<f64>; D] = std::array::from_fn(|a| {
            let axis = &grid.axes[a];
            if a == d { axis.distances.clone() } else { axis.widths.clone() }
        });
        Self { d, spacing, least: grid.smallest_width(), most: 0.0 }.with_most(grid)
    }

    /// The `d` that was given to [`Nodes::new`].
    pub fn component(&self) -> usize {
        self.d
    }

    fn with_most(mut self, grid: &Grid<D>) -> Self {
        self.most = grid.axes.iter().flat_map(|a| &a.widths).fold(0.0, |m, &w| m.max(w));
        self
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
}

impl Span {
    /// Places of its cells in the field.
    #[inline(always)]
    pub fn cells(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.count
    }
}

impl Cover {
    /// Rows of cells.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.odds.len()
    }

    /// Rows of cells with their odds.
    pub fn rows(&self) -> impl Iterator<Item = (&Span, &[f64])> {
        let mut rest = self.odds.as_slice();
        self.spans.iter().map(move |span| {
            let (odds, after) = rest.split_at(span.count);
            rest = after;
            (span, odds)
        })
    }

    /// Finds the cells of a grain of radius `radius` at `centre` (laboratory axes, m).
    pub fn place<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        nodes: &Nodes<D>,
        kernel: &Kernel,
        centre: [f64; 3],
        radius: f64,
    ) {
        let key = Key { centre, radius, kernel: *kernel };
        if self.key == Some(key) {
            return;
        }
        self.key = Some(key);
        self.spans.clear();
        self.odds.clear();
        let at: [f64; D] = std::array::from_fn(|a| centre[laboratory(grid.geometry, a)]);
        let [least, most] = nodes.bounds(grid, &at, radius);
        let [inner, outer] = kernel.reach(radius, least, most);
        let place = Place { grid, nodes, at, outer };
        let mut batch = Batch::new(kernel, radius, inner.max(0.0));
        let rows = place.range(1, at[1], outer);
        for m in rows.0..rows.1 {
            let near = place.node(1, m);
            if D == 2 {
                self.row(&place, &mut batch, [near.arm, 0.0], [near.index, 0]);
                continue;
            }
            let layers = place.range(2, at[D - 1], (outer * outer - near.arm * near.arm).max(0.0).sqrt());
            for l in layers.0..layers.1 {
                let far = place.node(2, l);
                self.row(&place, &mut batch, [near.arm, far.arm], [near.index, far.index]);
            }
        }
        batch.flush(&mut self.odds);
    }

    /// Adds the cells of one row, `arm` and `index` being those along the other axes.
    fn row<const D: usize>(
        &mut self,
        place: &Place<'_, D>,
        batch: &mut Batch,
        arm: [f64; 2],
        index: [usize; 2],
    ) {
        let grid = place.grid;
        let off = arm[0] * arm[0] + arm[1] * arm[1];
        let chord = place.outer * place.outer - off;
        if chord <= 0.0 {
            return;
        }
        let (first, last) = place.range(0, place.at[0], chord.sqrt());
        let (d, n) = (place.nodes.d, grid.cells[0] as isize);
        let sums = place.sums(arm, index);
        let mut m = first;
        while m < last {
            // A row that crosses a periodic face is cut there.
            let end = if grid.periodic(0) { last.min((m.div_euclid(n) + 1) * n) } else { last };
            let near = place.node(0, m);
            let mut at = [near.index as isize; D];
            let mut weight = grid.turn();
            let mut lab = [0.0; 3];
            for a in 1..D {
                at[a] = index[a - 1] as isize;
                weight *= grid.volumes(d, a)[index[a - 1]];
                lab[laboratory(grid.geometry, a)] = arm[a - 1];
            }
            lab[0] = near.arm - grid.nodes(d, 0)[near.index];
            let count = (end - m) as usize;
            let cells = near.index..near.index + count;
            self.spans.push(Span {
                start: grid.index(at),
                first: near.index,
                across: index,
                count,
                weight,
                arm: lab,
            });
            let (x, widths) = (&grid.nodes(d, 0)[cells.clone()], &place.nodes.spacing[0][cells]);
            batch.row(x, widths, lab[0], &sums, &mut self.odds);
            m = end;
        }
    }
}

/// One grain on one set of nodes.
struct Place<'a, const D: usize> {
    grid: &'a Grid<D>,
    nodes: &'a Nodes<D>,
    at: [f64; D],
    outer: f64,
}

impl<const D: usize> Place<'_, D> {
    /// Sums of a row over the axes but the first.
    fn sums(&self, arm: [f64; 2], index: [usize; 2]) -> Sums {
        let mut sums = Sums { square: 0.0, size: 0.0, across: 0.0, fourth: 0.0 };
        for a in 1..D {
            let (r, h) = (arm[a - 1], self.nodes.spacing[a][index[a - 1]]);
            let (r2, h2) = (r * r, h * h);
            sums.square += r2;
            sums.size += r.abs();
            sums.across += r2 * h2;
            sums.fourth += r2 * r2 * h2;
        }
        sums
    }

    /// Unwrapped indices along `axis` of the unknowns within `half` of `centre`. On a periodic axis
    /// they may lie outside `0..n`, but never hold a cell twice: the nearest image counts.
    fn range(&self, axis: usize, centre: f64, half: f64) -> (isize, isize) {
        let nodes = self.grid.nodes(self.nodes.d, axis);
        let n = self.grid.cells[axis];
        if !self.grid.periodic(axis) {
            let first = usize::from(axis == self.nodes.d);
            let low = nodes[..n].partition_point(|x| *x < centre - half).clamp(first, n);
            let high = nodes[..n].partition_point(|x| *x <= centre + half).clamp(low, n);
            return (low as isize, high as isize);
        }
        let h = self.grid.axes[axis].length() / n as f64;
        let half = half.min(0.5 * h * n as f64);
        let low = ((centre - half - nodes[0]) / h).ceil() as isize;
        let high = ((centre + half - nodes[0]) / h).floor() as isize + 1;
        (low, high.clamp(low, low + n as isize))
    }

    /// Index in the box and arm of unwrapped index `m` along `axis`.
    fn node(&self, axis: usize, m: isize) -> Near {
        let nodes = self.grid.nodes(self.nodes.d, axis);
        let n = self.grid.cells[axis] as isize;
        if !self.grid.periodic(axis) {
            return Near { index: m as usize, arm: nodes[m as usize] - self.at[axis] };
        }
        let index = m.rem_euclid(n) as usize;
        let shift = m.div_euclid(n) as f64 * self.grid.axes[axis].length();
        Near { index, arm: nodes[index] + shift - self.at[axis] }
    }
}
