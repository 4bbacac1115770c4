//! Logs that drive solvers: with other values of the scene, another solver, cut short, of another release, of
//! a solver that ran alone.

use std::path::{Path, PathBuf};
use std::process::Output;

use protocol::log::{LogReader, Message, Topic, flip_bit};
use tests::harness::{Folder, SMALL_BOUNCE, bedload, program, said};

/// `protocol/examples/minimal_dem.rs`.
const MINIMAL: &str = "examples/minimal_dem";

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Runs a scene, and returns its log.
fn log(folder: &Folder, scene: &str, more: &[&str]) -> PathBuf {
    let (scene, out) = (folder.write("scene.toml", scene), folder.join("run"));
    let output = bedload(&[&["run", path(&scene), "--out", path(&out)], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    out.join("exchange.mcap")
}

fn replay(log: &Path, side: &str, more: &[&str]) -> Output {
    bedload(&[&["replay", path(log), "--drive", side], more].concat())
}

fn ends(output: &Output, code: i32, words: &[&str]) {
    assert_eq!(output.status.code(), Some(code), "{}", said(output));
    for word in words {
        assert!(said(output).contains(word), "no {word:?} in {}", said(output));
    }
}

/// Largest relative difference of each quantity in a `divergence.csv`, and its number of windows.
fn largest(csv: &Path) -> (Vec<(String, f64)>, usize) {
    let text = std::fs::read_to_string(csv).expect("divergence.csv");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let rows: Vec<Vec<&str>> = lines.collect();
    let of = |(place, name): (usize, &&str)| {
        let quantity = name.strip_suffix("_relative")?.to_owned();
        let value = |row: &Vec<&str>| row[place].parse::<f64>().expect("a number");
        Some((quantity, rows.iter().map(value).fold(0.0, f64::max)))
    };
    (header.iter().enumerate().filter_map(of).collect(), rows.len())
}

#[test]
fn other_values_are_compared_window_by_window() {
    let folder = Folder::new("replay-set");
    let log = log(&folder, SMALL_BOUNCE, &[]);
    // As it was run, over the channels: the same bits of both sides.
    for (side, quantities) in [("dem", 5), ("fluid", 2)] {
        let out = folder.join(side);
        let output = replay(&log, side, &["--compare", "--out", path(&out)]);
        ends(&output, 0, &["no difference beyond 1e-12", "divergence.csv"]);
        let (same, windows) = largest(&out.join("divergence.csv"));
        assert_eq!((same.len(), windows), (quantities, 300));
        assert!(same.iter().all(|(_, relative)| *relative == 0.0), "{same:?}");
    }
    // Without a film the sphere meets the wall faster; before that all is the same.
    let out = folder.join("dry-contact");
    let output = replay(&log, "dem", &["--set", "dem.lubrication.form=none", "--out", path(&out)]);
    ends(&output, 0, &["first difference beyond 1e-12", "grain 0, lubrication_force"]);
    let differs = largest(&out.join("divergence.csv")).0;
    let of = |name: &str| differs.iter().find(|(other, _)| other == name).expect("a column").1;
    assert_eq!((of("lubrication_force"), of("spin")), (1.0, 0.0));
    assert!(of("velocity") > 0.1, "{differs:?}");
    let svg = std::fs::read_to_string(out.join("divergence.svg")).expect("a figure");
    assert!(svg.starts_with("<svg") && svg.contains("lubrication force"));
    // A sub-step of its own is ordered for a DEM with another dt.
    ends(&replay(&log, "dem", &["--set", "dem.dt=1e-5"]), 0, &["window 0, t = 0.01 s", "position"]);
    let fluid = replay(&log, "fluid", &["--set", "medium.viscosity=0.06"]);
    ends(&fluid, 0, &["first difference", "grain 0, force"]);
    // The folder of a run keeps what it holds.
    let run = folder.join("run");
    ends(&replay(&log, "dem", &["--compare", "--out", path(&run)]), 2, &["holds a run", "--out"]);
    // What does not fit is named.
    ends(
        &replay(&log, "dem", &["--set", "dem.contact.friction=-1"]),
        2,
        &["exchange.mcap", "friction is -1"],
    );
    ends(
        &replay(&log, "dem", &["--set", "dem.lubrication.form=none", "--verify"]),
        2,
        &["cannot be used with"],
    );
}

#[test]
fn another_dem_is_driven_where_that_is_allowed_and_none_that_the_log_names() {
    let folder = Folder::new("replay-command");
    let (minimal, trace) = (program(MINIMAL), folder.join("trace"));
    let text = format!("#!/bin/sh\necho started >> '{}'\nexec '{}' \"$@\"\n", path(&trace), path(&minimal));
    let script = folder.write("dem.sh", &text);
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&script, mode).expect("may be run");
    let command = format!("dem.command=[{:?}]", path(&script));
    let theirs = ["--set", &command, "--set", "dem.dt=2e-5"];
    let log = log(&folder, SMALL_BOUNCE, &theirs);
    let starts = || std::fs::read_to_string(&trace).expect("a trace").lines().count();
    let before = starts();
    assert!(before > 0, "the run started it");
    ends(&replay(&log, "dem", &theirs), 2, &["dem.command", "--allow-commands"]);
    ends(&replay(&log, "fluid", &theirs), 2, &["dem.command", "drive the dem"]);
    ends(&replay(&log, "fluid", &["--verify"]), 0, &[]);
    ends(&replay(&log, "dem", &["--allow-commands", "--compare"]), 0, &["bedload-dem"]);
    assert_eq!(starts(), before, "a command of the log was started");
    let allowed = replay(&log, "dem", &[&theirs[..], &["--allow-commands"]].concat());
    ends(&allowed, 0, &["no difference beyond 1e-12", "dem.sh"]);
    assert!(starts() > before);
}

#[test]
fn a_log_that_breaks_off_has_an_exit_code_of_its_own() {
    let folder = Folder::new("replay-cut");
    let log = log(&folder, SMALL_BOUNCE, &["--until", "1.5"]);
    let cut = |from: &Path, name: &str| {
        let bytes = std::fs::read(from).expect("the log");
        let to = folder.join(name);
        std::fs::write(&to, &bytes[..bytes.len() * 2 / 3]).expect("a file for the test");
        to
    };
    let short = cut(&log, "short.mcap");
    for side in ["dem", "fluid"] {
        let output = replay(&short, side, &["--verify"]);
        ends(&output, 6, &["breaks off", "all up to window", "is the same", "log repair"]);
    }
    ends(&replay(&short, "dem", &["--compare"]), 6, &["no difference", "breaks off"]);
    let flipped = folder.join("flipped.mcap");
    flip_bit(&log, &flipped, Topic::Kinematics, 20, 0, 64 * 8 + 20).expect("flips");
    ends(&replay(&cut(&flipped, "wrong.mcap"), "dem", &["--verify"]), 1, &["step 20"]);
    let nothing = folder.write("nothing.mcap", "");
    ends(&replay(&nothing, "dem", &["--verify"]), 2, &["nothing.mcap"]);
}

/// A log of release 0.1.0: every later one reads each of its messages, and its solvers do nearly the same
/// again. Not the same bits: those differ between machines whose vectors have another width.
#[test]
fn logs_of_releases_are_read_and_replayed() {
    for release in ["0.1.0", "0.2.0"] {
        let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("golden/two-spheres-{release}.mcap"));
        assert_golden_is_read(&golden);
    }
}

