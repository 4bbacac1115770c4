//! The solver: windows of sub-steps under constant loads.
//!
//! One sub-step, symplectic Euler, from top to bottom:
//!
//! 1. contact forces at xⁿ, vⁿ, springs take dt vⁿ (eqs 11–16);
//! 2. kick: gravity, fluid, virtual mass, contact;
//! 3. neighbour lists, if the grains may outrun them in this sub-step;
//! 4. films: implicit impulses over the path of the sub-step (eq. 19);
//! 5. drift: positions and orientations with the new velocities.
//!
//! Verlet starts with half a kick, evaluates contacts after the drift (springs along the half-step
//! velocity, dashpots at the predicted full-step one) and ends with the other half.

use crate::Vec3;
use crate::bulk::{self, Bulk};
use crate::error::{AdvanceError, SpecError};
use crate::general::energy::Account;
use crate::general::forces::{Forces, Kinematics, Scene, SpringStep, contact_forces};
use crate::general::integrate::{Integrator, Speed, drift, kick, prescribed};
use crate::general::lists::Neighbours;
use crate::general::rk3;
use crate::grains::{Grains, Response};
use crate::laws::walls::Plane;
use crate::lubrication::gap::{FilmIntegration, FilmModel};
use crate::lubrication::simultaneous::{Films, explicit_forces};
use crate::report::{GrainLoad, NonFinite, Observations, WindowReport};
use crate::spec::{DemSpec, Engine, Grain, Shape};

/// Up to this number of grains the gaps at the end of a window are exact at any distance.
pub const EXACT_GAPS: usize = 64;

/// The solver.
#[derive(Clone, Debug)]
pub struct Dem {
    /// Grains, in their present state.
    pub grains: Grains,
    pub(crate) bulk: Option<Box<Bulk>>,
    pub(crate) account: Option<Box<Account>>,
    pub(crate) lists: Neighbours,
    pub(crate) forces: Forces,
    pub(crate) response: Response,
    pub(crate) rk3: rk3::Start,
    pub(crate) time: f64,
    pub(crate) substeps: u64,
    pub(crate) windows: u64,
    scene: Scene,
    shape: Shape,
    gravity: Vec3,
    integrator: Integrator,
    film: Option<(FilmModel, FilmIntegration, u32)>,
    films: Films,
    seen: Observations,
    prescribed: Vec<u32>,
    wall_speed: f64,
    start: (Vec<Vec3>, Vec<Vec3>),
    ahead: (Vec<Vec3>, Vec<Vec3>),
    max_speed2: f64,
    orientation: bool,
}

/// The bulk engine, if it is to do the work.
fn choose(spec: &DemSpec) -> Option<Bulk> {
    let wanted = match spec.engine {
        Engine::General => false,
        Engine::Bulk => true,
        Engine::Auto => spec.grains.len() >= bulk::FROM,
    };
    if wanted && bulk::prevents(spec).is_none() { Bulk::new(spec) } else { None }
}

