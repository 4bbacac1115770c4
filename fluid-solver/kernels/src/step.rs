//! The time step: predict, diffuse, project, correct.
//!
//! One stage of length `2 α dt` (see [`crate::scheme`]):
//! ```text
//! (1 − α ν dt ∇²)(u* − u) = dt (γ N + ζ N_old) + 2 α dt (f − ∇p + ν ∇²u)
//! ∇²φ = ∇·u* / (2 α dt),   u ← u* − 2 α dt ∇φ,   p ← p + φ − ½ ν ∇·u*
//! ```
//! The pressure gradient stands in the predictor (van Kan 1986) and the last term makes it second
//! order with implicit viscosity (Kim & Moin 1985; Brown, Cortez & Minion 2001). Solving for the
//! increment keeps a steady state steady to round-off and makes every wall condition homogeneous.
//!
//! The parts are those of an `Engine`, one for two axes and one for space. What a stage leaves out
//! because another part does it is planned beforehand (`stages`).

use crate::drive::Drive;
use crate::engine::Engine;
use crate::engines::HasEngine;
use crate::field::State;
use crate::flow::Flow;
use crate::flow_rate::FlowRate;
use crate::grid::Grid;
use crate::near_convection::NearConvection;
use crate::scheme::{Options, Viscous};
use crate::stages::{LastProjection, PressureUpdate, StepPlan, Sweeps};
use bedload_over_time::OverTime;

/// The incompressible Navier–Stokes equations on one grid, advanced in time.
pub struct Stepper<const D: usize> {
    flow: Flow<D>,
    engine: Box<dyn Engine<D>>,
    flow_rate: Option<FlowRate<D>>,
    /// What changes over time, where anything does.
    drive: Option<Box<Drive>>,
    /// The projection that the caller still has to ask for.
    left: Option<PressureUpdate>,
    broken: bool,
}

impl<const D: usize> Stepper<D> {
    /// Fluid at rest on `grid`. Working memory is sized for the current rayon pool.
    pub fn new(grid: Grid<D>, options: Options<D>) -> Self
    where
        Grid<D>: HasEngine<D>,
    {
        let engine = grid.engine(&options);
        let flow = Flow { state: State::at_rest(&grid), near: None, grid, options };
        Self { flow, engine, flow_rate: None, drive: None, left: None, broken: false }
    }

    /// One full time step of length `dt` (s), ending in a divergence-free velocity.
    ///
    /// `force`: body force per unit mass at the nodes of each component (m/s², field layout),
    /// constant over the step, added in full in every stage. It need not be divergence-free, nor
    /// need the velocity be so on entry.
    pub fn step(&mut self, dt: f64, force: Option<&[Vec<f64>; D]>) {
        self.stages(dt, force, LastProjection::Planned);
    }

    /// The step up to its last projection: the caller may change the velocity (direct forcing)
    /// and must then call [`Stepper::project`].
    pub fn advance_without_projection(&mut self, dt: f64, force: Option<&[Vec<f64>; D]>) {
        self.engine.keep_pressure_gradient(&self.flow);
        self.stages(dt, force, LastProjection::LeftToCaller);
    }

    /// All stages of one step.
    fn stages(&mut self, dt: f64, force: Option<&[Vec<f64>; D]>, end: LastProjection) {
        debug_assert!(dt > 0.0 && dt.is_finite(), "the time step must be positive");
        let sweeps = self.sweeps();
        let Self { flow, engine, flow_rate, drive, left, broken } = self;
        let plan =
            StepPlan::new(&flow.options, [dt, flow.state.previous_dt], sweeps, flow.near.is_some(), end);
        let implicit = flow.options.viscous == Viscous::Implicit;
        let nu = if implicit { flow.options.viscosity } else { 0.0 };
        (*left, *broken) = (plan.left, false);
        flow_rate.iter_mut().for_each(FlowRate::begin);
        let mut time = flow.state.time;
        if let Some(drive) = drive {
            drive.move_walls(&mut flow.grid, time);
            flow.fill_halos();
        }
        for stage in plan.stages() {
            let start = time;
            time += stage.length();
            if stage.fills_halos {
                flow.fill_halos();
            }
            if let Some(drive) = drive {
                drive.enter(flow, time);
            }
            flow.convect_outflow(stage.length());
            if stage.refreshes_near {
                flow.refresh_near();
            }
            if let Some(drive) = drive {
                drive.act(flow, start, time);
                if !engine.fuses() {
                    flow.fill_halos();
                }
            }
            engine.predict(flow, stage, force);
            engine.diffuse(flow, stage);
            if let Some(drive) = drive {
                drive.move_walls(&mut flow.grid, time);
            }
            if let Some(rate) = flow_rate {
                let velocity = &mut flow.state.velocity;
                rate.correct(&flow.grid, stage.number, (stage.diffusion(nu), time), velocity);
            }
            let Some(update) = stage.projection else { continue };
            *broken = !engine.project(flow, update, stage.fuses_divergence);
            if *broken {
                return;
            }
            if !stage.defers_correction {
                engine.correct(flow, update);
            }
        }
        flow_rate.iter_mut().for_each(|rate| rate.end(dt));
        flow.state.previous_dt = dt;
        flow.state.time += dt;
        flow.state.steps += 1;
    }