/// Reads every message of a golden log.
fn assert_golden_is_read(golden: &Path) {
    let mut count = std::collections::BTreeMap::<String, u32>::new();
    let (mut touched, mut loaded) = (false, false);
    for entry in LogReader::open(golden).expect("the log of a release") {
        let entry = entry.expect("every message is read");
        match entry.message {
            Message::Kinematics(_, grains) => touched |= grains[1].contact_force[2] > 0.0,
            Message::Loads(_, loads) => loaded |= loads[0].force[2] > 0.0,
            _ => {}
        }
        *count.entry(entry.channel.topic.clone()).or_default() += 1;
    }
    let windows = ["command", "loads", "kinematics"].map(|name| count[&format!("bedload/{name}")]);
    assert_eq!((windows, count["bedload/status"]), ([60; 3], 120));
    for topic in ["scene", "points", "window", "grains"] {
        assert_eq!(count[&format!("viewer/{topic}")], 60, "viewer/{topic}");
    }
    assert!(touched && loaded);
}

/// The scene of 0.1.0 has keys that are retired: its log is read, and a replay says which key it is.
#[test]
fn the_log_of_this_release_is_replayed_and_one_with_retired_keys_refused() {
    let golden = |release: &str| {
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("golden/two-spheres-{release}.mcap"))
    };
    ends(&replay(&golden("0.1.0"), "dem", &["--verify"]), 2, &["is retired", "leave it out"]);
    let golden = golden("0.2.0");
    let folder = Folder::new("golden");
    for side in ["dem", "fluid"] {
        let out = folder.join(side);
        ends(&replay(&golden, side, &["--compare", "--out", path(&out)]), 0, &["60 windows"]);
        let (differences, windows) = largest(&out.join("divergence.csv"));
        assert_eq!(windows, 60);
        assert!(differences.iter().all(|(_, relative)| *relative < 1e-6), "{side}: {differences:?}");
    }
}

