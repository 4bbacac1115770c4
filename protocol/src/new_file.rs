//! Files that did not exist before.

use std::fs::File;
use std::io;
use std::path::Path;

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

/// Is there no room for what was to be written: a full disk, a quota, a limit of the file's size?
#[must_use]
pub fn is_full(error: &io::Error) -> bool {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_replaced_and_not_followed() {
        let folder = std::env::temp_dir().join(format!("bedload-new-file-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let (aim, link) = (folder.join("aim"), folder.join("link"));
        std::fs::write(&aim, "dear").expect("written");
        std::os::unix::fs::symlink(&aim, &link).expect("linked");
        write_new(&link, b"new").expect("written");
        assert_eq!(std::fs::read(&aim).expect("read"), b"dear");
        assert_eq!(std::fs::read(&link).expect("read"), b"new");
        assert!(!is_full(&new_file(&folder.join("none/file")).expect_err("no folder")));
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
