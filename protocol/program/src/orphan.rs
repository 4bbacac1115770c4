//! A solver that runs alone, or a replay, for `bedload` ends when `bedload` ends, for whatever reason.

use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};

use crate::failure::Failure;

/// Variable in which `bedload` names itself to a solver that it starts.
pub const PARENT: &str = "BEDLOAD_PARENT";

/// From here on the death of the `bedload` that started this process (kill -9 included) is as SIGTERM to it.
/// Nothing changes for a solver that a shell, a script or `mpirun` started.
///
/// # Errors
/// If the parent has died already.
pub(crate) fn end_with_parent() -> Result<(), Failure> {
    let named = std::env::var(PARENT).ok().and_then(|text| text.parse::<i32>().ok()).and_then(Pid::from_raw);
    let Some(named) = named else { return Ok(()) };
    let alive = || getppid() == Some(named);
    if !alive() {
        return Ok(());
    }
    // Where the system cannot do it the solver goes on, as before.
    let _ = set_parent_process_death_signal(Some(Signal::TERM));
    // It may have died in between.
    if alive() {
        return Ok(());
    }
    Err(Failure::Run("the `bedload` that started this solver has died".into()))
}
