//! The fluid as a program: facts, schema and what stands in for the DEM when it runs alone.

use crate::config::FluidSection;
use crate::follow::follow;
use crate::orders::dismiss;
use crate::participant::Fluid;
use crate::ranks::{Ranks, Traffic};
use bedload_output::{MetricValue, OutputFolder};
use bedload_program::Solver;
use bedload_program::alone::{self, Answer, Clock};
use bedload_scene::{CheckedScene, Grain, Motion, SUPERFICIAL, SceneError};
use protocol::facts::{DemFacts, FluidFacts};
use protocol::message::Kinematics;
use protocol::participant::{Participant, SolverError};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

/// The whole program, alone or as one of several `ranks`, of which all but the first follow the first.
pub fn main(ranks: Option<Ranks>) -> ExitCode {
    let Some(ranks) = ranks else { return bedload_program::main::<Fluid>() };
    if !ranks.is_first() {
        return match follow(&ranks) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => failed(&format!("rank {}: {error}", ranks.rank())),
        };
    }
    ranks.clone().set_process();
    let code = bedload_program::main::<Fluid>();
    // Who is gone needs no order.
    let _ = dismiss(&ranks);
    let (size, Traffic { messages, bytes }) = (ranks.size(), ranks.traffic());
    let megabytes = bytes as f64 * 1e-6;
    protocol::tell!(
        "{}: {size} ranks; the first sent {messages} messages, {megabytes:.1} MB",
        Fluid::PROGRAM
    );
    code
}

/// Says `what` is wrong, and that the program has failed.
pub fn failed(what: &str) -> ExitCode {
    protocol::say!("{}: {what}", Fluid::PROGRAM);
    ExitCode::FAILURE
}

/// Part of the mean speed at which fluid may go through a grain at the end of a run: about that part its
/// force lacks, too.
const LEAK: f64 = 0.05;

impl Fluid {
    /// Says where the force on grains at rest had not caught up with the flow when the run ended. Each window
    /// adds what still goes through the grain; a drop of pressure Δp over a grain of length l takes 3.5 Δp
    /// dt/(ρ l U) windows to 5 % (measured: blocks that leave 1/2 to 1/48 of a channel, ν dt/Δx² 1 to 64).
    fn warn_of_leak(&self, scene: &CheckedScene) {
        let stays = |grain: &Grain| grain.stays(scene.scene.domain.geometry);
        let Some((leak, grain)) = self.leak().filter(|_| scene.grains.iter().all(stays)) else { return };
        // A flow that turns round is slow for a moment.
        let speed = self.mean_speed() * self.peak_over_now();
        if leak <= LEAK * speed {
            return;
        }
        protocol::say!(
            "{}: warning: the force on grain {grain} was still growing at the end: fluid went through it at \
             {:.0} % of the largest root mean square of the velocity, and the flow is not that around it; run on, \
             lower fluid.time.dt, or leave it out",
            Self::PROGRAM,
            100.0 * leak / speed
        );
    }
}

impl Solver for Fluid {
    const PROGRAM: &'static str = "bedload-fluid";
    const ABOUT: &'static str = "The fluid of Bedload, an immersed-boundary Navier-Stokes solver: checks a \
        scene, runs alone, joins a coupled run, replays a log";
    type Facts = FluidFacts;

    fn facts(scene: &CheckedScene) -> Result<FluidFacts, SceneError> {
        crate::facts::facts(scene)
    }

    fn build(scene: &CheckedScene, out: &Path) -> Result<Self, SceneError> {
        Self::new(scene, out)
    }

    fn schema() -> serde_json::Value {
        bedload_scene::schema::<FluidSection>()
    }

    fn stand_in(scene: &CheckedScene) -> Result<Answer<Kinematics>, SceneError> {
        match scene.grains.iter().position(|grain| grain.motion == Motion::Free) {
            None => Ok(alone::prescribed_motion(scene)),
            Some(grain) => Err(scene.source.error(
                &format!("grains[{grain}].motion"),
                format!("lets grain {grain} move freely, which a fluid alone cannot decide"),
                "run the scene with `bedload run`, or make the grain \"fixed\" or \"prescribed\"",
            )),
        }
    }

    /// `superficial_velocity_<axis>` at the end, for each periodic axis.
    fn finish(
        &mut self,
        scene: &CheckedScene,
        folder: &OutputFolder,
    ) -> Result<BTreeMap<String, MetricValue>, SolverError> {
        let domain = &scene.scene.domain;
        let along = |axis: usize| {
            let letter = format!("{:?}", domain.geometry.axes()[axis]).to_lowercase();
            let value = MetricValue::measured(self.mean_velocity(axis), "m/s", None, None);
            (format!("{SUPERFICIAL}{letter}"), value)
        };
        let mut values: BTreeMap<_, _> =
            (0..domain.dimensions()).filter(|axis| domain.is_periodic(*axis)).map(along).collect();
        values.extend(self.measure_lines(folder)?);
        self.warn_of_leak(scene);
        Ok(values)
    }

    fn clock(_: &CheckedScene, facts: &FluidFacts) -> Clock {
        Clock { window: facts.first(), substep: f64::INFINITY, adaptive: facts.adaptive }
    }

    fn scalars(&self) -> Vec<f64> {
        if self.holds_flow_rate() { vec![self.pressure_gradient()] } else { Vec::new() }
    }

    fn speed(&self) -> Option<f64> {
        Some(self.fastest())
    }

    fn facts_by_role(facts: &FluidFacts) -> (Option<&FluidFacts>, Option<&DemFacts>) {
        (Some(facts), None)
    }
}
