//! A solver driven from outside: by the coupler over shared memory, or by a log.

use std::path::{Path, PathBuf};

use crate::error::ProgramError;
use crate::options::RunOptions;
use crate::solver::Solver;
use crate::threads::with_threads;
use bedload_scene::{CheckedScene, SceneSource};
use protocol::channel::{Rendezvous, SharedMemory, Wire};
use protocol::log::{LogError, LogReader, Logged, ReplayOptions, ReplayReport, StandIn, replay_beside};
use protocol::participant::{ExchangeError, Role, SolverError};

/// Joins a coupled run and obeys until the coupler says stop.
pub(crate) fn serve<S>(
    options: &RunOptions,
    connect: Option<&str>,
    checkpoint: Option<&Path>,
) -> Result<(), ProgramError>
where
    S: Solver,
    S::Incoming: Wire,
    S::Outgoing: Wire,
{
    let rendezvous = match connect {
        Some(token) => Some(Rendezvous::parse(token)),
        None => Rendezvous::from_environment().transpose(),
    };
    let missing = || {
        let what = "no coupler to join: `bedload run` starts this command and passes --connect";
        ExchangeError::Transport(what.into())
    };
    let rendezvous = rendezvous.ok_or_else(missing).flatten().map_err(SolverError::from)?;
    let scene = options.read_scene()?;
    let out = options.out_path();
    let mut solver = S::build(&scene, &out)?;
    if let Some(folder) = checkpoint {
        solver.read_checkpoint(folder)?;
    }
    let grains = solver.grains();
    with_threads(options.threads(), || -> Result<(), SolverError> {
        let mut link = SharedMemory::join(&rendezvous, S::ROLE, grains)?;
        protocol::serve::serve(&mut solver, &mut link, &out)
    })??;
    Ok(())
}

/// Does again what a log says the solver did.
pub(crate) fn replay<S>(
    log: &Path,
    verify: bool,
    checkpoint: Option<&Path>,
    out: Option<&Path>,
    threads: usize,
) -> Result<(), ProgramError>
where
    S: Solver,
    S::Incoming: Logged,
    S::Outgoing: Logged,
{
    let reader = LogReader::open(log).map_err(failed)?;
    let name = format!("{} (its scene)", log.display());
    let mut scene = CheckedScene::new(SceneSource { file: name, text: reader.manifest().scene.clone() })?;
    let alone = !(reader.manifest().has(Role::Fluid) && reader.manifest().has(Role::Dem));
    if alone {
        // Its checkpoints are of the scene as it was read, which the log has written out.
        scene.written_from = bedload_output::state_of(&reader.manifest().scene).map(str::to_owned);
    }
    let folder = out.map_or_else(|| PathBuf::from("out/replay"), Path::to_owned);
    let mut solver = S::build(&scene, &folder)?;
    let options = ReplayOptions { verify, checkpoint: checkpoint.map(Path::to_owned), fields: out.is_some() };
    let peer = if alone { Some(S::stand_in(&scene)?) } else { None };
    let report = with_threads(threads, move || {
        let peer = peer.as_ref().map(|peer| peer as &StandIn<S::Incoming>);
        replay_beside(&mut solver, reader, &options, peer, &mut |_, _| {})
    })?
    .map_err(failed)?;
    println!(
        "{}: {} windows to t = {} s in {:.3} s, {} messages compared",
        S::PROGRAM,
        report.windows,
        report.time,
        report.wall_s,
        report.compared
    );
    for (field, difference) in &report.fields {
        println!("  {field}: {difference:?}");
    }
    if let Some(difference) = report.first_difference.as_ref().filter(|_| verify) {
        return Err(ProgramError::Different(format!("first difference: {difference}")));
    }
    match &report.truncated {
        Some(cut) => Err(ProgramError::BreaksOff(breaks_off(&report, cut, verify))),
        None => Ok(()),
    }
}

/// Up to where a log that breaks off holds.
fn breaks_off(report: &ReplayReport, cut: &LogError, verify: bool) -> String {
    let outcome = if verify { "is the same" } else { "was done again" };
    let whole = match report.last {
        Some(step) => format!("all up to window {step}, t = {} s, {outcome}", report.time),
        None => "no whole window is there".to_owned(),
    };
    let cut_short =
        report.unfinished.map_or_else(String::new, |(step, _)| format!(", window {step} is cut short"));
    format!("{cut}: {whole}{cut_short}")
}

fn failed(error: impl std::fmt::Display) -> ProgramError {
    ProgramError::Solver(SolverError::Failed(error.to_string()))
}
