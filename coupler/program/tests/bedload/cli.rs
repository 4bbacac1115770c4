//! The command line: exit codes, errors with place and remedy, plans.

use std::path::Path;
use std::process::{Command, Output};

use crate::fake_solvers::{Room, SPHERE, bedload, run, scene, stderr};

fn check(scene: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["check", scene.to_str().unwrap(), "--allow-commands"];
    arguments.extend(more);
    bedload(&arguments).output().unwrap()
}

/// A solver that answers `check` with these facts and cannot do anything else.
fn answering(facts: &str) -> String {
    format!("command = [\"sh\", \"-c\", {:?}, \"sh\"]", format!("printf '%s' '{facts}'"))
}

fn scene_with_facts(fluid: &str, dem: &str, density: f64) -> String {
    let sphere = SPHERE.replace("density = 4.0", &format!("density = {density:?}"));
    format!("{sphere}[fluid]\n{}\n[dem]\n{}\n", answering(fluid), answering(dem))
}

const DEM: &str =
    r#"{"grains": 1, "dt": 1e-4, "contact_time": 2e-3, "lubrication_dt": null, "interaction_range": 0.1}"#;
const SEED: &str = concat!(
    r#"{"cells": 262144, "dt": 0.01, "spacing": 0.0625, "schemes": ["explicit"], "#,
    r#""implicit_viscosity": true, "cfl_limit": 0.8}"#
);

/// What our maps say of a method is not known of another fluid, whatever order of the exchange it names.
#[test]
fn bounds_that_were_measured_with_our_fluid_are_not_judged_for_another() {
    let room = Room::new("light");
    let path = room.put(&scene_with_facts(SEED, DEM, 1.5));
    let output = check(&path, &[]);
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        shown.contains("t_c/dt_dem") && shown.contains("with which grains it is stable is not known"),
        "{shown}"
    );
    let rows = shown.lines().filter(|line| line.contains("ρ_p/ρ")).count();
    assert_eq!(rows, 0, "{shown}");
}

/// A scene that one only looks at starts nothing.
#[test]
fn check_starts_no_command_of_a_scene_unless_it_is_allowed() {
    let room = Room::new("looks");
    let trace = room.0.join("trace");
    let text =
        scene_with_facts(SEED, DEM, 4.0).replace("printf", &format!("touch {}; printf", trace.display()));
    let path = room.put(&text);
    let output = bedload(&["check", path.to_str().unwrap()]).output().unwrap();
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(!trace.exists(), "{shown}");
    assert!(shown.contains("was not started") && shown.contains("--allow-commands"), "{shown}");
    assert!(shown.contains("t_c, and every bound with it, is not known"), "{shown}");
    assert_eq!(check(&path, &[]).status.code(), Some(0));
    assert!(trace.exists());
}

/// A DEM that says nothing of itself is held to the contact time of the scene.
#[test]
fn the_scenes_contact_time_binds_a_dem_that_says_nothing() {
    let room = Room::new("contact-time");
    let text = scene("good", "good", "").replace("contact_time = 0.06", "contact_time = 0.002");
    let output = check(&room.put(&text), &["--json"]);
    let plan: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(plan["substeps"], 100, "windows of 0.01 s, sub-steps of t_c/20, whatever dem.dt says");
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
    for name in ["contact-steps", "window-over-contact", "overlap"] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
}

fn heap(keys: &str) -> String {
    format!("[[metrics]]\nname = \"heap\"\nkind = \"deposit-run-out\"\nhalf_length = 1.0\n{keys}\n")
}

