//! Coupling schemes with the real programs: repeated windows record, resume and replay bit for bit, and light
//! grains run where the semi-implicit order fails.

use std::path::{Path, PathBuf};

use protocol::log::LogReader;
use tests::harness::{Folder, SMALL_BOUNCE, bedload, metric, said, signal, start, summary, wait_until};

const ITERATED: &str = "coupling.scheme=\"iterated\"";
/// Repeats touches and what follows them.
const SELECTIVE: [&str; 2] = [ITERATED, "coupling.iterations.repeat_above=1e-3"];

/// The schemes that are not the plain one.
const OTHERS: [(&str, &[&str]); 2] = [("iterated", &[ITERATED]), ("selective", &SELECTIVE)];

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Runs the scene into `out` with keys and further arguments; what was said.
fn run(scene: &Path, out: &Path, keys: &[&str], more: &[&str]) -> String {
    let mut arguments = vec!["run", path(scene), "--out", path(out)];
    keys.iter().for_each(|key| arguments.extend(["--set", key]));
    arguments.extend(more);
    let output = bedload(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    said(&output)
}

/// The small bounce, shorter: it lands at t = 1.2 or so.
fn bounce(folder: &Folder) -> PathBuf {
    folder.write("bounce.toml", &SMALL_BOUNCE.replace("until = 3.0", "until = 1.6"))
}

/// Step and attempt of every window of a log, and whether it was accepted.
fn windows(log: &Path) -> Vec<(u64, u64, bool)> {
    let reader = LogReader::open(log).expect("a log");
    let windows = reader.windows().map(|window| window.expect("a whole window"));
    windows.map(|window| (window.command.step, window.command.attempt, window.accepted)).collect()
}

#[test]
fn attempts_count_up_and_the_last_is_accepted() {
    let folder = Folder::new("attempts");
    let (scene, out) = (bounce(&folder), folder.join("out"));
    run(&scene, &out, &[ITERATED], &[]);
    let windows = windows(&out.join("exchange.mcap"));
    for pair in windows.windows(2) {
        let ((step, attempt, accepted), next) = (pair[0], pair[1]);
        let expected = if accepted { (step + 1, 0) } else { (step, attempt + 1) };
        assert_eq!((next.0, next.1), expected);
    }
    let accepted = windows.iter().filter(|window| window.2).count();
    assert_eq!(accepted, 160);
    assert!(windows.len() >= 2 * accepted, "a change takes two attempts to see");
    let mean = windows.len() as f64 / accepted as f64;
    assert!((metric(&out, "attempts_per_window") - mean).abs() < 1e-12);
    assert_eq!(metric(&out, "unconverged_windows"), 0.0);
    let resolved = text(&out.join("scene.toml"));
    assert!(resolved.contains("scheme = \"iterated\""), "{resolved}");
}

#[test]
fn iterated_runs_replay_bit_for_bit() {
    for (name, keys) in OTHERS {
        let folder = Folder::new(&format!("replay-{name}"));
        let (scene, out) = (bounce(&folder), folder.join("out"));
        run(&scene, &out, keys, &[]);
        for side in ["dem", "fluid"] {
            let log = out.join("exchange.mcap");
            let output = bedload(&["replay", path(&log), "--drive", side, "--verify"]);
            assert_eq!(output.status.code(), Some(0), "{name} {side}: {}", said(&output));
        }
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let folder = Folder::new("scheme-threads");
    let scene = bounce(&folder);
    for (name, keys) in OTHERS {
        let series: Vec<String> = ["1", "2"]
            .into_iter()
            .map(|threads| {
                let out = folder.join(&format!("{name}-{threads}"));
                run(&scene, &out, keys, &["--threads", threads, "--no-record"]);
                text(&out.join("series.csv"))
            })
            .collect();
        assert!(series[0].lines().count() > 100);
        assert_eq!(series[0], series[1], "{name}");
    }
}

#[test]
fn the_same_bits_after_an_interrupt_and_resume() {
    for (name, keys) in OTHERS {
        let folder = Folder::new(&format!("scheme-resume-{name}"));
        let scene = bounce(&folder);
        let (whole, parts) = (folder.join("whole"), folder.join("parts"));
        // So many windows that the interrupt comes before the last, also where the machine is busy.
        let keys = [keys, &["fluid.time.dt=0.001"]].concat();
        run(&scene, &whole, &keys, &[]);
        let mut arguments = vec!["run", path(&scene), "--out", path(&parts)];
        keys.iter().for_each(|key| arguments.extend(["--set", key]));
        let child = start(&arguments);
        let begun = || std::fs::metadata(parts.join("exchange.mcap")).is_ok_and(|data| data.len() > 20_000);
        wait_until(30.0, begun).expect("the run begins");
        signal(child.id(), "INT");
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(130), "{}", said(&output));
        let reached = summary(&parts)["time"]["simulated"].as_f64().expect("a number");
        assert!(reached > 0.0 && reached < 1.6, "interrupted at t = {reached}");
        run(&scene, &parts, &keys, &["--resume"]);
        assert_eq!(text(&parts.join("series.csv")), text(&whole.join("series.csv")), "{name}");
        assert_eq!(summary(&parts)["metrics"], summary(&whole)["metrics"], "{name}");
    }
}

/// A disc in a flow whose mean is held, so that what drives the fluid changes from window to window.
const HELD: &str = r#"
until = 0.5
gravity = [0.3, 0.0, -1.0]
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [4.0, 3.0]
cells = [32, 24]
boundary = { x = "periodic", z = "no-slip" }
[medium]
density = 1.3
viscosity = 0.1
flow_rate = { axis = "x", mean_velocity = 0.3 }
[[grains]]
position = [2.0, 0.0, 1.5]
radius = 0.5
density = 3.0
[fluid.time]
dt = 0.0078125
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.7
contact_time = 0.02
"#;

#[test]
fn the_same_bits_where_the_drive_changes_between_two_parts() {
    for (name, keys) in OTHERS {
        let folder = Folder::new(&format!("scheme-held-{name}"));
        let scene = folder.write("held.toml", HELD);
        let (whole, parts) = (folder.join("whole"), folder.join("parts"));
        run(&scene, &whole, keys, &["--no-record"]);
        run(&scene, &parts, keys, &["--no-record", "--until", "0.25"]);
        run(&scene, &parts, keys, &["--no-record", "--resume"]);
        assert_eq!(text(&parts.join("series.csv")), text(&whole.join("series.csv")), "{name}");
    }
}

/// First apex over D, mean over where in its window the sphere touches: windows of five contact times move it
/// by 6 % from where windows of half a contact time have it, and by less than half of that where touches are
/// repeated.
#[test]
fn repeated_touches_bring_the_bounce_nearer_to_that_of_short_windows() {
    let folder = Folder::new("scheme-touches");
    let scene = folder.write("bounce.toml", &SMALL_BOUNCE.replace("until = 3.0", "until = 2.4"));
    let apex = |name: &str, keys: &[&str]| {
        let heights = [0.0, 0.003, 0.006, 0.009, 0.012].map(|higher| {
            let out = folder.join(&format!("{name}-{higher}"));
            let place = format!("grains[0].position=[0.0, 0.0, {}]", 1.6 + higher);
            run(&scene, &out, &[keys, &[place.as_str()]].concat(), &["--no-record"]);
            metric(&out, "rebound_height_over_diameter")
        });
        heights.iter().sum::<f64>() / heights.len() as f64
    };
    let short = apex("short", &["fluid.time.dt=0.001"]);
    let [plain, selective] =
        [apex("plain", &[]), apex("selective", &SELECTIVE)].map(|apex| apex / short - 1.0);
    println!("short windows {short:.4} D, long ones {plain:+.3}, with touches repeated {selective:+.3}");
    assert!(plain > 0.03 && selective.abs() < 0.5 * plain, "{plain} and {selective} of {short} D");
    let attempts = metric(&folder.join("selective-0"), "attempts_per_window");
    assert!((1.0..2.0).contains(&attempts), "{attempts}: some stand at once, some are repeated");
}

#[test]
fn windows_that_do_not_converge_are_counted_and_told_once() {
    let folder = Folder::new("unconverged");
    let (scene, out) = (bounce(&folder), folder.join("out"));
    let keys = [
        ITERATED,
        "coupling.iterations.tolerance=1e-15",
        "coupling.iterations.max_iterations=3",
        "until=0.5",
    ];
    let words = run(&scene, &out, &keys, &["--no-record"]);
    assert_eq!(words.matches("did not converge").count(), 1, "{words}");
    assert!(words.contains("window 0 ") && words.contains("3 attempts"), "{words}");
    assert_eq!(metric(&out, "unconverged_windows"), 50.0);
    assert_eq!(metric(&out, "attempts_per_window"), 3.0);
}

/// A sphere in a small box of viscous fluid, D = g = ρ = ν = 1, from rest; it reaches its speed in one
/// window.
fn release(density: f64, dt: f64) -> String {
    format!(
        r#"
until = 40.0
gravity = [0.0, 0.0, -1.0]

[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [2.0, 8.0]
cells = [16, 64]
boundary = {{ r_upper = "free-slip", z = "no-slip" }}

[medium]
density = 1.0
viscosity = 1.0

[[grains]]
position = [0.0, 0.0, 2.0]
radius = 0.5
density = {density:?}

[fluid.time]
dt = {dt:?}

[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.1
friction = 0.25

[[metrics]]
name = "fastest"
kind = "max"
column = "velocity_z[0]"
"#
    )
}

#[test]
fn a_bubble_of_a_grain_runs_because_windows_are_repeated_where_the_bound_asks_for_it() {
    let folder = Folder::new("bubble");
    let scene = folder.write("bubble.toml", &release(0.01, 0.8));
    let out = folder.join("out");
    // The first window, from rest, takes more than the usual 20 attempts.
    let words = run(&scene, &out, &["coupling.iterations.max_iterations=40"], &["--no-record"]);
    assert!(words.contains("scheme: iterated") && words.contains("0.01"), "{words}");
    assert_eq!(metric(&out, "unconverged_windows"), 0.0);
    // Stokes' speed in a wide fluid is (1 − ρ_r) g D²/18 ν; the box holds it back.
    let stokes = 0.99 / 18.0;
    let fastest = metric(&out, "fastest");
    assert!((0.2 * stokes..stokes).contains(&fastest), "{fastest} against {stokes}");
    // The same window lengths without repeating are refused by name.
    let plain = "coupling.scheme=\"semi-implicit\"";
    let output = bedload(&["run", path(&scene), "--out", path(&out), "--set", plain]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("density-ratio") && said(&output).contains("iterated"),
        "{}",
        said(&output)
    );
    // A heavy one pays nothing.
    let heavy = folder.write("heavy.toml", &release(2.0, 0.8).replace("2.0]\nradius", "6.0]\nradius"));
    let words = run(&heavy, &folder.join("heavy"), &["until=8"], &["--no-record"]);
    assert!(!words.contains("iterated"), "{words}");
    assert!(summary(&folder.join("heavy"))["metrics"].get("attempts_per_window").is_none());
}
