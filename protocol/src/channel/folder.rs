//! The folder of a run, its lock, and the removal of everything a run leaves behind.
//!
//! Every process of a run holds `run.lock` shared for as long as it lives; the kernel lets go of it
//! however the process ends. Who can take it exclusively is therefore the last one, and removes the
//! segments and the folder. Founding and removing runs is serialised by `.lock` in the user's folder.

use std::fs::{self, DirBuilder, File, TryLockError};
use std::io;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::names::{failed, is_private, prefix_of, user, user_folders};
use super::rendezvous::Rendezvous;
use super::space::segments;
use crate::new_file::is_at;
use crate::participant::ExchangeError;

const RUN_LOCK: &str = "run.lock";
const USER_LOCK: &str = ".lock";
/// The user's lock is held for a few file operations; longer means that its holder is stopped.
const LOCK_PATIENCE: Duration = Duration::from_secs(30);

/// Holds the user's lock: nobody else founds or removes a run of this user meanwhile.
struct UserLock {
    folder: PathBuf,
    _file: File,
}

impl UserLock {
    fn take(folder: &Path) -> Result<Self, ExchangeError> {
        let start = Instant::now();
        loop {
            make_private(folder)?;
            let path = folder.join(USER_LOCK);
            match open_lock(&path) {
                // Another process removed the empty folder in between: make it again.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(failed("cannot open", &path, &error)),
                Ok(file) => {
                    let taken = match file.try_lock() {
                        Ok(()) => is_at(&file, &path),
                        Err(TryLockError::WouldBlock) => false,
                        Err(TryLockError::Error(error)) => {
                            return Err(failed("cannot lock", &path, &error));
                        }
                    };
                    if taken {
                        let folder = folder.to_owned();
                        return Ok(Self { folder, _file: file });
                    }
                }
            }
            if start.elapsed() > LOCK_PATIENCE {
                return Err(ExchangeError::Transport(format!(
                    "{} has been locked by others for {LOCK_PATIENCE:?}: some hundreds of runs start at \
                     once, or a bedload process is stopped while it founds or removes a run",
                    path.display()
                )));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Removes the user's folder if it holds no run any more.
    fn remove_if_empty(&self) {
        let Ok(entries) = fs::read_dir(&self.folder) else { return };
        let only_lock = entries.flatten().all(|entry| entry.file_name() == USER_LOCK);
        if only_lock {
            // Whoever waits for this lock sees that the file is gone and starts again.
            let _ = fs::remove_file(self.folder.join(USER_LOCK));
            let _ = fs::remove_dir(&self.folder);
        }
    }
}

/// Makes `folder` with mode 0700, or refuses one that is not a folder of this user.
fn make_private(folder: &Path) -> Result<(), ExchangeError> {
    match DirBuilder::new().mode(0o700).create(folder) {
        Ok(()) => return Ok(()),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        Err(error) => return Err(failed("cannot make", folder, &error)),
    }
    match fs::symlink_metadata(folder) {
        Ok(data) if is_private(&data, user()?) => Ok(()),
        Ok(_) => Err(ExchangeError::Transport(format!(
            "{} is not a private folder of this user: remove it",
            folder.display()
        ))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(failed("cannot look at", folder, &error)),
    }
}

fn open_lock(path: &Path) -> io::Result<File> {
    File::options().read(true).write(true).create(true).truncate(false).mode(0o600).open(path)
}

/// This process's part in a run: the shared lock. Leaving (drop) as the last one removes the run.
#[derive(Debug)]
pub(crate) struct Membership {
    root: PathBuf,
    prefix: String,
    lock: File,
}

impl Membership {
    /// Makes the folder of a new run.
    pub(crate) fn found(rendezvous: &Rendezvous) -> Result<Self, ExchangeError> {
        rendezvous.check()?;
        let root = &rendezvous.root;
        let parent = root.parent().unwrap_or(root);
        let _user = UserLock::take(parent)?;
        DirBuilder::new()
            .mode(0o700)
            .create(root)
            .map_err(|error| failed("cannot make the run's folder", root, &error))?;
        let path = root.join(RUN_LOCK);
        let lock = open_lock(&path).map_err(|error| failed("cannot make", &path, &error))?;
        lock.lock_shared().map_err(|error| failed("cannot lock", &path, &error))?;
        Ok(Self::of(rendezvous, lock))
    }

    /// Joins a run that the coupler has founded.
    pub(crate) fn join(rendezvous: &Rendezvous) -> Result<Self, ExchangeError> {
        rendezvous.check()?;
        let path = rendezvous.root.join(RUN_LOCK);
        let over = |why: &str| {
            ExchangeError::Transport(format!(
                "run {} is over or was never started: {why} {}; bedload starts the solvers itself",
                rendezvous.run,
                path.display()
            ))
        };
        let lock =
            File::options().read(true).write(true).open(&path).map_err(|error| over(&format!("{error}:")))?;
        // Refused only while the last process removes the run.
        lock.try_lock_shared().map_err(|_| over("being removed:"))?;
        if !is_at(&lock, &path) {
            return Err(over("removed:"));
        }
        Ok(Self::of(rendezvous, lock))
    }

    fn of(rendezvous: &Rendezvous, lock: File) -> Self {
        Self { root: rendezvous.root.clone(), prefix: rendezvous.prefix.clone(), lock }
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        let _ = self.lock.unlock();
        let Some(parent) = self.root.parent() else { return };
        // Without the folder the run was removed by another process that left at the same time.
        if !self.root.exists() {
            return;
        }
        // A run that cannot be removed now is removed by the next coupler of this user.
        let Ok(user) = UserLock::take(parent) else { return };
        if is_at(&self.lock, &self.root.join(RUN_LOCK)) && self.lock.try_lock().is_ok() {
            remove_run(&self.root, &self.prefix);
        }
        user.remove_if_empty();
    }
}

/// Removes a dead run: segments first, so that a removal cut short is found and finished later.
/// A foreign solver that does not hold the lock, but lives, is respected too.
fn remove_run(root: &Path, prefix: &str) -> bool {
    if super::watch::anyone_alive(root, prefix) {
        return false;
    }
    for segment in segments(prefix) {
        let _ = fs::remove_file(segment);
    }
    fs::remove_dir_all(root).is_ok()
}

/// Removes what is left of this user's runs of which every process is dead, and returns their
/// number. Runs with a living process, and runs of other users, are not touched. The coupler calls
/// it when it starts.
///
/// # Errors
/// [`ExchangeError::Transport`] if the user's folder cannot be read or locked.
pub fn remove_stale_runs() -> Result<usize, ExchangeError> {
    user_folders()?.iter().map(|folder| remove_stale_runs_in(folder)).sum()
}

fn remove_stale_runs_in(folder: &Path) -> Result<usize, ExchangeError> {
    let user = UserLock::take(folder)?;
    let entries = fs::read_dir(folder).map_err(|error| failed("cannot read", folder, &error))?;
    let mut removed = 0;
    for entry in entries.flatten() {
        let root = entry.path();
        let name = entry.file_name();
        let Some(run) = name.to_str().filter(|name| *name != USER_LOCK) else { continue };
        if root.is_dir() && remove_if_dead(&root, run) {
            removed += 1;
        }
    }
    user.remove_if_empty();
    Ok(removed)
}

/// Removes the run if no process holds its lock; held meanwhile, so that nobody joins. A folder
/// without a lock is a removal cut short: founding happens under the user's lock, which the caller
/// holds.
fn remove_if_dead(root: &Path, run: &str) -> bool {
    let lock = match File::options().read(true).write(true).open(root.join(RUN_LOCK)) {
        Ok(lock) => Some(lock),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(_) => return false,
    };
    if lock.as_ref().is_some_and(|lock| lock.try_lock().is_err()) {
        return false;
    }
    remove_run(root, &prefix_of(run))
}
