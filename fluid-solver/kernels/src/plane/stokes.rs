//! The momentum equation on two axes without convection (Stokes flow), one term after the other.

use super::project::Projection;
use crate::factors::Factors;
use crate::grid::Grid;
use crate::stencil::Stencil;

/// Weights of viscosity for one component.
#[derive(Clone, Debug)]
pub(crate) struct Stokes {
    d: usize,
    stencils: [Stencil; 2],
}

impl Stokes {
    /// For component `d`; walls are taken from the halo.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>, d: usize) -> Self {
        Self { d, stencils: [0, 1].map(|a| Stencil::of_component(grid, d, a)) }
    }

    /// One row: `rhs` and `history` (N_old on entry, N on return), values `0..n`.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "only arguments tell that the results overlap nothing")]
    pub(crate) fn row<const D: usize>(
        &self,
        grid: &Grid<D>,
        projection: &Projection<D>,
        f: &Factors,
        u: &[f64],
        pressure: &[f64],
        row: usize,
        rhs: &mut [f64],
        history: &mut [f64],
    ) {
        for (r, n) in rhs.iter_mut().zip(&mut *history) {
            *r = f.old * *n + f.body[self.d];
            *n = 0.0;
        }
        if f.implicit == 0.0 {
            self.add_laplacian(grid, f.explicit, u, row, history);
        } else {
            self.add_laplacian(grid, f.implicit, u, row, rhs);
        }
        projection.add_gradient_row(grid, self.d, -f.length, pressure, row, rhs);
        for (r, n) in rhs.iter_mut().zip(&*history) {
            *r += f.now * n;
        }
    }

    /// Adds `weight ∇²u` on interior row `row` to `out`; in the radial component it includes −u_r/r².
    #[inline(always)]
    fn add_laplacian<const D: usize>(
        &self,
        grid: &Grid<D>,
        weight: f64,
        u: &[f64],
        row: usize,
        out: &mut [f64],
    ) {
        let (n, start, s) = (out.len(), grid.row(row), grid.stride(1));
        let mid = &u[start..][..n];
        let [first, second] = &self.stencils;
        let (lower, upper, extra) = (&first.lower[..n], &first.upper[..n], &first.extra[..n]);
        let (low, high) = (&u[start - 1..][..n], &u[start + 1..][..n]);
        for i in 0..n {
            out[i] +=
                weight * (lower[i] * (low[i] - mid[i]) + upper[i] * (high[i] - mid[i]) - extra[i] * mid[i]);
        }
        let (lower, upper) = (weight * second.lower[row], weight * second.upper[row]);
        let (low, high) = (&u[start - s..][..n], &u[start + s..][..n]);
        for i in 0..n {
            out[i] += lower * (low[i] - mid[i]) + upper * (high[i] - mid[i]);
        }
    }
}
