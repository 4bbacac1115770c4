//! `--quiet` and `--verbose`: what is said, and where.

use std::process::{Command, Output};

use tests::harness::{Folder, bedload, program, said};

use crate::film::SCENE as WET;

fn both(output: &Output) -> (String, String) {
    assert!(output.status.success(), "{}", said(output));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

#[test]
fn a_quiet_run_says_its_folder_alone_and_a_verbose_one_what_it_does() {
    let dry = WET.replace("[medium]\ndensity = 1.0\nviscosity = 0.1\n", "").replace("cells = [32, 48]\n", "");
    let folder = Folder::new("loudness");
    for (name, text, by) in
        [("wet", WET, "bedload"), ("dry", &*dry, "bedload"), ("grains", &*dry, "bedload-dem")]
    {
        let (scene, out) = (folder.write(&format!("{name}.toml"), text), folder.join(name));
        let run = |before: &[&str], after: &[&str]| {
            let mut command = Command::new(program(by));
            command.args(before).arg("run").arg(&scene).arg("--out").arg(&out).arg("--overwrite").args(after);
            both(&command.output().expect("it starts"))
        };
        let path = format!("{}\n", out.display());
        assert_eq!(run(&[], &["-q"]), (path.clone(), String::new()), "{name}");
        assert_eq!(run(&["--quiet"], &[]), (path.clone(), String::new()), "{name}");
        let usual = format!("{by}: done, see {path}");
        let (shown, told) = run(&[], &[]);
        assert!(shown.is_empty() && told.ends_with(&usual) && !told.contains("checkpoint"), "{told}");
        let (shown, told) = run(&[], &["-v"]);
        let planned = if by == "bedload" { "  sub-steps " } else { "contact_time = " };
        let started = if by == "bedload" { "bedload: starts " } else { "" };
        for word in [planned, started, "checkpoint of step ", &usual] {
            assert!(shown.is_empty() && told.contains(word), "{name}: {word}: {told}");
        }
    }
    let check =
        |option: &str| bedload(&["check".as_ref(), folder.join("wet.toml").as_os_str(), option.as_ref()]);
    assert_eq!(both(&check("-q")), (String::new(), String::new()));
    let (_, told) = both(&check("-v"));
    assert!(told.contains("bedload: asks "), "{told}");
    let refused = check("-qv");
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
}

/// What remains of the words of a solver is what may matter.
#[test]
fn a_quiet_run_still_warns() {
    let folder = Folder::new("warns");
    // It leaves through a face that no grain touches.
    let open = WET
        .replace("z = \"no-slip\"", "z = \"free-slip\"")
        .replace("0.0, 4.0]", "0.0, 0.01]\nvelocity = [0.0, 0.0, -1.0]");
    let scene = folder.write("leaves.toml", &open);
    let mut command = Command::new(program("bedload"));
    let run = command.arg("run").arg(&scene).arg("--out").arg(folder.join("out")).arg("-q");
    let (_, told) = both(&run.output().expect("it starts"));
    let lines: Vec<&str> = told.lines().collect();
    assert!(!lines.is_empty() && lines.iter().all(|line| line.contains("warning")), "{told}");
    assert!(told.contains("dem: bedload-dem: warning: grain 0 left the box"), "{told}");
    // It rises out of the cells that are even.
    let stretched = WET
        .replace(
            "cells = [32, 48]",
            "cells = [32, 44]\nstretching = { axis = \"z\", uniform_to = 4.625, spacing = 0.125 }",
        )
        .replace("density = 2.0", "density = 2.0\nvelocity = [0.0, 0.0, 2.0]");
    let scene = folder.write("rises.toml", &stretched);
    let mut command = Command::new(program("bedload"));
    let run = command.arg("run").arg(&scene).arg("--out").arg(folder.join("risen")).arg("-q");
    let (_, told) = both(&run.output().expect("it starts"));
    let warned = told.matches("warning: grain 0 reaches past domain.stretching.uniform_to = 4.625 m").count();
    assert_eq!(warned, 1, "{told}");
}
