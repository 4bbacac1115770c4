//! The fluid with its grains: one window of time.
//!
//! The steps stand in the order of docs/equations-immersed.md, section 3.

mod iterated;
mod overlapped;

use crate::attempts::Attempts;
use crate::build;
use crate::build::Transport;
use crate::config::{Choices, DisplacedMass, FluidSection, Nearness, VirtualMass};
use crate::coupling;
use crate::culprit::Culprit;
use crate::fictitious::FictitiousDomain;
use crate::field::{State, copy_own, own_planes};
use crate::gather;
use crate::grain_memory::Memory;
use crate::grid::Grid;
use crate::halo::fill_velocity;
use crate::health::Health;
use crate::immersed::body::Motion;
use crate::immersed::brinkman::{Brinkman, LAG, lag};
use crate::immersed::carried::Imposed;
use crate::immersed::mask_model::{Mask, MaskModel};
use crate::immersed::places::Places;
use crate::immersed::pores::Pores;
use crate::immersed::{Immersed, Wrench};
use crate::initial::{self, Start};
use crate::loads::{LoadsRule, Measured};
use crate::plan::Plan;
use crate::ranks::Ranks;
use crate::step::Stepper;
use crate::virtual_mass::ByGap;
use crate::work::Work;
use bedload_scene::{CheckedScene, Medium, SceneError};
use protocol::facts::{Forcing, LoadsForm};
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, SolverError, Window, WindowReport};
use protocol::scheme::Scheme;

/// Everything that decides the next window.
struct Saved<const D: usize> {
    /// Velocity, pressure, previous convection, time.
    state: State<D>,
    /// The carried force per unit mass, m/s².
    lambda: [Vec<f64>; D],
    /// The same at the points of the bodies, with the fictitious-domain method.
    multipliers: Option<[Vec<f64>; D]>,
    /// The grains.
    memory: Memory,
}

/// Part of the smallest cell width within which a grain counts as where it was expected. The mask falls by
/// about one over a cell, so this changes a cell's share by as much at most; and it never adds up, as every
/// window expects a grain from where it truly is.
const AS_EXPECTED: f64 = 1e-4;

/// What moves the carried force with the grains, instead of leaving it in its cells.
struct Advection<const D: usize> {
    /// In which steps.
    transport: Transport,
    /// Mask b of the grains where the force stands.
    masks: [Vec<f64>; D],
    /// Room for the force, all zero.
    spare: [Vec<f64>; D],
    /// What viscosity does with its change, where it is told.
    brinkman: Option<Brinkman<D>>,
    /// Longest step in which it may be told by itself, s.
    bears: f64,
}

/// The exchange of a fluid.
pub type FluidExchange<'a> = dyn Exchange<Kinematics, Loads> + 'a;

