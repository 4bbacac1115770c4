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
//!
//! On two axes the stage goes term by term (`step/flat.rs`), in space plane by plane
//! (`space/mod.rs`), where a pressure gradient that the projection undoes is left out.

mod flat;

use crate::boundary::{
    Boundary, fill_scalar_across, fill_velocity, fill_velocity_across, fill_velocity_and_open,
};
use crate::field::State;
use crate::flow_rate::FlowRate;
use crate::grid::{Grid, GridError};
use crate::scheme::{Scheme, Viscous};
use crate::space::{SpaceStep, StageTask};
use crate::timings::{Part, Timings};
use crate::work::Work;
use flat::FlatStep;

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
pub(crate) struct Pending {
    /// Time over which φ acts, s.
    pub(crate) weight: f64,
    /// What multiplies ∇·u* in the pressure, m²/s.
    pub(crate) correction: f64,
}

/// How far the pending projection is.
#[derive(Clone, Copy, Debug)]
enum Stand {
    /// There is none.
    Done,
    /// The velocity is predicted.
    Predicted(Pending),
    /// φ is solved for (in space).
    Solved(Pending),
}

/// Operators, solvers and working memory.
enum Engine<const D: usize> {
    Flat(Box<FlatStep<D>>),
    Space(Box<SpaceStep>),
}

/// The incompressible Navier–Stokes equations on one grid, advanced in time.
pub struct Stepper<const D: usize> {
    grid: Grid<D>,
    options: Options<D>,
    state: State<D>,
    engine: Engine<D>,
    stand: Stand,
    broken: bool,
    flow: Option<FlowRate<D>>,
    timings: Timings,
}

