//! The fluid with its grains: one window of time, in the order of docs/equations-immersed.md, section 3.
//!
//! What a step of the order means is for the method of the immersed boundary to say ([`crate::methods`]).

use crate::build;
use crate::config::FluidSection;
use crate::coupling;
use crate::engines::HasEngine;
use crate::field::{copy_own, gather_to_first, own_planes};
use crate::first_non_finite::FirstNonFinite;
use crate::grain_forces::GrainForces;
use crate::grid::Grid;
use crate::halo::fill_velocity;
use crate::health::Health;
use crate::immersed::Immersed;
use crate::immersed::body::Motion;
use crate::immersed::mask_model::{Mask, MaskModel};
use crate::initial::{self, Start};
use crate::methods;
use crate::methods::beyond::Beyond;
use crate::methods::calibrated::calibration::Calibration;
use crate::methods::grains::{Grains, Memory, drive};
use crate::methods::immersed_boundary::{ImmersedBoundary, OnWalls};
use crate::plan::{self, Plan};
use crate::ranks::Ranks;
use crate::scheme::Viscous;
use crate::step::Stepper;
use crate::work::Work;
use bedload_scene::{CheckedScene, Medium, OverTime, SceneError};
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, SolverError, Window, WindowReport};

/// Everything that decides the next window, as [`Solver::restart`] takes it.
#[derive(Default)]
struct Saved {
    /// Those of [`Solver::fields`].
    fields: Vec<Vec<f64>>,
    /// Time, length of the step before, s, and number of steps.
    times: (f64, f64, u64),
    memory: Memory,
}

/// The exchange of a fluid.
pub type FluidExchange<'a> = dyn Exchange<Kinematics, Loads> + 'a;

/// A fluid with its grains on `D` axes.
pub struct Solver<const D: usize> {
    stepper: Stepper<D>,
    method: Box<dyn ImmersedBoundary<D>>,
    pub(crate) grains: Grains<D>,
    plan: Plan,
    saved: Option<Box<Saved>>,
    beyond: Beyond,
    /// Gravity, m/s².
    gravity: OverTime<[f64; 3]>,
    /// What a step must resolve of what the scene changes over time.
    changes: Vec<plan::Change>,
    /// Density of the fluid, kg/m³.
    density: f64,
    /// Largest Σ|u|/Δx after the last window, 1/s; zero: not known.
    rate: f64,
    /// Largest one that there was, 1/s.
    largest_rate: f64,
    seconds: f64,
    /// Forces on grains, where stresses are asked for.
    pub(crate) kept: Option<Box<GrainForces>>,
}

/// Velocity over ν/Δx up to which a fluid counts as at rest.
const AT_REST: f64 = 1e-10;

impl<const D: usize> Solver<D> {
    /// Builds grid, fields and grains of a scene.
    ///
    /// # Errors
    /// With the key of whatever the fluid cannot do.
    ///
    /// ```
    /// use fluid_solver::solver::Solver;
    /// use bedload_scene::{CheckedScene, SceneSource};
    ///
    /// let text = r#"
    /// until = 1.0
    /// [domain]
    /// geometry = "plane"
    /// lower = [0.0, 0.0]
    /// upper = [2.0, 1.0]
    /// cells = [32, 16]
    /// boundary = { x = "periodic", z = "no-slip" }
    /// [medium]
    /// density = 1000.0
    /// viscosity = 0.001
    /// [[grains]]
    /// position = [1.0, 0.0, 0.5]
    /// radius = 0.2
    /// density = 2500.0
    /// "#;
    /// let scene = CheckedScene::new(SceneSource { file: "disc.toml".into(), text: text.into() })?;
    /// let solver = Solver::<2>::new(&scene)?;
    /// assert_eq!(solver.grid().cell_count(), 512);
    /// assert_eq!(solver.motions().len(), 1);
    /// # Ok::<(), bedload_scene::SceneError>(())
    /// ```
    pub fn new(scene: &CheckedScene) -> Result<Self, SceneError>
    where
        Grid<D>: HasEngine<D>,
    {
        Self::with_ranks(scene, &Ranks::of_process(), Calibration::default())
    }

