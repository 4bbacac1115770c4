//! Room for the shared memory of a run. A segment is a sparse file: a page for which there is no room when it
//! is written first ends the process with SIGBUS. So room is asked for before anything is made, and taken
//! once everything is there.

use std::fs::{self, File};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FallocateFlags, fallocate, statvfs};
use rustix::io::Errno;

use super::names::SHARED_MEMORY;
use super::rendezvous::Rendezvous;
use super::topics::{depth, most_lent};
use crate::message::{Header, Kinematics, Loads};
use crate::participant::ExchangeError;

/// All that does not grow with the number of grains: commands, reports, events, what iceoryx2 keeps.
/// Measured: 50 kB.
const SMALL: u64 = 256 << 10;
/// What a message has beside payload and [`Header`], at most.
const ENVELOPE: u64 = 128;

/// Bytes of shared memory that a run fills at most.
fn need(rendezvous: &Rendezvous) -> u64 {
    let grains = rendezvous.grains as u64;
    let topic = |record: usize, depth: usize| {
        most_lent(depth) as u64 * (grains * record as u64 + size_of::<Header>() as u64 + ENVELOPE)
    };
    SMALL
        + topic(size_of::<Loads>(), depth::<Loads>(rendezvous.grains))
        + topic(size_of::<Kinematics>(), depth::<Kinematics>(rendezvous.grains))
}

fn no_room(rendezvous: &Rendezvous, what: &str) -> ExchangeError {
    ExchangeError::NoRoom(format!(
        "{SHARED_MEMORY} has no room for the shared memory of this run, {} for {} grains: {what}; enlarge it (mount -o \
         remount,size=…; a container: --shm-size), or remove what lies there",
        mebibytes(need(rendezvous)),
        rendezvous.grains
    ))
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

/// Refuses a run for which there is no room.
///
/// # Errors
/// [`ExchangeError::NoRoom`].
pub(super) fn ask(rendezvous: &Rendezvous) -> Result<(), ExchangeError> {
    // Where the system does not say, what follows does.
    let Ok(system) = statvfs(SHARED_MEMORY) else { return Ok(()) };
    let free = system.f_bavail.saturating_mul(system.f_frsize);
    if free >= need(rendezvous) {
        return Ok(());
    }
    Err(no_room(rendezvous, &format!("{} are free", mebibytes(free))))
}

/// Takes the room of every segment of the run, and closes it to other users (iceoryx2 leaves one open to
/// all).
///
/// # Errors
/// [`ExchangeError::NoRoom`], [`ExchangeError::Transport`] if a segment cannot be opened.
pub(super) fn take(rendezvous: &Rendezvous) -> Result<(), ExchangeError> {
    for path in segments(&rendezvous.prefix) {
        let told = |error: std::io::Error| super::names::failed("cannot take the room of", &path, &error);
        let file = match File::options().read(true).write(true).open(&path) {
            Ok(file) => file,
            // Some are there for a moment only.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            Err(error) => return Err(told(error)),
        };
        let data = file.metadata().map_err(told)?;
        if data.permissions().mode() & 0o077 != 0 {
            file.set_permissions(fs::Permissions::from_mode(0o600)).map_err(told)?;
        }
        match fallocate(&file, FallocateFlags::empty(), 0, data.len().max(1)) {
            // A file system that cannot do it says so: then nothing was promised.
            Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS) => {}
            Err(Errno::NOSPC) => return Err(no_room(rendezvous, "it was taken by others meanwhile")),
            Err(error) => return Err(told(error.into())),
        }
    }
    Ok(())
}

/// The segments of a run that are there.
pub(super) fn segments(prefix: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(Path::new(SHARED_MEMORY)) else { return Vec::new() };
    let ours = |entry: &fs::DirEntry| entry.file_name().to_str().is_some_and(|name| name.starts_with(prefix));
    entries.flatten().filter(ours).map(|entry| entry.path()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_does_not_fit_is_refused_with_the_room_that_it_needs() {
        let mut rendezvous = Rendezvous::new(1).expect("a run");
        assert!(ask(&rendezvous).is_ok());
        rendezvous.grains = 1 << 40;
        let text = ask(&rendezvous).expect_err("no machine has that").to_string();
        assert!(
            text.contains("/dev/shm")
                && text.contains("MiB for 1099511627776 grains")
                && text.contains("are free"),
            "{text}"
        );
    }
}
