//! A program that `bedload` starts for a run ends when that `bedload` ends, for whatever reason: a solver
//! that runs alone, a replay, a run of a study.

use std::path::Path;

use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};

use crate::failure::Failure;

/// Variable in which `bedload` names itself to a program that it starts: [`parent_name`].
pub const PARENT: &str = "BEDLOAD_PARENT";

/// The signal by which a program hears that its parent has died: no one else sends it, so that it counts
/// once beside what a terminal sends to all.
pub(crate) const PARENT_DIED: Signal = Signal::USR1;

/// This process, for [`PARENT`]: its number, and where processes have these numbers.
pub fn parent_name() -> String {
    format!("{} {}", std::process::id(), numbered_in())
}

/// From here on the death of the `bedload` that started this process (kill -9 included) ends it in order, as
/// SIGTERM does. Where a shell, a script or `mpirun` stands between, only a death before this is noticed.
///
/// # Errors
/// If it has died already.
pub fn end_with_parent() -> Result<(), Failure> {
    let name = std::env::var(PARENT).unwrap_or_default();
    let Some((number, place)) = name.split_once(' ') else { return Ok(()) };
    let Some(named) = number.parse().ok().and_then(Pid::from_raw) else { return Ok(()) };
    if getppid() == Some(named) {
        // Where the system cannot do it the program goes on, as before.
        let _ = set_parent_process_death_signal(Some(PARENT_DIED));
    }
    // It may have died before, or in between.
    if getppid() != Some(named) && place == numbered_in() && !place.is_empty() && is_gone(named) {
        return Err(Failure::Run("the `bedload` that started this program has died".into()));
    }
    Ok(())
}

/// Which numbers processes have here: those of this start of this machine, in this namespace. Empty where
/// the system does not tell.
fn numbered_in() -> String {
    let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let space = std::fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    format!("{}{}", boot.trim(), space.display())
}

/// Has the process ended? One that nobody has waited for yet has.
fn is_gone(process: Pid) -> bool {
    let stat = Path::new("/proc").join(process.as_raw_nonzero().to_string()).join("stat");
    let stat = std::fs::read_to_string(stat).unwrap_or_default();
    stat.rsplit_once(") ").is_none_or(|(_, state)| state.starts_with(['Z', 'X']))
}
