//! `run`: a solver alone, with the options and the output folder of a coupled run.
//!
//! A fluid alone is given the motion that the scene prescribes; a DEM alone is given no load but, where
//! the scene has a fluid, the buoyancy.

use std::path::PathBuf;
use std::time::Instant;

use bedload_output::{Observer, OutputFolder, Sides};
use bedload_scene::{Appearing, CheckedScene, Grain, Motion, Observe, Rest};
use protocol::facts::DemFacts;
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Role, Window};
use serde::{Deserialize, Serialize};

use crate::alternation::{Flow, FlowSeen};
use crate::failure::Failure;
use crate::in_process::InProcess;
use crate::interrupts::Interrupts;
use crate::job::{Job, LogKind};
use crate::link::{Messages, Ordered, Schedule};
use crate::options::RunOptions;
use crate::run::{self, Setup};
use crate::solver::Solver;
use crate::threads::with_threads;
use crate::unstable::{self, Energy, Seen};

pub use crate::clock::Clock;
pub use crate::stand_in::{Answer, StandIn};

/// The motion that the scene prescribes, at the end of each window.
pub fn prescribed_motion(scene: &CheckedScene) -> Answer<Kinematics> {
    let grains = scene.grains.clone();
    Box::new(move |window, out| {
        let t = window.time + window.dt;
        for (grain, motion) in grains.iter().zip(out) {
            *motion = motion_at(grain, t);
        }
    })
}

/// State of a grain that forces do not move, at time `t`.
pub fn motion_at(grain: &Grain, t: f64) -> Kinematics {
    let zero = [0.0; 3];
    let (displacement, velocity, turned, spin) = match grain.motion {
        Motion::Prescribed => {
            let Grain { velocity, spin, .. } = grain;
            (velocity.integral(t), velocity.at(t), spin.integral(t), spin.at(t))
        }
        Motion::Free => (zero, grain.velocity.start(), grain.spin.start().map(|w| w * t), grain.spin.start()),
        Motion::Fixed => (zero, zero, zero, zero),
    };
    let [w, x, y, z] = grain.orientation;
    let start = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    let turned = nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(turned)) * start;
    Kinematics {
        position: std::array::from_fn(|axis| grain.position[axis] + displacement[axis]),
        orientation: [turned.w, turned.i, turned.j, turned.k],
        velocity,
        spin,
        ..Kinematics::default()
    }
}

/// Buoyancy alone: −m_f g on every grain, g the mean of the window, where the scene has a fluid.
pub fn buoyancy(scene: &CheckedScene) -> Answer<Loads> {
    let gravity = scene.scene.gravity.clone();
    let density = scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density);
    let displaced: Vec<f64> = scene.grains.iter().map(|grain| density * grain.volume()).collect();
    Box::new(move |window, out| {
        let gravity = gravity.mean(window.time, window.time + window.dt);
        for (mass, loads) in displaced.iter().zip(out) {
            *loads = Loads { force: gravity.map(|g| -mass * g), ..Loads::default() };
        }
    })
}

/// Everything that decides the next window of a solver alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AloneState {
    step: u64,
    time: f64,
    /// Largest step that the solver would accept, s.
    limit: f64,
    /// Do the grains rest, where the scene ends there?
    rests: bool,
    /// From when on they do so far without a break, s.
    #[serde(default)]
    since: Option<f64>,
    /// Of the energy of the grains.
    seen: Seen,
    /// Of the fluid.
    #[serde(default)]
    flow: FlowSeen,
}

/// What a user can do about an unstable run of grains alone.
const REMEDY: &str = "give more sub-steps per contact (dem.steps_per_contact, or a smaller dem.dt); to go on \
    all the same: --set 'coupling.force=[\"unstable\"]'";
/// The same of a fluid alone.
const FLOW_REMEDY: &str = "give a smaller fluid.time.dt or fluid.time.cfl; to go on all the same: \
    --set 'coupling.force=[\"unstable\"]'";

/// Overlap over a radius that ends a run of grains alone: beyond it they pass through each other.
const MOST_OVERLAP: f64 = 1.0;

/// The windows of a solver alone: as long as its clock says, until the scene's end or until the grains rest.
pub(crate) struct AloneSchedule {
    clock: Clock,
    until: f64,
    observe: Observe,
    rest: Option<Rest>,
    /// Is a window on its way?
    under_way: bool,
    /// None where a run is to go on all the same.
    watch: Option<(Energy, Flow)>,
    overlap: Option<Overlap>,
    state: AloneState,
}

/// Overlap over a radius in the window in which a wall appears that says that it did so within grains.
const OVERLAP_AT_A_WALL: f64 = 0.02;

