//! `bedload run`: from the scene to the output folder.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bedload_output::{OutputFolder, RunStatus, Summary};
use bedload_program::RunOptions;
use bedload_scene::Motion;
use protocol::channel::remove_stale_runs;
use protocol::participant::Role;
use protocol::scheme::SchemeKey;
use rustix::process::Signal;

use crate::conduct::End;
use crate::config::Coupling;
use crate::failure::Failure;
use crate::plan::Participants;
use crate::prepare::Prepared;
use crate::resume::{self, CouplerState};
use crate::rewind::rewind;
use crate::session::{Job, conduct, start};
use crate::solvers::Solver;
use crate::supervise::{Interrupts, Supervisor, Words};
use crate::{accuracy, supervise};

/// Version in `summary.json`.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Makes the page of a finished run from its output folder.
pub type Report = fn(&Path) -> Result<PathBuf, Failure>;

/// Runs a scene; `report` makes the page of the run, once its summary is written.
///
/// # Errors
/// [`Failure`], with `summary.json` written wherever there is an output folder.
pub fn run(options: &RunOptions, report: Report) -> Result<(), Failure> {
    match remove_stale_runs() {
        Ok(0) => {}
        Ok(count) => protocol::say!("bedload: removed what {count} dead run(s) had left in shared memory"),
        Err(error) => protocol::say!("bedload: warning: cannot remove what dead runs left: {error}"),
    }
    let (options, expected) = &accuracy::resolve(options)?;
    if let Some(expected) = expected {
        protocol::say!("bedload: {expected}");
    }
    let prepared = Prepared::new(options)?;
    for line in prepared.notices() {
        protocol::say!("bedload: {line}");
    }
    prepared.refuse_broken()?;
    let interrupts =
        Interrupts::listen().map_err(|error| Failure::Run(format!("cannot handle signals: {error}")))?;
    match (prepared.plan.participants, &prepared.fluid, &prepared.dem) {
        (Participants::Fluid, Some(fluid), _) => {
            alone(options, &prepared, &fluid.solver, &interrupts, report)
        }
        (Participants::Dem, _, Some(dem)) => alone(options, &prepared, &dem.solver, &interrupts, report),
        _ => coupled(options, &prepared, interrupts, report),
    }
}

fn coupled(
    options: &RunOptions,
    prepared: &Prepared,
    interrupts: Interrupts,
    report: Report,
) -> Result<(), Failure> {
    let begin = Instant::now();
    let folder = options.folder(&prepared.scene)?;
    if options.resume && folder.is_finished_to(prepared.scene.scene.until) {
        // A run of another scene, or of one that ends earlier, is refused before it is called finished.
        let (_, state) = resume::latest(&folder, &prepared.scene.state_sha256())?;
        prepared.scene.goes_on_from(state.observer.tally.simulated).map_err(Box::new)?;
        let root = folder.root().display();
        protocol::say!("bedload: {root} is finished: nothing to do; --until with a later time goes on");
        return Ok(());
    }
    let resumed = open_folder(options, prepared, &folder)?;
    let mut summary = Summary::new(&prepared.scene, VERSION);
    let job = Job { options, prepared, folder: &folder, begin, last: None };
    let mut done = None;
    let outcome = conduct(&job, interrupts.clone(), resumed, &mut summary, &mut done);
    if summary.cost.wall_s == 0.0 {
        summary.cost.wall_s = begin.elapsed().as_secs_f64();
    }
    let free = prepared.scene.grains.iter().filter(|grain| grain.motion == Motion::Free).count();
    summary.set_unit_costs(free as u64);
    let outcome = match outcome {
        Ok(End::Reached) => Ok(()),
        Ok(End::Interrupted) => {
            Err(Failure::Interrupted(format!("go on with --resume --out {}", folder.root().display())))
        }
        Err(failure) => Err(failure),
    };
    let failed = matches!(outcome, Err(Failure::Run(_) | Failure::Unstable(_)));
    let finished = finish(&folder, &mut summary, outcome, report);
    if let (true, Some(step)) = (failed, done) {
        rewind(options, prepared, &folder, interrupts, step);
    }
    finished
}

/// Makes the report; a failure there costs no result.
fn draw(folder: &Path, report: Report) {
    if let Err(error) = report(folder) {
        protocol::say!("bedload: warning: no report.html: {error}");
    }
}