    /// The part of the fluid that one of `ranks` works on, with the parts of the calibrated method that
    /// `calibration` says. All ranks must be asked to do the same things in the same order.
    ///
    /// # Errors
    /// As [`Solver::new`], and with the key of whatever several ranks cannot do.
    pub fn with_ranks(
        scene: &CheckedScene,
        ranks: &Ranks,
        calibration: Calibration,
    ) -> Result<Self, SceneError>
    where
        Grid<D>: HasEngine<D>,
    {
        let choices = FluidSection::read(scene)?.choices(calibration);
        let medium: &Medium = scene.scene.medium.as_ref().expect("FluidSection::read demands a medium");
        let (scheme, _) = coupling::read(scene, choices.method)?;
        let grid = build::divided::<D>(scene, &choices, ranks)?;
        let start = initial::read(scene, &choices, &grid);
        // All ranks must agree on the error, or the others wait for ever.
        if !ranks.all(start.is_ok()) && start.is_ok() {
            return Err(scene.source.error(
                "medium.initial.folder",
                "cannot be read by another rank",
                "see that all ranks find the folder",
            ));
        }
        let start = start?;
        let plan = Plan::new(scene, medium, &choices, &grid, start.as_ref())?;
        let (method, grains) = methods::build(scene, medium, &choices, scheme, &grid, plan.first);
        let mut solver = Self {
            stepper: Stepper::new(grid, build::options(scene, medium, &choices, plan.viscous)),
            method,
            grains,
            plan,
            saved: None,
            beyond: Beyond::new(scene),
            gravity: scene.scene.gravity.clone(),
            changes: plan::changes(scene),
            density: medium.density,
            rate: 0.0,
            largest_rate: 0.0,
            seconds: 0.0,
            kept: None,
        };
        if let Some(flow) = &medium.flow_rate {
            let axes = scene.scene.domain.geometry.axes();
            let axis = axes.iter().position(|axis| *axis == flow.axis).expect("the scene's axis was checked");
            solver.stepper.prescribe_flow_rate(axis, flow.mean_velocity.clone());
        }
        solver.stepper.set_drive(build::drive_over_time(scene, medium));
        solver.begin(scene, start.as_ref());
        Ok(solver)
    }

    /// Initial velocity: the scene's, or the last of the run `start`, with the grains' own inside them, made
    /// divergence-free. Where that run goes on, its state as it is.
    fn begin(&mut self, scene: &CheckedScene, start: Option<&Start<D>>) {
        let grid = self.stepper.grid().clone();
        let viscous = self.stepper.options().viscous;
        let entered = self.stepper.state().open.clone();
        let taken = start.and_then(|start| start.take(&grid, viscous, self.fields_mut()));
        if let Some((previous_dt, memory)) = taken {
            self.stepper.state_mut().open.enter_as(&grid, &entered);
            return self.restart((0.0, previous_dt, 0), memory);
        }
        match start {
            Some(start) => start.interpolate(&grid, self.stepper.state_mut()),
            None => build::set_initial(scene, &grid, self.stepper.state_mut()),
        }
        let Grains { immersed, model, memory, .. } = &mut self.grains;
        let sharp = MaskModel { mask: Mask::Izard2014, ..*model };
        immersed.impose_direct((&grid, &sharp, &memory.motions), &mut self.stepper.state_mut().velocity);
        self.stepper.project_velocity();
        if let Some(start) = start {
            self.carry_over(start);
        }
    }

