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

/// Is it a folder of `user` into which nobody else can write?
pub(crate) fn is_private(data: &fs::Metadata, user: u32) -> bool {
    data.is_dir() && data.uid() == user && data.mode() & 0o022 == 0
}

/// The folders that hold runs of this user.
pub(crate) fn user_folders() -> Result<Vec<PathBuf>, ExchangeError> {
    private_folders(&base(), user()?)
}

/// The folder for the next run of this user, mode 0700, which need not be there yet.
pub(crate) fn user_folder() -> Result<PathBuf, ExchangeError> {
    folder_for(&base(), user()?)
}

fn private_folders(base: &Path, user: u32) -> Result<Vec<PathBuf>, ExchangeError> {
    let plain = format!("bedload-{user}");
    let entries = fs::read_dir(base).map_err(|error| failed("cannot read", base, &error))?;
    let is_one =
        |name: &str| name.strip_prefix(&plain).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'));
    let mut found: Vec<PathBuf> = entries
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(is_one))
        .filter(|entry| entry.metadata().is_ok_and(|data| is_private(&data, user)))
        .map(|entry| entry.path())
        .collect();
    found.sort();
    Ok(found)
}

/// One that is there, else the plain name; where that is somebody else's, who took it first, one that nobody
/// can foresee.
fn folder_for(base: &Path, user: u32) -> Result<PathBuf, ExchangeError> {
    if let Some(first) = private_folders(base, user)?.into_iter().next() {
        return Ok(first);
    }
    let plain = base.join(format!("bedload-{user}"));
    if fs::symlink_metadata(&plain).is_err() {
        return Ok(plain);
    }
    Ok(base.join(format!("bedload-{user}-{}", &fresh_run_name()[..4])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_somebody_else_took_first_blocks_nobody() {
        let base = std::env::temp_dir().join(format!("bedload-names-{}", std::process::id()));
        fs::create_dir_all(&base).expect("a folder");
        let user = user().expect("a user");
        let plain = base.join(format!("bedload-{user}"));
        assert_eq!(folder_for(&base, user).expect("a name"), plain);
        // A file, a link or a folder that others may write to is not ours.
        fs::write(&plain, "").expect("a file");
        let other = folder_for(&base, user).expect("a name");
        assert!(other != plain && other.parent() == Some(&base), "{}", other.display());
        fs::create_dir(&other).expect("a folder");
        assert_eq!(folder_for(&base, user).expect("a name"), other, "found again");
        assert_eq!(private_folders(&base, user).expect("a list"), [other]);
        fs::remove_dir_all(&base).expect("removed");
    }
}