impl Dem {
    /// Checks the run and builds the solver at time zero.
    pub fn new(spec: &DemSpec) -> Result<Self, SpecError> {
        spec.validate()?;
        let n = spec.grains.len();
        let grains = Grains::new(&spec.grains, spec.shape);
        let walls: Vec<Plane> = spec.walls.iter().map(Plane::from).collect();
        let periods = crate::search::cells::Periods::new(spec.periods);
        let settings = spec.lubrication.settings();
        let bulk = choose(spec).map(Box::new);
        // what only the general engine needs: a run of many grains would spend a third of its memory on it
        let own = if bulk.is_some() { 0 } else { n };
        let zeros = |n| (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
        let mut dem = Self {
            lists: Neighbours::new(spec.range(), spec.skin(), own),
            forces: Forces::new(own),
            response: Response::new(own),
            rk3: rk3::Start::default(),
            time: 0.0,
            substeps: 0,
            windows: 0,
            wall_speed: walls.iter().map(|wall| wall.velocity.dot(&wall.normal).abs()).fold(0.0, f64::max),
            scene: Scene { walls, periods, laws: spec.laws(), range: spec.range() },
            shape: spec.shape,
            gravity: spec.gravity.into(),
            integrator: spec.integrator,
            film: spec
                .film()
                .zip(settings)
                .map(|(model, settings)| (model, settings.integration, settings.sweeps)),
            films: Films::default(),
            seen: Observations::new(if bulk.is_some() && !spec.observations { 0 } else { n }),
            prescribed: prescribed(&grains),
            start: zeros(own),
            ahead: zeros(if spec.integrator == Integrator::VelocityVerlet { n } else { 0 }),
            orientation: spec.orientation,
            account: spec.energy.then(Box::default),
            bulk,
            max_speed2: 0.0,
            grains,
        };
        dem.wrap();
        Ok(dem)
    }

    /// Time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Sub-steps done since the start of the run.
    #[must_use]
    pub fn substeps(&self) -> u64 {
        self.substeps
    }

    /// Windows done since the start of the run.
    #[must_use]
    pub fn windows(&self) -> u64 {
        self.windows
    }

    /// The same state with the general engine, for what needs its lists.
    pub(crate) fn general(&self) -> Self {
        let mut copy = self.clone();
        if copy.bulk.take().is_some() {
            let n = copy.grains.len();
            copy.forces = Forces::new(n);
            copy.response = Response::new(n);
            copy.seen = Observations::new(n);
            copy.start = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
            let restored = copy.restore(&self.save());
            debug_assert!(restored.is_ok(), "{restored:?}");
        }
        copy
    }

    /// Threads of the bulk engine; they change no bit.
    pub fn set_threads(&mut self, threads: usize) {
        if let Some(bulk) = &mut self.bulk {
            bulk.set_threads(threads);
        }
    }

    /// Takes `more` grains up at `places`, behind those that are there. False, and nothing done, if the present
    /// engine cannot: then a solver for all of them must take the state over.
    pub(crate) fn join(&mut self, more: &[Grain], places: &[Vec3]) -> bool {
        let Some(bulk) = &mut self.bulk else { return false };
        let before = self.grains.len();
        let mut new = Grains::new(more, self.shape);
        new.position.copy_from_slice(places);
        self.grains.append(new);
        if bulk.join(&self.grains) {
            self.prescribed = prescribed(&self.grains);
            return true;
        }
        self.grains.truncate(before);
        false
    }

    /// Threads that the present size is worth, of those allowed.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.bulk.as_ref().map_or(1, |bulk| bulk.threads())
    }

    /// Whether the next windows note forces, gaps and speeds per grain. The general engine always does.
    pub fn set_observations(&mut self, wanted: bool) {
        let n = if wanted { self.grains.len() } else { 0 };
        if self.bulk.is_some() && self.seen.gap_end.len() != n {
            self.seen = Observations::new(n);
        }
    }

    /// Whether the bulk engine does the work.
    #[must_use]
    pub fn is_bulk(&self) -> bool {
        self.bulk.is_some()
    }

    /// Observations of the last window; empty in the bulk engine if they were not asked for.
    #[must_use]
    pub fn observations(&self) -> &Observations {
        &self.seen
    }

    /// Contact forces at the last evaluation, N (symplectic Euler: at the start of the last sub-step). Empty in the bulk engine.
    #[must_use]
    pub fn contact_force(&self) -> &[Vec3] {
        &self.forces.contact
    }

    /// Contact torques at the last evaluation, N m. Empty in the bulk engine.
    #[must_use]
    pub fn contact_torque(&self) -> &[Vec3] {
        &self.forces.torque
    }

    /// Film forces at the last sub-step, N. Empty in the bulk engine.
    #[must_use]
    pub fn lubrication_force(&self) -> &[Vec3] {
        &self.forces.film
    }

    /// How often the neighbour lists were built.
    #[must_use]
    pub fn list_builds(&self) -> u64 {
        self.bulk.as_ref().map_or(self.lists.builds, |bulk| bulk.builds)
    }

    /// Gap up to which pairs are watched during a window, m.
    #[must_use]
    pub fn watched_range(&self) -> f64 {
        self.scene.range
    }