    /// From another grid: the force where the grains hold it, and their last acceleration.
    fn carry_over(&mut self, start: &Start<D>) {
        let Self { stepper, method, grains, .. } = self;
        if let Some(memory) = start.memory() {
            grains.memory.before.clone_from(&memory.before);
            grains.memory.before_dt = memory.before_dt;
            grains.memory.drive = memory.drive;
            grains.memory.jumps.clone_from(&memory.jumps);
            grains.memory.taken.clone_from(&memory.taken);
        }
        if start.interpolate_force(stepper.grid(), &mut grains.force) {
            grains.memory.imposed_dt = grains.model.dt;
        }
        method.resume(stepper, grains);
        if grains.memory.imposed_dt > 0.0 {
            grains.clear_free_force(stepper.grid());
        }
    }

    /// Does one window: place, step, measure, exchange, impose.
    ///
    /// # Errors
    /// If the velocity or the grains' motion is not finite, or the exchange fails.
    pub fn advance(
        &mut self,
        window: &Window,
        exchange: &mut FluidExchange<'_>,
    ) -> Result<WindowReport, SolverError> {
        if !(window.dt > 0.0 && window.dt.is_finite()) {
            return Err(SolverError::Failed(format!(
                "window {} has the length {}: a window must last longer than 0 s",
                window.step, window.dt
            )));
        }
        let outcome = self.window(window, exchange);
        // A rank that is gone is the cause of whatever else went wrong.
        self.grid().division.ranks().check()?;
        let health = outcome?;
        let time = self.stepper.state().time;
        let plan = self.plan.until_change(&self.changes, time);
        let Memory { motions, before, .. } = &self.grains.memory;
        let allowed = plan.allowed(health.rate, motions, before);
        let part = self.method.part_of_step(&self.grains, allowed, plan.spacing);
        let dt_limit = plan.next(window.dt, time, allowed, part);
        Ok(WindowReport { dt_limit, residual: health.divergence, substeps: 0 })
    }

    fn window(&mut self, window: &Window, exchange: &mut FluidExchange<'_>) -> Result<Health, SolverError> {
        let work = Work::begin();
        self.grains.model.dt = window.dt;
        self.grains.gravity = self.gravity.mean(window.time, window.time + window.dt);
        self.method.place(&self.stepper, &mut self.grains, window);
        self.method.step(&mut self.stepper, &mut self.grains, window.dt);
        let health = self.health(window)?;
        self.method.measure(&mut self.stepper, &mut self.grains, window.dt);
        self.seconds += work.seconds();
        self.exchange(window, exchange)?;
        let work = Work::begin();
        self.method.impose(&mut self.stepper, &mut self.grains, window.dt);
        self.seconds += work.seconds();
        Ok(health)
    }

    /// Sends the loads and takes over the motion that comes back.
    fn exchange(&mut self, window: &Window, exchange: &mut FluidExchange<'_>) -> Result<(), SolverError> {
        let Self { stepper, method, grains, beyond, kept, density, .. } = self;
        exchange.send(window.header(), &mut |out| {
            method.loads(grains, out);
            beyond.replace(grains, out);
            let masses = grains.immersed.shapes().iter().map(|shape| *density * shape.volume);
            kept.iter_mut().for_each(|kept| kept.keep_loads(grains.gravity, masses.clone(), out));
        })?;
        let memory = &mut grains.memory;
        std::mem::swap(&mut memory.before, &mut memory.motions);
        memory.before_dt = window.dt;
        memory.drive = drive(stepper);
        let geometry = stepper.grid().geometry;
        let mut count = 0;
        exchange.receive(window, &mut |_, records| {
            count = records.len();
            kept.iter_mut().for_each(|kept| kept.keep_kinematics(records));
            for (motion, record) in memory.motions.iter_mut().zip(records) {
                *motion = Motion::received(geometry, record);
            }
        })?;
        if count != memory.motions.len() {
            return Err(SolverError::Failed(format!(
                "window {}: kinematics of {count} grains came, the scene has {}",
                window.step,
                memory.motions.len()
            )));
        }
        match memory.motions.iter().position(|motion| !motion.is_finite()) {
            None => Ok(()),
            Some(grain) => Err(SolverError::Failed(format!(
                "window {}: the DEM sent a motion of grain {grain} that is not finite, which the fluid cannot take: \
                 see its forces, or its step",
                window.step
            ))),
        }
    }

