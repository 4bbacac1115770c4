//! The DEM as a participant of a run: receives loads, sub-steps, sends kinematics.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use bedload_output::{MetricValue, OutputFolder, observed_grains};
use bedload_program::Solver;
use bedload_program::alone::{self, Answer, Clock};
use bedload_scene::{Appearing, Axis, CheckedScene, SceneError};
use cpu_time::ProcessTime;
use protocol::checkpoint;
use protocol::facts::{DemFacts, FluidFacts};
use protocol::message::{Kinematics, Loads};
use protocol::new_file::write_new;
use protocol::participant::{Exchange, Participant, Role, SolverError, Window, WindowReport};

use crate::config::{Config, DemSection};
use crate::contacts::Contact;
use crate::initial;
use crate::insertion::Insertions;
use crate::output::profile::Profile;
use crate::output::substeps::Substeps;
use crate::output::totals::{Totals, add_servos};
use crate::output::{finish, grain_files};
use crate::outside::Outside;
use crate::report::GrainLoad;
use crate::solver::Dem;
use crate::spec::DemSpec;
use crate::state::State;

/// The DEM with what a run needs around it.
pub struct DemParticipant {
    /// The grains that are there; inserted ones join at the end.
    dem: Dem,
    /// All grains, also those still to be inserted.
    spec: DemSpec,
    insertions: Insertions,
    outside: Outside,
    appearing: Appearing,
    profile: Option<bedload_scene::Profile>,
    totals: Option<Totals>,
    /// Along which axes stresses on servos are told; none where nothing is asked for.
    servos: Option<&'static [Axis]>,
    substeps: Option<Substeps>,
    fields: PathBuf,
    /// Whether forces on grains are read after every window, or only when fields are written.
    read: bool,
    /// Grains whose gap is told at any distance.
    observed: Vec<usize>,
    loads: Vec<GrainLoad>,
    saved: State,
    identity: String,
    work: Duration,
}

impl DemParticipant {
    /// Builds the solver at time zero; files go below `out`.
    ///
    /// # Errors
    /// [`SceneError`] if the scene does not make a DEM.
    pub fn new(scene: &CheckedScene, out: &Path) -> Result<Self, SceneError> {
        let Config { mut spec, initial_state, facts } = Config::new(scene)?;
        spec.contact_step = facts.dt;
        // Of all grains, so that it does not change as they are inserted.
        spec.skin = Some(spec.skin());
        // Orientations and forces per grain cost time; some dry scenes read neither, or forces in their files
        // only.
        let observe = &scene.scene.observe;
        let read = scene.scene.medium.is_some()
            || observe.grains.as_ref().is_none_or(|grains| !grains.is_empty())
            || scene.scene.metrics.iter().any(|metric| metric.kind.grain().is_some());
        (spec.observations, spec.orientation) = (read, read);
        let of_metrics = scene.scene.metrics.iter().filter_map(|metric| metric.kind.grain());
        let observed = if read { observed_grains(scene) } else { Vec::new() };
        let observed: BTreeSet<usize> = observed.into_iter().chain(of_metrics).collect();
        let mut dem = dem(&spec, scene)?;
        if let Some(folder) = &initial_state {
            initial::load(&mut dem, folder, scene)?;
        }
        Ok(Self {
            spec,
            insertions: Insertions::new(scene),
            outside: Outside::new(scene),
            appearing: Appearing::of(&scene.scene.walls),
            profile: scene.scene.observe.profile.clone(),
            totals: Totals::of(scene),
            servos: observe.values_over_time.then(|| scene.scene.domain.geometry.axes()),
            substeps: observe
                .substeps
                .as_ref()
                .map(|asked| Substeps::new(asked, scene.scene.domain.geometry)),
            fields: out.join("fields"),
            read,
            observed: observed.into_iter().collect(),
            loads: vec![GrainLoad::default(); scene.grains.len()],
            saved: dem.save(),
            dem,
            identity: scene.state_sha256(),
            work: Duration::ZERO,
        })
    }