/// How deep grains may lie in each other and in walls.
struct Overlap {
    appearing: Appearing,
    /// Was the user told that contacts are too soft?
    told: bool,
}

impl Overlap {
    /// Takes the largest overlap of a window over the smaller half width.
    fn take(&mut self, window: &Window, part: f64) -> Result<(), Failure> {
        let end = window.time + window.dt;
        let appears = self.appearing.any(window.time, end);
        let most = if appears { OVERLAP_AT_A_WALL } else { DemFacts::MOST_OVERLAP };
        if part <= most || self.told && part <= MOST_OVERLAP {
            return Ok(());
        }
        let found = format!(
            "overlap: grains lie {:.1} % of the smaller radius (half width) in each other or in a wall in window {} \
             (t = {} s){}",
            100.0 * part,
            window.step,
            window.time,
            self.appearing.words(end)
        );
        let remedy = "shorten the contact time (dem.contact.contact_time), or stiffen the law";
        if part > MOST_OVERLAP {
            return Err(Failure::Run(format!(
                "{found}, at most {:.0} %; to go on all the same: --set 'coupling.force=[\"overlap\"]'; {remedy}",
                100.0 * MOST_OVERLAP
            )));
        }
        if appears {
            protocol::say!("warning: {found}");
        } else {
            self.told = true;
            protocol::say!("warning: {found}; contacts are softer than at 10 %: {remedy}");
        }
        Ok(())
    }
}

impl AloneSchedule {
    /// From the start of a run, or from a checkpoint; contacts last `contact_time`, s.
    pub(crate) fn new(
        scene: &CheckedScene,
        clock: Clock,
        contact_time: f64,
        from: Option<AloneState>,
    ) -> Self {
        let (seen, flow) = (Seen::default(), FlowSeen::default());
        let start =
            AloneState { step: 0, time: 0.0, limit: f64::INFINITY, rests: false, since: None, seen, flow };
        let state = from.unwrap_or(start);
        let forced = scene.scene.coupling.get("force").and_then(|force| force.as_array());
        let forced =
            |name: &str| forced.is_some_and(|names| names.iter().any(|forced| forced.as_str() == Some(name)));
        // What too few sub-steps do is told as unstable.
        let resolved = contact_time >= DemFacts::LEAST_CONTACT_STEPS * clock.substep;
        let overlap = (resolved && !forced("overlap"))
            .then(|| Overlap { appearing: Appearing::of(&scene.scene.walls), told: false });
        let watch = (!forced(unstable::NAME))
            .then(|| (Energy::new(scene, contact_time, state.seen), Flow::new(scene, state.flow.clone())));
        let (until, observe) = (scene.scene.until, scene.scene.observe.clone());
        Self { clock, until, observe, rest: Rest::new(scene), under_way: false, watch, overlap, state }
    }
}

impl Schedule for AloneSchedule {
    type State = AloneState;

    fn state(&self) -> AloneState {
        let mut state = self.state.clone();
        if let Some((energy, flow)) = &self.watch {
            (state.seen, state.flow) = (energy.seen(), flow.seen().clone());
        }
        state
    }

    fn step(&self) -> u64 {
        self.state.step
    }

    fn time(&self) -> f64 {
        self.state.time
    }

    fn is_over(&self) -> bool {
        self.state.time >= self.until || self.state.rests
    }

    fn next_window(&mut self) -> Result<Option<Ordered>, Failure> {
        if std::mem::replace(&mut self.under_way, true) {
            return Ok(None);
        }
        let AloneState { step, time, limit, .. } = self.state;
        let mut window = self.clock.next(step, time, self.until, limit, false);
        window.output = self.observe.fields_due(window.time, window.time + window.dt);
        Ok(Some(window.into()))
    }

    fn accept(&mut self, window: &Window, messages: &Messages<'_>) -> Result<(), Failure> {
        let time = window.time + window.dt;
        if let Some((energy, flow)) = &mut self.watch {
            let Messages { loads, kinematics, speed, .. } = messages;
            if let Some(found) = energy.take(window, loads, kinematics) {
                return Err(Failure::Unstable(found.message(window, REMEDY)));
            }
            if let Some(found) = speed.and_then(|speed| flow.take(window, loads, speed)) {
                return Err(Failure::Unstable(found.message(window, FLOW_REMEDY)));
            }
        }
        if let (Some(overlap), Some(_)) = (&mut self.overlap, messages.kinematics_header) {
            overlap.take(window, messages.residual)?;
        }
        let AloneState { step, time: at, limit, rests, since, .. } = &mut self.state;
        (*step, *at, *limit) = (window.step + 1, time, messages.dt_limit);
        *rests = self.rest.as_ref().is_some_and(|rest| rest.reached(time, messages.kinematics, since));
        self.under_way = false;
        Ok(())
    }

