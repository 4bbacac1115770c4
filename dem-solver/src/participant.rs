//! The DEM as a participant of a run: receives loads, sub-steps, sends kinematics.

use std::path::Path;
use std::time::Duration;

use cpu_time::ProcessTime;
use protocol::alone::{self, Answer, Clock};
use protocol::checkpoint;
use protocol::facts::{DemFacts, FluidFacts};
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, Participant, Role, SolverError, Window, WindowReport};
use protocol::program::Solver;
use protocol::scene::{CheckedScene, SceneError};

use crate::config::{Config, DemSection};
use crate::report::GrainLoad;
use crate::state::State;
use crate::step::Dem;

/// The DEM with what a run needs around it.
pub struct DemParticipant {
    dem: Dem,
    loads: Vec<GrainLoad>,
    saved: State,
    identity: String,
    work: Duration,
}

impl DemParticipant {
    /// Builds the solver at time zero.
    ///
    /// # Errors
    /// [`SceneError`] if the scene does not make a DEM.
    pub fn new(scene: &CheckedScene) -> Result<Self, SceneError> {
        let config = Config::new(scene)?;
        let dem = Dem::new(&config.spec).map_err(|fault| {
            scene.source.error("dem", fault.to_string(), "docs/scene.md says what [dem] allows")
        })?;
        Ok(Self {
            loads: vec![GrainLoad::default(); scene.grains.len()],
            saved: dem.save(),
            dem,
            identity: scene.sha256(),
            work: Duration::ZERO,
        })
    }

    fn fill(&self, out: &mut [Kinematics]) {
        let (grains, seen) = (&self.dem.grains, self.dem.observations());
        for (i, motion) in out.iter_mut().enumerate() {
            let q = grains.orientation[i];
            *motion = Kinematics {
                position: grains.position[i].into(),
                orientation: [q.w, q.i, q.j, q.k],
                velocity: grains.velocity[i].into(),
                spin: grains.spin[i].into(),
                contact_force: seen.mean_contact[i].into(),
                lubrication_force: seen.mean_lubrication[i].into(),
                gap: seen.gap_end[i],
                impact_speed: seen.impact_speed[i],
                rebound_speed: seen.rebound_speed[i],
            };
        }
    }
}

impl Participant for DemParticipant {
    type Incoming = Loads;
    type Outgoing = Kinematics;
    const ROLE: Role = Role::Dem;

    fn grains(&self) -> usize {
        self.dem.grains.len()
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
        let report = self
            .dem
            .advance(window.dt, substeps, &self.loads)
            .map_err(|fault| SolverError::Failed(fault.to_string()))?;
        self.work += start.elapsed();
        if let Some(fault) = report.first_non_finite {
            return Err(SolverError::Failed(format!(
                "{fault} in window {} (t = {} s): reduce [dem] dt, or see whether the loads are finite",
                window.step, window.time
            )));
        }
        let mut header = window.header();
        header.substeps = u64::from(report.n_sub_done);
        header.smallest_gap = report.smallest_gap;
        header.largest_overlap = report.largest_overlap;
        exchange.send(header, &mut |out| self.fill(out))?;
        let radius = self.dem.grains.radius.iter().copied().fold(0.0, f64::max);
        Ok(WindowReport {
            dt_limit: f64::INFINITY,
            residual: if radius > 0.0 { report.largest_overlap / radius } else { 0.0 },
            substeps: u64::from(report.n_sub_done),
        })
    }

    fn save(&mut self) {
        self.dem.save_into(&mut self.saved);
    }

    fn restore(&mut self) {
        // Its own state fits by construction.
        let restored = self.dem.restore(&self.saved);
        debug_assert!(restored.is_ok(), "{restored:?}");
    }

    fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError> {
        checkpoint::write(folder, "dem", &self.identity, &self.dem.save())
    }

    fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError> {
        let state: State = checkpoint::read(folder, "dem", &self.identity)?;
        self.dem.restore(&state).map_err(|fault| SolverError::Failed(fault.to_string()))
    }

    fn write_fields(&mut self, _: &Window) -> Result<(), SolverError> {
        Ok(())
    }

    fn solver_seconds(&self) -> f64 {
        self.work.as_secs_f64()
    }
}

impl Solver for DemParticipant {
    const PROGRAM: &'static str = "bedload-dem";
    type Facts = DemFacts;

    fn facts(scene: &CheckedScene) -> Result<DemFacts, SceneError> {
        Ok(Config::new(scene)?.facts)
    }

    fn build(scene: &CheckedScene, _: &Path) -> Result<Self, SceneError> {
        Self::new(scene)
    }

    fn schema() -> serde_json::Value {
        schemars::schema_for!(DemSection).to_value()
    }

    fn stand_in(scene: &CheckedScene) -> Result<Answer<Loads>, SceneError> {
        Ok(alone::buoyancy(scene))
    }

    fn clock(scene: &CheckedScene, facts: &DemFacts) -> Clock {
        // Windows of 100 sub-steps: short enough to observe, long enough to cost nothing.
        let observe = &scene.scene.observe;
        let longest = if observe.every > 0.0 { observe.every } else { scene.scene.until };
        let window = (100.0 * facts.dt).min(longest);
        Clock { window, substep: facts.dt, adaptive: false }
    }

    fn sides<'a>(incoming: &'a [Loads], outgoing: &'a [Kinematics]) -> (&'a [Loads], &'a [Kinematics]) {
        (incoming, outgoing)
    }

    fn facts_by_role(facts: &DemFacts) -> (Option<&FluidFacts>, Option<&DemFacts>) {
        (None, Some(facts))
    }
}
