//! `serve`: a solver in a coupled run, ordered by the coupler over shared memory.

use std::path::Path;

use protocol::channel::{Rendezvous, Wire};
use protocol::participant::{ExchangeError, SolverError};

use crate::failure::Failure;
use crate::options::RunOptions;
use crate::solver::Solver;
use crate::threads::with_threads;

/// Joins a coupled run and obeys until the coupler says stop.
pub(crate) fn serve<S>(
    options: &RunOptions,
    connect: Option<&str>,
    checkpoint: Option<&Path>,
) -> Result<(), Failure>
where
    S: Solver,
    S::Incoming: Wire<Answer = S::Outgoing>,
{
    let missing = "no coupler to join: `bedload run` starts this command and passes --connect";
    let rendezvous = match connect {
        Some(token) => Rendezvous::parse(token)?,
        None => Rendezvous::from_environment()?.ok_or_else(|| ExchangeError::Transport(missing.into()))?,
    };
    let scene = options.read_scene()?;
    let out = options.out_path();
    let mut solver = S::build(&scene, &out)?;
    if let Some(folder) = checkpoint {
        solver.read_checkpoint(folder)?;
    }
    let grains = solver.grains();
    with_threads(options.threads(), || -> Result<(), SolverError> {
        let mut link = S::Incoming::join(&rendezvous, S::ROLE, grains)?;
        protocol::serve::serve(&mut solver, &mut *link, &out)
    })??;
    Ok(())
}
