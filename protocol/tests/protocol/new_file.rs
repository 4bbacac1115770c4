//! Files that are written anew.

use std::fs::File;
use std::io;
use std::path::Path;

use protocol::new_file::{OwnFile, is_full, new_file, write_new};

#[test]
fn a_file_that_somebody_cuts_short_is_not_written_on() {
    use io::Write;
    let path = std::env::temp_dir().join(format!("bedload-own-file-{}", std::process::id()));
    let mut own = OwnFile::new(new_file(&path).expect("a file"), 0);
    own.write_all(b"first").expect("written");
    own.flush().expect("whole");
    File::options().write(true).open(&path).expect("there").set_len(2).expect("cut");
    for error in [own.write_all(b"second").expect_err("cut"), own.flush().expect_err("cut")] {
        assert!(error.to_string().contains("2 bytes, where 5 were written"), "{error}");
    }
    assert_eq!(std::fs::read(&path).expect("read"), b"fi");
    std::fs::remove_file(&path).expect("removed");
    // A device has no length.
    OwnFile::new(new_file(Path::new("/dev/null")).expect("a device"), 0).write_all(b"x").expect("written");
}

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
