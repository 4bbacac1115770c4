//! Files that are written whole or not at all.

use std::fs;
use std::io::Write;
use std::path::Path;

use protocol::new_file::new_file;

use crate::error::OutputError;

/// Writes a file whole or not at all: a neighbour with the ending `.tmp`, synced, then renamed.
///
/// # Errors
/// [`OutputError::File`].
pub fn atomic_write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_beside(path, bytes, true)
}

/// The same without a wait for the disk: of a file that is written often, and little loss after a power cut.
///
/// # Errors
/// [`OutputError::File`].
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_beside(path, bytes, false)
}

fn write_beside(path: &Path, bytes: &[u8], sync: bool) -> Result<(), OutputError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".tmp");
    let temporary = path.with_file_name(name);
    let write = || -> std::io::Result<()> {
        let mut file = new_file(&temporary)?;
        file.write_all(bytes)?;
        if sync {
            file.sync_all()?;
        }
        fs::rename(&temporary, path)
    };
    write().map_err(|error| {
        // Half a file keeps a full disk full.
        let _ = fs::remove_file(&temporary);
        OutputError::file("write", path)(error)
    })
}