/// Writes the summary and the report.
fn finish(
    folder: &OutputFolder,
    summary: &mut Summary,
    outcome: Result<(), Failure>,
    report: Report,
) -> Result<(), Failure> {
    match &outcome {
        Ok(()) => summary.status = RunStatus::Completed,
        Err(Failure::Interrupted(_)) => summary.status = RunStatus::Interrupted,
        Err(failure @ Failure::Unstable(_)) => summary.end(RunStatus::Unstable, failure),
        Err(failure) => summary.fail(failure),
    }
    let written = summary.write(&folder.summary());
    draw(folder.root(), report);
    outcome?;
    written?;
    protocol::say!("bedload: done, see {}", folder.root().display());
    Ok(())
}

/// Finds the checkpoint to go on from, and prepares the output folder.
pub(crate) fn open_folder(
    options: &RunOptions,
    prepared: &Prepared,
    folder: &OutputFolder,
) -> Result<Option<(PathBuf, CouplerState)>, Failure> {
    let resumed = if options.resume {
        let (path, state) = resume::latest(folder, &prepared.scene.state_sha256())?;
        prepared.scene.goes_on_from(state.observer.tally.simulated).map_err(Box::new)?;
        folder.remove_summary()?;
        Some((path, state))
    } else {
        None
    };
    // The solvers read the scheme that the plan chose.
    let scheme = prepared.plan.scheme.map_or(prepared.coupling.scheme, SchemeKey::from);
    let coupling = Coupling { scheme, ..prepared.coupling.clone() };
    let coupling = toml::Table::try_from(&coupling).map_err(|error| Failure::Run(error.to_string()))?;
    // What a solver did not resolve stays as the user wrote it.
    let fluid = prepared.fluid.as_ref().map(|fluid| &fluid.facts).filter(|facts| !facts.resolved.is_empty());
    let dem = prepared.dem.as_ref().map(|dem| &dem.facts).filter(|facts| !facts.resolved.is_empty());
    folder.write_scene(&prepared.scene, fluid, dem, Some(&coupling))?;
    if prepared.has_others() {
        folder.write_scene_in_full(&prepared.scene, fluid, dem, Some(&coupling))?;
    }
    let plan =
        serde_json::to_string_pretty(&prepared.plan).map_err(|error| Failure::Run(error.to_string()))?;
    bedload_output::atomic_write(&folder.plan(), plan.as_bytes())?;
    Ok(resumed)
}

/// A scene that needs one solver only: its own `run` does everything.
fn alone(
    options: &RunOptions,
    prepared: &Prepared,
    solver: &Solver,
    interrupts: &Interrupts,
    report: Report,
) -> Result<(), Failure> {
    let mut supervisor = Supervisor::default();
    start(&mut supervisor, solver, &alone_arguments(options), Words::Own)?;
    let mut passed_on = 0;
    while !supervisor.wait_all(Duration::from_millis(20)) {
        let count = interrupts.count();
        if count > passed_on {
            passed_on = count;
            supervisor.signal(if count == 1 { Signal::INT } else { Signal::KILL });
        }
    }
    let Some(exit) = supervisor.exits().pop() else {
        return Err(Failure::Peer(format!("{} is gone", supervise::program(solver.role))));
    };
    match exit.code() {
        Some(0) => {
            draw(&options.out_path(), report);
            Ok(())
        }
        Some(code) => Err(Failure::Passed(u8::try_from(code).unwrap_or(1))),
        None => lost(options, prepared, solver.role, &exit.to_string(), passed_on > 0, report),
    }
}

/// The solver was killed and could not sum up: do it here.
fn lost(
    options: &RunOptions,
    prepared: &Prepared,
    role: Role,
    what: &str,
    interrupted: bool,
    report: Report,
) -> Result<(), Failure> {
    let failure = if interrupted {
        Failure::Interrupted(format!("{} was killed", supervise::program(role)))
    } else {
        Failure::Peer(what.to_owned())
    };
    if let Ok(folder) = OutputFolder::open(&options.out_path()) {
        let mut summary = Summary::new(&prepared.scene, VERSION);
        return finish(&folder, &mut summary, Err(failure), report);
    }
    Err(failure)
}

fn alone_arguments(options: &RunOptions) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["run".into(), options.scene.clone().into()];
    arguments.extend(["--out".into(), options.out_path().into()]);
    for text in options.all_overrides() {
        arguments.extend(["--set".into(), text.into()]);
    }
    if let Some(threads) = options.threads {
        arguments.extend(["--threads".into(), threads.to_string().into()]);
    }
    if options.resume {
        arguments.push("--resume".into());
    }
    if options.overwrite {
        arguments.push("--overwrite".into());
    }
    if options.no_record {
        arguments.push("--no-record".into());
    }
    arguments
}
