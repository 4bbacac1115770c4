//! The step on two axes: momentum row by row, then viscosity, then the projection.

use super::{Options, Pending, fill_all};
use crate::advect::Advection;
use crate::boundary::fill_scalar;
use crate::diffuse::Diffusion;
use crate::field::State;
use crate::grid::Grid;
use crate::helmholtz::{Helmholtz, Unknown, Write};
use crate::lanes::{Kernel, dispatch};
use crate::momentum::{Factors, Momentum};
use crate::project::Projection;
use crate::scheme::{Stage, Viscous};
use crate::threads::{for_row_triples, for_rows};
use crate::timings::{Part, Timings};
use crate::work::Work;
use pulp::Simd;

/// Operators, solvers and working memory on two axes.
pub(super) struct FlatStep<const D: usize> {
    advection: Advection<D>,
    diffusion: [Diffusion<D>; D],
    projection: Projection<D>,
    /// The same terms in one loop per component.
    momentum: [Momentum; D],
    viscous_solver: [Helmholtz<D>; D],
    pressure_solver: Helmholtz<D>,
    rhs: [Vec<f64>; D],
    phi: Vec<f64>,
}

impl<const D: usize> FlatStep<D> {
    /// Plans a step. Working memory is sized for the current rayon pool.
    pub(super) fn new(grid: &Grid<D>) -> Self {
        let (advection, projection) = (Advection::new(grid), Projection::new(grid));
        Self {
            momentum: std::array::from_fn(|d| Momentum::new(grid, d, &advection, &projection)),
            advection,
            diffusion: std::array::from_fn(|d| Diffusion::new(grid, d)),
            projection,
            viscous_solver: std::array::from_fn(|d| Helmholtz::new(grid, Unknown::Component(d))),
            pressure_solver: Helmholtz::new(grid, Unknown::Pressure),
            rhs: grid.new_vector(),
            phi: grid.new_field(),
        }
    }

    /// Predictor of one stage.
    pub(super) fn stage(
        &mut self,
        grid: &Grid<D>,
        options: &Options<D>,
        state: &mut State<D>,
        (stage, dt): (Stage, f64),
        force: Option<&[Vec<f64>; D]>,
        timings: &mut Timings,
    ) {
        let begin = Work::begin();
        let Self { advection, diffusion, projection, momentum, rhs, .. } = self;
        let State { velocity, pressure, history, .. } = state;
        let (velocity, pressure) = (&*velocity, pressure.as_slice());
        for (d, (rhs, history)) in rhs.iter_mut().zip(history).enumerate() {
            let terms = Terms {
                grid,
                options,
                stage,
                dt,
                d,
                advection,
                diffusion: &diffusion[d],
                projection,
                momentum: Some(&momentum[d]).filter(|_| options.convection),
                velocity,
                pressure,
                force: force.map(|f| f[d].as_slice()),
            };
            for_rows(grid, rhs, history, |row, rhs, history| {
                dispatch(MomentumRow { terms: &terms, row, rhs, history });
            });
        }
        timings.add(Part::Momentum, begin);
        let begin = Work::begin();
        self.viscous(grid, options, state, stage.alpha * options.viscosity * dt);
        timings.add(Part::Viscous, begin);
    }

    /// `velocity` += increment, through the viscous solve where it is implicit.
    fn viscous(&mut self, grid: &Grid<D>, options: &Options<D>, state: &mut State<D>, c: f64) {
        for d in 0..D {
            let (rhs, u) = (&mut self.rhs[d], &mut state.velocity[d]);
            if options.viscous == Viscous::Implicit && c > 0.0 {
                self.viscous_solver[d].solve(grid, 1.0, c, rhs, u, Write::Add);
            } else {
                for_rows(grid, u, rhs, |_, u, rhs| {
                    u.iter_mut().zip(&*rhs).for_each(|(u, r)| *u += r);
                });
            }
        }
    }

    /// Projects and updates the pressure; `false`, with the velocity as it was, if φ is not finite.
    pub(super) fn project(
        &mut self,
        grid: &Grid<D>,
        state: &mut State<D>,
        pending: Pending,
        timings: &mut Timings,
    ) -> bool {
        let begin = Work::begin();
        fill_all(grid, state);
        self.solve(grid, state, pending.weight, timings);
        let Self { projection, phi, .. } = self;
        // Every φ depends on every cell: one is enough to know.
        if !phi[grid.row(grid.rows() / 2) + grid.cells[0] / 2].is_finite() {
            return false;
        }
        let weights = [pending.weight, pending.correction * pending.weight];
        let State { velocity, pressure, .. } = state;
        // ∇·u* = weight ∇²φ: the old velocity is not needed for the pressure.
        let [u, w, ..] = velocity.as_mut_slice() else { return false };
        for_row_triples(grid, [u, w, pressure], |row, fields| {
            dispatch(FinishRow { projection, grid, weights, phi, row, fields });
        });
        fill_all(grid, state);
        fill_scalar(grid, &mut state.pressure);
        timings.add(Part::Projection, begin);
        true
    }

    /// Makes the velocity divergence-free without touching the pressure. Halos are filled.
    pub(super) fn project_velocity(&mut self, grid: &Grid<D>, state: &mut State<D>, timings: &mut Timings) {
        self.solve(grid, state, 1.0, timings);
        let Self { projection, rhs, phi, .. } = self;
        for (d, (u, rhs)) in state.velocity.iter_mut().zip(rhs).enumerate() {
            for_rows(grid, u, rhs, |row, u, _| {
                dispatch(CorrectRow { projection, grid, d, weight: 1.0, phi, row, u });
            });
        }
    }