    fn fill(&self, out: &mut [Kinematics]) {
        let (grains, seen) = (&self.dem.grains, self.dem.observations());
        let there = grains.len().min(out.len());
        for (waiting, motion) in self.spec.grains[there..].iter().zip(&mut out[there..]) {
            // No orientation: not there yet.
            let (position, orientation) = (waiting.position, [0.0; 4]);
            *motion = Kinematics { position, orientation, gap: f64::INFINITY, ..Kinematics::default() };
        }
        for (i, motion) in out[..there].iter_mut().enumerate() {
            let q = grains.orientation[i];
            *motion = Kinematics {
                position: grains.position[i].into(),
                orientation: [q.w, q.i, q.j, q.k],
                velocity: grains.velocity[i].into(),
                spin: grains.spin[i].into(),
                contact_force: at(&seen.mean_contact, i).into(),
                lubrication_force: at(&seen.mean_lubrication, i).into(),
                gap: seen.gap_end.get(i).copied().unwrap_or(f64::INFINITY),
                impact_speed: at(&seen.impact_speed, i),
                rebound_speed: at(&seen.rebound_speed, i),
            };
        }
        for i in self.observed.iter().copied().filter(|i| *i < there) {
            out[i].gap = self.dem.gap_of(i);
        }
    }

    /// The largest overlap of a window over a half width, which is the radius of what is round: over the
    /// largest one, and where that is much of the smallest, over that of the smaller grain of each pair at
    /// the end of the window.
    fn overlap_part(&self, overlap: f64) -> f64 {
        let half = &self.dem.grains.half_width;
        let smallest = half.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = half.iter().copied().fold(smallest, f64::max);
        if overlap <= DemFacts::MOST_OVERLAP * smallest {
            return overlap / smallest;
        }
        if smallest == largest { overlap / largest } else { self.dem.deepest().max(overlap / largest) }
    }

    /// Adds the grains that are due and have room.
    fn insert(&mut self, window: &Window) -> Result<(), SolverError> {
        let there = self.dem.grains.len();
        if there == self.spec.grains.len() {
            return Ok(());
        }
        let places = self.insertions.places(&self.dem, &self.spec.grains, window.step, window.time);
        if places.is_empty() {
            return Ok(());
        }
        if self.dem.insert(&self.spec.grains[there..there + places.len()], &places) {
            return Ok(());
        }
        let mut state = self.dem.save();
        for (place, grain) in places.iter().zip(&self.spec.grains[there..]) {
            state.position.push((*place).into());
            state.velocity.push(grain.velocity);
            state.spin.push(grain.spin);
            state.orientation.push(grain.orientation);
            state.image.push([0; 3]);
            state.acceleration.push([0.0; 3]);
            state.spin_acceleration.push([0.0; 3]);
        }
        // the order of the grains that were there is none of all
        state.order.clear();
        self.adopt(&state)
    }

    /// Takes a state of any number of the scene's first grains.
    pub(crate) fn adopt(&mut self, state: &State) -> Result<(), SolverError> {
        let count = state.position.len();
        if count != self.dem.grains.len() && count <= self.spec.grains.len() {
            self.dem = Dem::new(&first(&self.spec, count)).map_err(failed)?;
        }
        self.dem.restore(state).map_err(failed)
    }

    fn write_field(&self, name: &str, bytes: &[u8]) -> Result<(), SolverError> {
        let path = self.fields.join(name);
        std::fs::create_dir_all(&self.fields)
            .and_then(|()| write_new(&path, bytes))
            .map_err(|source| SolverError::File { path: path.display().to_string(), source })
    }

    pub(crate) fn contacts(&self) -> Vec<Contact> {
        self.dem.contact_list(&self.loads[..self.dem.grains.len()])
    }

    /// The profile now, if the scene asks for one.
    pub(crate) fn profile(&self) -> Option<Profile> {
        let asked = self.profile.as_ref()?;
        Some(Profile::new(asked, &self.spec, &self.dem.grains, &self.contacts()))
    }

