//! The program as it is called. Cargo builds programs for the tests of their own package alone: by this one
//! the tests of all crates find the one of this source.

use std::process::{Command, Output};

fn fluid(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bedload-fluid")).args(arguments).output().expect("it starts")
}

#[test]
fn it_tells_its_version_and_refuses_a_scene_that_is_not_there() {
    let version = fluid(&["--version"]);
    let said = String::from_utf8_lossy(&version.stdout);
    assert!(version.status.success() && said.contains(env!("CARGO_PKG_VERSION")), "{said}");
    let missing = fluid(&["run", "no-such-scene.toml"]);
    let said = String::from_utf8_lossy(&missing.stderr);
    assert_eq!(missing.status.code(), Some(2), "{said}");
    assert!(said.contains("no-such-scene.toml"), "{said}");
}
