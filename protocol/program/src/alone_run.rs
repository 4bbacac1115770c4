//! `run`: a solver alone, with the options and the output folder of a coupled run.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::alone::{self, Clock, StandIn};
use crate::alone_log::AloneLog;
use crate::error::ProgramError;
use crate::options::RunOptions;
use crate::progress::Progress;
use crate::solver::Solver;
use crate::threads::with_threads;
use bedload_output::{Observer, OutputFolder, RunStatus, Sides, Summary};
use bedload_scene::{CheckedScene, Motion, Rest};
use protocol::checkpoint;
use protocol::checkpoints;
use protocol::message::Header;
use protocol::participant::{Role, SolverError, Window};
use protocol::serve::checkpoint_folder;

/// Where the plain loop stands; part of its checkpoint.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Position {
    step: u64,
    time: f64,
    limit: f64,
    observed: bedload_output::ObserverState,
}

/// Role of the file of a checkpoint that is written last, and makes it whole.
const LAST: &str = "loop";

/// Folder of the newest whole checkpoint. Where there is none, the folder in which it would lie: a reader says so.
fn newest(folder: &OutputFolder) -> PathBuf {
    checkpoints::newest(&folder.checkpoint(), LAST).unwrap_or_else(|| folder.checkpoint())
}

/// Seconds between checkpoints where `coupling.checkpoint_every` says nothing.
const CHECKPOINT_EVERY: f64 = 60.0;

/// Seconds between checkpoints; infinite: only at the end and on interruption.
fn checkpoint_every(scene: &CheckedScene) -> f64 {
    let value = scene.scene.coupling.get("checkpoint_every");
    let seconds = value.and_then(|value| value.as_float().or(value.as_integer().map(|whole| whole as f64)));
    match seconds {
        None => CHECKPOINT_EVERY,
        Some(seconds) if seconds > 0.0 => seconds,
        Some(_) => f64::INFINITY,
    }
}

/// Runs a solver alone, from the scene's start or from a checkpoint, to the scene's end.
pub(crate) fn run<S: Solver>(options: &RunOptions) -> Result<(), ProgramError> {
    let scene = options.read_scene()?;
    let facts = S::facts(&scene)?;
    let answer = S::stand_in(&scene)?;
    let folder = options.folder(&scene)?;
    if options.resume && goes_nowhere::<S>(&folder, &scene)? {
        return Ok(());
    }
    let mut summary = Summary::new(&scene, env!("CARGO_PKG_VERSION"));
    let begun = begin::<S>(options, &folder, &scene, &facts, answer);
    let mut run = begun.inspect_err(|error| {
        summary.fail(error);
        // The first failure counts, and is told.
        let _ = summary.write(&folder.summary());
    })?;
    let begin = Instant::now();
    let outcome = with_threads(options.threads(), || run.advance_to_end())?;
    // What failed first is the cause.
    let logged = run.log.take().map_or(Ok(()), AloneLog::finish);
    let outcome = outcome.and_then(|()| Ok(logged?));
    let summarised = run.summarise(&mut summary, begin, outcome.is_ok());
    // A full disk fails everything after it.
    let outcome = outcome.and(summarised);
    match &outcome {
        Ok(()) => {}
        Err(ProgramError::Interrupted) => summary.status = RunStatus::Interrupted,
        Err(error) => summary.fail(error),
    }
    let written = summary.write(&folder.summary());
    let outcome = outcome.and_then(|()| Ok(written?));
    if let Err(ProgramError::Solver(SolverError::Failed(_))) = &outcome {
        // The failure counts; without this checkpoint the last regular one stands.
        match with_threads(options.threads(), || run.rewind())? {
            Ok(at) => protocol::say!("{}: {at}", S::PROGRAM),
            Err(error) => {
                protocol::say!("{}: no checkpoint of the step before the failure: {error}", S::PROGRAM);
            }
        }
    }
    outcome
}

/// Says of a finished run that goes on to no later time that there is nothing to do.
fn goes_nowhere<S: Solver>(folder: &OutputFolder, scene: &CheckedScene) -> Result<bool, ProgramError> {
    let nowhere = folder.is_finished_to(scene.scene.until);
    if nowhere {
        // A run of another scene, or of one that ends earlier, is refused before it is called finished.
        let at: Position = checkpoint::read(&newest(folder), LAST, &scene.state_sha256())?;
        scene.goes_on_from(at.time)?;
        let root = folder.root().display();
        protocol::say!(
            "{}: {root} is finished: nothing to do; --until with a later time goes on",
            S::PROGRAM
        );
    }
    Ok(nowhere)
}