    /// The solver.
    pub fn dem(&self) -> &Dem {
        &self.dem
    }

    /// What it is made of, all grains included.
    pub fn spec(&self) -> &DemSpec {
        &self.spec
    }
}

/// The run with its first `count` grains only.
fn first(spec: &DemSpec, count: usize) -> DemSpec {
    DemSpec { grains: spec.grains[..count].to_vec(), ..spec.clone() }
}

/// The solver of the grains that are there at the start.
fn dem(spec: &DemSpec, scene: &CheckedScene) -> Result<Dem, SceneError> {
    Dem::new(&first(spec, scene.present()))
        .map_err(|fault| scene.source.error("dem", fault.to_string(), "docs/scene.md says what [dem] allows"))
}

fn failed(fault: impl std::fmt::Display) -> SolverError {
    SolverError::Failed(fault.to_string())
}

/// What was observed of grain `i`; zero where nobody asked for it.
fn at<T: Copy + Default>(values: &[T], i: usize) -> T {
    values.get(i).copied().unwrap_or_default()
}

impl Participant for DemParticipant {
    type Incoming = Loads;
    type Outgoing = Kinematics;
    const ROLE: Role = Role::Dem;

    fn grains(&self) -> usize {
        self.spec.grains.len()
    }

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Loads, Kinematics>,
    ) -> Result<WindowReport, SolverError> {
        let loads = &mut self.loads;
        exchange.receive(window, &mut |_, incoming| {
            for (load, from) in loads.iter_mut().zip(incoming) {
                *load = GrainLoad {
                    force: from.force.into(),
                    torque: from.torque.into(),
                    added_mass: from.added_mass,
                    added_inertia: from.added_inertia,
                };
            }
        })?;
        let start = ProcessTime::now();
        let substeps = u32::try_from(window.substeps).map_err(|_| {
            SolverError::Failed(format!("{} sub-steps in one window; at most {}", window.substeps, u32::MAX))
        })?;
        self.insert(window)?;
        let there = self.dem.grains.len();
        self.dem.set_threads(rayon::current_num_threads());
        self.dem.set_observations(self.read || window.output);
        let end = window.time + window.dt;
        let split = self.substeps.as_mut().is_some_and(|asked| asked.begin(&mut self.dem, window.time, end));
        let report = self.dem.advance(window.dt, substeps, &self.loads[..there]).map_err(failed)?;
        self.work += start.elapsed();
        if let Some(asked) = self.substeps.as_ref().filter(|_| split) {
            // a window that is done again is written again
            let table = asked.table(&self.dem, &self.spec.gravity, &self.loads);
            self.write_field(&format!("substeps_{:08}.csv", window.step), table.as_bytes())?;
        }
        if let Some(fault) = report.first_non_finite {
            return Err(SolverError::Failed(format!(
                "{fault} in window {} (t = {} s): shorten dem.contact.contact_time, or see whether the loads \
                 are finite",
                window.step, window.time
            )));
        }
        if let Some(i) = report.lost {
            let (x, v) = (self.dem.grains.position[i], self.dem.grains.velocity[i]);
            let appeared = self.appearing.words(end);
            let otherwise = if appeared.is_empty() { "" } else { "otherwise " };
            return Err(SolverError::Failed(format!(
                "grain {i} left through a wall in window {} (t = {end} s): it is at {:?} m with {:?} \
                 m/s{appeared}; {otherwise}the contact is too soft for that speed: shorten \
                 dem.contact.contact_time, or stiffen the law",
                window.step,
                <[f64; 3]>::from(x),
                <[f64; 3]>::from(v),
            )));
        }
        self.outside.look(&self.dem.grains, window.step, end);
        let substeps = u64::from(report.n_sub_done);
        let mut header = window.header();
        header.substeps = substeps;
        header.smallest_gap = report.smallest_gap;
        header.largest_overlap = report.largest_overlap;
        exchange.send(header, &mut |out| self.fill(out))?;
        Ok(WindowReport {
            dt_limit: f64::INFINITY,
            residual: self.overlap_part(report.largest_overlap),
            substeps,
        })
    }

    fn save(&mut self) {
        self.dem.save_into(&mut self.saved);
    }

    fn restore(&mut self) {
        // Its own state fits by construction.
        let saved = std::mem::take(&mut self.saved);
        let restored = self.adopt(&saved);
        self.saved = saved;
        debug_assert!(restored.is_ok(), "{restored:?}");
    }

    fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError> {
        checkpoint::write(folder, "dem", &self.identity, &self.dem.save())
    }

    fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError> {
        let state: State = checkpoint::read(folder, "dem", &self.identity)?;
        self.adopt(&state)
    }

    fn write_fields(&mut self, window: &Window) -> Result<(), SolverError> {
        let time = window.time + window.dt;
        let (grains, seen) = (&self.dem.grains, self.dem.observations());
        let bodies = grain_files::outlines(time, grains, seen, &self.spec.outlines);
        for (kind, bytes) in [("grains", Some(grain_files::vtp(time, grains, seen))), ("bodies", bodies)] {
            let Some(bytes) = bytes else { continue };
            let name = format!("{kind}_{:08}.vtp", window.step);
            self.write_field(&name, &bytes)?;
            bedload_output::vtk::list(&self.fields.join(format!("{kind}.pvd")), time, &name)?;
        }
        if let Some(profile) = self.profile() {
            let name = format!("profile_{:08}.csv", window.step);
            self.write_field(&name, profile.table(&[]).as_bytes())?;
        }
        Ok(())
    }

    fn solver_seconds(&self) -> f64 {
        self.work.as_secs_f64()
    }

    fn totals(&self, out: &mut Vec<f64>) {
        if let Some(asked) = &self.totals {
            asked.add(&self.dem, || self.contacts(), out);
        }
        if let Some(axes) = self.servos {
            add_servos(axes, &self.dem, out);
        }
    }
}