#[test]
fn bad_input_is_exit_2_with_place_and_remedy() {
    let room = Room::new("bad");
    std::fs::write(room.0.join("grains.csv"), "x,y,z,radius,density\n3.5,3.5,3.5,0.1,2.0\n").expect("a file");
    let good = scene("good", "good", "");
    for (text, words) in [
        (good.replace("radius = 0.5", "radius = -0.5"), vec!["grains[0].radius", "-0.5", "positive"]),
        (good.replace("deadline = 2.0", "deadlin = 2.0"), vec!["deadlin", "unknown field"]),
        (good.replace("until = 0.2", "until = "), vec!["not valid TOML"]),
        (
            good.replace("gravity = [0.0, 0.0, -1.0]", "gravity = [0.0, 0.0, -1.0, 5.0]"),
            vec!["gravity", "4 entries", "too many"],
        ),
        (format!("{good}\n[chart]\nmetrik = \"peak\"\n"), vec!["metrik", "unknown field"]),
        (format!("{good}\n[stability]\nsignel = \"peak\"\n"), vec!["signel", "unknown field"]),
        (format!("{good}\n{}", heap("centre = 1e30")), vec!["metrics[0].centre", "1e30", "in the box"]),
        (format!("{good}\n{}", heap("centre = 0.5\nbin = 1e-300")), vec!["metrics[0].bin", "1e5 bins"]),
        (
            format!("{good}\n[[grain_files]]\nfile = \"grains.csv\"\ncopies = 99999999999\n"),
            vec!["grain_files[0].copies", "fewer times"],
        ),
        (
            good.replace("contact = { contact_time = 0.06 }", ""),
            vec!["dem.contact.contact_time", "how long a contact lasts", "check SCENE --json"],
        ),
        (good.replace("contact_time = 0.06", "contact_time = 0"), vec!["dem.contact.contact_time", "is 0"]),
        (good.replace("dt = 0.01", ""), vec!["fluid", "has no dt"]),
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

/// A pipe waits for ever for a writer, and a device has no end.
#[test]
fn a_pipe_or_a_device_is_refused_at_once() {
    let room = Room::new("pipes");
    let pipe = room.0.join("pipe.toml");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for file in [pipe.as_path(), Path::new("/dev/zero")] {
        let text = format!("{}[[grain_files]]\nfile = {file:?}\n", scene("good", "good", ""));
        let scene = room.put(&text);
        let (name, scene, out) = (file.to_str().unwrap(), scene.to_str().unwrap(), room.out());
        for arguments in [
            &["check", name][..],
            &["check", scene],
            &["run", name],
            &["chart", name],
            &["stability", name],
            &["study", name],
            &["log", "info", name],
            &["log", "cat", name],
            &["log", "repair", name, out.to_str().unwrap()],
            &["replay", name, "--drive", "dem"],
        ] {
            let mut command = Command::new("timeout");
            command.args(["30", env!("CARGO_BIN_EXE_bedload")]).args(arguments);
            let output = command.output().unwrap();
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
            let words = said.split_whitespace().collect::<Vec<_>>().join(" ").replace("│ ", "");
            assert!(words.contains("a pipe, a socket or a device"), "{arguments:?}: {said}");
        }
    }
}

#[test]
fn a_full_device_is_no_room_and_not_a_panic() {
    let room = Room::new("full");
    let path = room.put(&scene_with_facts(SEED, DEM, 4.0));
    for more in [&[][..], &["--json"]] {
        let mut arguments = vec!["check", path.to_str().unwrap(), "--allow-commands"];
        arguments.extend(more);
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = bedload(&arguments).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(5), "{}", stderr(&output));
        assert!(stderr(&output).contains("cannot print: No space left"), "{}", stderr(&output));
    }
}

/// What only reads a run has no checkpoint to go on from.
#[test]
fn a_full_disk_is_exit_5_and_no_advice_to_resume_where_nothing_resumes() {
    let room = Room::new("full-disk");
    let path = room.put(&scene("good", "good", ""));
    assert_eq!(run(&room, &path, &["--until", "0.02"]).status.code(), Some(0));
    let (out, log, new) = (room.out(), room.out().join("exchange.mcap"), room.0.join("new.mcap"));
    let [out, log, new] = [&out, &log, &new].map(|path| path.to_str().unwrap());
    for arguments in [&["report", out][..], &["log", "repair", log, new], &["log", "thin", log, new]] {
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -f 1; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_bedload")]).args(arguments);
        let output = command.output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(5), "{arguments:?}: {said}");
        assert!(said.contains("make room") && !said.contains("--resume"), "{arguments:?}: {said}");
    }
    assert!(!Path::new(new).exists());
}

/// No thread can have a stack of this size, as none can be had at a limit of processes.
#[test]
fn a_thread_that_cannot_start_is_an_error() {
    let room = Room::new("threads");
    let path = room.put(&scene_with_facts(SEED, DEM, 4.0));
    let arguments = ["check", path.to_str().unwrap(), "--allow-commands"];
    let output = bedload(&arguments).env("RUST_MIN_STACK", "1000000000000000").output().unwrap();
    assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
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

/// Shells and manuals know every command, and the version says which commit was built.
#[test]
fn completions_manual_pages_and_version_are_of_this_build() {
    let room = Room::new("words");
    let printed = |arguments: &[&str]| {
        let output = bedload(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let help = printed(&["--help"]);
    let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = commands.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
    let names: Vec<&str> = names.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.contains(&"run") && names.contains(&"man"), "{help}");

    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let text = printed(&["completions", shell]);
        let missing: Vec<&&str> = names.iter().filter(|name| !text.contains(**name)).collect();
        assert!(missing.is_empty(), "{shell} lacks {missing:?}");
    }
    let folder = room.out();
    printed(&["man", folder.to_str().unwrap()]);
    for name in names.iter().filter(|name| **name != "help") {
        let page = std::fs::read_to_string(folder.join(format!("bedload-{name}.1"))).expect(name);
        assert!(page.contains(".SH SYNOPSIS"), "{page}");
    }
    let file = room.put("");
    let output = bedload(&["man", file.join("man").to_str().unwrap()]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("remedy: name a folder"), "{}", stderr(&output));

    let version = printed(&["--version"]);
    let commit = version.trim().strip_prefix(concat!("bedload ", env!("CARGO_PKG_VERSION"), " ("));
    let commit = commit.and_then(|rest| rest.strip_suffix(')')).expect(&version);
    assert!(!commit.is_empty() && commit.chars().all(|c| c.is_ascii_hexdigit() || c == '.'), "{version}");
}