/// Grains that fall into a box and touch.
const DRY: &str = r#"
until = 1.0
gravity = [0.0, 0.0, -10.0]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [1.0, 1.0, 1.0]
boundary = { x = "free-slip", y = "free-slip", z = "no-slip" }
[[grains]]
position = [0.5, 0.5, 0.5]
radius = 0.1
density = 2.0
[[grains]]
position = [0.52, 0.5, 0.8]
radius = 0.1
density = 2.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 0.005
[observe]
every = 0.05
"#;

#[test]
fn a_dem_alone_is_logged_at_each_observation() {
    let folder = Folder::new("replay-dry");
    let log = log(&folder, DRY, &[]);
    let info = bedload(&["log", "info", path(&log)]);
    ends(&info, 0, &["bedload/kinematics", "complete"]);
    let mut observed = 0;
    for entry in LogReader::open(&log).expect("a log") {
        match entry.expect("whole").message {
            Message::Kinematics(..) => observed += 1,
            Message::Loads(..) => panic!("no fluid took part"),
            _ => {}
        }
    }
    assert_eq!(observed, 20, "one for each row of series.csv");
    let export = bedload(&["export", path(&folder.join("run")), "--foxglove"]);
    ends(&export, 0, &["exchange.mcap"]);
    ends(&replay(&log, "dem", &["--verify"]), 0, &["20 messages compared"]);
    ends(&replay(&log, "fluid", &["--verify"]), 2, &["no fluid took part"]);
    ends(&replay(&log, "dem", &["--compare"]), 0, &["no difference", "20 windows"]);
    let softer = replay(&log, "dem", &["--set", "dem.contact.restitution=0.9"]);
    ends(&softer, 0, &["first difference beyond", "contact_force"]);
    // A bit that is not what it was is named.
    let flipped = folder.join("flipped.mcap");
    let step = LogReader::open(&log)
        .expect("a log")
        .filter_map(Result::ok)
        .find(|entry| entry.channel.topic == "bedload/kinematics")
        .expect("kinematics")
        .step;
    let window = u32::try_from(step).expect("few windows");
    flip_bit(&log, &flipped, Topic::Kinematics, window, 0, 64 * 8 + 20).expect("flips");
    ends(&replay(&flipped, "dem", &["--verify"]), 1, &[&format!("step {step}"), "grain 0"]);
    let (scene, bare) = (folder.join("scene.toml"), folder.join("bare"));
    ends(&bedload(&["run", path(&scene), "--out", path(&bare), "--no-record"]), 0, &[]);
    assert!(!bare.join("exchange.mcap").exists(), "--no-record recorded");
    // Both runs are the same otherwise.
    let series =
        |name: &str| std::fs::read_to_string(folder.join(name).join("series.csv")).expect("a series");
    assert_eq!(series("run"), series("bare"));
}

