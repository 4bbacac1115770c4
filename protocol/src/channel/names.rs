//! Names of a run: its own, that of its folder, and the prefix of its segments.

use std::collections::hash_map::RandomState;
use std::fs;
use std::hash::{BuildHasher, Hasher};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::participant::ExchangeError;

/// Where POSIX shared memory lives on Linux. The runs' folders stand there too: they vanish with the
/// segments at a restart, no cleaner of temporary files touches them, and `TMPDIR` does not move them.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Begins the name of every segment of `run`. Names of runs have no `_`, so no prefix begins another.
pub(crate) fn prefix_of(run: &str) -> String {
    format!("bl{run}_")
}

/// A random name of ten letters and digits. Short, because the name of a socket in the folder may
/// have 107 bytes in all. Founding fails if a run of that name exists.
pub(crate) fn fresh_run_name() -> String {
    let mut value = RandomState::new().build_hasher().finish();
    let digit = |_| {
        let digit = b"0123456789abcdefghijklmnopqrstuvwxyz"[(value % 36) as usize];
        value /= 36;
        char::from(digit)
    };
    (0..10).map(digit).collect()
}

fn base() -> PathBuf {
    let shared = Path::new(SHARED_MEMORY);
    if shared.is_dir() { shared.to_owned() } else { std::env::temp_dir() }
}

pub(crate) fn failed(what: &str, path: &Path, error: &io::Error) -> ExchangeError {
    ExchangeError::Transport(format!("{what} {}: {error}", path.display()))
}

pub(crate) fn user() -> Result<u32, ExchangeError> {
    let own = Path::new("/proc/self");
    fs::metadata(own).map(|data| data.uid()).map_err(|error| failed("cannot tell the user from", own, &error))
}

/// The folder that holds the runs of this user, mode 0700.
pub(crate) fn user_folder() -> Result<PathBuf, ExchangeError> {
    Ok(base().join(format!("bedload-{}", user()?)))
}