    /// Mean force over density on the walls of the box in the last window that pressure and friction do not
    /// have, by axis, side and component, m⁴/s² (plane: m³/s²).
    pub(crate) fn beyond_stress(&self) -> Option<OnWalls<D>> {
        self.method.force_on_walls(self.grid(), self.grains.memory.before_dt)
    }

    /// p/ρ of the last window, m²/s².
    pub(crate) fn pressure(&self) -> &[f64] {
        self.method.mean_pressure().unwrap_or(&self.stepper.state().pressure)
    }

    /// How fast the fluid still goes through a grain, m/s, and through which: see [`ImmersedBoundary::leak`].
    /// Nothing where that is round-off of a fluid at rest.
    pub(crate) fn leak(&self) -> Option<(f64, usize)> {
        let least = AT_REST * self.stepper.options().viscosity / self.plan.spacing;
        self.method.leak(&self.grains).filter(|(leak, _)| *leak > least)
    }

    /// How many times faster than now the flow was in the fastest window so far.
    pub(crate) fn peak_over_now(&self) -> f64 {
        if self.rate > 0.0 { self.largest_rate / self.rate } else { 1.0 }
    }

    /// Largest Σ|u|/Δx after the last window times the smallest Δx, m/s.
    pub fn fastest(&self) -> f64 {
        self.rate * self.plan.spacing
    }

    fn health(&mut self, window: &Window) -> Result<Health, SolverError> {
        let (grid, velocity) = (self.stepper.grid(), &self.stepper.state().velocity);
        let health = Health::of(grid, velocity);
        if health.finite && !self.stepper.is_broken() {
            self.rate = health.rate;
            self.largest_rate = self.largest_rate.max(health.rate);
            return Ok(health);
        }
        let found = FirstNonFinite::find(&self.stepper, self.grains.force());
        let found = found.of_all(grid.division.ranks());
        let before = match self.rate * window.dt {
            courant if courant > 0.0 => format!(" (dt Σ|u|/Δx was {courant:.2e} before it)"),
            _ => String::new(),
        };
        Err(SolverError::Failed(format!(
            "the velocity is not finite in window {}, t = {} s, dt = {} s{before}: {found}; the step is \
             too long or the coupling unstable: lower fluid.time.cfl or dt, or run `bedload check`",
            window.step, window.time, window.dt
        )))
    }

    /// Keeps everything that decides the next window.
    pub fn save(&mut self) {
        let mut saved = self.saved.take().unwrap_or_default();
        let (own, whole, fields) = (own_planes(self.grid()), self.grid().len(), self.fields());
        if saved.fields.is_empty() {
            saved.fields = fields.iter().map(|field| vec![0.0; field.len()]).collect();
        }
        for (to, from) in saved.fields.iter_mut().zip(fields) {
            copy_own(&own, whole, to, from);
        }
        let state = self.stepper.state();
        saved.times = (state.time, state.previous_dt, state.steps);
        saved.memory.clone_from(&self.grains.memory);
        self.saved = Some(saved);
    }

    /// Goes back to the last [`Solver::save`]; without one, stays.
    pub fn restore(&mut self) {
        let Some(saved) = self.saved.take() else { return };
        let (own, whole) = (own_planes(self.grid()), self.grid().len());
        for (to, from) in self.fields_mut().into_iter().zip(&saved.fields) {
            copy_own(&own, whole, to, from);
        }
        self.restart(saved.times, saved.memory.clone());
        self.saved = Some(saved);
    }

