//! The command line: exit codes, errors with place and remedy, plans.

mod common;

use std::path::Path;
use std::process::Output;

use common::{Room, bedload, run, scene, stderr};

#[test]
fn fake_solver() {
    common::play();
}

fn check(scene: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["check", scene.to_str().unwrap()];
    arguments.extend(more);
    bedload(&arguments).output().unwrap()
}

/// A solver that answers `check` with these facts and cannot do anything else.
fn answering(facts: &str) -> String {
    format!("command = [\"sh\", \"-c\", {:?}, \"sh\"]", format!("printf '%s' '{facts}'"))
}

fn scene_with_facts(fluid: &str, dem: &str, density: f64) -> String {
    format!(
        r#"until = 1.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
cells = [64, 64, 64]
boundary = {{ x = "periodic", y = "periodic", z = "no-slip" }}
[medium]
density = 1.0
viscosity = 0.01
[[grains]]
position = [2.0, 2.0, 2.0]
radius = 0.5
density = {density:?}
[fluid]
{}
[dem]
{}
"#,
        answering(fluid),
        answering(dem)
    )
}

const DEM: &str =
    r#"{"grains": 1, "dt": 1e-4, "contact_time": 2e-3, "lubrication_dt": null, "interaction_range": 0.1}"#;
const SEED: &str = r#"{"cells": 262144, "dt": 0.01, "spacing": 0.0625, "loads": "izard-2014", "implicit_viscosity": true, "cfl_limit": 0.8}"#;

#[test]
fn light_grains_are_refused_by_name_with_the_seeds_form_and_can_be_forced() {
    let room = Room::new("light");
    let path = room.put(&scene_with_facts(SEED, DEM, 1.5));
    let output = check(&path, &[]);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("density-ratio: ρ_p/ρ = 1.5, must be ≥ 2"), "{text}");
    assert!(text.contains("remedy:") && text.contains("coupling.force"), "{text}");
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(shown.contains("BROKEN") && shown.contains("t_c/dt_dem"), "{shown}");

    let run_refused = run(&room, &path, &[]);
    assert_eq!(run_refused.status.code(), Some(2));
    assert!(!room.out().exists(), "a refused run leaves no folder");

    let forced = check(&path, &["--set", r#"coupling.force=["density-ratio"]"#]);
    let shown = String::from_utf8_lossy(&forced.stdout).into_owned();
    assert_eq!(forced.status.code(), Some(0), "{}", stderr(&forced));
    assert!(shown.contains("forced") && shown.contains("warning: density-ratio"), "{shown}");

    let neutral =
        check(&path, &["--set", "grains[0].density=1.0", "--set", r#"coupling.force=["density-ratio"]"#]);
    assert_eq!(neutral.status.code(), Some(2));
    assert!(stderr(&neutral).contains("loads-singular"), "{}", stderr(&neutral));

    let heavy = check(&path, &["--set", "grains[0].density=4.0"]);
    assert_eq!(heavy.status.code(), Some(0), "{}", stderr(&heavy));
}

#[test]
fn the_plan_as_json_has_steps_and_bounds() {
    let room = Room::new("json");
    let path = room.put(&scene_with_facts(SEED, DEM, 4.0));
    let output = check(&path, &["--json"]);
    let plan: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(plan["substeps"], 100);
    assert_eq!(plan["cells"], 262_144);
    assert_eq!(plan["scheme"], "explicit");
    let names: Vec<&str> =
        plan["bounds"].as_array().unwrap().iter().map(|bound| bound["name"].as_str().unwrap()).collect();
    for name in ["density-ratio", "resting-weight", "contact-steps", "window-over-contact", "resolution"] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
}

#[test]
fn bad_input_is_exit_2_with_place_and_remedy() {
    let room = Room::new("bad");
    let good = scene("good", "good", "");
    for (text, words) in [
        (good.replace("radius = 0.5", "radius = -0.5"), vec!["grains[0].radius", "-0.5", "positive"]),
        (good.replace("deadline = 2.0", "deadlin = 2.0"), vec!["deadlin", "unknown field"]),
        (good.replace("until = 0.2", "until = "), vec!["not valid TOML"]),
        (good.replace("dt = 0.003", ""), vec!["dem", "has no dt"]),
        (
            good.replacen("command = [\"sh\"", "command = [3, \"sh\"", 1),
            vec!["fluid.command", "list of strings"],
        ),
    ] {
        let path = room.put(&text);
        for output in [check(&path, &[]), run(&room, &path, &[])] {
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{said}");
            for word in &words {
                assert!(said.contains(word), "{word:?} in {said}");
            }
        }
    }
    let missing = check(&room.0.join("nowhere.toml"), &[]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(stderr(&missing).contains("nowhere.toml"));
    let no_arguments = bedload(&["run"]).output().unwrap();
    assert_eq!(no_arguments.status.code(), Some(2));
}

#[test]
fn a_solver_that_is_not_there_is_exit_3_with_what_to_do() {
    let room = Room::new("absent");
    let text = scene("good", "good", "");
    let start = text.find("[dem]").unwrap();
    let text = format!("{}[dem]\ndt = 0.003\ncommand = [\"/no/such/solver\"]\n", &text[..start]);
    let path = room.put(&text);
    let output = check(&path, &[]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("/no/such/solver") && stderr(&output).contains("PATH"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_folder_of_other_things_is_not_touched() {
    let room = Room::new("foreign");
    let path = room.put(&scene("good", "good", ""));
    std::fs::create_dir_all(room.out()).unwrap();
    std::fs::write(room.out().join("thesis.tex"), "years of work").unwrap();
    let output = run(&room, &path, &[]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(room.read("thesis.tex"), "years of work");
    let output = run(&room, &path, &["--resume"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}

#[test]
fn replay_and_export_say_what_they_cannot_do() {
    let room = Room::new("cannot");
    let output = bedload(&["replay", "/no/such.mcap", "--drive", "dem"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("/no/such.mcap"));
    let path = room.put(&scene("good", "good", ""));
    assert_eq!(run(&room, &path, &["--until", "0.02"]).status.code(), Some(0));
    let out = room.out();
    let log = out.join("exchange.mcap");
    let info = bedload(&["log", "info", log.to_str().unwrap()]).output().unwrap();
    assert_eq!(info.status.code(), Some(0), "{}", stderr(&info));
    let cat = bedload(&["log", "cat", log.to_str().unwrap(), "--topic", "loads", "--step", "1", "--json"])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&cat.stdout).lines().count(), 1, "{}", stderr(&cat));
    let wrong = bedload(&["log", "cat", log.to_str().unwrap(), "--step", "x"]).output().unwrap();
    assert_eq!(wrong.status.code(), Some(2));
    let export = |what: &str| bedload(&["export", out.to_str().unwrap(), what]).output().unwrap();
    assert_eq!(export("--csv").status.code(), Some(0));
    assert!(String::from_utf8_lossy(&export("--foxglove").stdout).contains("exchange.mcap"));
    let vtk = export("--vtk");
    assert_eq!(vtk.status.code(), Some(2));
    assert!(stderr(&vtk).contains("fields_every"), "{}", stderr(&vtk));
}