#[test]
fn a_dem_alone_that_goes_on_begins_another_part() {
    let folder = Folder::new("replay-dry-resumed");
    let first = log(&folder, DRY, &["--until", "0.5"]);
    let (scene, out) = (folder.join("scene.toml"), folder.join("run"));
    // The run that goes on replaces its checkpoints, but for the one at which its log begins.
    let kept = protocol::checkpoints::newest_of_run(&out);
    ends(&bedload(&["run", path(&scene), "--out", path(&out), "--resume"]), 0, &[]);
    ends(&replay(&first, "dem", &["--verify"]), 0, &["10 messages"]);
    let rest = out.join("exchange.2.mcap");
    ends(&bedload(&["log", "info", path(&rest)]), 0, &["bedload/kinematics", "complete"]);
    ends(&replay(&rest, "dem", &["--verify"]), 2, &["--checkpoint"]);
    ends(&replay(&rest, "dem", &["--verify", "--checkpoint", path(&kept)]), 0, &["10 messages compared"]);
    let newest = protocol::checkpoints::newest_of_run(&out);
    assert!(newest != kept && kept.exists());
    ends(&replay(&rest, "dem", &["--verify", "--checkpoint", path(&newest)]), 2, &["begins at step"]);
    ends(&replay(&first, "dem", &["--checkpoint", path(&kept)]), 2, &["leave it out"]);
    // Nothing is written into the folder of a run.
    ends(&replay(&first, "dem", &["--out", path(&out)]), 2, &["holds a run", "--out"]);
    // Of another scene it is refused.
    let other = folder.write("other.toml", &DRY.replace("restitution = ", "restitution = 0.2 # "));
    let elsewhere = folder.join("elsewhere");
    ends(&bedload(&["run", path(&other), "--out", path(&elsewhere), "--until", "0.5"]), 0, &[]);
    let theirs = protocol::checkpoints::newest_of_run(&elsewhere);
    ends(&replay(&rest, "dem", &["--verify", "--checkpoint", path(&theirs)]), 1, &["another scene"]);
}

#[test]
fn a_fluid_alone_is_logged_too() {
    let folder = Folder::new("replay-fluid-alone");
    let held = ["--set", "grains[0].motion=fixed", "--set", "grains[0].density=1.0", "--until", "0.5"];
    let wall = "domain.boundary.r_upper={ type = \"no-slip\", velocity = [0.0, 0.0, 1.0] }";
    let push = ["--set", wall, "--set", "observe.every=0.1"];
    let log = log(&folder, SMALL_BOUNCE, &[&held[..], &push].concat());
    ends(&replay(&log, "fluid", &["--verify"]), 0, &["5 messages compared"]);
    ends(&replay(&log, "fluid", &["--compare"]), 0, &["no difference"]);
    ends(&replay(&log, "dem", &["--verify"]), 2, &["no dem took part"]);
}

/// What reads a run again takes the tables that its scene names: other ones than the run read are refused,
/// unless `--set` names them.
#[test]
fn a_table_that_was_changed_since_the_run_is_named() {
    let folder = Folder::new("replay-table");
    let table =
        |radius: f64| format!("x,y,z,radius,density\n1.0,0.0,2.0,{radius},2.0\n3.0,0.0,2.0,0.5,2.0\n");
    folder.write("grains.csv", &table(0.5));
    let scene = "until = 0.1\ngravity = [0.0, 0.0, -1.0]\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\n\
                 upper = [6.0, 4.0]\nboundary = { x = \"no-slip\", z = \"no-slip\" }\n[[grain_files]]\n\
                 file = \"grains.csv\"\n[dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.5\n\
                 contact_time = 1e-2\n";
    let log = log(&folder, scene, &[]);
    let replay = |more: &[&str]| replay(&log, "dem", more);
    let average = || {
        let mut command = std::process::Command::new(program("bedload-dem"));
        command.arg("coarse-grain").arg(folder.join("run")).args(["--slabs", "4"]).output().expect("starts")
    };
    folder.write("grains.csv", &table(0.4));
    let other = "dem.contact.contact_time=0.011";
    for output in [replay(&["--verify"]), replay(&["--compare"]), replay(&["--set", other]), average()] {
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(
            text.contains("grain_files[0].file") && text.contains("put back what the run read"),
            "{text}"
        );
    }
    let named = folder.write("named.csv", &table(0.4));
    let output = replay(&["--set", &format!("grain_files=[{{file={named:?}}}]")]);
    ends(&output, 0, &[]);
    folder.write("grains.csv", &table(0.5));
    for output in [replay(&["--verify"]), replay(&["--set", other]), average()] {
        ends(&output, 0, &[]);
    }
}