    /// Advances by `dt_window` in `n_sub` sub-steps under constant `loads` (one per grain; none at all
    /// for a dry run). A state that stops being finite ends the window early and is named in the
    /// report.
    pub fn advance(
        &mut self,
        dt_window: f64,
        n_sub: u32,
        loads: &[GrainLoad],
    ) -> Result<WindowReport, AdvanceError> {
        self.check(dt_window, n_sub, loads)?;
        if self.bulk.is_some() {
            return Ok(self.advance_bulk(dt_window, n_sub, loads));
        }
        self.begin(loads);
        let (t, dt) = (self.time, dt_window / f64::from(n_sub));
        let mut done = 0;
        let mut finite = true;
        if self.integrator == Integrator::VelocityVerlet {
            self.evaluate_at_rest(t);
        }
        while done < n_sub && finite {
            let speed = self.substep(t + f64::from(done) * dt, dt);
            self.max_speed2 = self.max_speed2.max(speed.largest2);
            finite = speed.finite;
            done += 1;
        }
        let failed =
            if finite { self.first_non_finite() } else { Some(self.first_non_finite().unwrap_or(OVERFLOW)) };
        self.finish(dt_window, n_sub);
        Ok(self.report(done, failed))
    }

    /// One sub-step from `t` to `t + dt`.
    fn substep(&mut self, t: f64, dt: f64) -> Speed {
        match self.integrator {
            Integrator::SymplecticEuler => {
                self.evaluate(t, dt, SpringStep::Before);
                self.tally(1.0);
                let speed = self.kick(dt);
                self.refresh(&speed, t, dt);
                self.lubricate(t, dt);
                drift(dt, t, &mut self.grains, &self.prescribed);
                speed
            }
            Integrator::VelocityVerlet => {
                self.tally(0.5);
                let speed = self.kick(0.5 * dt);
                self.refresh(&speed, t, dt);
                self.lubricate(t, dt);
                drift(dt, t, &mut self.grains, &self.prescribed);
                self.evaluate_ahead(t + dt, dt);
                self.tally(0.5);
                self.kick(0.5 * dt)
            }
            Integrator::Rk3 => {
                let speed = self.speed();
                self.refresh(&speed, t, 2.0 * dt);
                rk3::substep(self, t, dt)
            }
        }
    }

    /// Forces at the present state; springs take `dt` of the present slip.
    pub(crate) fn evaluate(&mut self, t: f64, dt: f64, spring: SpringStep) {
        let kinematics = Kinematics {
            velocity: &self.grains.velocity,
            spin: &self.grains.spin,
            path: None,
            dt,
            spring,
            t,
        };
        let lists = (&mut self.lists.pairs, &mut self.lists.walls);
        contact_forces(
            &self.scene,
            &self.grains,
            &self.response,
            &kinematics,
            lists,
            &mut self.forces,
            &mut self.seen,
            self.account.as_deref_mut(),
        );
        if let Some((model, FilmIntegration::Explicit, _)) = &self.film {
            let lists = (&self.lists.pairs, &self.lists.walls);
            explicit_forces(
                &self.scene,
                model,
                &self.grains,
                &self.grains.velocity,
                lists,
                t,
                &mut self.forces.film,
            );
        }
    }

    /// Forces at the start of a Verlet window; the springs stay.
    fn evaluate_at_rest(&mut self, t: f64) {
        let speed = self.speed();
        self.refresh(&speed, t, 0.0);
        self.evaluate(t, 0.0, SpringStep::Before);
    }