/// A fluid with its grains on `D` axes.
pub struct Solver<const D: usize> {
    stepper: Stepper<D>,
    immersed: Immersed<D>,
    fictitious: Option<Box<FictitiousDomain<D>>>,
    lambda: [Vec<f64>; D],
    advection: Option<Advection<D>>,
    pores: Option<Pores<D>>,
    memory: Memory,
    choices: Choices,
    model: MaskModel,
    rule: LoadsRule,
    by_gap: Option<ByGap>,
    plan: Plan,
    measured: Vec<Measured>,
    predicted: Vec<Motion>,
    volumes: Vec<[f64; 3]>,
    scheme: Scheme,
    /// Attempts at the window under way, where windows are repeated.
    attempts: Option<Box<Attempts<D>>>,
    saved: Option<Box<Saved<D>>>,
    /// Largest Σ|u|/Δx after the last window, 1/s; zero: not known.
    rate: f64,
    seconds: f64,
}

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
    pub fn new(scene: &CheckedScene) -> Result<Self, SceneError> {
        Self::with_ranks(scene, &Ranks::of_process())
    }

    /// The part of the fluid that one of `ranks` works on. All of them must be asked to do the same things
    /// in the same order.
    ///
    /// # Errors
    /// As [`Solver::new`], and with the key of whatever several ranks cannot do.
    pub fn with_ranks(scene: &CheckedScene, ranks: &Ranks) -> Result<Self, SceneError> {
        let choices = FluidSection::read(scene)?.choices();
        let medium: &Medium = scene.scene.medium.as_ref().expect("FluidSection::read demands a medium");
        let (scheme, iterations) = coupling::read(scene, choices.form)?;
        let grid = build::divided::<D>(scene, &choices, ranks)?;
        let start = initial::read(scene, &choices, &grid);
        // Whoever cannot read it must not leave the others to wait.
        if !ranks.all(start.is_ok()) && start.is_ok() {
            return Err(scene.source.error(
                "medium.initial.folder",
                "cannot be read by another rank",
                "see that all ranks find the folder",
            ));
        }
        let start = start?;
        let plan = Plan::new(scene, medium, &choices, &grid, start.as_ref())?;
        let shapes = build::shapes(scene);
        let grains = shapes.len();
        let rule = LoadsRule {
            form: choices.form,
            virtual_mass: choices.virtual_mass.alone(),
            gravity: scene.scene.gravity,
            density: medium.density,
            dimensions: grid.geometry.grain_dimensions(),
            displaced_mass: choices.displaced_mass == DisplacedMass::AsMass,
        };
        let free = build::free(scene);
        let by_gap = (choices.virtual_mass == VirtualMass::By(Nearness::ByGap) && free.contains(&true))
            .then(|| ByGap::new(&grid, &shapes, free));
        let model = MaskModel {
            mask: choices.mask,
            width: choices.width,
            viscosity: medium.kinematic_viscosity(),
            dt: plan.first(),
        };
        let carried = choices.method.is_carried() && grains > 0;
        let fictitious = (choices.method == Forcing::FictitiousDomain && grains > 0)
            .then(|| Box::new(FictitiousDomain::new(&grid, &shapes)));
        let transport = build::transport(scene, &choices, scheme);
        let keeps = build::keeps(scene, &choices, transport);
        let motions = build::motions(scene);
        let gyration = shapes.iter().map(|shape| shape.gyration).collect();
        let attempts = (scheme == Scheme::Iterated).then(|| Box::new(Attempts::new(iterations, gyration)));
        let corrects = grains > 0 && build::corrects_radius(scene, &choices);
        let pores = corrects.then(|| Pores::new(&grid, &shapes));
        let mut solver = Self {
            pores,
            immersed: Immersed::new(&grid, shapes, keeps),
            fictitious,
            lambda: std::array::from_fn(|_| if carried { grid.new_field() } else { Vec::new() }),
            advection: transport.map(|transport| Advection {
                transport,
                masks: grid.new_vector(),
                spare: grid.new_vector(),
                brinkman: build::tells_viscosity(&choices)
                    .then(|| Brinkman::new(&grid, choices.viscous_sweeps)),
                bears: match transport {
                    Transport::Always => f64::INFINITY,
                    Transport::WhereItLags => build::longest_local_step(scene, medium),
                },
            }),
            memory: Memory {
                imposed: motions.clone(),
                before: motions.clone(),
                contents: vec![Wrench::default(); grains],
                motions,
                ..Memory::default()
            },
            measured: vec![Measured::default(); grains],
            predicted: vec![Motion::default(); grains],
            volumes: vec![[0.0; 3]; grains],
            stepper: Stepper::new(grid, build::options(scene, medium, &choices, plan.viscous)),
            choices,
            model,
            rule,
            by_gap,
            plan,
            scheme,
            attempts,
            saved: None,
            rate: 0.0,
            seconds: 0.0,
        };
        if let Some(flow) = &medium.flow_rate {
            let axes = scene.scene.domain.geometry.axes();
            let axis = axes.iter().position(|axis| *axis == flow.axis).expect("the scene's axis was checked");
            solver.stepper.prescribe_flow_rate(axis, flow.mean_velocity);
        }
        solver.begin(scene, start.as_ref());
        Ok(solver)
    }

    /// Initial velocity: the scene's, or the last of the run `start`, with the grains' own inside them, made
    /// divergence-free. Where that run goes on, its state as it is.
    fn begin(&mut self, scene: &CheckedScene, start: Option<&Start<D>>) {
        self.set_radii();
        let grid = self.stepper.grid().clone();
        if let Some((previous_dt, memory)) = start.and_then(|start| start.take(&grid, self.fields_mut())) {
            return self.restart((0.0, previous_dt, 0), memory);
        }
        match start {
            Some(start) => start.interpolate(&grid, self.stepper.state_mut()),
            None => build::set_initial(scene, &grid, self.stepper.state_mut()),
        }
        let sharp = MaskModel { mask: Mask::Izard2014, ..self.model };
        let velocity = &mut self.stepper.state_mut().velocity;
        self.immersed.impose_direct(&grid, &sharp, &self.memory.motions, velocity);
        self.stepper.project_velocity();
        if let Some(start) = start {
            self.carry_over(start);
        }
        if self.choices.form == LoadsForm::KempeFroehlich2012 {
            let velocity = &self.stepper.state().velocity;
            let contents = self.immersed.contents(&grid, &self.model, &self.memory.motions, velocity);
            self.memory.contents.copy_from_slice(contents);
        }
        if self.scheme == Scheme::Overlapped && self.memory.kept.is_empty() {
            self.keep_first();
        }
    }

    /// From another grid: the force where the grains hold it, their last acceleration and the loads under way.
    fn carry_over(&mut self, start: &Start<D>) {
        if let Some(memory) = start.memory() {
            self.memory.before.clone_from(&memory.before);
            self.memory.before_dt = memory.before_dt;
            if self.scheme == Scheme::Overlapped {
                self.memory.kept.clone_from(&memory.kept);
            }
        }
        let Self { stepper, lambda, .. } = self;
        if start.interpolate_force(stepper.grid(), lambda) {
            self.memory.imposed_dt = self.model.dt;
        }
        self.take_hold();
        if self.memory.imposed_dt > 0.0 {
            // What lies outside of their cells nobody would take back.
            let Self { immersed, stepper, lambda, .. } = self;
            let (mut places, mut values) = (Places::default(), std::array::from_fn(|_| Vec::new()));
            places.add(stepper.grid(), immersed);
            places.gather(lambda, &mut values);
            let own = own_planes(stepper.grid());
            lambda.iter_mut().for_each(|lambda| lambda[own.clone()].fill(0.0));
            places.scatter(&values, lambda);
        }
    }

    /// Does one window, exchanging once each way.
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
        self.model.dt = window.dt;
        self.set_radii();
        let outcome = match self.scheme {
            Scheme::Explicit => self.window_explicit(window, exchange),
            Scheme::SemiImplicit => self.window_semi_implicit(window, exchange),
            Scheme::Overlapped => self.window_overlapped(window, exchange),
            Scheme::Iterated => self.window_iterated(window, exchange),
        };
        // A rank that is gone is the cause of whatever else went wrong.
        self.grid().division.ranks().check()?;
        let health = outcome?;
        Ok(WindowReport {
            dt_limit: self.plan.next(window.dt, health.rate, &self.memory.motions),
            residual: health.divergence,
            substeps: 0,
        })
    }

    /// Radii of the masks in a window that begins with the motion known now.
    fn set_radii(&mut self) {
        if let Some(pores) = &mut self.pores {
            self.immersed.set_radii(self.stepper.grid(), &self.model, pores, &self.memory.motions);
        }
    }

    /// yu-shao-2007, yu-shao-fixed-point: predict u*, send the loads, receive the motion, impose it.
    fn window_semi_implicit(
        &mut self,
        window: &Window,
        exchange: &mut FluidExchange<'_>,
    ) -> Result<Health, SolverError> {
        let work = Work::begin();
        let health = self.predict(window)?;
        self.seconds += work.seconds();
        self.exchange(window, exchange)?;
        let work = Work::begin();
        self.impose_carried();
        self.seconds += work.seconds();
        Ok(health)
    }

    /// The step with the force λ, and G of every grain where it will be.
    fn predict(&mut self, window: &Window) -> Result<Health, SolverError> {
        for (grain, (predicted, motion)) in self.predicted.iter_mut().zip(&self.memory.motions).enumerate() {
            *predicted = motion.predicted(window.dt);
            if let Some(centre) = self.attempts.as_ref().and_then(|attempts| attempts.centre(grain)) {
                predicted.centre = centre;
            }
        }
        let lag = self.lag();
        self.advect_force(lag);
        if let Some(fictitious) = &mut self.fictitious {
            fictitious.place(self.stepper.grid(), &self.predicted);
            fictitious.spread(self.stepper.grid(), &mut self.lambda);
        }
        let force = (!self.memory.motions.is_empty()).then_some(&self.lambda);
        self.stepper.step(window.dt, force);
        let health = self.health(window)?;
        self.respond(lag, window.dt);
        self.measure_impulse();
        Ok(health)
    }

    /// By how much the flow between the grains would err if the force stayed in its cells; without bound where it
    /// never is to.
    fn lag(&self) -> f64 {
        match &self.advection {
            Some(Advection { transport: Transport::Always, .. }) => f64::INFINITY,
            Some(_) => lag(self.grid(), &self.model, self.immersed.shapes(), &self.memory.motions),
            None => 0.0,
        }
    }

    /// Takes the force to where the grains will be, if it goes with them.
    fn advect_force(&mut self, lag: f64) {
        let Self { immersed, stepper, lambda, advection, memory, predicted, model, .. } = self;
        let Some(Advection { masks, spare, .. }) = advection.as_mut().filter(|_| lag >= LAG[0]) else {
            return;
        };
        immersed.advect_force(stepper.grid(), model, [&memory.motions, predicted], [lambda, masks, spare]);
    }

    /// What viscosity does with the change of the force, if it goes with the grains.
    fn respond(&mut self, lag: f64, dt: f64) {
        let Self { immersed, stepper, lambda, advection, predicted, model, .. } = self;
        let wanted = |advection: &&mut Advection<D>| lag >= LAG[1] && dt <= advection.bears;
        let Some(Advection { brinkman: Some(brinkman), .. }) = advection.as_mut().filter(wanted) else {
            return;
        };
        let (grid, state) = stepper.parts_mut();
        brinkman.respond(immersed, grid, model, predicted, [&mut state.velocity, lambda]);
    }

    /// The order of Izard et al. (2014): the whole step with the motion known, then loads and motion cross.
    fn window_explicit(
        &mut self,
        window: &Window,
        exchange: &mut FluidExchange<'_>,
    ) -> Result<Health, SolverError> {
        let work = Work::begin();
        let dt = window.dt;
        if self.choices.method == Forcing::Direct {
            self.stepper.advance_without_projection(dt, None);
            self.measure_force();
            let (grid, state) = self.stepper.parts_mut();
            self.immersed.impose_direct(grid, &self.model, &self.memory.motions, &mut state.velocity);
            self.stepper.project();
        } else {
            let force = (!self.memory.motions.is_empty()).then_some(&self.lambda);
            self.stepper.step(dt, force);
            self.measure_force();
            self.impose_carried();
        }
        let health = self.health(window)?;
        self.measure_interior(dt);
        self.seconds += work.seconds();
        self.exchange(window, exchange)?;
        Ok(health)
    }

    /// G of every grain at its predicted place, as the force −G/dt (docs/equations-immersed.md, section 4).
    fn measure_impulse(&mut self) {
        let Self { immersed, fictitious, stepper, lambda, predicted, measured, memory, .. } = self;
        if measured.is_empty() {
            return;
        }
        let (grid, velocity) = (stepper.grid(), &stepper.state().velocity);
        let by_force = self.choices.form == LoadsForm::YuShaoFixedPoint;
        let carried = by_force.then_some(&*lambda);
        let forces = match fictitious {
            Some(fictitious) => fictitious.forces(grid, predicted, self.model.dt, velocity),
            None => immersed.forces(grid, &self.model, predicted, velocity, carried),
        };
        for (m, force) in measured.iter_mut().zip(forces) {
            m.force = *force;
        }
        let counts = self.choices.displaced_mass != DisplacedMass::Neglected;
        if counts {
            immersed.volumes(grid.geometry, &mut self.volumes);
        }
        if !by_force && memory.imposed_dt > 0.0 {
            let before = MaskModel { dt: memory.imposed_dt, ..self.model };
            for (m, carried) in
                measured.iter_mut().zip(immersed.carried(grid, &before, &memory.imposed, lambda))
            {
                for c in 0..3 {
                    m.force.force[c] += carried.force[c];
                    m.force.torque[c] += carried.torque[c];
                }
            }
        }
        for (grain, m) in measured.iter_mut().enumerate() {
            m.acceleration = memory.acceleration(grain);
            m.drive = memory.first_drive(stepper);
            m.starts = memory.before_dt == 0.0 && m.drive == [0.0; 3];
            m.volume = counts.then(|| self.volumes[grain]);
        }
    }

    /// What walls and neighbours add to the virtual mass in a window that begins with the motion known now, and
    /// what they added in the one before; in repeated windows each attempt's own virtual mass cancels.
    fn measure_virtual_mass(&mut self) {
        let Self { by_gap: Some(by_gap), immersed, memory, measured, rule, model, .. } = self else { return };
        let near = by_gap.excess(immersed.shapes(), rule.density, &memory.motions, model.dt);
        let repeated = self.scheme == Scheme::Iterated;
        for (m, near) in measured.iter_mut().zip(near) {
            m.near_before = if repeated { *near } else { m.near };
            m.near = *near;
        }
    }

    /// ∫ f dV of every grain where it is.
    fn measure_force(&mut self) {
        let Self { immersed, stepper, lambda, measured, memory, .. } = self;
        let (grid, velocity) = (stepper.grid(), &stepper.state().velocity);
        let carried = self.choices.method.is_carried().then_some(&*lambda);
        let forces = immersed.forces(grid, &self.model, &memory.motions, velocity, carried);
        for (grain, (m, force)) in measured.iter_mut().zip(forces).enumerate() {
            m.force = *force;
            m.acceleration = memory.acceleration(grain);
            m.drive = memory.first_drive(stepper);
        }
    }

    /// d/dt ∫ α u dV of every grain (kempe-froehlich-2012).
    fn measure_interior(&mut self, dt: f64) {
        if self.choices.form != LoadsForm::KempeFroehlich2012 {
            return;
        }
        let Self { immersed, stepper, measured, memory, .. } = self;
        let (grid, velocity) = (stepper.grid(), &stepper.state().velocity);
        let contents = immersed.contents(grid, &self.model, &memory.motions, velocity);
        for ((m, now), before) in measured.iter_mut().zip(contents).zip(&mut memory.contents) {
            for c in 0..3 {
                m.interior.force[c] = (now.force[c] - before.force[c]) / dt;
                m.interior.torque[c] = (now.torque[c] - before.torque[c]) / dt;
            }
            *before = *now;
        }
    }

    /// Sends the loads and takes over the motion that comes back.
    fn exchange(&mut self, window: &Window, exchange: &mut FluidExchange<'_>) -> Result<(), SolverError> {
        let work = Work::begin();
        self.measure_virtual_mass();
        self.seconds += work.seconds();
        let Self { rule, immersed, measured, .. } = self;
        exchange.send(window.header(), &mut |out| {
            for ((loads, shape), m) in out.iter_mut().zip(immersed.shapes()).zip(&*measured) {
                *loads = rule.loads(shape, m);
            }
        })?;
        self.receive(window, exchange)
    }

    /// Takes over the motion at the end of the window.
    fn receive(&mut self, window: &Window, exchange: &mut FluidExchange<'_>) -> Result<(), SolverError> {
        let memory = &mut self.memory;
        std::mem::swap(&mut memory.before, &mut memory.motions);
        memory.before_dt = window.dt;
        let geometry = self.stepper.grid().geometry;
        let mut count = 0;
        exchange.receive(window, &mut |_, records| {
            count = records.len();
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
                "window {}: the motion received for grain {grain} is not finite: {:?}",
                window.step, memory.motions[grain]
            ))),
        }
    }

    /// Masks and carried force at the motion known now (docs/equations-immersed.md, eqs 6 and 7). A grain that
    /// came back where it was expected is held there, where its mask is known.
    fn impose_carried(&mut self) {
        if self.memory.motions.is_empty() {
            return;
        }
        let Self { immersed, fictitious, stepper, lambda, advection, memory, predicted, model, .. } = self;
        let imposed =
            if self.choices.form == LoadsForm::YuShao2007 { Imposed::ByVelocity } else { Imposed::ByForce };
        let (grid, state) = stepper.parts_mut();
        memory.imposed_dt = model.dt;
        if let Some(fictitious) = fictitious {
            // The points stay where they were expected; the motion is the one that came back.
            let numbers = [model.dt, model.viscosity];
            fictitious.impose(&memory.motions, numbers, &mut state.velocity);
            memory.imposed.copy_from_slice(&memory.motions);
            return;
        }
        let near = AS_EXPECTED * grid.smallest_width();
        for (to, (motion, predicted)) in memory.imposed.iter_mut().zip(memory.motions.iter().zip(predicted)) {
            let expected = (0..3).all(|c| (motion.centre[c] - predicted.centre[c]).abs() <= near);
            let place = if expected { predicted } else { motion };
            *to = Motion { centre: place.centre, angle: place.angle, ..*motion };
        }
        let velocity = &mut state.velocity;
        if let Some(Advection { masks, .. }) = advection {
            immersed.impose_and_store_mask(grid, model, &memory.imposed, [velocity, lambda, masks]);
        } else {
            immersed.impose_carried(grid, model, &memory.imposed, imposed, [velocity, lambda]);
        }
    }

    /// Looks at the projected velocity.
    fn health(&mut self, window: &Window) -> Result<Health, SolverError> {
        let (grid, velocity) = (self.stepper.grid(), &self.stepper.state().velocity);
        let health = Health::of(grid, velocity);
        if health.finite && !self.stepper.is_broken() {
            self.rate = health.rate;
            return Ok(health);
        }
        let force = self.choices.method.is_carried().then_some(&self.lambda);
        let culprit = Culprit::find(&self.stepper, force).told(grid.division.ranks());
        let before = match self.rate * window.dt {
            courant if courant > 0.0 => format!(" (dt Σ|u|/Δx was {courant:.2e} before it)"),
            _ => String::new(),
        };
        Err(SolverError::Failed(format!(
            "the velocity is not finite in window {}, t = {} s, dt = {} s{before}: {culprit}; the step is \
             too long or the coupling unstable: lower fluid.time.cfl or dt, or run `bedload check`",
            window.step, window.time, window.dt
        )))
    }

    /// Keeps everything that decides the next window.
    pub fn save(&mut self) {
        let Self { stepper, lambda, memory, .. } = self;
        let multipliers = self.fictitious.as_ref().map(|fictitious| fictitious.multipliers());
        match &mut self.saved {
            Some(saved) => {
                if let (Some(to), Some(from)) = (&mut saved.multipliers, multipliers) {
                    to.clone_from(from);
                }
                saved.state.copy_from(stepper.grid(), stepper.state());
                for (to, from) in saved.lambda.iter_mut().zip(lambda) {
                    copy_own(stepper.grid(), to, from);
                }
                saved.memory.clone_from(memory);
            }
            None => {
                let grid = stepper.grid();
                let mut state = State::at_rest(grid);
                state.copy_from(grid, stepper.state());
                let lambda = std::array::from_fn(|d| {
                    let mut copy = vec![0.0; lambda[d].len()];
                    copy_own(grid, &mut copy, &lambda[d]);
                    copy
                });
                self.saved = Some(Box::new(Saved {
                    state,
                    lambda,
                    multipliers: multipliers.cloned(),
                    memory: memory.clone(),
                }));
            }
        }
    }

    /// Goes back to the last [`Solver::save`]; without one, stays.
    pub fn restore(&mut self) {
        let Self { stepper, lambda, memory, saved, .. } = self;
        let Some(saved) = saved else { return };
        stepper.restore(&saved.state);
        for (to, from) in lambda.iter_mut().zip(&saved.lambda) {
            copy_own(stepper.grid(), to, from);
        }
        if let (Some(fictitious), Some(multipliers)) = (&mut self.fictitious, &saved.multipliers) {
            fictitious.multipliers_mut().clone_from(multipliers);
        }
        memory.clone_from(&saved.memory);
        self.take_hold();
    }

    /// All fields that decide the next window: velocity, history, force (one per axis each), pressure,
    /// the velocity on each open face, and the force at the points of bodies.
    pub(crate) fn fields(&self) -> Vec<&[f64]> {
        let state = self.stepper.state();
        let fields = state.velocity.iter().chain(&state.history).chain(&self.lambda);
        let points = self.fictitious.iter().flat_map(|fictitious| fictitious.multipliers());
        let fields = fields.chain([&state.pressure]).chain(state.open.fields()).chain(points);
        fields.map(Vec::as_slice).collect()
    }

    /// The same, to be set before [`Solver::restart`].
    pub(crate) fn fields_mut(&mut self) -> Vec<&mut [f64]> {
        let state = self.stepper.state_mut();
        let fields = state.velocity.iter_mut().chain(&mut state.history).chain(&mut self.lambda);
        let points = self.fictitious.iter_mut().flat_map(|fictitious| fictitious.multipliers_mut());
        let fields = fields.chain([&mut state.pressure]).chain(state.open.fields_mut()).chain(points);
        fields.map(Vec::as_mut_slice).collect()
    }

    /// Halos of the velocity for whoever looks at the whole field: velocity and pressure of all ranks come to
    /// the first one, which alone has them then. All ranks must call it; says whether this one is to look.
    pub fn show(&mut self) -> bool {
        if self.grid().division.ranks().is_alone() {
            self.stepper.fill_halos();
            return true;
        }
        let (grid, state) = self.stepper.parts_mut();
        let shown = gather::to_first(grid, state.velocity.iter_mut().chain([&mut state.pressure]));
        if shown {
            let whole = grid.undivided();
            for (d, u) in state.velocity.iter_mut().enumerate() {
                fill_velocity(&whole, d, u);
            }
        }
        shown
    }

    /// What decides the next window besides the fields.
    pub(crate) fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Goes on from the present fields: time, the step before and the number of steps, and the rest.
    pub(crate) fn restart(&mut self, (time, previous_dt, steps): (f64, f64, u64), memory: Memory) {
        self.stepper.restart(time, previous_dt, steps);
        self.memory = memory;
        self.take_hold();
    }

    /// Finds the cells that hold force, and the virtual masses of the window before.
    fn take_hold(&mut self) {
        if let Some(by_gap) = &mut self.by_gap {
            let Self { immersed, memory, measured, rule, .. } = self;
            // Where both solvers work at once, the loads kept are those of the window to come.
            let start = if self.scheme == Scheme::Overlapped { &memory.motions } else { &memory.before };
            let near = by_gap.excess(immersed.shapes(), rule.density, start, memory.before_dt);
            measured.iter_mut().zip(near).for_each(|(m, near)| m.near = *near);
        }
        if self.memory.imposed_dt > 0.0 && self.fictitious.is_none() {
            let model = MaskModel { dt: self.memory.imposed_dt, ..self.model };
            let grid = self.stepper.grid();
            if let Some(pores) = &mut self.pores {
                self.immersed.set_radii(grid, &model, pores, &self.memory.before);
            }
            self.immersed.mark_forced(grid, &model, &self.memory.imposed);
            if let Some(Advection { masks, spare, .. }) = &mut self.advection {
                let own = own_planes(grid);
                masks.iter_mut().chain(spare).for_each(|field| field[own.clone()].fill(0.0));
                self.immersed.store_mask(grid, &model, &self.memory.imposed, masks);
            }
        }
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

    /// The carried force, m/s²; empty fields with direct forcing.
    pub fn lambda(&self) -> &[Vec<f64>; D] {
        &self.lambda
    }

    /// Motion of the grains now.
    pub fn motions(&self) -> &[Motion] {
        &self.memory.motions
    }

    /// Shapes and places of the grains.
    pub fn immersed(&self) -> &Immersed<D> {
        &self.immersed
    }

    /// The mask with the present dt.
    pub fn mask_model(&self) -> &MaskModel {
        &self.model
    }

    /// Bounds on the time step.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Density of the fluid, kg/m³.
    pub fn density(&self) -> f64 {
        self.rule.density
    }

    /// Mean pressure gradient that held the flow rate in the last window, Pa/m; 0 without one.
    pub fn pressure_gradient(&self) -> f64 {
        let flow = self.stepper.flow_rate();
        flow.map_or(0.0, |flow| -self.rule.density * flow.acceleration())
    }

    /// CPU seconds of solver work so far, over all threads, without the exchange.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }
}
