//! A solver driven window by window from a log: this process is the coupler and the other side.

use std::path::{Path, PathBuf};
use std::time::Instant;

use bedload_output::{OutputFolder, atomic_write};
use bedload_program::alone::{buoyancy, prescribed_motion};
use bedload_scene::CheckedScene;
use protocol::channel::remove_stale_runs;
use protocol::log::{LogReader, LoggedWindow, Windows};
use protocol::message::{Command, Kinematics, Loads, Order};
use protocol::participant::{Role, Window};
use protocol::scheme::Scheme;

use super::changed::{changed, logged};
use super::divergence::Divergence;
use super::request::Replay;
use super::substeps::{Substeps, aimed_at};
use crate::config::Coupling;
use crate::failure::Failure;
use crate::number::Short;
use crate::scratch::Scratch;
use crate::solvers::Solver;
use crate::stage::{Lines, Setting, Stage, Stand};
use crate::supervise::Interrupts;

/// Drives the solver through the log, prints what differs, and writes `divergence.csv` and `.svg` where an output
/// folder is named. Differences are the result, and no failure.
///
/// # Errors
/// [`Failure`]: a scene that does not fit, a solver that fails, a log that is damaged or breaks off. What was
/// compared until then is told and written all the same.
pub(super) fn compare(request: &Replay, reader: LogReader, interrupts: &Interrupts) -> Result<(), Failure> {
    if let Err(error) = remove_stale_runs() {
        protocol::say!("bedload: warning: cannot remove what dead runs left: {error}");
    }
    if request.checkpoint.is_some() && !request.overrides.is_empty() {
        return Err(Failure::Input(
            "--set with --checkpoint: a checkpoint is of one scene; replay the log of a run from its start"
                .into(),
        ));
    }
    let scratch = Scratch::new().map_err(Failure::Run)?;
    let (stand, substeps) = prepare(request, &reader, scratch.path())?;
    let mut drive = Drive::new(request, &stand, substeps, &reader);
    let title = reader.manifest().title.clone();
    let begin = Instant::now();
    let outcome = drive.run(reader, interrupts);
    let seconds = begin.elapsed().as_secs_f64();
    // Before anything is printed: a pipe may be closed.
    let written = match &request.out {
        Some(out) => write(&drive.divergence, &title, request, out)?,
        None => Vec::new(),
    };
    println!(
        "{} windows of {} compared, given to the {} solver `{}` in {} s; what it sends changes nothing in what it is \
         given",
        drive.divergence.windows(),
        request.log.display(),
        stand.role,
        stand.command.join(" "),
        Short(seconds)
    );
    print!("{}", drive.divergence.summary());
    for path in written {
        println!("{}", path.display());
    }
    outcome
}

/// Reads the scene, asks the solver, and prepares its folder.
fn prepare(request: &Replay, reader: &LogReader, scratch: &Path) -> Result<(Stand, Substeps), Failure> {
    let manifest = reader.manifest();
    let now = changed(request, manifest)?;
    let coupling = Coupling::read(&now.scene)?;
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
            now: aim(&now.solver, &now.scene, &coupling, "changed.toml")?,
            // Of a scene that our solver cannot read the sub-step is not known.
            logged: Coupling::read(&before)
                .map_err(Failure::from)
                .and_then(|coupling| aim(&Solver::ours(request.drive), &before, &coupling, "logged.toml"))
                .unwrap_or(None),
        },
    };
    let root = request.out.clone().unwrap_or_else(|| scratch.join("out"));
    refuse_run(&root)?;
    let folder = OutputFolder::create(&root, &now.scene, false)?;
    if !now.solver.is_ours() {
        folder.write_scene_in_full(&now.scene, None, None, None)?;
    }
    let file = if now.solver.is_ours() { folder.scene() } else { folder.scene_in_full() };
    let (role, command) = (request.drive, now.solver.run_command());
    let join_s = coupling.startup_deadline;
    Ok((Stand { role, command, scene: now.scene, coupling, folder, file, join_s }, substeps))
}

/// A folder with a run in it would be emptied, perhaps of the log itself.
fn refuse_run(folder: &Path) -> Result<(), Failure> {
    let of_run =
        ["exchange.mcap", "series.csv", "summary.json"].into_iter().find(|name| folder.join(name).exists());
    of_run.map_or(Ok(()), |name| {
        let folder = folder.display();
        Err(Failure::Input(format!(
            "{folder} holds a run ({name}): name a new folder for the replay with --out"
        )))
    })
}

/// A replay under way.
struct Drive<'a> {
    request: &'a Replay,
    stand: &'a Stand,
    substeps: Substeps,
    peer: Peer,
    divergence: Divergence,
}

/// What the other side says in a window that the log has no message of it for: it took no part.
type Peer = Box<dyn Fn(&Window) -> Lines>;

impl<'a> Drive<'a> {
    fn new(request: &'a Replay, stand: &'a Stand, substeps: Substeps, reader: &LogReader) -> Self {
        let grains = reader.manifest().grains();
        let divergence = Divergence::new(stand.role, &stand.scene);
        Self { request, stand, substeps, peer: peer(stand.role, &stand.scene, grains), divergence }
    }

