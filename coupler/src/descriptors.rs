//! Files that a process may have open at once (`ulimit -n`): shared memory takes dozens of them.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// What any run takes, with the commands that it asks. Measured: 20.
pub(crate) const ANY_RUN: u64 = 32;

/// What each process of a coupled run takes. Measured: 65.
pub(crate) const COUPLED_RUN: u64 = 96;

/// Sees to it that this process, and those that it starts, may open so many, where the system lets it.
pub(crate) fn allow(needed: u64) -> Result<(), String> {
    let limit = getrlimit(Resource::Nofile);
    let Some(current) = limit.current.filter(|current| *current < needed) else { return Ok(()) };
    let allowed = limit.maximum.is_none_or(|most| most >= needed);
    if allowed && setrlimit(Resource::Nofile, Rlimit { current: Some(needed), ..limit }).is_ok() {
        return Ok(());
    }
    Err(format!(
        "a process may have {current} files open at once here, this run needs {needed}: raise the limit, such as \
         `ulimit -n 256`, or that of the container or job"
    ))
}