    /// Forces after a Verlet drift: springs take the half-step velocity, dashpots see the velocity
    /// predicted for the full step, without which they would be first order.
    fn evaluate_ahead(&mut self, t: f64, dt: f64) {
        let (grains, response, forces) = (&self.grains, &self.response, &mut self.forces);
        let explicit = matches!(self.film, Some((_, FilmIntegration::Explicit, _)));
        let h = 0.5 * dt;
        for i in 0..grains.len() {
            let force = if explicit { forces.contact[i] + forces.film[i] } else { forces.contact[i] };
            self.ahead.0[i] = grains.velocity[i]
                + (response.acceleration[i] + response.inverse_mass[i].component_mul(&force)) * h;
            self.ahead.1[i] = grains.spin[i]
                + (response.spin_acceleration[i]
                    + response.inverse_inertia[i].component_mul(&forces.torque[i]))
                    * h;
        }
        let path = Some((&grains.velocity[..], &grains.spin[..]));
        let kinematics = Kinematics {
            velocity: &self.ahead.0,
            spin: &self.ahead.1,
            path,
            dt,
            spring: SpringStep::Before,
            t,
        };
        let lists = (&mut self.lists.pairs, &mut self.lists.walls);
        let account = self.account.as_deref_mut();
        contact_forces(&self.scene, grains, response, &kinematics, lists, forces, &mut self.seen, account);
        if let Some((model, FilmIntegration::Explicit, _)) = &self.film {
            let lists = (&self.lists.pairs, &self.lists.walls);
            explicit_forces(&self.scene, model, grains, &self.ahead.0, lists, t, &mut forces.film);
        }
    }

    fn kick(&mut self, h: f64) -> Speed {
        let film = self.film_is_explicit().then_some(&self.forces.film[..]);
        if let Some(account) = &mut self.account {
            account.before_kick(&self.grains);
        }
        let (contact, torque) = (&self.forces.contact, &self.forces.torque);
        let speed = kick(h, &mut self.grains, &self.response, contact, torque, film);
        if let Some(account) = &mut self.account {
            account.after_kick(h, &self.grains);
        }
        speed
    }

    /// Builds the lists again if a grain may leave them within `dt`. Films only slow a pair down, but
    /// pass momentum on: a grain may gain up to √2 of the largest speed.
    fn refresh(&mut self, speed: &Speed, t: f64, dt: f64) {
        if speed.finite {
            let step = 1.5 * dt * speed.largest2.sqrt().max(self.wall_speed);
            if self.lists.refresh(step, &self.grains, &self.scene.walls, &self.scene.periods, t)
                && self.film.is_some()
            {
                self.films.reserve(self.lists.pairs.len() + self.lists.walls.len());
            }
        }
    }

    /// Implicit films over `dt`.
    fn lubricate(&mut self, t: f64, dt: f64) {
        if let Some((model, FilmIntegration::Implicit, sweeps)) = self.film {
            let lists = (&self.lists.pairs, &self.lists.walls);
            self.films.apply(
                &self.scene,
                &model,
                sweeps,
                &mut self.grains,
                &self.response,
                lists,
                (t, dt),
                &mut self.forces.film,
            );
            for (mean, film) in self.seen.mean_lubrication.iter_mut().zip(&self.forces.film) {
                *mean += film;
            }
        }
    }

    /// Adds the present forces to the window's means with a weight in sub-steps.
    pub(crate) fn tally(&mut self, weight: f64) {
        for (mean, force) in self.seen.mean_contact.iter_mut().zip(&self.forces.contact) {
            *mean += force * weight;
        }
        if self.film_is_explicit() {
            for (mean, film) in self.seen.mean_lubrication.iter_mut().zip(&self.forces.film) {
                *mean += film * weight;
            }
        }
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(crate) fn gravity(&self) -> &Vec3 {
        &self.gravity
    }

    pub(crate) fn wall_count(&self) -> usize {
        self.scene.walls.len()
    }

    pub(crate) fn film_is_explicit(&self) -> bool {
        matches!(self.film, Some((_, FilmIntegration::Explicit, _)))
    }

    /// Sets the velocities that are functions of time.
    pub(crate) fn set_prescribed(&mut self, t: f64) {
        for &i in &self.prescribed {
            let (velocity, spin) = self.grains.motion[i as usize].velocity_at(t);
            self.grains.velocity[i as usize] = velocity;
            self.grains.spin[i as usize] = spin;
        }
    }
}

/// Named when a square overflows before any value does.
const OVERFLOW: NonFinite = NonFinite { grain: 0, quantity: "velocity" };

mod window;