    /// What may go in one sweep. Outflow and a prescribed flow rate look at the velocity of every
    /// stage: then no two stages share a sweep.
    fn sweeps(&self) -> Sweeps {
        match (self.engine.fuses(), self.flow.is_open() || self.flow_rate.is_some()) {
            (false, _) => Sweeps::Apart,
            (true, true) => Sweeps::ApartFilled,
            (true, false) => Sweeps::Fused,
        }
    }

    /// Ends a step begun by [`Stepper::advance_without_projection`]: projects, updates the pressure.
    /// Does nothing if no step has been begun.
    pub fn project(&mut self) {
        let Some(update) = self.left.take() else { return };
        if self.broken {
            return;
        }
        self.broken = !self.engine.project(&mut self.flow, update, false);
        if !self.broken {
            self.engine.correct(&mut self.flow, update);
        }
    }

    /// Time over which the projection that was left to the caller acts, s: of the last stage.
    pub fn projection_left(&self) -> f64 {
        self.left.map_or(0.0, |update| update.duration)
    }

    /// Makes the velocity divergence-free without touching the pressure (initial conditions).
    pub fn project_velocity(&mut self) {
        let State { open, velocity, .. } = &mut self.flow.state;
        open.follow(&self.flow.grid, velocity);
        self.fill_halos();
        self.engine.project_velocity(&mut self.flow);
        self.fill_halos();
    }

    /// Makes a change of velocity divergence-free: nothing of it passes through a face of the box that is not
    /// periodic, open ones included.
    pub fn project_other(&mut self, change: &mut [Vec<f64>; D]) {
        let open = std::mem::take(&mut self.flow.state.open);
        std::mem::swap(&mut self.flow.state.velocity, change);
        self.project_velocity();
        std::mem::swap(&mut self.flow.state.velocity, change);
        self.flow.state.open = open;
    }

    /// Refreshes halo and wall faces of the velocity.
    pub fn fill_halos(&mut self) {
        self.flow.fill_halos();
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.flow.grid
    }

    /// Choices of the run.
    pub fn options(&self) -> &Options<D> {
        &self.flow.options
    }

    /// Sets the uniform body force of the steps to come, m/s².
    pub fn set_body_force(&mut self, force: [f64; D]) {
        self.flow.options.body_force = force;
    }

    /// Moves walls, and drives the fluid, as functions of the time of the state, from now on.
    pub fn set_drive(&mut self, drive: Drive) {
        self.drive = (!drive.is_empty()).then(|| Box::new(drive));
        self.move_walls();
    }

    /// Gives walls that change the velocity that they have at the time of the state.
    fn move_walls(&mut self) {
        if let Some(drive) = &self.drive {
            drive.move_walls(&mut self.flow.grid, self.flow.state.time);
        }
    }

    /// Prescribes the mean velocity (m/s) along `axis`, which is periodic, from now on.
    pub fn prescribe_flow_rate(&mut self, axis: usize, mean: impl Into<OverTime<f64>>) {
        let (stages, implicit) =
            (self.flow.options.scheme.stages(), self.flow.options.viscous == Viscous::Implicit);
        self.flow_rate = Some(FlowRate::new(&self.flow.grid, axis, mean.into(), stages, implicit));
    }

    /// Refines convection near spheres (discs on two axes), given by centre (laboratory axes, m) and radius,
    /// in the steps to come: see [`crate::near_convection`].
    pub fn refine_near(&mut self, spheres: impl Iterator<Item = ([f64; 3], f64)> + Clone) {
        let Flow { grid, options, near, .. } = &mut self.flow;
        let near = near.get_or_insert_with(|| Box::new(NearConvection::new(grid, options.viscosity)));
        near.set(grid, spheres);
    }

    /// The prescribed flow rate, if any.
    pub fn flow_rate(&self) -> Option<&FlowRate<D>> {
        self.flow_rate.as_ref()
    }

    /// Everything that decides the next step.
    pub fn state(&self) -> &State<D> {
        &self.flow.state
    }

    /// The same, to be changed: velocity by direct forcing, initial conditions.
    pub fn state_mut(&mut self) -> &mut State<D> {
        &mut self.flow.state
    }

    /// The grid and the state, to be changed.
    pub fn parts_mut(&mut self) -> (&Grid<D>, &mut State<D>) {
        (&self.flow.grid, &mut self.flow.state)
    }

    /// Whether the last step stopped at a projection whose solution is not finite. The velocity is
    /// then the prediction as that projection was given it, before one bad cell spoils all.
    pub fn is_broken(&self) -> bool {
        self.broken
    }

    /// Treats viscosity in another way from now on. The convection of the last step must be of that kind.
    pub fn treat_viscosity(&mut self, viscous: Viscous)
    where
        Grid<D>: HasEngine<D>,
    {
        if self.flow.options.viscous != viscous {
            self.flow.options.viscous = viscous;
            self.engine = self.flow.grid.engine(&self.flow.options);
        }
    }

    /// Goes on from the present fields; a step that was begun is forgotten.
    pub fn restart(&mut self, time: f64, previous_dt: f64, steps: u64) {
        (self.flow.state.time, self.flow.state.previous_dt, self.flow.state.steps) =
            (time, previous_dt, steps);
        (self.left, self.broken) = (None, false);
        self.move_walls();
    }
}
