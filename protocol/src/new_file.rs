//! Files that did not exist before.

use std::fs::File;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use sha2::{Digest as _, Sha256};

/// Opens a new file to write, in place of the one that stood at that path. A link there is removed, not
/// followed; a device or a pipe is written to.
///
/// # Errors
/// The system's.
pub fn new_file(path: &Path) -> io::Result<File> {
    match std::fs::symlink_metadata(path).map(|data| data.file_type()) {
        Ok(kind) if kind.is_file() || kind.is_symlink() => std::fs::remove_file(path)?,
        Ok(_) => return File::options().write(true).open(path),
        Err(_) => {}
    }
    // `create_new` opens nothing that is there, be it a link that leads nowhere.
    File::options().read(true).write(true).create_new(true).open(path)
}

/// Writes a new file ([`new_file`]); nothing of it stays if that fails.
///
/// # Errors
/// The system's.
pub fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let written = new_file(path).and_then(|mut file| io::Write::write_all(&mut file, bytes));
    if written.is_err() {
        let _ = std::fs::remove_file(path);
    }
    written
}

/// A file that this process alone makes longer. Where somebody has cut it short or written to it meanwhile,
/// the next write fails: what is written behind a hole is no use to anybody.
#[derive(Debug)]
pub struct OwnFile {
    file: File,
    bytes: u64,
}

impl OwnFile {
    /// Over a file that holds so many bytes, and is written behind them.
    pub fn new(file: File, bytes: u64) -> Self {
        Self { file, bytes }
    }

    /// The file.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Whether the file still has the length that this process gave it; a device has none.
    ///
    /// # Errors
    /// The system's; [`io::ErrorKind::InvalidData`] if it has another.
    pub fn check(&self) -> io::Result<()> {
        let data = self.file.metadata()?;
        if !data.is_file() || data.len() == self.bytes {
            return Ok(());
        }
        let what = format!(
            "it has {} bytes, where {} were written: somebody changed it while the run wrote it; start \
             the run again, and leave its files alone",
            data.len(),
            self.bytes
        );
        Err(io::Error::new(io::ErrorKind::InvalidData, what))
    }
}

impl io::Write for OwnFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.check()?;
        let count = self.file.write(bytes)?;
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.check()?;
        self.file.flush()
    }
}

/// Counts and digests (SHA-256) what is written through it.
#[derive(Debug)]
pub struct Digested<W> {
    /// Where it goes.
    pub to: W,
    /// Bytes so far.
    pub length: u64,
    digest: Sha256,
}

impl<W> Digested<W> {
    /// Nothing was written yet.
    pub fn new(to: W) -> Self {
        Self { to, length: 0, digest: Sha256::new() }
    }

    /// Digest of what was written.
    pub fn digest(&self) -> [u8; 32] {
        self.digest.clone().finalize().into()
    }

    /// The same, of which the rest goes elsewhere.
    pub fn going_to<V>(self, to: V) -> Digested<V> {
        Digested { to, length: self.length, digest: self.digest }
    }
}

impl<W: io::Write> io::Write for Digested<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.to.write(bytes)?;
        self.digest.update(&bytes[..count]);
        self.length += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// Does `path` still name the opened file or folder?
pub fn is_at(file: &File, path: &Path) -> bool {
    let identity = |data: std::fs::Metadata| (data.dev(), data.ino());
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(ours), Ok(there)) => identity(ours) == identity(there),
        _ => false,
    }
}

/// Is there no room for what was to be written: a full disk, a quota, a limit of the file's size?
pub fn is_full(error: &io::Error) -> bool {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge)
}
