//! A coupled run from the start of its solvers to their end.

use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::Path;
use std::time::{Duration, Instant};

use bedload_output::{OutputFolder, Summary};
use bedload_program::RunOptions;
use protocol::channel::{ConductorLink, Rendezvous, Waiting};
use protocol::participant::ExchangeError;
use protocol::scheme::Scheme;

use crate::conduct::{Conductor, End, alive, explain};
use crate::failure::Failure;
use crate::prepare::Prepared;
use crate::record;
use crate::resume::CouplerState;
use crate::scheme::Planner;
use crate::solvers::Solver;
use crate::supervise::{Interrupts, Supervisor, Words};

/// What a coupled run is to do.
pub(crate) struct Job<'a> {
    pub(crate) options: &'a RunOptions,
    pub(crate) prepared: &'a Prepared,
    pub(crate) folder: &'a OutputFolder,
    pub(crate) begin: Instant,
    /// Window before which it ends, without a log: to do again what was done.
    pub(crate) last: Option<u64>,
}

/// Starts the solvers and conducts them; `done`: windows done, once they have begun.
pub(crate) fn conduct(
    job: &Job<'_>,
    interrupts: Interrupts,
    resumed: Option<(std::path::PathBuf, CouplerState)>,
    summary: &mut Summary,
    done: &mut Option<u64>,
) -> Result<End, Failure> {
    let Job { options, prepared, folder, begin, last } = *job;
    let exchange = |error: ExchangeError| match error {
        ExchangeError::NoRoom(text) => Failure::Full(text),
        other => Failure::Run(other.to_string()),
    };
    let rendezvous = rendezvous(prepared).map_err(exchange)?;
    let mut link = ConductorLink::create(&rendezvous).map_err(exchange)?;
    let mut supervisor = Supervisor::default();
    let (checkpoint, state) = resumed.unzip();
    start_solvers(options, prepared, folder, &mut supervisor, &link, checkpoint.as_deref())?;
    if let Err(error) = link.wait_ready(&mut || alive(&supervisor, &interrupts, false, 0)) {
        // Give the one that goes the time to be gone.
        supervisor.wait_all(Duration::from_millis(200));
        let failure = explain(&error, None, &supervisor);
        supervisor.end(Duration::from_millis(300));
        return Err(failure);
    }
    let recorder = if last.is_some() { None } else { open_log(options, prepared, folder, state.as_ref())? };
    let mut conductor =
        Conductor::new(supervisor, link, prepared, folder, recorder, interrupts, state, begin)?;
    if let Some(last) = last {
        conductor.end_before(last);
    }
    let outcome = conductor.conduct();
    *done = Some(conductor.done());
    let closed = conductor.close(summary, outcome.is_ok());
    let end = outcome?;
    closed?;
    Ok(end)
}

fn rendezvous(prepared: &Prepared) -> Result<Rendezvous, ExchangeError> {
    let coupling = &prepared.coupling;
    let mut rendezvous = Rendezvous::new(prepared.scene.grains.len())?;
    rendezvous.ahead = crate::scheme::AHEAD;
    rendezvous.repeatable = prepared.plan.scheme == Some(Scheme::Iterated);
    rendezvous.join_s = coupling.startup_deadline;
    // The coupler judges first who hangs; the solvers are only to give up in the end.
    rendezvous.deadline_s = 2.0 * coupling.deadline + 1.0;
    rendezvous.waiting = if coupling.spin { Waiting::Spin } else { Waiting::Event };
    Ok(rendezvous)
}

fn start_solvers(
    options: &RunOptions,
    prepared: &Prepared,
    folder: &OutputFolder,
    supervisor: &mut Supervisor,
    link: &ConductorLink,
    checkpoint: Option<&Path>,
) -> Result<(), Failure> {
    let solvers =
        [prepared.fluid.as_ref().map(|fluid| &fluid.solver), prepared.dem.as_ref().map(|dem| &dem.solver)];
    for solver in solvers.into_iter().flatten() {
        let scene = if solver.is_ours() { folder.scene() } else { folder.scene_in_full() };
        let arguments = serve_arguments(&scene, folder, link.rendezvous(), options.threads, checkpoint);
        start(supervisor, solver, &arguments, Words::Kept)?;
    }
    Ok(())
}

/// Arguments of a solver that takes part in a run (interface: `serve`).
pub(crate) fn serve_arguments(
    scene: &Path,
    folder: &OutputFolder,
    rendezvous: &Rendezvous,
    threads: Option<NonZeroUsize>,
    checkpoint: Option<&Path>,
) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["serve".into(), scene.into()];
    arguments.extend(["--connect".into(), rendezvous.token().into()]);
    arguments.extend(["--out".into(), folder.root().into()]);
    if let Some(threads) = threads {
        arguments.extend(["--threads".into(), threads.to_string().into()]);
    }
    if let Some(checkpoint) = checkpoint {
        arguments.extend(["--checkpoint".into(), checkpoint.into()]);
    }
    arguments
}

/// Starts a solver.
pub(crate) fn start(
    supervisor: &mut Supervisor,
    solver: &Solver,
    arguments: &[OsString],
    words: Words,
) -> Result<(), Failure> {
    let command = solver.run_command();
    supervisor.start(solver.role, &command, arguments, words).map_err(|error| {
        Failure::Peer(format!("cannot start the {} solver `{}`: {error}", solver.role, command.join(" ")))
    })
}

fn open_log(
    options: &RunOptions,
    prepared: &Prepared,
    folder: &OutputFolder,
    state: Option<&CouplerState>,
) -> Result<Option<protocol::log::Recorder>, Failure> {
    if options.no_record || !prepared.coupling.record {
        return Ok(None);
    }
    let mut planner = Planner::new(&prepared.plan, &prepared.coupling, &prepared.scene.scene.observe);
    let mut part = 1;
    if let Some(state) = state {
        planner.resume(state.planner.clone());
        part = folder.next_log_part();
    }
    record::open(prepared, folder, part, planner.step(), planner.time()).map(Some)
}
