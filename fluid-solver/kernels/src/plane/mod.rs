//! The step on two axes, plane (x, z) or axisymmetric (r, z): row by row, each part by itself.

mod momentum;
mod project;
mod rows;
mod stokes;

use crate::engine::Engine;
use crate::factors::Factors;
use crate::field::State;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::halo::fill_scalar;
use crate::helmholtz::{Helmholtz, Unknown, Write};
use crate::lanes::dispatch;
use crate::scheme::Viscous;
use crate::stages::{PlannedStage, PressureUpdate};
use crate::threads::for_rows;
use momentum::Momentum;
use project::Projection;
use rows::{DivergenceRow, FinishRow, PredictRow};
use stokes::Stokes;

/// Operators, solvers and working memory on two axes.
pub(crate) struct PlaneEngine<const D: usize> {
    momentum: [Momentum; D],
    stokes: [Stokes; D],
    projection: Projection<D>,
    viscous_solver: [Helmholtz<D>; D],
    pressure_solver: Helmholtz<D>,
    rhs: [Vec<f64>; D],
    phi: Vec<f64>,
}

impl<const D: usize> PlaneEngine<D> {
    /// Plans a step. Working memory is sized for the current rayon pool.
    pub(crate) fn new(grid: &Grid<D>) -> Self {
        debug_assert!(D == 2, "a plane has two axes");
        let projection = Projection::new(grid);
        Self {
            momentum: std::array::from_fn(|d| Momentum::new(grid, d, &projection)),
            stokes: std::array::from_fn(|d| Stokes::new(grid, d)),
            projection,
            viscous_solver: std::array::from_fn(|d| Helmholtz::new(grid, Unknown::Component(d))),
            pressure_solver: Helmholtz::new(grid, Unknown::Pressure),
            rhs: grid.new_vector(),
            phi: grid.new_field(),
        }
    }

    /// `phi` ← solution of ∇²φ = ∇·u / duration, halos included.
    fn solve(&mut self, flow: &Flow<D>, duration: f64) {
        let inverse = 1.0 / duration;
        let Self { projection, rhs, phi, .. } = self;
        let (grid, velocity, rhs) = (&flow.grid, &flow.state.velocity, &mut rhs[0]);
        for_rows(grid, [rhs], |row, [rhs]| {
            dispatch(DivergenceRow { projection, grid, velocity, row, inverse, rhs });
        });
        self.pressure_solver.solve(grid, [0.0, -1.0], rhs, phi, Write::Set);
        fill_scalar(grid, phi);
    }
}

impl<const D: usize> Engine<D> for PlaneEngine<D> {
    fn fuses(&self) -> bool {
        false
    }

    fn predict(&mut self, flow: &mut Flow<D>, stage: &PlannedStage, force: Option<&[Vec<f64>; D]>) {
        let Self { momentum, stokes, projection, rhs, .. } = self;
        let Flow { grid, options, state: State { velocity, pressure, history, .. }, near } = flow;
        let (grid, velocity, near) = (&*grid, &*velocity, near.as_deref());
        let factors = &Factors::new(options, stage);
        for (d, (rhs, history)) in rhs.iter_mut().zip(history).enumerate() {
            let momentum = Some(&momentum[d]).filter(|_| options.convection);
            let (stokes, force) = (&stokes[d], force.map(|force| force[d].as_slice()));
            for_rows(grid, [rhs, history], |row, [rhs, history]| {
                dispatch(PredictRow {
                    grid,
                    factors,
                    momentum,
                    stokes,
                    projection,
                    d,
                    velocity,
                    pressure,
                    force,
                    near,
                    row,
                    rhs,
                    history,
                });
            });
        }
    }

    fn diffuse(&mut self, flow: &mut Flow<D>, stage: &PlannedStage) {
        let Flow { grid, options, state, .. } = flow;
        let c = stage.diffusion(options.viscosity);
        for d in 0..D {
            let (rhs, u) = (&mut self.rhs[d], &mut state.velocity[d]);
            if options.viscous == Viscous::Implicit && c > 0.0 {
                self.viscous_solver[d].solve(grid, [1.0, c], rhs, u, Write::Add);
            } else {
                for_rows(grid, [u, rhs], |_, [u, rhs]| {
                    u.iter_mut().zip(&*rhs).for_each(|(u, r)| *u += r);
                });
            }
        }
    }

    fn project(&mut self, flow: &mut Flow<D>, update: PressureUpdate, _: bool) -> bool {
        flow.fill_halos();
        self.solve(flow, update.duration);
        // Every φ depends on every cell: one is enough to know.
        let grid = &flow.grid;
        self.phi[grid.row(grid.rows() / 2) + grid.cells[0] / 2].is_finite()
    }

    fn correct(&mut self, flow: &mut Flow<D>, update: PressureUpdate) {
        let Self { projection, phi, .. } = self;
        // ∇·u* = duration ∇²φ: the old velocity is not needed for the pressure.
        let weights = [update.duration, update.viscosity * update.duration];
        let Flow { grid, state: State { velocity, pressure, .. }, .. } = flow;
        let [u, w, ..] = velocity.as_mut_slice() else { return };
        for_rows(grid, [u, w, pressure], |row, fields| {
            dispatch(FinishRow { projection, grid, weights, phi, row, fields });
        });
        flow.fill_halos();
        fill_scalar(&flow.grid, &mut flow.state.pressure);
    }

    fn project_velocity(&mut self, flow: &mut Flow<D>) {
        self.solve(flow, 1.0);
        let Self { projection, rhs, phi, .. } = self;
        let Flow { grid, state, .. } = flow;
        let [u, w, ..] = state.velocity.as_mut_slice() else { return };
        // The pressure stays: working memory takes its place.
        for_rows(grid, [u, w, &mut rhs[0]], |row, fields| {
            dispatch(FinishRow { projection, grid, weights: [1.0, 0.0], phi, row, fields });
        });
    }

    /// It always has.
    fn keep_pressure_gradient(&mut self, _: &Flow<D>) {}
}
