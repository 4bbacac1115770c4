//! The time step: predictor, viscosity, projection.
//!
//! One stage of length `2 α dt` (see [`crate::scheme`]):
//! ```text
//! (1 − α ν dt ∇²)(u* − u) = dt (γ N + ζ N_old) + 2 α dt (f − ∇p + ν ∇²u)
//! ∇²φ = ∇·u* / (2 α dt),   u ← u* − 2 α dt ∇φ,   p ← p + φ − ½ ν ∇·u*
//! ```
//! The pressure gradient is carried (van Kan 1986) and the last term makes it second order with
//! implicit viscosity (Kim & Moin 1985; Brown, Cortez & Minion 2001). Solving for the increment
//! keeps a steady state steady to round-off and makes every wall condition homogeneous.

use crate::advect::Advection;
use crate::boundary::{Boundary, fill_scalar, fill_velocity};
use crate::diffuse::Diffusion;
use crate::field::State;
use crate::grid::{Grid, GridError};
use crate::helmholtz::{Helmholtz, Unknown, Write};
use crate::lanes::{Kernel, dispatch};
use crate::momentum::{Factors, Momentum};
use crate::project::Projection;
use crate::scheme::{Scheme, Stage, Viscous};
use crate::threads::{for_row_triples, for_rows};
use crate::timings::{Part, Timings};
use crate::work::Work;
use pulp::Simd;

/// Choices of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options<const D: usize> {
    /// Kinematic viscosity, m²/s.
    pub viscosity: f64,
    /// Time scheme.
    pub scheme: Scheme,
    /// Implicit or explicit viscosity.
    pub viscous: Viscous,
    /// Whether there is convection (off: Stokes flow).
    pub convection: bool,
    /// Uniform body force per unit mass, mean pressure gradient −∇P/ρ included, m/s².
    pub body_force: [f64; D],
}

/// A projection that is still to be done.
#[derive(Clone, Copy, Debug)]
struct Pending {
    /// Time over which φ acts, s.
    weight: f64,
    /// What multiplies ∇·u* in the pressure, m²/s.
    correction: f64,
}

/// The incompressible Navier–Stokes equations on one grid, advanced in time.
pub struct Stepper<const D: usize> {
    grid: Grid<D>,
    options: Options<D>,
    state: State<D>,
    advection: Advection<D>,
    diffusion: [Diffusion<D>; D],
    projection: Projection<D>,
    /// The same terms in one loop per component; on two axes only.
    momentum: Vec<Momentum>,
    viscous_solver: [Helmholtz<D>; D],
    pressure_solver: Helmholtz<D>,
    rhs: [Vec<f64>; D],
    phi: Vec<f64>,
    pending: Option<Pending>,
    timings: Timings,
}

impl<const D: usize> Stepper<D> {
    /// Fluid at rest on `grid`. Working memory is sized for the current rayon pool.
    pub fn new(grid: Grid<D>, options: Options<D>) -> Self {
        let (advection, projection) = (Advection::new(&grid), Projection::new(&grid));
        let fused = if D == 2 { 0..D } else { 0..0 };
        Self {
            state: State::at_rest(&grid),
            momentum: fused.map(|d| Momentum::new(&grid, d, &advection, &projection)).collect(),
            advection,
            diffusion: std::array::from_fn(|d| Diffusion::new(&grid, d)),
            projection,
            viscous_solver: std::array::from_fn(|d| Helmholtz::new(&grid, Unknown::Component(d))),
            pressure_solver: Helmholtz::new(&grid, Unknown::Pressure),
            rhs: grid.new_vector(),
            phi: grid.new_field(),
            pending: None,
            timings: Timings::default(),
            grid,
            options,
        }
    }

    /// One full time step of length `dt` (s), ending in a divergence-free velocity.
    ///
    /// `force`: body force per unit mass at the nodes of each component (m/s², field layout),
    /// constant over the step, added in full in every stage. It need not be divergence-free, nor
    /// need the velocity be so on entry.
    pub fn step(&mut self, dt: f64, force: Option<&[Vec<f64>; D]>) {
        self.advance_without_projection(dt, force);
        self.project();
    }