    /// `phi` ← solution of ∇²φ = ∇·u / weight.
    fn solve(&mut self, grid: &Grid<D>, state: &State<D>, weight: f64, timings: &mut Timings) {
        let inverse = 1.0 / weight;
        let Self { projection, rhs, phi, .. } = self;
        let (velocity, rhs) = (&state.velocity, &mut rhs[0]);
        for_rows(grid, rhs, phi, |row, rhs, _| {
            dispatch(DivergenceRow { projection, grid, velocity, row, inverse, rhs });
        });
        let begin = Work::begin();
        self.pressure_solver.solve(grid, 0.0, -1.0, rhs, phi, Write::Set);
        timings.add(Part::Pressure, begin);
        fill_scalar(grid, phi);
    }
}

/// All that one row of the momentum equation needs.
struct Terms<'a, const D: usize> {
    grid: &'a Grid<D>,
    options: &'a Options<D>,
    stage: Stage,
    dt: f64,
    d: usize,
    advection: &'a Advection<D>,
    diffusion: &'a Diffusion<D>,
    projection: &'a Projection<D>,
    momentum: Option<&'a Momentum>,
    velocity: &'a [Vec<f64>; D],
    pressure: &'a [f64],
    force: Option<&'a [f64]>,
}

impl<const D: usize> Terms<'_, D> {
    /// `rhs = dt (γ N + ζ N_old) + 2 α dt (f − ∇p + ν ∇²u)`, `history = N`.
    #[inline(always)]
    fn row(&self, row: usize, rhs: &mut [f64], history: &mut [f64]) {
        match self.momentum {
            Some(momentum) => {
                let factors = self.factors();
                momentum.row(self.grid, &factors, self.velocity, self.pressure, row, rhs, history);
            }
            None => self.row_by_terms(row, rhs, history),
        }
        if let Some(force) = self.force {
            let share = 2.0 * self.stage.alpha * self.dt;
            let force = &force[self.grid.row(row)..][..rhs.len()];
            for (r, f) in rhs.iter_mut().zip(force) {
                *r += share * f;
            }
        }
    }

    /// What multiplies each term.
    fn factors(&self) -> Factors {
        let Self { stage, dt, options, .. } = *self;
        let share = 2.0 * stage.alpha * dt;
        let [explicit, implicit] = match options.viscous {
            Viscous::Explicit => [options.viscosity, 0.0],
            Viscous::Implicit => [0.0, share * options.viscosity],
        };
        let body = share * options.body_force[self.d];
        Factors { now: dt * stage.gamma, old: dt * stage.zeta, share, explicit, implicit, body }
    }

    /// [`Self::row`] without forces of the caller, one term after the other.
    #[inline(always)]
    fn row_by_terms(&self, row: usize, rhs: &mut [f64], history: &mut [f64]) {
        let Self { grid, options, d, .. } = *self;
        let Factors { now, old, share, explicit, implicit, body } = self.factors();
        let u = &self.velocity[d];
        for (r, n) in rhs.iter_mut().zip(&mut *history) {
            *r = old * *n + body;
            *n = 0.0;
        }
        if options.convection {
            self.advection.add_row(grid, d, self.velocity, row, history);
        }
        match options.viscous {
            Viscous::Explicit => self.diffusion.add_row(grid, explicit, u, row, history),
            Viscous::Implicit => self.diffusion.add_row(grid, implicit, u, row, rhs),
        }
        self.projection.add_gradient_row(grid, d, -share, self.pressure, row, rhs);
        for (r, n) in rhs.iter_mut().zip(&*history) {
            *r += now * n;
        }
    }
}

/// [`Terms::row`] on one row.
struct MomentumRow<'a, const D: usize> {
    terms: &'a Terms<'a, D>,
    row: usize,
    rhs: &'a mut [f64],
    history: &'a mut [f64],
}

impl<const D: usize> Kernel for MomentumRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.terms.row(self.row, self.rhs, self.history);
    }
}

/// One row of `rhs = inverse ∇·u`.
struct DivergenceRow<'a, const D: usize> {
    projection: &'a Projection<D>,
    grid: &'a Grid<D>,
    velocity: &'a [Vec<f64>; D],
    row: usize,
    inverse: f64,
    rhs: &'a mut [f64],
}

impl<const D: usize> Kernel for DivergenceRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.projection.divergence_row(self.grid, self.velocity, self.row, self.rhs);
        for r in self.rhs {
            *r *= self.inverse;
        }
    }
}

/// One row of `u −= weight ∇φ`.
struct CorrectRow<'a, const D: usize> {
    projection: &'a Projection<D>,
    grid: &'a Grid<D>,
    d: usize,
    weight: f64,
    phi: &'a [f64],
    row: usize,
    u: &'a mut [f64],
}

impl<const D: usize> Kernel for CorrectRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.projection.add_gradient_row(self.grid, self.d, -self.weight, self.phi, self.row, self.u);
    }
}

/// [`Projection::finish_row`] on one row.
struct FinishRow<'a, const D: usize> {
    projection: &'a Projection<D>,
    grid: &'a Grid<D>,
    weights: [f64; 2],
    phi: &'a [f64],
    row: usize,
    fields: [&'a mut [f64]; 3],
}

impl<const D: usize> Kernel for FinishRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.projection.finish_row(self.grid, self.weights, self.phi, self.row, self.fields);
    }
}
