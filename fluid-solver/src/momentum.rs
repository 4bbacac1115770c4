//! The momentum equation on two axes: one loop per row and component.
//!
//! Convection, viscosity, pressure gradient and the scheme's sums of [`crate::advect`],
//! [`crate::diffuse`] and [`crate::project`], term by term the same, with each value read once. Per
//! row: N = −∇·(u u_d) + ν ∇²u_d (explicit part) and
//! rhs = dt (γ N + ζ N_old) + 2 α dt (f − ∂p/∂x_d + ν ∇²u_d (implicit part)).

use crate::advect::Advection;
use crate::grid::Grid;
use crate::project::Projection;
use crate::stencil::Stencil;

/// Factors of one stage.
#[derive(Clone, Copy, Debug)]
pub struct Factors {
    /// dt γ, s.
    pub now: f64,
    /// dt ζ, s.
    pub old: f64,
    /// 2 α dt, s.
    pub share: f64,
    /// Viscosity that goes to N, m²/s.
    pub explicit: f64,
    /// Viscosity that goes to the increment, times 2 α dt, m².
    pub implicit: f64,
    /// Body force times 2 α dt, m/s.
    pub body: f64,
}

/// Weights of the fluxes of one component on two axes.
#[derive(Clone, Debug)]
pub struct Momentum {
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
    pub fn new<const D: usize>(
        grid: &Grid<D>,
        d: usize,
        advection: &Advection<D>,
        p: &Projection<D>,
    ) -> Self {
        let of = |axis: usize| {
            let [area, volume, cell, face] = advection.metric(axis);
            let inverse = if axis == d { face } else { cell };
            (area.to_vec(), volume.to_vec(), inverse.to_vec())
        };
        let ((area, volume, inverse), second) = (of(0), of(1));
        Self {
            d,
            stencils: [0, 1].map(|a| Stencil::of_component(grid, d, a)),
            quarter: inverse.iter().map(|v| 0.25 * v).collect(),
            area,
            volume,
            along: [second.0, second.1, second.2],
            slope: p.slope(d).to_vec(),
        }
    }

    /// One row: `rhs` and `history` (N_old on entry, N on return), values `0..n`.
    #[inline(always)]
    pub fn row<const D: usize>(
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
            self.first(f, &velocity[0], &velocity[1], pressure, &at, rhs, history);
        } else {
            self.second(f, &velocity[1], &velocity[0], pressure, &at, rhs, history);
        }
    }

    /// Component 0.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "only arguments tell that the results overlap nothing")]
    fn first(
        &self,
        f: &Factors,
        u: &[f64],
        w: &[f64],
        p: &[f64],
        at: &Row,
        rhs: &mut [f64],
        history: &mut [f64],
    ) {
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
                (f.old * history[i] + f.body) + (f.implicit * laplacian - f.share * gradient) + f.now * new;
            history[i] = new;
        }
    }

    /// Component 1.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "only arguments tell that the results overlap nothing")]
    fn second(
        &self,
        f: &Factors,
        u: &[f64],
        w: &[f64],
        p: &[f64],
        at: &Row,
        rhs: &mut [f64],
        history: &mut [f64],
    ) {
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
        let slope = self.slope[j] * f.share;
        let (under_weight, over_weight) = (self.stencils[1].lower[j], self.stencils[1].upper[j]);
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
            rhs[i] = (f.old * history[i] + f.body) + (f.implicit * laplacian - gradient) + f.now * new;
            history[i] = new;
        }
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
