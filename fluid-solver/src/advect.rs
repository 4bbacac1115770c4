//! Convection, −∇·(u u): conservative, second order, central.
//!
//! On the control volume of component `d` the flux through a face is the mean of the two discrete
//! mass fluxes beside it, times the plain mean of the two velocities (Verstappen & Veldman 2003,
//! symmetry-preserving form). As the mass fluxes are those of the discrete continuity equation, a
//! divergence-free field neither gains nor loses energy by convection, with any metric.

use crate::grid::Grid;

/// Metric factors of one axis with one entry of halo on each side: entry `i + 1` belongs to `i`.
#[derive(Clone, Debug)]
struct Metric {
    area: Vec<f64>,
    volume: Vec<f64>,
    inverse_cell: Vec<f64>,
    inverse_face: Vec<f64>,
}

/// Convection on one grid.
#[derive(Clone, Debug)]
pub struct Advection<const D: usize> {
    axes: [Metric; D],
}

impl<const D: usize> Advection<D> {
    /// Gathers the metric factors.
    pub fn new(grid: &Grid<D>) -> Self {
        let axes = std::array::from_fn(|a| {
            let axis = &grid.axes[a];
            let n = axis.cells();
            let periodic = grid.periodic(a);
            let cell = |i: usize| match (i, periodic) {
                (0, true) => n - 1,
                (0, false) => 0,
                (i, true) if i == n + 1 => 0,
                (i, false) if i == n + 1 => n - 1,
                (i, _) => i - 1,
            };
            Metric {
                area: (0..n + 2).map(|i| axis.face_area[i.saturating_sub(1)]).collect(),
                volume: (0..n + 2).map(|i| axis.cell_volume[cell(i)]).collect(),
                inverse_cell: axis.cell_volume.iter().map(|v| 1.0 / v).collect(),
                inverse_face: axis.face_volume.iter().map(|v| 1.0 / v).collect(),
            }
        });
        Self { axes }
    }

    /// Metric factors along `axis`: areas and volumes with one entry of halo on each side, then
    /// 1 / volume of the cells and of the faces without.
    pub(crate) fn metric(&self, axis: usize) -> [&[f64]; 4] {
        let Metric { area, volume, inverse_cell, inverse_face } = &self.axes[axis];
        [area, volume, inverse_cell, inverse_face]
    }

    /// Adds −∇·(u u_d) on interior row `row` to `out` (values `0..n` of the row), m/s².
    #[inline(always)]
    pub fn add_row(&self, grid: &Grid<D>, d: usize, velocity: &[Vec<f64>; D], row: usize, out: &mut [f64]) {
        let place =
            Place { start: grid.row(row), n: out.len(), at: [0, row % grid.cells[1], row / grid.cells[1]] };
        for a in 0..D {
            match (a == d, d == 0, a == 0) {
                (true, true, _) => self.own_first(&velocity[0], &place, out),
                (true, false, _) => self.own(grid, d, &velocity[d], &place, out),
                (_, true, _) => self.across_first(grid, a, velocity, &place, out),
                (_, _, true) => self.first_across(grid, d, velocity, &place, out),
                _ => self.across(grid, d, a, velocity, &place, out),
            }
        }
    }

    /// Component 0 along axis 0.
    #[inline(always)]
    fn own_first(&self, u: &[f64], place: &Place, out: &mut [f64]) {
        let n = place.n;
        let m = &self.axes[0];
        let (low, mid, high) = (place.of(u, -1), place.of(u, 0), place.of(u, 1));
        let (a, b, c) = (&m.area[..n], &m.area[1..n + 1], &m.area[2..n + 2]);
        let volume = &m.inverse_face[..n];
        for i in 0..n {
            let below = (a[i] * low[i] + b[i] * mid[i]) * (low[i] + mid[i]);
            let above = (b[i] * mid[i] + c[i] * high[i]) * (mid[i] + high[i]);
            out[i] -= 0.25 * volume[i] * (above - below);
        }
    }

    /// Component `d > 0` along its own axis.
    #[inline(always)]
    fn own(&self, grid: &Grid<D>, d: usize, u: &[f64], place: &Place, out: &mut [f64]) {
        let (m, j, s) = (&self.axes[d], place.at[d], grid.stride(d) as isize);
        let (low, mid, high) = (place.of(u, -s), place.of(u, 0), place.of(u, s));
        let weight = 0.25 * m.inverse_face[j];
        let [a, b, c] = [0, 1, 2].map(|o| weight * m.area[j + o]);
        for i in 0..place.n {
            let below = (a * low[i] + b * mid[i]) * (low[i] + mid[i]);
            let above = (b * mid[i] + c * high[i]) * (mid[i] + high[i]);
            out[i] -= above - below;
        }
    }

