//! The momentum equation on two axes: one loop per row and component.
//!
//! ```text
//! N   = −∇·(u u_d) + ν ∇²u_d (explicit part)
//! rhs = dt (γ N + ζ N_old) + 2 α dt (f − ∂p/∂x_d + ν ∇²u_d (implicit part))
//! ```
//! Convection is conservative, second order, central: on the control volume of component `d` the flux
//! through a face is the mean of the two discrete mass fluxes beside it, times the plain mean of the
//! two velocities (Verstappen & Veldman 2003, symmetry-preserving form). As the mass fluxes are those
//! of the discrete continuity equation, a divergence-free field neither gains nor loses energy by
//! convection, with any metric. The tests compare each term with the same written by itself.

use super::project::Projection;
use crate::factors::Factors;
use crate::grid::Grid;
use crate::stencil::Stencil;

/// Weights of the fluxes of one component on two axes.
#[derive(Clone, Debug)]
pub(crate) struct Momentum {
    d: usize,
    stencils: [Stencil; 2],
    /// ¼ / volume along axis 0.
    quarter: Vec<f64>,
    /// Area of the faces along axis 0 (own axis: with a halo entry on each side).
    area: Vec<f64>,
    /// Share of the cells on both sides in the flux along axis 1 (component 0), along axis 0.
    volume: Vec<f64>,
    /// The same three along axis 1.
    along: [Vec<f64>; 3],
    /// 1 / distance along the component's own axis, 1/m.
    slope: Vec<f64>,
}

impl Momentum {
    /// Gathers the weights of component `d`.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>, d: usize, projection: &Projection<D>) -> Self {
        let (own, other) = (Metric::new(grid, 0), Metric::new(grid, 1));
        let quarter = own.inverse_volume(d == 0).iter().map(|v| 0.25 * v).collect();
        Self {
            d,
            stencils: [0, 1].map(|a| Stencil::of_component(grid, d, a)),
            quarter,
            along: [other.area.clone(), other.volume.clone(), other.inverse_volume(d == 1).to_vec()],
            area: own.area,
            volume: own.volume,
            slope: projection.slope[d].clone(),
        }
    }

    /// One row: `rhs` and `history` (N_old on entry, N on return), values `0..n`.
    #[inline(always)]
    pub(crate) fn row<const D: usize>(
        &self,
        grid: &Grid<D>,
        f: &Factors,
        velocity: &[Vec<f64>; D],
        pressure: &[f64],
        row: usize,
        rhs: &mut [f64],
        history: &mut [f64],
    ) {
        let at = Row { n: rhs.len(), start: grid.row(row), j: row, stride: grid.stride(1) };
        if self.d == 0 {
            self.first(f, [&velocity[0], &velocity[1], pressure], &at, rhs, history);
        } else {
            self.second(f, [&velocity[1], &velocity[0], pressure], &at, rhs, history);
        }
    }

    /// Component 0. The results are arguments, which tells that they overlap nothing.
    #[inline(always)]
    fn first(&self, f: &Factors, [u, w, p]: [&[f64]; 3], at: &Row, rhs: &mut [f64], history: &mut [f64]) {
        let (n, j, s) = (at.n, at.j, at.stride as isize);
        let (rhs, history) = (&mut rhs[..n], &mut history[..n]);
        let (low, mid, high) = (at.of(u, -1), at.of(u, 0), at.of(u, 1));
        let (under, over) = (at.of(u, -s), at.of(u, s));
        let (w_ll, w_l, w_hl, w_h) = (at.of(w, -1), at.of(w, 0), at.of(w, s - 1), at.of(w, s));
        let (p_low, p_mid) = (at.of(p, -1), at.of(p, 0));
        let (a, b, c) = (&self.area[..n], &self.area[1..][..n], &self.area[2..][..n]);
        let (v_l, v_r) = (&self.volume[..n], &self.volume[1..][..n]);
        let (quarter, slope) = (&self.quarter[..n], &self.slope[..n]);
        let Stencil { lower, upper, extra } = &self.stencils[0];
        let (lower, upper, extra) = (&lower[..n], &upper[..n], &extra[..n]);
        let [area, _, inverse] = &self.along;
        let (below, above) = (inverse[j] * area[j + 1], inverse[j] * area[j + 2]);
        let (under_weight, over_weight) = (self.stencils[1].lower[j], self.stencils[1].upper[j]);
        let body = f.body[0];
        for i in 0..n {
            let m = mid[i];
            let east = (b[i] * m + c[i] * high[i]) * (m + high[i]);
            let west = (a[i] * low[i] + b[i] * m) * (low[i] + m);
            let north = above * (v_l[i] * w_hl[i] + v_r[i] * w_h[i]) * (m + over[i]);
            let south = below * (v_l[i] * w_ll[i] + v_r[i] * w_l[i]) * (under[i] + m);
            let convection = quarter[i] * ((east - west) + (north - south));
            let laplacian = lower[i] * (low[i] - m) + upper[i] * (high[i] - m) - extra[i] * m
                + (under_weight * (under[i] - m) + over_weight * (over[i] - m));
            let gradient = slope[i] * (p_mid[i] - p_low[i]);
            let new = f.explicit * laplacian - convection;
            rhs[i] =
                (f.old * history[i] + body) + (f.implicit * laplacian - f.length * gradient) + f.now * new;
            history[i] = new;
        }
    }

    /// Component 1, likewise.
    #[inline(always)]
    fn second(&self, f: &Factors, [u, w, p]: [&[f64]; 3], at: &Row, rhs: &mut [f64], history: &mut [f64]) {
        let (n, j, s) = (at.n, at.j, at.stride as isize);
        let (rhs, history) = (&mut rhs[..n], &mut history[..n]);
        let (low, mid, high) = (at.of(u, -1), at.of(u, 0), at.of(u, 1));
        let (under, over) = (at.of(u, -s), at.of(u, s));
        let (w_ll, w_l, w_hl, w_h) = (at.of(w, -s), at.of(w, 0), at.of(w, 1 - s), at.of(w, 1));
        let (p_low, p_mid) = (at.of(p, -s), at.of(p, 0));
        let (below, above) = (&self.area[1..][..n], &self.area[2..][..n]);
        let quarter = &self.quarter[..n];
        let Stencil { lower, upper, extra } = &self.stencils[0];
        let (lower, upper, extra) = (&lower[..n], &upper[..n], &extra[..n]);
        let [area, volume, inverse] = &self.along;
        let own = 0.25 * inverse[j];
        let (a, b, c) = (own * area[j], own * area[j + 1], own * area[j + 2]);
        let (v_l, v_r) = (inverse[j] * volume[j], inverse[j] * volume[j + 1]);
        let slope = self.slope[j] * f.length;
        let (under_weight, over_weight) = (self.stencils[1].lower[j], self.stencils[1].upper[j]);
        let body = f.body[1];
        for i in 0..n {
            let m = mid[i];
            let north = (b * m + c * over[i]) * (m + over[i]);
            let south = (a * under[i] + b * m) * (under[i] + m);
            let east = above[i] * (v_l * w_hl[i] + v_r * w_h[i]) * (m + high[i]);
            let west = below[i] * (v_l * w_ll[i] + v_r * w_l[i]) * (low[i] + m);
            let convection = quarter[i] * (east - west) + (north - south);
            let laplacian = lower[i] * (low[i] - m) + upper[i] * (high[i] - m) - extra[i] * m
                + (under_weight * (under[i] - m) + over_weight * (over[i] - m));
            let gradient = slope * (p_mid[i] - p_low[i]);
            let new = f.explicit * laplacian - convection;
            rhs[i] = (f.old * history[i] + body) + (f.implicit * laplacian - gradient) + f.now * new;
            history[i] = new;
        }
    }
}