    fn run(&mut self, reader: LogReader, interrupts: &Interrupts) -> Result<(), Failure> {
        let coupling = &self.stand.coupling;
        let repeats = coupling.scheme.named() == Some(Scheme::Iterated) && self.stand.role == Role::Fluid;
        let writes = self.request.out.is_some();
        let setting = Setting {
            repeatable: repeats,
            // Files take their time.
            deadline: writes.then_some(6.0 * coupling.deadline),
            checkpoint: self.request.checkpoint.as_deref(),
            ..Setting::default()
        };
        let first = Window { step: 0, attempt: 0, time: 0.0, dt: 0.0, substeps: 1, output: false };
        let stage = Stage::open(self.stand, (self.peer)(&first), setting);
        let mut stage = stage.map_err(|error| {
            Failure::Peer(format!("the {} solver does not join: {error}", self.stand.role))
        })?;
        let mut windows = reader.windows();
        let cut = self.windows(&mut windows, &mut stage, repeats, interrupts)?;
        stage.stop().map_err(|error| Failure::Peer(format!("the {} solver {error}", self.stand.role)))?;
        if let Some((step, _)) = windows.unfinished() {
            protocol::say!("bedload: window {step} was not finished, and is not compared");
        }
        cut.map_or(Ok(()), |cut| {
            Err(Failure::BreaksOff(format!("{cut}; all windows up to there were given")))
        })
    }

    /// Every window of the log; returns where it breaks off, if it does.
    fn windows(
        &mut self,
        windows: &mut Windows,
        stage: &mut Stage<'_>,
        repeats: bool,
        interrupts: &Interrupts,
    ) -> Result<Option<String>, Failure> {
        while let Some(window) = windows.next() {
            let window = match window {
                Err(error) if error.is_truncation() => return Ok(Some(error.to_string())),
                other => other?,
            };
            if interrupts.count() > 0 {
                return Err(Failure::Interrupted("the replay was not finished".into()));
            }
            let last = !windows.peek().is_some_and(LoggedWindow::is_repeat);
            // A DEM goes back to the start of the window each time: only what was accepted matters to it.
            if last || repeats {
                self.window(stage, window, repeats, last)?;
            }
        }
        Ok(None)
    }

    fn window(
        &mut self,
        stage: &mut Stage<'_>,
        logged: LoggedWindow,
        repeats: bool,
        last: bool,
    ) -> Result<(), Failure> {
        let window = logged.window();
        let mut command = self.substeps.order(logged.command);
        if !repeats {
            (command.order, command.attempt) = (Order::Advance as u64, 0);
        }
        command.output &= u64::from(self.request.out.is_some());
        let (loads, kinematics) = (
            logged.loads.map(|(_, loads)| Lines::Loads(loads)),
            logged.kinematics.map(|(_, k)| Lines::Kinematics(k)),
        );
        let (given, wanted) = match self.stand.role {
            Role::Fluid => (kinematics, loads),
            Role::Dem => (loads, kinematics),
        };
        stage.prompt(given.unwrap_or_else(|| (self.peer)(&window)));
        let turn = stage.play(command).map_err(|error| {
            let what = format!("the {} solver: window {}: {error}", self.stand.role, window.step);
            if stage.has_failed() { Failure::Run(what) } else { Failure::Peer(what) }
        })?;
        if last {
            if let Some(wanted) = &wanted {
                self.divergence.take(&window, wanted, &turn.records);
            }
            if repeats {
                let accept = Command { order: Order::Accept as u64, ..command };
                stage.order(accept).map_err(Failure::Peer)?;
            }
        }
        Ok(())
    }
}

/// What the plain loop of a solver alone says in place of the absent one.
fn peer(driven: Role, scene: &CheckedScene, grains: usize) -> Peer {
    match driven {
        Role::Dem => {
            let answer = buoyancy(scene);
            Box::new(move |window| {
                let mut loads = vec![Loads::default(); grains];
                answer(window, &mut loads);
                Lines::Loads(loads)
            })
        }
        Role::Fluid => {
            let answer = prescribed_motion(scene);
            Box::new(move |window| {
                let mut motion = vec![Kinematics::default(); grains];
                answer(window, &mut motion);
                Lines::Kinematics(motion)
            })
        }
    }
}

/// Writes `divergence.csv` and `divergence.svg`.
fn write(
    divergence: &Divergence,
    title: &str,
    request: &Replay,
    out: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    let name = if title.is_empty() { "Replay" } else { title };
    let title = match &request.overrides[..] {
        [] => format!("{name}: replay against log"),
        [only] if only.chars().count() <= 60 => format!("{name}: replay with {only} against log"),
        more => format!("{name}: replay with {} other value(s) against log", more.len()),
    };
    for (file, text) in [
        ("divergence.csv", divergence.csv()),
        ("divergence.svg", (request.figure)(&title, divergence.curves())),
    ] {
        let path = out.join(file);
        atomic_write(&path, text.as_bytes())?;
        written.push(path);
    }
    Ok(written)
}