    /// How far, how much work, how lively.
    fn progress(&self, window: &Window, messages: &Messages<'_>, observer: &Observer) -> String {
        let steps = match observer.tally().substeps {
            0 => format!("step {}", window.step + 1),
            substeps => format!("{substeps} sub-steps"),
        };
        let energy = observer.latest("kinetic_energy");
        let energy = energy.map_or(String::new(), |energy| format!(", kinetic energy {energy:.3e} J"));
        let share = self.rest.as_ref().and_then(|rest| rest.energy(messages.kinematics));
        let share = share.map_or(String::new(), |share| format!(" = {share:.1e} m g R"));
        format!("t = {:.6} of {} s, {steps}{energy}{share}", self.state.time, self.until)
    }
}

/// A solver that runs alone.
struct Alone<'a, S: Solver> {
    scene: &'a CheckedScene,
    folder: &'a OutputFolder,
    facts: &'a S::Facts,
    clock: Clock,
    contact_time: f64,
}

impl<S: Solver> Setup for Alone<'_, S> {
    type Link = InProcess<S>;
    type Schedule = AloneSchedule;

    fn write_scene(&self) -> Result<(), Failure> {
        let (fluid, dem) = S::facts_by_role(self.facts);
        let sections = [fluid.map(|facts| &facts.resolved), dem.map(|facts| &facts.resolved), None];
        Ok(self.folder.write_scene(self.scene, sections)?)
    }

    fn start(&self, from: Option<(PathBuf, AloneState)>) -> Result<(InProcess<S>, AloneSchedule), Failure> {
        let mut solver = S::build(self.scene, self.folder.root())?;
        let mut state = None;
        if let Some((folder, position)) = from {
            solver.read_checkpoint(&folder)?;
            state = Some(position);
        }
        let link = InProcess::alone(solver, S::stand_in(self.scene)?, self.folder.root());
        Ok((link, AloneSchedule::new(self.scene, self.clock, self.contact_time, state)))
    }
}

/// Seconds between checkpoints where `coupling.checkpoint_every` says nothing.
const CHECKPOINT_EVERY: f64 = 60.0;

/// Runs a solver alone, from the scene's start or from a checkpoint, to the scene's end.
pub(crate) fn run<S: Solver>(options: &RunOptions) -> Result<(), Failure> {
    let begin = Instant::now();
    let scene = options.read_scene()?;
    let facts = S::facts(&scene)?;
    // Refuses a scene that needs the other solver.
    let _ = S::stand_in(&scene)?;
    if let Ok(facts) = toml::Table::try_from(&facts) {
        protocol::detail!("{facts}");
    }
    let folder = options.folder(&scene)?;
    // The section is the coupler's; of it only these keys mean something to a solver alone.
    let key = |name: &str| scene.scene.coupling.get(name);
    let every = key("checkpoint_every")
        .and_then(|value| value.as_float().or(value.as_integer().map(|whole| whole as f64)));
    let recorded = !options.no_record && key("record").and_then(|value| value.as_bool()) != Some(false);
    let clock = S::clock(&scene, &facts);
    let contact_time = S::facts_by_role(&facts).1.map_or(f64::INFINITY, |facts| facts.contact_time);
    let job = Job {
        program: S::PROGRAM,
        scene: &scene,
        folder: &folder,
        resume: options.resume,
        interrupts: &Interrupts::listen(2)?,
        sides: match S::ROLE {
            Role::Fluid => Sides::fluid_alone(!scene.grains.is_empty()),
            Role::Dem => Sides::dry(),
        },
        dt: clock.window,
        contact_time,
        checkpoint_every: every.unwrap_or(CHECKPOINT_EVERY),
        log: recorded.then_some(LogKind::Alone(S::ROLE)),
        begin,
    };
    let setup = Alone::<S> { scene: &scene, folder: &folder, facts: &facts, clock, contact_time };
    with_threads(options.threads(), || run::run(&job, &setup))?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_window_lands_on_the_end() {
        let clock = Clock { window: 0.1, substep: 0.03, adaptive: false };
        let (mut time, mut step) = (0.0, 0);
        while time < 1.05 {
            let window = clock.next(step, time, 1.05, f64::INFINITY, false);
            assert_eq!(window.substeps, if window.dt > 0.09 { 4 } else { 3 });
            assert!(window.dt > 0.07, "no window is a sliver: {}", window.dt);
            time = window.time + window.dt;
            step += 1;
        }
        assert_eq!((time, step), (1.05, 11));
    }
}
