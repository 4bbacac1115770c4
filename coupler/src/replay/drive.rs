//! A solver driven window by window from a log: this process is the coupler and the other side.

use std::path::{Path, PathBuf};
use std::time::Instant;

use bedload_output::{OutputFolder, atomic_write};
use bedload_program::alone::{buoyancy, prescribed_motion};
use bedload_program::replay::{self, LogOptions, LogSchedule};
use bedload_program::{Interrupts, Link, Messages, Ordered};
use bedload_scene::CheckedScene;
use protocol::channel::remove_stale_runs;
use protocol::log::{LogReader, Records};
use protocol::message::{Command, Kinematics, Loads};
use protocol::participant::{Role, Window};
use protocol::scheme::Scheme;

use super::changed::{changed, logged};
use super::divergence::Divergence;
use super::request::{Figure, Replay};
use super::substeps::{Substeps, aimed_at};
use crate::config::Coupling;
use crate::failure::Failure;
use crate::number::Short;
use crate::scratch::scratch;
use crate::solo_run::{Setting, Setup, SoloRun, Turn};
use crate::solvers::Solver;

/// Drives the solver through the log, prints what differs, and writes `divergence.csv` and `.svg` where an
/// output folder is named. Differences are the result, and no failure. Fails at a scene that does not fit, a
/// solver that fails, a log that is damaged or breaks off. What was compared until then is printed and
/// written all the same.
pub(super) fn compare(
    request: &Replay,
    figure: Figure,
    reader: LogReader,
    interrupts: &Interrupts,
) -> Result<(), Failure> {
    if let Err(error) = remove_stale_runs() {
        protocol::say!("bedload: warning: cannot remove what dead runs left: {error}");
    }
    if request.checkpoint.is_some() && !request.overrides.is_empty() {
        return Err(Failure::Input(
            "--set with --checkpoint: a checkpoint is of one scene; replay the log of a run from its start"
                .into(),
        ));
    }
    let folder = scratch().map_err(Failure::Run)?;
    let (setup, substeps) = prepare(request, &reader, folder.path())?;
    let divergence = Divergence::new(setup.role, &setup.scene);
    let title = reader.manifest().title.clone();
    let begin = Instant::now();
    let (divergence, outcome) = run(request, &setup, &substeps, reader, interrupts, divergence);
    let seconds = begin.elapsed().as_secs_f64();
    // Before anything is printed: a pipe may be closed.
    let written = match &request.out {
        Some(out) => write(&divergence, &title, request, figure, out)?,
        None => Vec::new(),
    };
    protocol::show!(
        "{} windows of {} compared, given to the {} solver `{}` in {} s; what it sends changes nothing in what it is \
         given",
        divergence.windows(),
        request.log.display(),
        setup.role,
        setup.command.join(" "),
        Short(seconds)
    );
    print!("{}", divergence.summary());
    for path in written {
        println!("{}", path.display());
    }
    outcome
}

/// Reads the scene, asks the solver, and prepares its folder.
fn prepare(request: &Replay, reader: &LogReader, scratch: &Path) -> Result<(Setup, Substeps), Failure> {
    let manifest = reader.manifest();
    let (scene, solver) = changed(request, manifest)?;
    let coupling = Coupling::read(&scene)?;
    let before = logged(request, manifest)?;
    let aim = |solver: &Solver, scene: &CheckedScene, coupling: &Coupling, name: &str| {
        let path = scratch.join(name);
        atomic_write(&path, scene.source.text.as_bytes())?;
        // The solver names the file that it was given, which is of this question alone.
        let said = |text: String| text.replace(&*path.to_string_lossy(), &scene.source.file);
        aimed_at(solver, scene, coupling, &path).map_err(|failure| match failure {
            Failure::Input(text) => Failure::Input(said(text)),
            other => other,
        })
    };
    let substeps = match request.overrides.is_empty() {
        true => Substeps::default(),
        false => Substeps {
            now: aim(&solver, &scene, &coupling, "changed.toml")?,
            // Of a scene that our solver cannot read the sub-step is not known.
            logged: Coupling::read(&before)
                .map_err(Failure::from)
                .and_then(|coupling| aim(&Solver::ours(request.drive), &before, &coupling, "logged.toml"))
                .unwrap_or(None),
        },
    };
    let root = request.out.clone().unwrap_or_else(|| scratch.join("out"));
    let folder = OutputFolder::create(&root, &scene, false)?;
    if !solver.is_ours() {
        folder.write_scene_in_full(&scene, [None; 3])?;
    }
    let file = if solver.is_ours() { folder.scene() } else { folder.scene_in_full() };
    let (role, command) = (request.drive, solver.run_command());
    let join_s = coupling.startup_deadline;
    Ok((Setup { role, command, scene, coupling, folder, file, join_s }, substeps))
}

/// What the other side sends in a window that the log has no message of it for: it took no part.
type Peer = Box<dyn Fn(&Window) -> Records>;

/// The solver as a process, given the messages of the log.
struct Driven<'a> {
    run: SoloRun<'a>,
    role: Role,
    peer: Peer,
    ordered: Option<Command>,
    sent: Option<Turn>,
}

