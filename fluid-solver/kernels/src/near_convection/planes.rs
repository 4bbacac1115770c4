//! The planes about the one whose terms are computed, with what lies beyond the ends of the grid.

use super::bands::Bands;
use crate::grid::Grid;
use crate::lanes::Aligned;

/// Values before cell 0 of a row: fluxes of whole rows begin with cell −1, which is the first of a vector.
/// Behind the last cell there is room for a vector and more.
pub(super) const LEAD: usize = 9;
/// Rows before row 0.
pub(super) const ROWS: usize = 2;

/// Bytes that the planes of a block of rows may take, fluxes included: they stay near the core.
const BYTES: usize = 384 << 10;

/// Copies of a block of rows of planes, two rows more on both sides, each with two values more on both sides.
#[derive(Clone, Debug)]
pub(super) struct Planes {
    /// Length of a row.
    pub(super) row: usize,
    /// Most rows of a block.
    pub(super) rows: usize,
    /// First row of the block.
    first: usize,
    size: usize,
    /// Velocity: by component, plane `k` at place `k` modulo 5.
    velocity: [[Aligned; 5]; 3],
    /// Weights, plane `k` at place `k` modulo 2.
    weights: [Aligned; 2],
    /// Which plane each place has.
    loaded: [Option<isize>; 5],
    weighed: [Option<isize>; 2],
}

impl Planes {
    pub(super) fn new<const D: usize>(grid: &Grid<D>) -> Self {
        let row = (grid.cells[0] + LEAD + 16).next_multiple_of(8);
        // Velocity, weights and fluxes: 5 × 3 + 2 + 10, or 2 + 1 + 4 on two axes.
        let planes = if D == 3 { 27 } else { 7 };
        let fits = BYTES / (size_of::<f64>() * row * planes);
        let rows = fits.saturating_sub(2 * ROWS + 1).max(4).min(grid.cells[1]);
        let size = row * (rows + 2 * ROWS + 1);
        let plane = || Aligned::zeros(size);
        let planes = if D == 3 { 5 } else { 1 };
        let velocity = |c: usize| {
            std::array::from_fn(|k| if c < D && k < planes { plane() } else { Aligned::default() })
        };
        Self {
            row,
            rows,
            first: 0,
            size,
            velocity: std::array::from_fn(velocity),
            weights: std::array::from_fn(|k| if k == 0 || D == 3 { plane() } else { Aligned::default() }),
            loaded: [None; 5],
            weighed: [None; 2],
        }
    }

    pub(super) fn zeros(&self) -> Aligned {
        Aligned::zeros(self.size)
    }

    /// Begins a block of rows at row `first`.
    pub(super) fn begin(&mut self, first: usize) {
        self.first = first;
        (self.loaded, self.weighed) = ([None; 5], [None; 2]);
    }

    /// Where row `j` begins, at cell 0.
    #[inline(always)]
    pub(super) fn at(&self, j: isize) -> usize {
        (j - self.first as isize + ROWS as isize) as usize * self.row + LEAD
    }

    /// Planes from `k` − 2 to `k` + 2 by component; those that are not there are empty.
    pub(super) fn velocities(&self, k: isize) -> [[&[f64]; 5]; 3] {
        let place = |near: usize| (k + near as isize - 2).rem_euclid(5) as usize;
        std::array::from_fn(|c| std::array::from_fn(|near| &self.velocity[c][place(near)][..]))
    }

    /// Weights on plane `k`.
    pub(super) fn weights(&self, k: isize) -> &[f64] {
        &self.weights[k.rem_euclid(2) as usize]
    }

    /// Copies plane `k` of the velocity, rows `rows` and two on each side.
    pub(super) fn load<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        velocity: &[Vec<f64>; D],
        k: isize,
        rows: &std::ops::Range<usize>,
    ) {
        let place = k.rem_euclid(5) as usize;
        if self.loaded[place] == Some(k) {
            return;
        }
        self.loaded[place] = Some(k);
        let n = grid.cells[0];
        let layer = if D == 3 { wrapped(grid, D - 1, k) * grid.cells[1] } else { 0 };
        let low = rows.start as isize - 2;
        let (row, begin) = (self.row, self.at(low) - LEAD);
        for (planes, u) in self.velocity.iter_mut().zip(velocity) {
            let lines = planes[place][begin..].chunks_exact_mut(row);
            for (j, to) in (low..rows.end as isize + 2).zip(lines) {
                let from = &u[grid.row(layer + wrapped(grid, 1, j))..][..n];
                to[LEAD..][..n].copy_from_slice(from);
                for beyond in 1..=2 {
                    to[LEAD - beyond] = from[wrapped(grid, 0, -(beyond as isize))];
                    to[LEAD + n - 1 + beyond] = from[wrapped(grid, 0, (n - 1 + beyond) as isize)];
                }
            }
        }
    }

    /// Writes the weights of plane `k`, rows `rows` and one on each side.
    pub(super) fn weigh<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        bands: &Bands<D>,
        k: isize,
        rows: &std::ops::Range<usize>,
    ) {
        let place = k.rem_euclid(2) as usize;
        if self.weighed[place] == Some(k) {
            return;
        }
        self.weighed[place] = Some(k);
        let (layer, low) = (layer_of(grid, k), rows.start as isize - 1);
        let (row, begin) = (self.row, self.at(low) - LEAD);
        let lines = self.weights[place][begin..].chunks_exact_mut(row);
        for (j, to) in (low..rows.end as isize + 1).zip(lines) {
            to.fill(0.0);
            let inside = grid.periodic(1) || (0..grid.cells[1] as isize).contains(&j);
            if let (Some(layer), true) = (layer, inside) {
                bands.write(grid, layer + wrapped(grid, 1, j), LEAD, to);
            }
        }
    }
}

/// First row of plane `k`; none beyond the ends of an axis that is not periodic.
pub(super) fn layer_of<const D: usize>(grid: &Grid<D>, k: isize) -> Option<usize> {
    if D < 3 {
        return Some(0);
    }
    let inside = grid.periodic(D - 1) || (0..grid.cells[D - 1] as isize).contains(&k);
    inside.then(|| wrapped(grid, D - 1, k) * grid.cells[1])
}

/// Index along an axis, which may lie beyond its ends: round a periodic axis, else the nearest one.
pub(super) fn wrapped<const D: usize>(grid: &Grid<D>, a: usize, index: isize) -> usize {
    let n = grid.cells[a] as isize;
    if (0..n).contains(&index) {
        return index as usize;
    }
    (if grid.periodic(a) { index.rem_euclid(n) } else { index.clamp(0, n - 1) }) as usize
}