impl<const D: usize> Stepper<D> {
    /// Fluid at rest on `grid`. Working memory is sized for the current rayon pool.
    pub fn new(grid: Grid<D>, options: Options<D>) -> Self {
        let engine = if D == 3 {
            Engine::Space(Box::new(SpaceStep::new(&grid, &options)))
        } else {
            Engine::Flat(Box::new(FlatStep::new(&grid)))
        };
        Self {
            state: State::at_rest(&grid),
            engine,
            stand: Stand::Done,
            broken: false,
            flow: None,
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
        self.stages(dt, force, true);
        self.project();
    }

    /// The step up to its last projection: the caller may change the velocity (direct forcing)
    /// and must then call [`Stepper::project`].
    pub fn advance_without_projection(&mut self, dt: f64, force: Option<&[Vec<f64>; D]>) {
        if let Engine::Space(engine) = &mut self.engine {
            engine.carry_pressure(&self.grid);
        }
        self.stages(dt, force, false);
    }

    /// All stages; `whole`: nobody looks at the velocity before the projection.
    fn stages(&mut self, dt: f64, force: Option<&[Vec<f64>; D]>, whole: bool) {
        debug_assert!(dt > 0.0 && dt.is_finite(), "the time step must be positive");
        let scheme = self.options.scheme;
        let every = scheme.projects_every_stage();
        self.broken = false;
        // Outflow and a flow that is held look at the velocity of every stage: then no two stages
        // share a sweep.
        let open = !self.state.open.is_empty();
        let apart = open || self.flow.is_some();
        self.flow.iter_mut().for_each(FlowRate::begin);
        for k in 0..scheme.stages() {
            let last = k + 1 == scheme.stages();
            let stage = scheme.stage(k, dt, self.state.previous_dt);
            let share = if every { 2.0 * stage.alpha } else { 1.0 };
            let implicit = self.options.viscous == Viscous::Implicit;
            let nu = if implicit { self.options.viscosity } else { 0.0 };
            let pending = Pending { weight: share * dt, correction: nu * stage.alpha / share };
            if D == 2 && (k == 0 || !every) {
                self.fill_halos();
            }
            if every && (D == 2 || apart) {
                self.project();
                if self.broken {
                    return;
                }
            }
            if open {
                self.state.open.convect(&self.grid, &self.state.velocity, 2.0 * stage.alpha * dt);
                self.fill_halos();
            }
            let Self { grid, options, state, engine, stand, broken, flow, timings } = self;
            match engine {
                Engine::Flat(engine) => {
                    engine.stage(grid, options, state, (stage, dt), force, timings);
                    *stand = Stand::Predicted(pending);
                }
                Engine::Space(engine) => {
                    engine.refresh(grid);
                    let before = if let Stand::Solved(before) = *stand { Some(before) } else { None };
                    let after = (!apart && (every && !last || last && whole)).then_some(pending);
                    let keep = !last || scheme == Scheme::AdamsBashforth2;
                    let force = force.map(|f| std::array::from_fn(|d| f[d].as_slice()));
                    let task = StageTask { stage, dt, keep, force, before, after };
                    *broken = !engine.stage(options, state, &task, timings);
                    if *broken {
                        return;
                    }
                    *stand = if after.is_some() { Stand::Solved(pending) } else { Stand::Predicted(pending) };
                }
            }
            if let Some(flow) = flow {
                flow.hold(grid, k, nu * stage.alpha * dt, &mut state.velocity);
            }
        }
        self.flow.iter_mut().for_each(|flow| flow.end(dt));
        self.state.previous_dt = dt;
        self.state.time += dt;
        self.state.steps += 1;
    }

    /// Ends a step begun by [`Stepper::advance_without_projection`]: projects, updates the pressure.
    /// Does nothing if no step has been begun.
    pub fn project(&mut self) {
        let stand = std::mem::replace(&mut self.stand, Stand::Done);
        if self.broken {
            return;
        }
        let (Stand::Predicted(pending) | Stand::Solved(pending)) = stand else { return };
        if let (Engine::Space(_), Stand::Predicted(_)) = (&self.engine, stand) {
            self.fill_halos();
        }
        let Self { grid, state, engine, broken, timings, .. } = self;
        match engine {
            Engine::Flat(engine) => *broken = !engine.project(grid, state, pending, timings),
            Engine::Space(engine) => {
                if let Stand::Predicted(_) = stand {
                    *broken = !engine.solve(state, pending, timings);
                    if *broken {
                        return;
                    }
                }
                engine.finish(state, pending, timings);
                let begin = Work::begin();
                if !self.state.open.is_empty() {
                    self.fill_halos();
                }
                // Those along x and y are filled.
                let Self { grid, state, .. } = &mut *self;
                if state.open.is_empty() {
                    for (d, u) in state.velocity.iter_mut().enumerate() {
                        fill_velocity_across(grid, d, D - 1, u);
                    }
                }
                fill_scalar_across(grid, D - 1, &mut state.pressure);
                self.timings.add(Part::Projection, begin);
            }
        }
    }

    /// Makes the velocity divergence-free without touching the pressure (initial conditions).
    pub fn project_velocity(&mut self) {
        let State { open, velocity, .. } = &mut self.state;
        open.follow(&self.grid, velocity);
        self.fill_halos();
        let Self { grid, state, engine, timings, .. } = self;
        match engine {
            Engine::Flat(engine) => engine.project_velocity(grid, state, timings),
            Engine::Space(engine) => {
                engine.refresh(grid);
                engine.project_velocity(grid, state);
            }
        }
        self.fill_halos();
    }

    /// Refreshes halo and wall faces of the velocity.
    pub fn fill_halos(&mut self) {
        fill_all(&self.grid, &mut self.state);
    }

    /// Sets the velocity on an inflow face from a function of component and position (m), from now
    /// on: profiles that no scene can say, or that change in time.
    pub fn set_inflow(&mut self, axis: usize, side: usize, value: impl Fn(usize, [f64; D]) -> f64) {
        self.state.open.set(&self.grid, axis, side, value);
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

    /// Holds the mean velocity (m/s) along `axis`, which is periodic, from now on.
    pub fn hold_flow_rate(&mut self, axis: usize, mean: f64) {
        let (stages, implicit) = (self.options.scheme.stages(), self.options.viscous == Viscous::Implicit);
        self.flow = Some(FlowRate::new(&self.grid, axis, mean, stages, implicit));
    }

    /// The flow rate that is held, if any.
    pub fn flow_rate(&self) -> Option<&FlowRate<D>> {
        self.flow.as_ref()
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

    /// The grid and the state, to be changed.
    pub fn parts_mut(&mut self) -> (&Grid<D>, &mut State<D>) {
        (&self.grid, &mut self.state)
    }

    /// Whether the last step stopped at a projection whose solution is not finite. The velocity is
    /// then the prediction as that projection was given it, before one bad cell spoils all.
    pub fn is_broken(&self) -> bool {
        self.broken
    }

    /// Puts a saved state back (same grid); a step that was begun is forgotten.
    pub fn restore(&mut self, state: &State<D>) {
        self.state.clone_from(state);
        (self.stand, self.broken) = (Stand::Done, false);
    }

    /// Goes on from the present fields; a step that was begun is forgotten.
    pub(crate) fn restart(&mut self, time: f64, previous_dt: f64, steps: u64) {
        (self.state.time, self.state.previous_dt, self.state.steps) = (time, previous_dt, steps);
        (self.stand, self.broken) = (Stand::Done, false);
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

/// Refreshes halo, wall faces and open faces of the velocity.
fn fill_all<const D: usize>(grid: &Grid<D>, state: &mut State<D>) {
    let State { velocity, open, .. } = state;
    for (d, u) in velocity.iter_mut().enumerate() {
        if open.is_empty() {
            fill_velocity(grid, d, u);
        } else {
            fill_velocity_and_open(grid, open, d, u);
        }
    }
}