    /// All fields that decide the next window: velocity, history, force (one per axis each), pressure,
    /// the velocity on each open face, and the force at the points of bodies.
    pub(crate) fn fields(&self) -> Vec<&[f64]> {
        let state = self.stepper.state();
        let fields = state.velocity.iter().chain(&state.history).chain(&self.grains.force);
        let points = self.method.points().into_iter().flatten();
        let fields = fields.chain([&state.pressure]).chain(state.open.fields()).chain(points);
        fields.map(Vec::as_slice).collect()
    }

    /// The same, to be set before [`Solver::restart`].
    pub(crate) fn fields_mut(&mut self) -> Vec<&mut [f64]> {
        let state = self.stepper.state_mut();
        let fields = state.velocity.iter_mut().chain(&mut state.history).chain(&mut self.grains.force);
        let points = self.method.points_mut().into_iter().flatten();
        let fields = fields.chain([&mut state.pressure]).chain(state.open.fields_mut()).chain(points);
        fields.map(Vec::as_mut_slice).collect()
    }

    /// Halos of the velocity for output of the whole field: velocity and pressure of all ranks come to the
    /// first rank, which alone has them then. All ranks must call it; says whether this rank writes.
    pub fn show(&mut self) -> bool {
        if self.grid().division.ranks().is_alone() {
            self.stepper.fill_halos();
            return true;
        }
        let (grid, state) = self.stepper.parts_mut();
        let shown = gather_to_first(grid, state.velocity.iter_mut().chain([&mut state.pressure]));
        if shown {
            let whole = grid.undivided();
            for (d, u) in state.velocity.iter_mut().enumerate() {
                fill_velocity(&whole, d, u);
            }
        }
        shown
    }

    /// Keeps the forces on grains from now on.
    pub(crate) fn keep_forces(&mut self) {
        self.kept = Some(Box::new(GrainForces::new(self.grains.memory.motions.len())));
    }

    /// The carried force as the first rank needs it for stresses, where several ranks have it. All must call
    /// it.
    pub(crate) fn gather_force(&self) -> Option<[Vec<f64>; D]> {
        let grid = self.grid();
        self.kept.as_ref().filter(|_| !grid.division.ranks().is_alone())?;
        let mut force = self.grains.force()?.clone();
        gather_to_first(grid, force.iter_mut());
        Some(force)
    }

    /// Treats viscosity as the run has done that goes on: the speeds that are expected up to a later end may
    /// ask for another treatment.
    pub(crate) fn treat_viscosity(&mut self, viscous: Viscous)
    where
        Grid<D>: HasEngine<D>,
    {
        self.stepper.treat_viscosity(viscous);
        self.plan.viscous = viscous;
    }

    /// Goes on from the present fields: time, the step before and the number of steps, and the rest.
    pub(crate) fn restart(&mut self, (time, previous_dt, steps): (f64, f64, u64), memory: Memory) {
        self.stepper.restart(time, previous_dt, steps);
        self.grains.memory = memory;
        self.method.resume(&self.stepper, &mut self.grains);
    }

    /// The stepper: grid, state, options.
    pub fn stepper(&self) -> &Stepper<D> {
        &self.stepper
    }

    /// The stepper, to be changed (halos before output, say).
    pub fn stepper_mut(&mut self) -> &mut Stepper<D> {
        &mut self.stepper
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        self.stepper.grid()
    }

    /// Motion of the grains now.
    pub fn motions(&self) -> &[Motion] {
        &self.grains.memory.motions
    }

    /// Shapes and places of the grains.
    pub fn immersed(&self) -> &Immersed<D> {
        &self.grains.immersed
    }

    /// The mask with the present dt.
    pub fn mask_model(&self) -> &MaskModel {
        &self.grains.model
    }

    /// Bounds on the time step.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Density of the fluid, kg/m³.
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Mean pressure gradient that held the flow rate in the last window, Pa/m; 0 without one.
    pub fn pressure_gradient(&self) -> f64 {
        let flow = self.stepper.flow_rate();
        flow.map_or(0.0, |flow| -self.density * flow.acceleration())
    }

    /// CPU seconds of solver work so far, over all threads, without the exchange.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }
}
