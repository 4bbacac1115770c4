//! The kernels of the step on two axes, one row each.

use super::momentum::Momentum;
use super::project::Projection;
use super::stokes::Stokes;
use crate::factors::Factors;
use crate::grid::Grid;
use crate::lanes::Kernel;
use crate::near_convection::NearConvection;
use pulp::Simd;

/// One row of `rhs = dt (γ N + ζ N_old) + 2 α dt (f − ∇p + ν ∇²u)`, `history = N`.
pub(super) struct PredictRow<'a, const D: usize> {
    pub(super) grid: &'a Grid<D>,
    pub(super) factors: &'a Factors,
    /// With convection.
    pub(super) momentum: Option<&'a Momentum>,
    /// Without.
    pub(super) stokes: &'a Stokes,
    pub(super) projection: &'a Projection<D>,
    pub(super) d: usize,
    pub(super) velocity: &'a [Vec<f64>; D],
    pub(super) pressure: &'a [f64],
    pub(super) force: Option<&'a [f64]>,
    pub(super) near: Option<&'a NearConvection<D>>,
    pub(super) row: usize,
    pub(super) rhs: &'a mut [f64],
    pub(super) history: &'a mut [f64],
}

impl<const D: usize> Kernel for PredictRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { grid, factors, velocity, pressure, row, rhs, history, .. } = self;
        match self.momentum {
            Some(momentum) => momentum.row(grid, factors, velocity, pressure, row, rhs, history),
            None => {
                let u = &velocity[self.d];
                self.stokes.row(grid, self.projection, factors, u, pressure, row, rhs, history);
            }
        }
        for (first, terms) in self.near.iter().flat_map(|near| near.terms(self.d, row)) {
            let (rhs, history) = (&mut rhs[first..], &mut history[first..]);
            for ((r, history), term) in rhs.iter_mut().zip(history).zip(terms) {
                *r += factors.now * term;
                *history += term;
            }
        }
        if let Some(force) = self.force {
            let force = &force[grid.row(row)..][..rhs.len()];
            for (r, f) in rhs.iter_mut().zip(force) {
                *r += factors.length * f;
            }
        }
    }
}

/// One row of `rhs = inverse ∇·u`.
pub(super) struct DivergenceRow<'a, const D: usize> {
    pub(super) projection: &'a Projection<D>,
    pub(super) grid: &'a Grid<D>,
    pub(super) velocity: &'a [Vec<f64>; D],
    pub(super) row: usize,
    pub(super) inverse: f64,
    pub(super) rhs: &'a mut [f64],
}

impl<const D: usize> Kernel for DivergenceRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { projection, grid, velocity, row, rhs, .. } = self;
        let (n, start, s) = (rhs.len(), grid.row(row), grid.stride(1));
        let u = &velocity[0][start..];
        let across = [&velocity[1][start..][..n], &velocity[1][start + s..][..n]];
        projection.divergence([&u[..n], &u[1..][..n]], across, row, rhs);
        for r in rhs {
            *r *= self.inverse;
        }
    }
}

/// The end of a projection on one row of u, w and p: `u −= weight ∇φ`, `p += φ − correction ∇²φ`, by these
/// weights. Halo of φ up to date.
pub(super) struct FinishRow<'a, const D: usize> {
    pub(super) projection: &'a Projection<D>,
    pub(super) grid: &'a Grid<D>,
    pub(super) weights: [f64; 2],
    pub(super) phi: &'a [f64],
    pub(super) row: usize,
    pub(super) fields: [&'a mut [f64]; 3],
}

impl<const D: usize> Kernel for FinishRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { projection, grid, weights, phi, row, fields: [u, w, p] } = self;
        let (start, s) = (grid.row(row), grid.stride(1));
        let at = [start - 1, start, start + 1, start - s, start + s].map(|at| &phi[at..][..p.len()]);
        projection.finish(weights, at, row, u, w, p);
    }
}