    /// The step up to its last projection: the caller may change the velocity (direct forcing)
    /// and must then call [`Stepper::project`].
    pub fn advance_without_projection(&mut self, dt: f64, force: Option<&[Vec<f64>; D]>) {
        debug_assert!(dt > 0.0 && dt.is_finite(), "the time step must be positive");
        self.fill_halos();
        let scheme = self.options.scheme;
        let every = scheme.projects_every_stage();
        for k in 0..scheme.stages() {
            if k > 0 && every {
                self.project_stage();
            } else if k > 0 {
                self.fill_halos();
            }
            let stage = scheme.stage(k, dt, self.state.previous_dt);
            self.momentum(stage, dt, force);
            self.viscous(stage, dt);
            let share = if every { 2.0 * stage.alpha } else { 1.0 };
            let implicit = self.options.viscous == Viscous::Implicit;
            let nu = if implicit { self.options.viscosity } else { 0.0 };
            self.pending = Some(Pending { weight: share * dt, correction: nu * stage.alpha / share });
        }
        self.state.previous_dt = dt;
        self.state.time += dt;
        self.state.steps += 1;
    }

    /// Ends a step begun by [`Stepper::advance_without_projection`]: projects, updates the pressure.
    /// Does nothing if no step has been begun.
    pub fn project(&mut self) {
        self.project_stage();
    }

    /// Makes the velocity divergence-free without touching the pressure (initial conditions).
    pub fn project_velocity(&mut self) {
        self.fill_halos();
        self.solve_phi(Pending { weight: 1.0, correction: 0.0 }, false);
        self.correct(1.0);
    }