/// Builds the solver, and brings it to where the run begins.
fn begin<'a, S: Solver>(
    options: &RunOptions,
    folder: &'a OutputFolder,
    scene: &'a CheckedScene,
    facts: &S::Facts,
    answer: alone::Answer<S::Incoming>,
) -> Result<Run<'a, S>, ProgramError> {
    let (fluid, dem) = S::facts_by_role(facts);
    let solver = S::build(scene, folder.root())?;
    let clock = S::clock(scene, facts);
    let contact_time = dem.map_or(f64::INFINITY, |facts| facts.contact_time);
    let mut run = Run::new(folder, scene, solver, clock, options.resume, contact_time, answer)?;
    folder.remove_summary()?;
    folder.write_scene(scene, fluid, dem, None)?;
    // The section is the coupler's; of it only this key means something to a solver alone.
    let wanted = scene.scene.coupling.get("record").and_then(|value| value.as_bool()) != Some(false);
    if wanted && !options.no_record {
        let at = (run.position.step, run.position.time);
        run.log = AloneLog::begin(S::PROGRAM, S::ROLE, scene, folder, clock.window, at)?;
    }
    Ok(run)
}

/// A run of a solver alone under way.
struct Run<'a, S: Solver> {
    folder: &'a OutputFolder,
    scene: &'a CheckedScene,
    solver: S,
    exchange: StandIn<S::Incoming, S::Outgoing>,
    clock: Clock,
    observer: Observer,
    position: Position,
    /// Step of the checkpoint of this run that stands on the disk.
    saved: Option<u64>,
    contact_time: f64,
    rest: Option<Rest>,
    stop: Arc<AtomicBool>,
    log: Option<AloneLog>,
}

