//! The same through the programs: exit code 2, and file, key and remedy on stderr.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::bad_input::bases::SPACE;
use crate::bad_input::elsewhere::File;

/// `bedload` beside this test's folder, if it and both solvers were built with it: a test that
/// crosses crates is not told by cargo where the programs are.
fn bedload() -> Option<PathBuf> {
    let own = std::env::current_exe().ok()?;
    let folder = own.parent()?.parent()?;
    let there = ["bedload", "bedload-fluid", "bedload-dem"].iter().all(|name| folder.join(name).is_file());
    there.then(|| folder.join("bedload"))
}

fn check(program: &Path, text: &str, name: &str) -> Output {
    let scene = File::new(name, text);
    Command::new(program).arg("check").arg(&scene.0).output().expect("starts")
}

#[test]
fn programs_leave_with_code_2_and_say_why() {
    let Some(program) = bedload() else {
        eprintln!(
            "skipped: bedload, bedload-fluid and bedload-dem are not all built (cargo build --release)"
        );
        return;
    };
    let good = check(&program, SPACE, "good.toml");
    // `cargo test -p tests` does not build the programs: ones of another build say nothing of this one.
    if !(good.status.success() && String::from_utf8_lossy(&good.stdout).contains("window-over-contact")) {
        eprintln!("skipped: {} does not know the good scene: build it anew", program.display());
        return;
    }
    for (name, from, to, words) in [
        ("radius.toml", "radius = 0.5", "radius = -0.5", ["grains[0].radius", "-0.5", "positive"]),
        (
            "solver.toml",
            "cfl = 0.5",
            "cfl = 0.5\nclf = 1",
            ["fluid.time.clf", "unknown field", "docs/scene.md"],
        ),
        (
            "contact.toml",
            "restitution = 0.9",
            "restitution = 0.0",
            ["dem.contact.restitution", "above 0", "remedy"],
        ),
        (
            "memory.toml",
            "cells = [32, 32, 32]",
            "cells = [2000, 2000, 2000]",
            ["domain.cells", "GiB to give", "would fit"],
        ),
        (
            "bound.toml",
            "contact_time = 0.02",
            "contact_time = 5e-5",
            ["window-over-contact", "must be", "remedy"],
        ),
    ] {
        let output = check(&program, &SPACE.replacen(from, to, 1), name);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(said.contains(name) || name == "bound.toml", "{said}");
        for word in words {
            assert!(said.contains(word), "{name} without {word}: {said}");
        }
    }
}
