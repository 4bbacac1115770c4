//! Room for the shared memory of a run. A segment is a sparse file: a page for which there is no room when it
//! is written first ends the process with SIGBUS. So room is asked for before anything is made, and taken
//! once everything is there.

use std::fs::{self, File};
use std::io::Write as _;
use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt};
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
pub(super) fn ask(rendezvous: &Rendezvous) -> Result<(), ExchangeError> {
    // Where the system does not say, what follows does.
    let Ok(system) = statvfs(SHARED_MEMORY) else { return Ok(()) };
    let free = system.f_bavail.saturating_mul(system.f_frsize);
    if free >= need(rendezvous) {
        return Ok(());
    }
    Err(no_room(rendezvous, &format!("{} are free", mebibytes(free))))
}

/// The segment with iceoryx2's number of nodes, after the prefix of the run, and its bytes before there is
/// one: the version of iceoryx2, 0.10.0, and the count.
const NODES: (&str, [u8; 16]) = (
    "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt",
    [0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
);

/// Makes that segment, for this user alone, before iceoryx2 does: it opens it to all users, whatever the
/// mask, and any of them could cut it off before [`take`] closes it. Another version of iceoryx2 makes its
/// own.
pub(super) fn make_nodes(rendezvous: &Rendezvous) -> Result<(), ExchangeError> {
    let path = Path::new(SHARED_MEMORY).join(format!("{}{}", rendezvous.prefix, NODES.0));
    let file = File::options().write(true).create_new(true).mode(0o600).open(&path);
    file.and_then(|mut file| file.write_all(&NODES.1))
        .map_err(|error| super::names::failed("cannot make", &path, &error))
}

/// Takes the room of every segment of the run, and closes it to other users, should one be open.
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

    /// It is found, not made anew: an update of iceoryx2 that calls it otherwise fails here.
    #[test]
    fn iceoryx2_counts_its_nodes_in_the_segment_that_was_made_for_this_user() {
        let rendezvous = Rendezvous::new(1).expect("a run");
        let _membership = super::super::folder::Membership::found(&rendezvous).expect("founded");
        make_nodes(&rendezvous).expect("made");
        let own = Path::new(SHARED_MEMORY).join(format!("{}{}", rendezvous.prefix, NODES.0));
        let mode = || fs::metadata(&own).expect("there").permissions().mode() & 0o777;
        let node =
            super::super::topics::node(&rendezvous, super::super::watch::Member::Coupler).expect("a node");
        let counts = |path: &PathBuf| path.to_string_lossy().ends_with(".global_mgmt");
        let found: Vec<PathBuf> = segments(&rendezvous.prefix).into_iter().filter(counts).collect();
        assert_eq!((found, mode()), (vec![own.clone()], 0o600));
        assert_ne!(fs::read(&own).expect("read"), NODES.1, "it has counted");
        drop(node);
    }

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
