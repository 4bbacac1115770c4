//! A solver that does everything by itself, as a child: waited for, and given up when it is stopped or hangs.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use crate::config::Coupling;
use crate::coupled::{FILES_TAKE, start};
use crate::failure::Failure;
use crate::solvers::{Solver, patience};
use crate::supervise::{Exit, StderrMode, Supervisor, program};

/// How often it is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Longest times for which a solver may be silent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Silence {
    /// Before its first heartbeat: it starts, and does a window.
    begin: Duration,
    /// Between two of them: a window with files.
    window: Duration,
}

impl Silence {
    /// Of a run of so many grains, by the limits of a coupled run.
    pub(crate) fn of(coupling: &Coupling, grains: usize) -> Self {
        let window = Duration::from_secs_f64(coupling.deadline) * FILES_TAKE;
        Self { begin: patience(Duration::from_secs_f64(coupling.startup_deadline), grains) + window, window }
    }
}

/// Runs a solver with `arguments` to its end; `meanwhile` is called while it runs. One that does nothing for
/// as long as `silence` says is ended. Returns how it ended, or why nobody knows.
pub(crate) fn run(
    solver: &Solver,
    arguments: &[OsString],
    silence: Silence,
    mut meanwhile: impl FnMut(&Supervisor),
) -> Result<Result<Exit, String>, Failure> {
    let mut supervisor = Supervisor::listening();
    start(&mut supervisor, solver, arguments, StderrMode::Own)?;
    // A solver of another, or one behind a launcher, may send no heartbeats.
    let mut limit = (solver.is_ours() && solver.launcher.is_empty()).then_some(silence.begin);
    let (mut silent, mut looked) = (Duration::ZERO, Instant::now());
    while !supervisor.wait_all(LOOK_EVERY) {
        meanwhile(&supervisor);
        // Time in which this process itself was stopped does not count.
        silent += looked.elapsed().min(4 * LOOK_EVERY);
        looked = Instant::now();
        if supervisor.heard() {
            (silent, limit) = (Duration::ZERO, Some(silence.window));
        } else if let Some(limit) = limit.filter(|limit| silent >= *limit) {
            supervisor.end(Duration::from_millis(300));
            return Ok(Err(format!(
                "{} did nothing for {:.1} s: it is stopped, or hangs; where a window takes that long, raise \
                 coupling.deadline",
                program(solver.role),
                limit.as_secs_f64()
            )));
        }
    }
    Ok(supervisor.exits().pop().ok_or_else(|| format!("{} is gone", program(solver.role))))
}
