//! A run that blows up stops at that window, names the first bad cell, and leaves the window before it.

use std::path::Path;
use std::process::{Command, Output};

use tests::harness::{Folder, bedload, program, said, summary};

/// A decaying vortex, with a step far beyond what convection bears once `--set` has its way.
const VORTEX: &str = r#"
until = 20.0

[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = [24, 24]
boundary = { x = "periodic", z = "no-slip" }

[medium]
density = 1.0
viscosity = 0.001
initial = { type = "taylor-green", amplitude = 1.0 }

[[grains]]
position = [0.5, 0.0, 0.4]
velocity = [0.1, 0.0, 0.0]
radius = 0.125
density = 1.0
motion = "prescribed"
"#;

const CONTACT: &str = r#"
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.01
friction = 0.0
"#;

/// The velocity outgrows the scene before it is not finite.
const GO_ON: [&str; 2] = ["--set", "coupling.force=[\"unstable\"]"];

/// Runs a program on a scene with overrides.
fn run(name: &str, scene: &Path, out: &Path, more: &[&str]) -> Output {
    let path = |path: &Path| path.to_str().expect("UTF-8").to_owned();
    Command::new(program(name))
        .args(["run", &path(scene), "--out", &path(out)])
        .args(more)
        .output()
        .expect("starts")
}

/// The window that failed and the cell, from what a run said.
fn failure(output: &Output) -> (u64, String) {
    let text = said(output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let after = text.split("the velocity is not finite in window ").nth(1);
    let after = after.unwrap_or_else(|| panic!("no window is named: {text}"));
    let window = after.split(',').next().and_then(|number| number.parse().ok());
    let cell = after.split(" in cell [").nth(1).and_then(|rest| rest.split(']').next());
    let cell = cell.unwrap_or_else(|| panic!("no cell is named: {text}"));
    assert!(cell.split(", ").all(|index| index.parse::<usize>().is_ok()), "{cell}");
    (window.unwrap_or_else(|| panic!("{text}")), cell.to_owned())
}

#[test]
fn a_fluid_alone_leaves_the_step_before() {
    let folder = Folder::new("blow-up-alone");
    let scene = folder.write("vortex.toml", VORTEX);
    for (kind, more) in [
        ("explicit", vec!["--set", "fluid.time.dt=0.2", "--set", "fluid.time.viscosity=explicit"]),
        ("implicit", vec!["--set", "fluid.time.dt=0.2", "--set", "fluid.time.viscosity=implicit"]),
    ] {
        let out = folder.join(kind);
        let ended = run("bedload-fluid", &scene, &out, &more);
        assert_eq!(ended.status.code(), Some(4), "{}", said(&ended));
        assert!(said(&ended).contains("smaller fluid.time.dt"), "{}", said(&ended));
        assert_eq!(summary(&out)["status"], "unstable");
        let out = folder.join(&format!("{kind}-on"));
        let more = [more, GO_ON.to_vec()].concat();
        let (window, cell) = failure(&run("bedload-fluid", &scene, &out, &more));
        assert!(window > 0, "{kind} fails in window {window}: it should do some first");
        let summary = summary(&out);
        assert_eq!(summary["status"], "failed");
        assert_eq!(summary["time"]["fluid_steps"], window, "{kind}: windows before the failure count");
        // From its checkpoint there is nothing left to do but the window that failed, with the same bits.
        let mut again = more.clone();
        again.push("--resume");
        let resumed = run("bedload-fluid", &scene, &out, &again);
        assert_eq!(failure(&resumed), (window, cell), "{kind}");
        assert!(said(&resumed).contains(&format!("stands at step {window}")), "{}", said(&resumed));
    }
}

/// In space, too; here the run fails before there was any regular checkpoint.
#[test]
fn a_fluid_in_space_leaves_the_step_before() {
    let folder = Folder::new("blow-up-space");
    let text = VORTEX
        .replace("\"plane\"", "\"space\"")
        .replace("lower = [0.0, 0.0]", "lower = [0.0, 0.0, 0.0]")
        .replace("upper = [1.0, 1.0]", "upper = [1.0, 1.0, 1.0]")
        .replace("cells = [24, 24]", "cells = [24, 24, 24]")
        .replace("x = \"periodic\",", "x = \"periodic\", y = \"periodic\",")
        .replace("position = [0.5, 0.0,", "position = [0.5, 0.5,");
    let scene = folder.write("vortex.toml", &text);
    for kind in ["explicit", "implicit"] {
        let viscosity = format!("fluid.time.viscosity={kind}");
        let more = [&["--set", "fluid.time.dt=0.14", "--set", &viscosity], &GO_ON[..]].concat();
        let out = folder.join(kind);
        let (window, cell) = failure(&run("bedload-fluid", &scene, &out, &more));
        let again = [&more[..], &["--resume"]].concat();
        assert_eq!(failure(&run("bedload-fluid", &scene, &out, &again)), (window, cell), "{kind}");
    }
}

#[test]
fn a_coupled_run_leaves_the_window_before() {
    let folder = Folder::new("blow-up-coupled");
    // A disc that takes part but is held, so that the fluid is the one to fail.
    let held = "radius = 0.125\nlocked = [\"x\", \"z\", \"spin-y\"]";
    let text = VORTEX
        .replace("velocity = [0.1, 0.0, 0.0]\n", "")
        .replace("motion = \"prescribed\"\n", "")
        .replace("radius = 0.125", held);
    let scene = folder.write("vortex.toml", &(text + CONTACT));
    let out = folder.join("out");
    let more = ["--set", "fluid.time.dt=0.2", "--set", "coupling.force=[\"cfl\"]"];
    let first = run("bedload", &scene, &out, &more);
    let (window, cell) = failure(&first);
    assert_eq!(summary(&out)["time"]["fluid_steps"], window);
    let names: Vec<String> = std::fs::read_dir(out.join("checkpoint"))
        .expect("checkpoints")
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names, [format!("{window:010}")], "one whole checkpoint, of the window that failed");
    let mut again = more.to_vec();
    again.push("--resume");
    assert_eq!(failure(&run("bedload", &scene, &out, &again)), (window, cell));
    // The log of the run that failed is as it was.
    let log = bedload(&["log", "info", out.join("exchange.mcap").to_str().expect("UTF-8")]);
    assert_eq!(log.status.code(), Some(0), "{}", said(&log));
}