impl Solver for DemParticipant {
    const PROGRAM: &'static str = "bedload-dem";
    const ABOUT: &'static str = "The grains of Bedload, a soft-sphere DEM with lubrication: checks a scene, \
        runs alone, joins a coupled run, replays a log; `bedload-dem coarse-grain --help`: fields of a \
        continuum from a run";
    type Facts = DemFacts;

    fn facts(scene: &CheckedScene) -> Result<DemFacts, SceneError> {
        let config = Config::new(scene)?;
        if let Some(folder) = &config.initial_state {
            // Before the run takes the place of another one.
            initial::load(&mut dem(&config.spec, scene)?, folder, scene)?;
        }
        Ok(config.facts)
    }

    fn build(scene: &CheckedScene, out: &Path) -> Result<Self, SceneError> {
        Self::new(scene, out)
    }

    fn finish(
        &mut self,
        scene: &CheckedScene,
        folder: &OutputFolder,
    ) -> Result<BTreeMap<String, MetricValue>, SolverError> {
        let what = (&self.dem, &self.spec);
        finish::finish(what, self.profile().as_ref(), &self.outside, scene, folder)
    }

    fn schema() -> serde_json::Value {
        bedload_scene::schema::<DemSection>()
    }

    fn stand_in(scene: &CheckedScene) -> Result<Answer<Loads>, SceneError> {
        Ok(alone::buoyancy(scene))
    }

    fn clock(scene: &CheckedScene, facts: &DemFacts) -> Clock {
        Clock::of_dem(facts.dt, scene.scene.observe.every, scene.scene.until)
    }

    fn scalars(&self) -> Vec<f64> {
        let Some(lost) = self.dem.dissipated() else { return Vec::new() };
        let (elastic, potential) = (self.dem.elastic_energy(), self.dem.potential_energy());
        vec![elastic, potential, lost.normal, lost.tangential, lost.sliding, lost.total()]
    }

    fn facts_by_role(facts: &DemFacts) -> (Option<&FluidFacts>, Option<&DemFacts>) {
        (None, Some(facts))
    }
}
