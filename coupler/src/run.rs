//! `bedload run`: from the scene to the output folder.

use std::ffi::OsString;
use std::time::Instant;

use bedload_output::{OutputFolder, Sides, Summary};
use bedload_program::{Interrupts, Job, LogKind, Loudness, RunOptions, VERSION, summarise};
use protocol::channel::remove_stale_runs;
use rustix::process::Signal;

use crate::by_itself::Silence;
use crate::coupled::{Coupled, draw};
use crate::failure::Failure;
use crate::plan::Participants;
use crate::prepare::Prepared;
use crate::solvers::Solver;
use crate::{accuracy, by_itself, descriptors, supervise};

pub use crate::coupled::Report;

/// Runs a scene; `report` makes the page of the run, once its summary is written.
///
/// # Errors
/// [`Failure`], with `summary.json` written wherever there is an output folder.
pub fn run(options: &RunOptions, report: Report) -> Result<(), Failure> {
    begin()?;
    let (options, expected) = &accuracy::resolve(options)?;
    if let Some(expected) = expected {
        protocol::tell!("bedload: {expected}");
    }
    let mut prepared = Prepared::new(options)?;
    prepared.tell();
    prepared.refuse_broken()?;
    let every = fields_every(options, &prepared);
    prepared.scene.scene.observe.fields_every = Some(every);
    let options = RunOptions { fields_every: Some(every), ..options.clone() };
    carry_out(&options, &prepared, &listen()?, report)?;
    bedload_program::done("bedload", &options.out_path(), "");
    Ok(())
}

/// Time between fields, s: as the scene says, or the plan; a run that goes on keeps that which it had.
fn fields_every(options: &RunOptions, prepared: &Prepared) -> f64 {
    let files = &prepared.plan.files;
    let before = || {
        let text = protocol::input_file::read_text(&options.out_path().join("scene.toml")).ok()?;
        let scene: toml::Table = toml::from_str(&text).ok()?;
        scene.get("observe")?.get("fields_every")?.as_float()
    };
    let before = if options.resume && !files.fields_asked { before() } else { None };
    before.unwrap_or(files.fields_every)
}

/// Before the first run of this process.
pub(crate) fn begin() -> Result<(), Failure> {
    descriptors::allow(descriptors::ANY_RUN).map_err(Failure::Run)?;
    match remove_stale_runs() {
        Ok(0) => {}
        Ok(count) => protocol::tell!("bedload: removed what {count} dead run(s) had left in shared memory"),
        Err(error) => protocol::say!("bedload: warning: cannot remove what dead runs left: {error}"),
    }
    Ok(())
}

/// The first signal ends the run in order, the second kills the solvers, the third the coupler itself.
pub(crate) fn listen() -> Result<Interrupts, Failure> {
    Interrupts::listen(3)
}

pub(crate) fn carry_out(
    options: &RunOptions,
    prepared: &Prepared,
    interrupts: &Interrupts,
    report: Report,
) -> Result<(), Failure> {
    match (prepared.plan.participants, &prepared.fluid, &prepared.dem) {
        (Participants::Fluid, Some(fluid), _) => alone(options, prepared, &fluid.solver, interrupts, report),
        (Participants::Dem, _, Some(dem)) => alone(options, prepared, &dem.solver, interrupts, report),
        _ => coupled(options, prepared, interrupts, report),
    }
}

fn coupled(
    options: &RunOptions,
    prepared: &Prepared,
    interrupts: &Interrupts,
    report: Report,
) -> Result<(), Failure> {
    let begin = Instant::now();
    let folder = options.folder(&prepared.scene)?;
    let (coupling, plan) = (&prepared.coupling, &prepared.plan);
    let [fluid, dem] = prepared.solvers().map(|solver| solver.map_or_else(Vec::new, |s| s.command.clone()));
    let log = LogKind::Coupled { fluid, dem };
    let job = Job {
        program: "bedload",
        scene: &prepared.scene,
        folder: &folder,
        resume: options.resume,
        interrupts,
        sides: Sides::coupled(),
        dt: plan.steps.dt_fluid,
        contact_time: plan.steps.contact_time,
        checkpoint_every: coupling.checkpoint_every,
        log: (coupling.record && !options.no_record).then_some(log),
        begin,
    };
    let setup = Coupled { options, prepared, folder: &folder, interrupts: interrupts.clone(), report };
    bedload_program::run(&job, &setup)
}

/// A scene that needs one solver only: its own `run` does everything.
fn alone(
    options: &RunOptions,
    prepared: &Prepared,
    solver: &Solver,
    interrupts: &Interrupts,
    report: Report,
) -> Result<(), Failure> {
    let mut passed_on = 0;
    let silence = Silence::of(&prepared.coupling, prepared.scene.grains.len());
    let exit = by_itself::run(solver, &alone_arguments(options, solver), silence, |supervisor| {
        let count = interrupts.count();
        if count > passed_on {
            passed_on = count;
            supervisor.signal(if count == 1 { Signal::INT } else { Signal::KILL });
        }
    })?;
    let (what, interrupted) = match exit.map(|exit| (exit.code(), exit.to_string())) {
        Ok((Some(0), _)) => {
            draw(&options.out_path(), report);
            return Ok(());
        }
        Ok((Some(code), _)) => return Err(Failure::Passed(u8::try_from(code).unwrap_or(1))),
        Ok((None, what)) => (what, passed_on > 0),
        Err(what) => (what, false),
    };
    let failure = if interrupted {
        Failure::Interrupted(format!("{} was killed", supervise::program(solver.role)))
    } else {
        Failure::Peer(what)
    };
    // The solver wrote no summary: it is written here.
    if let Ok(folder) = OutputFolder::open(&options.out_path()) {
        let mut summary = Summary::new(&prepared.scene, VERSION);
        let failed = summarise(&folder, &mut summary, Err(failure));
        draw(folder.root(), report);
        return failed;
    }
    Err(failure)
}

fn alone_arguments(options: &RunOptions, solver: &Solver) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["run".into(), options.scene.clone().into()];
    arguments.extend(["--out".into(), options.out_path().into()]);
    for text in options.all_overrides() {
        arguments.extend(["--set".into(), text.into()]);
    }
    if let Some(threads) = options.threads {
        arguments.extend(["--threads".into(), threads.to_string().into()]);
    }
    let RunOptions { resume, overwrite, no_record, .. } = *options;
    for (flag, is_given) in [("--resume", resume), ("--overwrite", overwrite), ("--no-record", no_record)] {
        arguments.extend(is_given.then(|| flag.into()));
    }
    arguments.extend(Loudness::option().filter(|_| solver.is_ours()).map(OsString::from));
    // Only where it says something: a solver of another need not know the option.
    if let Some(every) = options.fields_every.filter(|every| *every > 0.0) {
        arguments.extend(["--fields-every".into(), every.to_string().into()]);
    }
    arguments
}