    /// `rhs` ← increment of each component before the viscous solve; `history` ← N.
    fn momentum(&mut self, stage: Stage, dt: f64, force: Option<&[Vec<f64>; D]>) {
        let begin = Work::begin();
        let Self { grid, options, state, advection, diffusion, projection, momentum, rhs, .. } = self;
        let grid = &*grid;
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
                momentum: momentum.get(d).filter(|_| options.convection),
                velocity,
                pressure,
                force: force.map(|f| f[d].as_slice()),
            };
            for_rows(grid, rhs, history, |row, rhs, history| {
                dispatch(MomentumRow { terms: &terms, row, rhs, history });
            });
        }
        self.timings.add(Part::Momentum, begin);
    }

    /// `velocity` += increment, through the viscous solve where it is implicit.
    fn viscous(&mut self, stage: Stage, dt: f64) {
        let begin = Work::begin();
        let c = stage.alpha * self.options.viscosity * dt;
        for d in 0..D {
            let (rhs, u) = (&mut self.rhs[d], &mut self.state.velocity[d]);
            if self.options.viscous == Viscous::Implicit && c > 0.0 {
                self.viscous_solver[d].solve(&self.grid, 1.0, c, rhs, u, Write::Add);
            } else {
                for_rows(&self.grid, u, rhs, |_, u, rhs| {
                    u.iter_mut().zip(&*rhs).for_each(|(u, r)| *u += r);
                });
            }
        }
        self.timings.add(Part::Viscous, begin);
    }

    /// The projection that is pending, if any.
    fn project_stage(&mut self) {
        let Some(pending) = self.pending.take() else { return };
        let begin = Work::begin();
        self.fill_halos();
        self.solve_phi(pending, D > 2);
        if D == 2 {
            self.finish(pending);
        } else {
            let Self { grid, state, phi, .. } = self;
            for_rows(grid, &mut state.pressure, phi, |_, p, phi| {
                p.iter_mut().zip(&*phi).for_each(|(p, phi)| *p += phi);
            });
            self.correct(pending.weight);
        }
        fill_scalar(&self.grid, &mut self.state.pressure);
        self.timings.add(Part::Projection, begin);
    }

    /// `phi` ← solution of ∇²φ = ∇·u / weight; `pressure` −= correction ∇·u where asked.
    fn solve_phi(&mut self, pending: Pending, carry: bool) {
        let inverse = 1.0 / pending.weight;
        let correction = if carry { pending.correction } else { 0.0 };
        let Self { grid, state, projection, rhs, phi, .. } = self;
        let State { velocity, pressure, .. } = state;
        let rhs = &mut rhs[0];
        for_rows(grid, rhs, pressure, |row, rhs, p| {
            dispatch(DivergenceRow { projection, grid, velocity, row, correction, inverse, rhs, p });
        });
        let begin = Work::begin();
        self.pressure_solver.solve(grid, 0.0, -1.0, rhs, phi, Write::Set);
        self.timings.add(Part::Pressure, begin);
        fill_scalar(&self.grid, &mut self.phi);
    }

    /// `velocity` −= weight ∇φ, `pressure` += φ − correction ∇·u* in one pass on two axes; with
    /// ∇·u* = weight ∇²φ the old velocity is not needed for it.
    fn finish(&mut self, pending: Pending) {
        let Self { grid, state, projection, phi, .. } = self;
        let weights = [pending.weight, pending.correction * pending.weight];
        let State { velocity, pressure, .. } = state;
        let [u, w, ..] = velocity.as_mut_slice() else { return };
        for_row_triples(grid, [u, w, pressure], |row, fields| {
            dispatch(FinishRow { projection, grid, weights, phi, row, fields });
        });
        self.fill_halos();
    }

    /// `velocity` −= weight ∇φ.
    fn correct(&mut self, weight: f64) {
        let Self { grid, state, projection, rhs, phi, .. } = self;
        for (d, (u, rhs)) in state.velocity.iter_mut().zip(rhs).enumerate() {
            for_rows(grid, u, rhs, |row, u, _| {
                dispatch(CorrectRow { projection, grid, d, weight, phi, row, u });
            });
        }
        self.fill_halos();
    }

    /// Refreshes halo and wall faces of the velocity.
    pub fn fill_halos(&mut self) {
        for (d, u) in self.state.velocity.iter_mut().enumerate() {
            fill_velocity(&self.grid, d, u);
        }
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// Choices of the run.
    pub fn options(&self) -> &Options<D> {
        &self.options
    }

    /// Sets the uniform body force of the steps to come, m/s².
    pub fn set_body_force(&mut self, force: [f64; D]) {
        self.options.body_force = force;
    }

    /// Sets the velocity of a no-slip wall, m/s, from now on (an impulsive change).
    ///
    /// # Errors
    /// If the velocity has a component along the wall's normal.
    pub fn set_wall_velocity(
        &mut self,
        axis: usize,
        side: usize,
        velocity: [f64; D],
    ) -> Result<(), GridError> {
        if velocity[axis] != 0.0 {
            let velocity = velocity[axis];
            return Err(GridError::NormalVelocity { axis, side, velocity });
        }
        if let Boundary::NoSlip { velocity: wall } = &mut self.grid.boundaries[axis][side] {
            *wall = velocity;
        }
        Ok(())
    }

    /// Everything that decides the next step.
    pub fn state(&self) -> &State<D> {
        &self.state
    }

    /// The same, to be changed: velocity by direct forcing, initial conditions.
    pub fn state_mut(&mut self) -> &mut State<D> {
        &mut self.state
    }

    /// Puts a saved state back (same grid); a step that was begun is forgotten.
    pub fn restore(&mut self, state: &State<D>) {
        self.state.clone_from(state);
        self.pending = None;
    }

    /// Time spent in each part so far.
    pub fn timings(&self) -> &Timings {
        &self.timings
    }

    /// Forgets the time spent.
    pub fn reset_timings(&mut self) {
        self.timings = Timings::default();
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

/// One row of `p −= correction ∇·u`, `rhs = inverse ∇·u`.
struct DivergenceRow<'a, const D: usize> {
    projection: &'a Projection<D>,
    grid: &'a Grid<D>,
    velocity: &'a [Vec<f64>; D],
    row: usize,
    correction: f64,
    inverse: f64,
    rhs: &'a mut [f64],
    p: &'a mut [f64],
}

impl<const D: usize> Kernel for DivergenceRow<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.projection.divergence_row(self.grid, self.velocity, self.row, self.rhs);
        if self.correction != 0.0 {
            for (r, p) in self.rhs.iter().zip(self.p) {
                *p -= self.correction * *r;
            }
        }
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
