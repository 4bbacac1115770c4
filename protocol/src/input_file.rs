//! Files that a user names to be read.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Opens a file to read. A pipe, a device or a folder is refused at once: a pipe may wait for ever for a
/// writer, and a device may have no end.
///
/// # Errors
/// The system's; [`io::ErrorKind::InvalidInput`] with what it is, if it is no file.
pub fn open(path: &Path) -> io::Result<File> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return File::open(path);
    }
    let what = if kind.is_dir() { "a folder" } else { "a pipe, a socket or a device" };
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("it is {what}; a file is needed")))
}

/// The bytes of a file ([`open`]).
///
/// # Errors
/// As [`open`], and where it cannot be read.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file ([`open`]).
///
/// # Errors
/// As [`read`], and where it is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.read_to_string(&mut text)?;
    Ok(text)
}
