//! Viscosity, ν ∇²u, explicit part.

use crate::grid::Grid;
use crate::stencil::Stencil;

/// The Laplacian of one velocity component.
#[derive(Clone, Debug)]
pub struct Diffusion<const D: usize> {
    stencils: [Stencil; D],
}

impl<const D: usize> Diffusion<D> {
    /// Laplacian of component `d`, walls taken from the halo.
    pub fn new(grid: &Grid<D>, d: usize) -> Self {
        Self { stencils: std::array::from_fn(|a| Stencil::of_component(grid, d, a)) }
    }

    /// Adds `weight ∇²u` on interior row `row` to `out` (values `0..n` of the row).
    ///
    /// In the axisymmetric radial component it includes −u_r/r².
    #[inline(always)]
    pub fn add_row(&self, grid: &Grid<D>, weight: f64, u: &[f64], row: usize, out: &mut [f64]) {
        let n = out.len();
        let start = grid.row(row);
        let mid = &u[start..start + n];
        let first = &self.stencils[0];
        let (lower, upper, extra) = (&first.lower[..n], &first.upper[..n], &first.extra[..n]);
        let (low, high) = (&u[start - 1..][..n], &u[start + 1..][..n]);
        for i in 0..n {
            out[i] +=
                weight * (lower[i] * (low[i] - mid[i]) + upper[i] * (high[i] - mid[i]) - extra[i] * mid[i]);
        }
        let at = [0, row % grid.cells[1], row / grid.cells[1]];
        for (a, stencil) in self.stencils.iter().enumerate().skip(1) {
            let (j, s) = (at[a], grid.stride(a));
            let (lower, upper) = (weight * stencil.lower[j], weight * stencil.upper[j]);
            let (low, high) = (&u[start - s..][..n], &u[start + s..][..n]);
            for i in 0..n {
                out[i] += lower * (low[i] - mid[i]) + upper * (high[i] - mid[i]);
            }
        }
    }
}
