//! Sizes of what a run leaves, as `bedload check` says them before, and the fields that it writes by default.

use std::path::Path;

use serde_json::Value;
use tests::harness::{Folder, bedload, said};

/// What all scenes share, then those of this file: a plane, space, and grains alone that fill a box.
const FALL: &str = r#"
gravity = [0.0, 0.0, -1.0]
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 0.02
[medium]
density = 1.0
viscosity = 0.1
[fluid]
time = { dt = 0.01 }
[observe]
fields_every = 0.2
"#;

const PLANE: &str = r#"
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [4.0, 6.0]
cells = [64, 96]
boundary = { x = "periodic", z = "no-slip" }
[[grains]]
position = [1.0, 0.0, 4.0]
shape = "ellipse"
semi_axes = [0.5, 0.3]
density = 2.0
[[groups]]
count = 3
lower = [0.0, 0.0, 0.0]
upper = [4.0, 0.0, 3.0]
radius = 0.4
density = 2.0
seed = 1
"#;

const SPACE: &str = r#"
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [2.0, 2.0, 3.0]
cells = [24, 24, 36]
boundary = { x = "periodic", y = "periodic", z = "no-slip" }
[[groups]]
count = 8
lower = [0.0, 0.0, 0.2]
upper = [2.0, 2.0, 2.8]
radius = 0.3
density = 2.0
seed = 4
"#;

const DRY: &str = r#"
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 12.0]
boundary = { x = "no-slip", y = "no-slip", z = "no-slip" }
[[groups]]
count = 500
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 12.0]
radius = 0.3
density = 2.0
seed = 4
"#;

fn scene(until: f64, more: &str) -> String {
    let fall = if more.contains("cells") {
        FALL.to_owned()
    } else {
        FALL.replace("[medium]\ndensity = 1.0\nviscosity = 0.1\n[fluid]\ntime = { dt = 0.01 }\n", "")
    };
    format!("until = {until}\n{fall}{more}")
}

/// Bytes of the files below a folder whose names end so.
fn bytes(folder: &Path, endings: &[&str]) -> u64 {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let wanted = |path: &Path| endings.iter().any(|end| path.to_string_lossy().ends_with(end));
    entries
        .map(|entry| match entry.path() {
            path if path.is_dir() => bytes(&path, endings),
            path if wanted(&path) => entry.metadata().expect("a file").len(),
            _ => 0,
        })
        .sum()
}

fn arguments<'a>(word: &'a str, scene: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    [&[word, scene.to_str().expect("UTF-8")], more].concat()
}

fn plan(scene: &Path, more: &[&str]) -> Value {
    let check = bedload(&arguments("check", scene, &[&["--json"], more].concat()));
    assert!(check.status.success(), "{}", said(&check));
    serde_json::from_slice(&check.stdout).expect("a plan")
}

#[test]
fn sizes_are_those_that_the_plan_says() {
    let folder = Folder::new("sizes");
    let mut off = Vec::new();
    for (name, until, more) in [("plane", 1.0, PLANE), ("space", 1.0, SPACE), ("dry", 12.0, DRY)] {
        let file = folder.write(&format!("{name}.toml"), &scene(until, more));
        let plan = plan(&file, &[]);
        let number = |value: &Value| value.as_f64().expect("a number");
        let files = &plan["files"];
        let out = folder.join(name);
        let run = bedload(&arguments("run", &file, &["--out", out.to_str().expect("UTF-8")]));
        assert!(run.status.success(), "{}", said(&run));
        let log = bedload(&["log", "info", out.join("exchange.mcap").to_str().expect("UTF-8")]);
        let text = String::from_utf8_lossy(&log.stdout).into_owned();
        let messages = text.lines().filter(|line| line.trim_start().starts_with("messages"));
        let logged: f64 = messages
            .map(|line| line.split_whitespace().nth(2).expect("bytes").parse::<f64>().expect("a number"))
            .sum();
        for (what, planned, found) in [
            (
                "fields",
                number(&files["instants"]) * number(&files["instant"]),
                bytes(&out.join("fields"), &[".vtr", ".vtp"]) as f64,
            ),
            (
                "checkpoint",
                number(&files["checkpoint"]),
                bytes(&out.join("checkpoint"), &["checkpoint"]) as f64,
            ),
            ("log", number(&plan["log"]), logged),
        ] {
            let error = planned / found - 1.0;
            println!("{name}: {what} {planned} planned, {found} found, {:+.1} %", 100.0 * error);
            if error.is_nan() || error.abs() > 0.1 {
                off.push(format!("{name}: {what} {planned} planned, {found} found"));
            }
        }
    }
    assert!(off.is_empty(), "{}", off.join("\n"));
}

/// Discs that lie on the floor, in a run that would be long and ends at once.
const RESTING: &str = r#"
until = 32000.0
gravity = [0.0, 0.0, -1.0]
stop_when = { kinetic_energy_per_grain_below = 1e-3 }
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [128.0, 4.0]
boundary = { x = "periodic", z = "no-slip" }
[[groups]]
count = 60
lower = [0.0, 0.0, 0.0]
upper = [128.0, 0.0, 1.001]
radius = 0.5
density = 2.0
seed = 1
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 0.02
"#;

#[test]
fn a_long_run_writes_fields_by_default_and_keeps_their_rhythm() {
    let folder = Folder::new("default-fields");
    let file = folder.write("resting.toml", RESTING);
    let planned = plan(&file, &[])["files"]["fields_every"].as_f64().expect("a time");
    assert!((640.0..6400.0).contains(&planned), "{planned}"); // at most 50 instants
    let later = plan(&file, &["--until", "48000"])["files"]["fields_every"].as_f64().expect("a time");
    assert!(later > 0.0 && later != planned, "{later}");
    let out = folder.join("out");
    let run = |more: &[&str]| {
        let run =
            bedload(&arguments("run", &file, &[&["--out", out.to_str().expect("UTF-8")], more].concat()));
        assert!(run.status.success(), "{}", said(&run));
        let text = std::fs::read_to_string(out.join("scene.toml")).expect("a scene");
        let scene: toml::Table = toml::from_str(&text).expect("TOML");
        scene["observe"]["fields_every"].as_float().expect("a time")
    };
    assert_eq!(run(&[]), planned);
    assert_eq!(run(&["--resume", "--until", "48000"]), planned, "goes on as it began");
    assert_eq!(run(&["--overwrite", "--set", "observe.fields_every=0.0"]), 0.0);
    assert_eq!(run(&["--overwrite", "--until", "1.0"]), 0.0, "a short run writes none");
}

#[test]
fn fields_change_no_bit_of_a_run() {
    let folder = Folder::new("fields-bits");
    let text = scene(1.0, PLANE).replace("fields_every = 0.2\n", "");
    let file = folder.write("plane.toml", &text);
    let series = |name: &str, more: &[&str]| {
        let out = folder.join(name);
        let run =
            bedload(&arguments("run", &file, &[&["--out", out.to_str().expect("UTF-8")], more].concat()));
        assert!(run.status.success(), "{}", said(&run));
        (
            bytes(&out.join("fields"), &[".vtr", ".vtp"]),
            std::fs::read(out.join("series.csv")).expect("series"),
        )
    };
    let (none, with) = (series("none", &[]), series("with", &["--fields-every", "0.05"]));
    assert!(none.0 == 0 && with.0 > 0);
    assert!(none.1 == with.1, "series.csv differs");
}
