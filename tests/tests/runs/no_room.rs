//! Files that may grow no further, as on a full disk: each kind of run ends with code 5, names the file,
//! leaves no half file and goes on where it stood once there is room.

use std::path::Path;
use std::process::{Command, Output};

use tests::harness::{Folder, LONG_FLIGHT, SMALL_BOUNCE, bedload, program, said, summary};

const FLUID: &str = r#"
until = 60.0
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = [16, 16]
boundary = { x = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.01
body_force = [0.1, 0.0, 0.0]
[fluid.time]
dt = 0.01
[coupling]
checkpoint_every = 0.001
"#;

/// Runs `bedload run` where no file may grow beyond `blocks` of 512 bytes.
fn limited(blocks: u32, arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(["-c", "ulimit -f $0; exec \"$@\"", &blocks.to_string()])
        .arg(program("bedload"))
        .args(arguments)
        .output()
        .expect("sh starts")
}

/// Files below `folder` that were begun and not finished.
fn half_files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .flat_map(|entry| {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            if path.is_dir() { half_files(&path) } else { vec![name] }
        })
        .filter(|name| name.ends_with(".partial") || name.ends_with(".tmp"))
        .collect()
}

/// A run that finds no room at `blocks`, and goes on where there is room to the bytes of one that always had
/// it.
fn ends_and_goes_on(name: &str, scene: &str, more: &[&str], blocks: u32, file: &str) {
    let folder = Folder::new(name);
    let scene = folder.write("scene.toml", scene);
    let (scene, out, whole) = (scene.to_str().expect("UTF-8"), folder.join("out"), folder.join("whole"));
    let out_name = out.to_str().expect("UTF-8");
    let ended = limited(blocks, &[&["run", scene, "--out", out_name], more].concat());
    let words = said(&ended);
    assert_eq!(ended.status.code(), Some(5), "{name}: {words}");
    assert!(words.contains(file), "{name}: {file} is named: {words}");
    assert_eq!(half_files(&out), Vec::<String>::new(), "{name}");
    assert_eq!(summary(&out)["status"], "failed", "{name}");
    let resumed = bedload(&[&["run", scene, "--out", out_name, "--resume"], more].concat());
    assert_eq!(resumed.status.code(), Some(0), "{name}: {}", said(&resumed));
    let straight = bedload(&[&["run", scene, "--out", whole.to_str().expect("UTF-8")], more].concat());
    assert_eq!(straight.status.code(), Some(0), "{name}: {}", said(&straight));
    let series = |folder: &Path| std::fs::read(folder.join("series.csv")).expect("series.csv");
    assert!(series(&out) == series(&whole), "{name}: resumed to other rows");
    assert_eq!(summary(&out)["status"], "completed", "{name}");
}

#[test]
fn a_dry_run_without_room_goes_on_later() {
    // A shorter one, written down often.
    let scene = LONG_FLIGHT.replace("until = 1e6", "until = 2000.0").replace("every = 10.0", "every = 0.5");
    let scene = scene + "[coupling]\ncheckpoint_every = 0.001\n";
    ends_and_goes_on("no-room-dry", &scene, &["--no-record"], 200, "series.csv");
}

#[test]
fn a_fluid_without_room_goes_on_later() {
    ends_and_goes_on("no-room-fluid", FLUID, &["--no-record"], 160, "series.csv");
}

#[test]
fn a_coupled_run_without_room_goes_on_later() {
    let scene = format!("{SMALL_BOUNCE}\n[coupling]\ncheckpoint_every = 0.001\n");
    ends_and_goes_on("no-room-coupled", &scene, &[], 160, "exchange.mcap");
}

/// Shared memory, too, is asked for before it is used.
#[test]
fn a_start_without_room_says_so() {
    let folder = Folder::new("no-room-start");
    let (scene, out) = (folder.write("scene.toml", SMALL_BOUNCE), folder.join("out"));
    let ended = limited(8, &["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    assert_eq!(ended.status.code(), Some(5), "{}", said(&ended));
    assert!(!out.join("summary.json").exists() || summary(&out)["status"] != "completed");
}