impl Driven<'_> {
    fn failed(&self, step: u64, error: &str) -> Failure {
        let what = format!("the {} solver: window {step}: {error}", self.role);
        if self.run.has_failed() { Failure::Run(what) } else { Failure::Peer(what) }
    }
}

impl Link for Driven<'_> {
    fn order(&mut self, Ordered { command, given, .. }: Ordered) {
        self.run.replace(given.map_or_else(|| (self.peer)(&command.into()), |(_, records)| records));
        self.ordered = Some(command);
    }

    fn await_window(&mut self) -> Result<Option<Command>, Failure> {
        let Some(command) = self.ordered.take() else { return Ok(None) };
        let sent = self.run.play(command);
        self.sent = Some(sent.map_err(|error| self.failed(command.step, &error))?);
        Ok(Some(command))
    }

    fn messages(&self) -> Messages<'_> {
        match &self.sent {
            Some(Turn { header, records: Records::Loads(loads), .. }) => {
                Messages { loads, loads_header: Some(header), ..Messages::default() }
            }
            Some(Turn { header, records: Records::Kinematics(kinematics), .. }) => {
                Messages { kinematics, kinematics_header: Some(header), ..Messages::default() }
            }
            None => Messages::default(),
        }
    }

    fn accept(&mut self, command: Command) -> Result<(), Failure> {
        self.run.order(command).map_err(Failure::Peer)
    }

    /// Nothing is kept of a replay.
    fn checkpoint(&mut self, _: u64, _: f64) -> Result<(), Failure> {
        Ok(())
    }

    fn stop(&mut self, _: u64, _: f64) -> Result<(), Failure> {
        self.run.stop().map_err(|error| Failure::Peer(format!("the {} solver {error}", self.role)))
    }
}

/// Starts the solver and drives it through the log.
fn run(
    request: &Replay,
    setup: &Setup,
    substeps: &Substeps,
    reader: LogReader,
    interrupts: &Interrupts,
    divergence: Divergence,
) -> (Divergence, Result<(), Failure>) {
    let coupling = &setup.coupling;
    // A DEM goes back to the start of the window each time: only what was accepted matters to it.
    let repeats = coupling.scheme.named() == Some(Scheme::Iterated) && setup.role == Role::Fluid;
    let writes = request.out.is_some();
    let setting = Setting {
        repeatable: repeats,
        // Files take their time.
        deadline: writes.then_some(6.0 * coupling.deadline),
        checkpoint: request.checkpoint.as_deref(),
        ..Setting::default()
    };
    let peer = peer(setup.role, &setup.scene, reader.manifest().grains());
    let first = Window { step: 0, attempt: 0, time: 0.0, dt: 0.0, substeps: 1, output: false };
    let run = match SoloRun::open(setup, peer(&first), setting) {
        Ok(run) => run,
        Err(error) => {
            let what = format!("the {} solver does not join: {error}", setup.role);
            return (divergence, Err(Failure::Peer(what)));
        }
    };
    let substeps = |command: &Command| substeps.order(*command).substeps;
    let options = LogOptions {
        drive: setup.role,
        attempts: repeats,
        accepts: repeats,
        fields: writes,
        substeps: Some(&substeps),
    };
    let link = Driven { run, role: setup.role, peer, ordered: None, sent: None };
    let driven = replay::drive(link, LogSchedule::new(reader, divergence, options), interrupts);
    let outcome = driven.outcome.and_then(|()| {
        if let Some((step, _)) = driven.unfinished {
            protocol::say!("bedload: window {step} was not finished, and is not compared");
        }
        let cut = |cut| Err(Failure::BreaksOff(format!("{cut}; all windows up to there were given")));
        driven.cut.map_or(Ok(()), cut)
    });
    (driven.compare, outcome)
}

/// What the plain loop of a solver alone says in place of the absent one.
fn peer(driven: Role, scene: &CheckedScene, grains: usize) -> Peer {
    match driven {
        Role::Dem => {
            let answer = buoyancy(scene);
            Box::new(move |window| {
                let mut loads = vec![Loads::default(); grains];
                answer(window, &mut loads);
                Records::Loads(loads)
            })
        }
        Role::Fluid => {
            let answer = prescribed_motion(scene);
            Box::new(move |window| {
                let mut motion = vec![Kinematics::default(); grains];
                answer(window, &mut motion);
                Records::Kinematics(motion)
            })
        }
    }
}

fn write(
    divergence: &Divergence,
    title: &str,
    request: &Replay,
    figure: Figure,
    out: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    let name = if title.is_empty() { "Replay" } else { title };
    let title = match &request.overrides[..] {
        [] => format!("{name}: replay against log"),
        [only] if only.chars().count() <= 60 => format!("{name}: replay with {only} against log"),
        more => format!("{name}: replay with {} other value(s) against log", more.len()),
    };
    for (file, text) in
        [("divergence.csv", divergence.csv()), ("divergence.svg", figure(&title, divergence.curves()))]
    {
        let path = out.join(file);
        atomic_write(&path, text.as_bytes())?;
        written.push(path);
    }
    Ok(written)
}