    /// Component 0 carried along axis `a > 0`.
    #[inline(always)]
    fn across_first(
        &self,
        grid: &Grid<D>,
        a: usize,
        velocity: &[Vec<f64>; D],
        place: &Place,
        out: &mut [f64],
    ) {
        let (n, j, s) = (place.n, place.at[a], grid.stride(a) as isize);
        let (first, other) = (&self.axes[0], &self.axes[a]);
        let u = &velocity[0];
        let (low, mid, high) = (place.of(u, -s), place.of(u, 0), place.of(u, s));
        let w = &velocity[a];
        let (w_ll, w_l) = (place.of(w, -1), place.of(w, 0));
        let (w_hl, w_h) = (place.of(w, s - 1), place.of(w, s));
        let (v_l, v_r) = (&first.volume[..n], &first.volume[1..n + 1]);
        let volume = &first.inverse_face[..n];
        let weight = 0.25 * other.inverse_cell[j];
        let [below, above] = [1, 2].map(|o| weight * other.area[j + o]);
        for i in 0..n {
            let flux_low = below * (v_l[i] * w_ll[i] + v_r[i] * w_l[i]) * (low[i] + mid[i]);
            let flux_high = above * (v_l[i] * w_hl[i] + v_r[i] * w_h[i]) * (mid[i] + high[i]);
            out[i] -= volume[i] * (flux_high - flux_low);
        }
    }

    /// Component `d > 0` carried along axis 0.
    #[inline(always)]
    fn first_across(
        &self,
        grid: &Grid<D>,
        d: usize,
        velocity: &[Vec<f64>; D],
        place: &Place,
        out: &mut [f64],
    ) {
        let (n, j, s) = (place.n, place.at[d], grid.stride(d) as isize);
        let (first, own) = (&self.axes[0], &self.axes[d]);
        let u = &velocity[d];
        let (low, mid, high) = (place.of(u, -1), place.of(u, 0), place.of(u, 1));
        let w = &velocity[0];
        let (w_ll, w_l) = (place.of(w, -s), place.of(w, 0));
        let (w_hl, w_h) = (place.of(w, 1 - s), place.of(w, 1));
        let weight = 0.25 * own.inverse_face[j];
        let (v_l, v_r) = (weight * own.volume[j], weight * own.volume[j + 1]);
        let (below, above) = (&first.area[1..n + 1], &first.area[2..n + 2]);
        let volume = &first.inverse_cell[..n];
        for i in 0..n {
            let flux_low = below[i] * (v_l * w_ll[i] + v_r * w_l[i]) * (low[i] + mid[i]);
            let flux_high = above[i] * (v_l * w_hl[i] + v_r * w_h[i]) * (mid[i] + high[i]);
            out[i] -= volume[i] * (flux_high - flux_low);
        }
    }

    /// Component `d > 0` carried along another axis `a > 0`.
    #[inline(always)]
    fn across(
        &self,
        grid: &Grid<D>,
        d: usize,
        a: usize,
        velocity: &[Vec<f64>; D],
        place: &Place,
        out: &mut [f64],
    ) {
        let (j, k) = (place.at[d], place.at[a]);
        let (sd, sa) = (grid.stride(d) as isize, grid.stride(a) as isize);
        let (own, other) = (&self.axes[d], &self.axes[a]);
        let u = &velocity[d];
        let (low, mid, high) = (place.of(u, -sa), place.of(u, 0), place.of(u, sa));
        let w = &velocity[a];
        let (w_ll, w_l) = (place.of(w, -sd), place.of(w, 0));
        let (w_hl, w_h) = (place.of(w, sa - sd), place.of(w, sa));
        let weight = 0.25 * own.inverse_face[j] * other.inverse_cell[k];
        let (v_l, v_r) = (weight * own.volume[j], weight * own.volume[j + 1]);
        let [below, above] = [1, 2].map(|o| other.area[k + o]);
        for i in 0..place.n {
            let flux_low = below * (v_l * w_ll[i] + v_r * w_l[i]) * (low[i] + mid[i]);
            let flux_high = above * (v_l * w_hl[i] + v_r * w_h[i]) * (mid[i] + high[i]);
            out[i] -= flux_high - flux_low;
        }
    }
}

/// One row: where it starts, how long it is, its indices along the other axes.
struct Place {
    start: usize,
    n: usize,
    at: [usize; 3],
}

impl Place {
    /// The row of `field` displaced by `shift` in memory.
    #[inline(always)]
    fn of<'a>(&self, field: &'a [f64], shift: isize) -> &'a [f64] {
        let start = self.start.wrapping_add_signed(shift);
        &field[start..start + self.n]
    }
}
