//! One process at a time writes into a folder.

use std::fs::{File, TryLockError};
use std::path::Path;

use protocol::new_file::is_at;

use crate::error::OutputError;

/// The sole right to write into a folder, given back when it is dropped or its process ends, however that
/// ends.
///
/// It is the system's lock on the folder itself, so that nothing lies there on its account, and holds among
/// Bedload's processes only. Where the file system knows no locks there is none.
#[derive(Debug)]
pub struct Claim {
    folder: Option<File>,
}

impl Claim {
    /// Claims a folder that is there.
    ///
    /// # Errors
    /// [`OutputError::InUse`] if another process, or another claim of this one, holds it.
    pub fn of(folder: &Path) -> Result<Self, OutputError> {
        let Ok(file) = File::open(folder) else { return Ok(Self { folder: None }) };
        match file.try_lock() {
            Ok(()) => Ok(Self { folder: Some(file) }),
            Err(TryLockError::WouldBlock) => Err(OutputError::InUse(folder.to_owned())),
            // Without a lock it still tells which folder was claimed.
            Err(TryLockError::Error(_)) => Ok(Self { folder: Some(file) }),
        }
    }

    /// Is the claimed folder still the one at `path`?
    pub(crate) fn is_at(&self, path: &Path) -> bool {
        self.folder.as_ref().is_none_or(|folder| is_at(folder, path))
    }
}