/// Areas and volumes along one axis with an entry of halo on each side (entry `i + 1` belongs to `i`),
/// and 1 / volume of cells and faces without.
struct Metric {
    area: Vec<f64>,
    volume: Vec<f64>,
    inverse_cell: Vec<f64>,
    inverse_face: Vec<f64>,
}

impl Metric {
    fn new<const D: usize>(grid: &Grid<D>, a: usize) -> Self {
        let axis = &grid.axes[a];
        let n = axis.cells();
        let cell = |i: usize| {
            if grid.periodic(a) { (i + n - 1) % n } else { i.saturating_sub(1).min(n - 1) }
        };
        Self {
            area: (0..n + 2).map(|i| axis.face_area[i.saturating_sub(1)]).collect(),
            volume: (0..n + 2).map(|i| axis.cell_volume[cell(i)]).collect(),
            inverse_cell: axis.inverse_cell_volume.clone(),
            inverse_face: axis.face_volume.iter().map(|v| 1.0 / v).collect(),
        }
    }

    /// 1 / volume of what holds a component: faces along its own axis, else cells.
    fn inverse_volume(&self, own: bool) -> &[f64] {
        if own { &self.inverse_face } else { &self.inverse_cell }
    }
}

/// One row: its length, where it starts, its number, and how far the next one is.
struct Row {
    n: usize,
    start: usize,
    j: usize,
    stride: usize,
}

impl Row {
    /// The row of `field` displaced by `shift` in memory.
    #[inline(always)]
    fn of<'a>(&self, field: &'a [f64], shift: isize) -> &'a [f64] {
        &field[self.start.wrapping_add_signed(shift)..][..self.n]
    }
}
