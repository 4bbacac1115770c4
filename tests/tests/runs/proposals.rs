//! Cheaper models that `bedload check` proposes: each is run beside the scene that it stands for, and keeps
//! what it says.

use std::path::{Path, PathBuf};

use tests::harness::{Folder, bedload, is_stale, metric, said, summary};

/// A sphere that settles from rest along z in a box of sides `sides`; D = ρ = 1.
fn settling(geometry: &str, density: f64, viscosity: f64, gravity: f64, until: f64, sides: &str) -> String {
    let (lower, upper, cells, x) = match geometry {
        "space" => ("[0.0, 0.0, 0.0]", "[4.0, 4.0, 6.0]", "[24, 24, 36]", 2.0),
        _ => ("[0.0, 0.0]", "[2.5, 6.0]", "[20, 48]", 0.0),
    };
    let boundary = match geometry {
        "space" => format!("x = {sides:?}, y = {sides:?}"),
        _ => format!("r_upper = {sides:?}"),
    };
    format!(
        r#"
until = {until:?}
gravity = [0.0, 0.0, {gravity:?}]
[domain]
geometry = "{geometry}"
lower = {lower}
upper = {upper}
cells = {cells}
boundary = {{ {boundary}, z = "no-slip" }}
[medium]
density = 1.0
viscosity = {viscosity:?}
[[grains]]
position = [{x:?}, {x:?}, 4.0]
radius = 0.5
density = {density:?}
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.02
[[metrics]]
name = "speed"
kind = "final"
column = "velocity_z[0]"
"#
    )
}

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// The scene of the proposal `name`, written beside the scene, and the error that it expects.
fn proposal(folder: &Folder, scene: &Path, name: &str) -> (PathBuf, f64) {
    let output = bedload(&["check", path(scene)]);
    let words = said(&output);
    let mark = format!("cheaper: {name}: ");
    let line = words.lines().find(|line| line.trim_start().starts_with(&mark));
    let line = line.unwrap_or_else(|| panic!("{name} is not proposed in\n{words}"));
    let error = match line.split_once(", error ") {
        Some((_, rest)) => {
            rest.split(' ').next().and_then(|n| n.parse::<f64>().ok()).expect("a number") / 100.0
        }
        None => 0.0,
    };
    let output = bedload(&["check", path(scene), "--cheaper", name]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    (folder.write("cheaper.toml", &text), error)
}

/// Runs a scene; its output folder.
fn run(folder: &Folder, scene: &Path, out: &str) -> PathBuf {
    let out = folder.join(out);
    let output = bedload(&["run", path(scene), "--out", path(&out), "--no-record", "--threads", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    out
}

/// Runs both and returns the relative difference of a metric, the error expected of it and the ratio of the
/// solvers' CPU times.
fn both(name: &str, scene: &str, proposed: &str, measured: &str) -> (f64, f64, f64) {
    let folder = Folder::new(name);
    let scene = folder.write("scene.toml", scene);
    let (cheaper, expected) = proposal(&folder, &scene, proposed);
    let (whole, less) = (run(&folder, &scene, "whole"), run(&folder, &cheaper, "less"));
    let (a, b) = (metric(&whole, measured), metric(&less, measured));
    let cost = |folder: &Path| {
        let cost = &summary(folder)["cost"];
        ["fluid_cpu_s", "dem_cpu_s"].iter().filter_map(|part| cost[*part].as_f64()).sum::<f64>()
    };
    let ratio = cost(&whole) / cost(&less);
    println!(
        "{proposed}: {a} and {b}, {:.3} %, expected {:.3} %, {ratio:.1} times cheaper",
        100.0 * (b / a - 1.0),
        100.0 * expected
    );
    ((b / a - 1.0).abs(), expected, ratio)
}

#[test]
fn a_sphere_on_the_axis_of_a_duct_is_axisymmetric() {
    // Eight cells per diameter: at six the masks differ by more than is proposed.
    let scene = settling("space", 2.0, 1.0, -1.0, 2.0, "no-slip").replace("[24, 24, 36]", "[32, 32, 48]");
    let (error, expected, _) = both("axis", &scene, "axisymmetric", "speed");
    // The two grids cut the sphere differently: up to 1 % (docs/numerics.md, Mask).
    assert!(error < expected + 0.01, "{error} where {expected} was expected");
}

#[test]
fn a_heavy_sphere_falls_and_bounces_as_if_dry() {
    let scene = settling("axisymmetric", 8000.0, 1e-3, -1.0, 3.0, "free-slip");
    let (error, expected, _) = both("dry", &scene, "dry", "speed");
    assert!(expected > 1e-4 && error < expected, "{error} where {expected} was expected");
}

#[test]
fn a_channel_without_grains_is_plane() {
    let scene = r#"
until = 0.5
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [1.0, 0.5, 1.0]
cells = [16, 8, 16]
boundary = { x = "periodic", y = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.1
body_force = [0.8, 0.0, 0.0]
[fluid.time]
dt = 0.005
viscosity = "implicit"
"#;
    // A fluid alone reports this along periodic axes.
    let (error, _, ratio) = both("plane", scene, "plane", "superficial_velocity_x");
    assert!(error < 1e-9, "{error}");
    assert!(ratio > 0.0);
}

#[test]
fn a_grid_finer_than_two_per_cent_ask_for_is_coarsened() {
    // Ar = 500, D/Δx = 48.
    let scene =
        settling("axisymmetric", 4.0, 0.0775, -1.0, 1.8, "free-slip").replace("[20, 48]", "[120, 288]");
    if is_stale("docs/charts/settling-axis.csv") {
        let folder = Folder::new("coarser-stale");
        let words = said(&bedload(&["check", path(&folder.write("scene.toml", &scene))]));
        assert!(!words.contains("cheaper: coarser"), "nothing rests on a stale chart: {words}");
        return;
    }
    let (error, expected, ratio) = both("coarser", &scene, "coarser", "speed");
    assert!(expected == 0.02 && error < expected, "{error} where {expected} was expected");
    assert!(ratio > 1.0, "{ratio}");
}

#[test]
fn sub_steps_that_nothing_needs_change_nothing() {
    let scene = settling("axisymmetric", 4.0, 0.2, -1.0, 1.0, "free-slip")
        + "\n[fluid.time]\ndt = 0.02\n[coupling]\nsubsteps = \"full\"\n";
    let (error, _, _) = both("substeps", &scene, "one-sub-step", "speed");
    // The place at which the fluid feels the grain differs by half a window's acceleration times dt².
    assert!(error < 1e-3, "{error}");
}

#[test]
fn what_would_be_wrong_is_not_proposed() {
    let folder = Folder::new("no-proposal");
    // A sphere off the axis, at Re ≈ 50, nearly neutral.
    let scene =
        settling("space", 1.5, 0.01, -1.0, 2.0, "no-slip").replace("[2.0, 2.0, 4.0]", "[1.5, 2.0, 4.0]");
    let scene = folder.write("scene.toml", &scene);
    let words = said(&bedload(&["check", path(&scene)]));
    assert!(!words.contains("cheaper:"), "{words}");
    let output = bedload(&["check", path(&scene), "--cheaper", "dry"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("there are: none"), "{}", said(&output));
}