impl<'a, S: Solver> Run<'a, S> {
    fn new(
        folder: &'a OutputFolder,
        scene: &'a CheckedScene,
        mut solver: S,
        clock: Clock,
        resume: bool,
        contact_time: f64,
        answer: alone::Answer<S::Incoming>,
    ) -> Result<Self, ProgramError> {
        let sides = match S::ROLE {
            Role::Fluid => Sides::fluid_alone(!scene.grains.is_empty()),
            Role::Dem => Sides::dry(),
        };
        let stop = Arc::new(AtomicBool::new(false));
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        for signal in [SIGHUP, SIGINT, SIGTERM] {
            // A second signal ends the program at once.
            signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&stop))
                .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
                .map_err(|error| SolverError::Failed(format!("cannot handle signals: {error}")))?;
        }
        let (position, observer) = if resume {
            let from = newest(folder);
            let position: Position = checkpoint::read(&from, LAST, &scene.state_sha256())?;
            scene.goes_on_from(position.time)?;
            solver.read_checkpoint(&from)?;
            let observer = Observer::resume(folder, scene, sides, &[], position.observed.clone())?;
            (position, observer)
        } else {
            let observed = bedload_output::ObserverState::default();
            let position = Position { step: 0, time: 0.0, limit: f64::INFINITY, observed };
            (position, Observer::create(folder, scene, sides, &[])?)
        };
        let exchange = StandIn::new(solver.grains(), answer);
        let rest = Rest::new(scene);
        let saved = resume.then_some(position.step);
        Ok(Self {
            folder,
            scene,
            solver,
            exchange,
            clock,
            observer,
            position,
            saved,
            contact_time,
            rest,
            stop,
            log: None,
        })
    }

    fn advance_to_end(&mut self) -> Result<(), ProgramError> {
        let until = self.scene.scene.until;
        let mut progress = Progress::new(S::PROGRAM, self.position.time, until, self.rest.is_some());
        let outcome = self.advance(until, &mut progress);
        progress.finish();
        outcome
    }

    fn advance(&mut self, until: f64, progress: &mut Progress) -> Result<(), ProgramError> {
        let (mut saved, every) = (Instant::now(), checkpoint_every(self.scene));
        while self.position.time < until && !self.rests() {
            if self.stop.load(Ordering::Relaxed) {
                self.checkpoint()?;
                return Err(ProgramError::Interrupted);
            }
            let at = &self.position;
            let mut window = self.clock.next(at.step, at.time, until, at.limit, false);
            window.output = self.scene.scene.observe.fields_due(window.time, window.time + window.dt);
            self.window(&window)?;
            progress.tell(self.position.time, || self.standing(&window));
            if saved.elapsed().as_secs_f64() > every {
                self.checkpoint()?;
                saved = Instant::now();
            }
        }
        self.checkpoint()
    }

    /// How far, how much work, how lively.
    fn standing(&self, window: &Window) -> String {
        let steps = match self.observer.tally().substeps {
            0 => format!("step {}", window.step + 1),
            substeps => format!("{substeps} sub-steps"),
        };
        let energy = self.observer.latest("kinetic_energy");
        let energy = energy.map_or(String::new(), |energy| format!(", kinetic energy {energy:.3e} J"));
        let share = self.rest.as_ref().and_then(|rest| rest.energy(self.exchange_kinematics()));
        let share = share.map_or(String::new(), |share| format!(" = {share:.1e} m g R"));
        format!("t = {:.6} of {} s, {steps}{energy}{share}", self.position.time, self.scene.scene.until)
    }

    fn exchange_kinematics(&self) -> &[protocol::message::Kinematics] {
        S::sides(self.exchange.incoming(), self.exchange.outgoing().1).1
    }

    /// Whether the scene asks to stop here.
    fn rests(&self) -> bool {
        self.position.step > 0
            && self
                .rest
                .as_ref()
                .is_some_and(|rest| rest.reached(self.position.time, self.exchange_kinematics()))
    }

    fn window(&mut self, window: &Window) -> Result<(), ProgramError> {
        let report = alone::advance(&mut self.solver, window, &mut self.exchange)?;
        let (sent, outgoing) = self.exchange.outgoing();
        let (loads, kinematics) = S::sides(self.exchange.incoming(), outgoing);
        let header: &Header = sent;
        let sample =
            bedload_output::Sample { window, loads, header, kinematics, extras: &self.solver.scalars() };
        self.observer.record(&sample)?;
        if let Some(log) = &self.log {
            log.record(window, header, loads, kinematics)?;
        }
        self.position.step += 1;
        self.position.time = window.time + window.dt;
        self.position.limit = report.dt_limit;
        Ok(())
    }

    fn checkpoint(&mut self) -> Result<(), ProgramError> {
        self.position.observed = self.observer.state()?;
        let here = checkpoint_folder(self.folder.root(), self.position.step);
        self.solver.write_checkpoint(&here)?;
        checkpoint::write(&here, LAST, &self.scene.state_sha256(), &self.position)?;
        checkpoints::remove_others(&self.folder.checkpoint(), Some(&here));
        self.saved = Some(self.position.step);
        Ok(())
    }

    /// After a failure: a checkpoint of the step before it, and a line about it.
    ///
    /// The solver has lost that state, and no step pays for a copy of it: what led there is done
    /// again, bit for bit, from the last checkpoint or the start. Series and metrics stand there already.
    fn rewind(mut self) -> Result<String, ProgramError> {
        let (here, folder, identity) =
            (self.position.step, self.folder.checkpoint(), self.scene.state_sha256());
        if self.saved == Some(here) {
            return Ok(format!("the checkpoint stands at step {here}, before the failure"));
        }
        // Two solvers might not fit.
        drop(self.solver);
        self.solver = S::build(self.scene, self.folder.root())?;
        let (mut step, mut time, mut limit) = (0, 0.0, f64::INFINITY);
        if self.saved.is_some() {
            let newest = newest(self.folder);
            let from: Position = checkpoint::read(&newest, LAST, &identity)?;
            self.solver.read_checkpoint(&newest)?;
            (step, time, limit) = (from.step, from.time, from.limit);
        }
        protocol::say!(
            "{}: doing steps {step} to {here} again for a checkpoint before the failure",
            S::PROGRAM
        );
        while step < here {
            if self.stop.load(Ordering::Relaxed) {
                return Err(ProgramError::Interrupted);
            }
            let window = self.clock.next(step, time, self.scene.scene.until, limit, false);
            limit = self.solver.advance(&window, &mut self.exchange)?.dt_limit;
            (step, time) = (step + 1, window.time + window.dt);
        }
        self.checkpoint()?;
        Ok(format!("checkpoint of step {here}, before the failure, in {}", folder.display()))
    }

    fn summarise(
        &mut self,
        summary: &mut Summary,
        begin: Instant,
        in_order: bool,
    ) -> Result<(), ProgramError> {
        self.observer.finish(summary, self.contact_time)?;
        summary.cost.wall_s = begin.elapsed().as_secs_f64();
        let (cpu, memory) = (self.solver.solver_seconds(), protocol::memory::peak_rss_bytes());
        match S::ROLE {
            Role::Fluid => {
                summary.cost.fluid_cpu_s = cpu;
                summary.cost.peak_rss_bytes.fluid = Some(memory);
            }
            Role::Dem => {
                summary.cost.dem_cpu_s = cpu;
                summary.cost.peak_rss_bytes.dem = Some(memory);
            }
        }
        let free = self.scene.grains.iter().filter(|grain| grain.motion == Motion::Free).count();
        summary.set_unit_costs(free as u64);
        if in_order {
            summary.metrics.extend(self.solver.finish(self.scene, self.folder)?);
        }
        summary.remark(&self.scene.scene.metrics);
        Ok(())
    }
}
