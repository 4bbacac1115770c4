//! `bedload stability` on a sweep so small that it takes seconds: classes, table, map, page, exit codes.

use std::path::Path;

use study::stability::classify::Class;
use study::stability::counts::Counts;
use study::table::Table;
use tests::harness::{Folder, bedload, said};

/// A light and a heavy sphere with the paper's force and with the default: only the paper's fails, and
/// that for certain, for the light one.
const SWEEP: &str = r#"
title = "A sphere & a fluid"
until = 1.2
gravity = [0.0, 0.0, -0.05]

[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [2.0, 4.0]
cells = [16, 32]
boundary = { r_upper = "free-slip", z = "free-slip" }

[medium]
density = 1.0
viscosity = 0.12

[[grains]]
position = [0.0, 0.0, 2.0]
velocity = [0.0, 0.0, -0.05]
radius = 0.5
density = 4.0

[fluid.time]
dt = 0.02

[stability]
about = "Densities 0.3 and 4."
signal = "velocity_z[0]"
bound = "density-ratio"
x = "method"
y = "density_ratio"

[[stability.limits]]
column = "velocity_z[0]"
least = -0.5
most = 0.5

[[stability.vary]]
name = "method"
values = [
  { name = "paper", set = { "fluid.method" = "izard-2014" } },
  { name = "default", set = { "fluid.method" = "calibrated" } },
]

[[stability.vary]]
name = "density_ratio"
key = "grains[0].density"
values = [0.3, 4.0]
"#;

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn sweep(scene: &Path, out: &Path) -> std::process::Output {
    bedload(&["stability", path(scene), "--out", path(out), "--jobs", "2"])
}

#[test]
fn a_small_sweep_finds_what_fails_and_what_check_says_of_it() {
    let folder = Folder::new("stability");
    let (scene, out) = (folder.write("sweep.toml", SWEEP), folder.join("out"));
    let output = sweep(&scene, &out);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("4 runs: 3 stable and accepted, 1 failed"), "{}", said(&output));
    let table = Table::read(&out.join("stability.csv")).expect("a table");
    assert_eq!(table.keys, ["method", "grains[0].density"]);
    for row in &table.rows {
        let fails = row.values == ["paper", "0.3"];
        let expected = if fails { Class::Failed } else { Class::Stable };
        assert_eq!((row.class, row.refused), (Some(expected), fails), "{row:?}");
        assert_eq!(row.margin.is_some_and(|margin| margin < 1.0), fails, "{row:?}");
        assert_eq!(row.note.is_empty(), !fails, "{row:?}");
    }
    let counts = Counts::of(&table.rows);
    assert_eq!((counts.rightly_refused, counts.rightly_accepted), (1, 3));
    let map = std::fs::read_to_string(out.join("stability.svg")).expect("a map");
    assert_eq!(map.matches("<title>").count(), 4);
    assert!(map.contains("refused by check: density-ratio"), "what is refused is drawn");
    let page = std::fs::read_to_string(out.join("stability.html")).expect("a page");
    assert!(page.contains("A sphere &amp; a fluid") && page.contains("All 4 runs"));

    // Finished runs are not made again, failed ones neither, and the result is the same.
    let text = std::fs::read(out.join("stability.csv")).expect("a table");
    let again = sweep(&scene, &out);
    assert_eq!(again.status.code(), Some(0), "{}", said(&again));
    assert!(!said(&again).contains(": runs"), "{}", said(&again));
    assert_eq!(std::fs::read(out.join("stability.csv")).expect("a table"), text);

    // The page is made anew from the table alone.
    std::fs::remove_file(out.join("stability.html")).expect("it was there");
    std::fs::remove_dir_all(out.join("runs")).expect("they were there");
    let report = bedload(&["report", path(&out)]);
    assert_eq!(report.status.code(), Some(0), "{}", said(&report));
    assert_eq!(std::fs::read_to_string(out.join("stability.html")).expect("a page"), page);
}

#[test]
fn failures_that_check_accepts_end_with_exit_code_1() {
    let folder = Folder::new("stability-weak");
    // The heavy sphere does nothing wrong, but this limit calls its motion impossible, and no bound knows of
    // it.
    let text =
        SWEEP.replace("least = -0.5", "least = -1e-12").replace("values = [0.3, 4.0]", "values = [4.0]");
    let (scene, out) = (folder.write("weak.toml", &text), folder.join("out"));
    let output = sweep(&scene, &out);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("accepts 2 of 2 runs that failed"), "{}", said(&output));
    let table = Table::read(&out.join("stability.csv")).expect("a table");
    assert!(table.rows.iter().all(|row| row.note.contains("velocity_z[0] = ")), "{table:?}");
}

#[test]
fn what_a_solver_refuses_at_its_start_is_a_point_of_the_map() {
    let folder = Folder::new("stability-refused");
    // Of spheres, which that method does not have.
    let text = SWEEP.replace("izard-2014", "fictitious-domain").replace("[0.3, 4.0]", "[4.0]");
    let (scene, out) = (folder.write("refused.toml", &text), folder.join("out"));
    let output = sweep(&scene, &out);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let table = Table::read(&out.join("stability.csv")).expect("a table");
    let row = table.rows.iter().find(|row| row.values[0] == "paper").expect("the refused run");
    assert_eq!((row.class, row.refused, row.margin), (Some(Class::Failed), true, None), "{row:?}");
    assert!(row.note.contains("refuses the scene"), "{row:?}");
    assert!(table.rows.iter().any(|row| row.class == Some(Class::Stable)), "{table:?}");
    // Where every run is, the scene is at fault.
    let scene = folder.write("refused.toml", &text.replace("calibrated", "fictitious-domain"));
    let output = sweep(&scene, &out);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("every run is refused at its start"), "{}", said(&output));
}

#[test]
fn a_wrong_section_is_refused_with_file_line_and_key() {
    let folder = Folder::new("stability-bad");
    let changes = [
        ("signal = \"velocity_z[0]\"", "signal = \"velocity_z[7]\"", "stability.signal"),
        ("signal = \"velocity_z[0]\"", "", "stability.signal"),
        ("bound = \"density-ratio\"", "bound = \"speed\"", "stability.bound"),
        ("x = \"method\"", "x = \"viscosity\"", "stability.x"),
        ("y = \"density_ratio\"", "y = \"method\"", "stability.y"),
        ("y = \"density_ratio\"", "y = \"density_ratio\"\nscale = -1.0", "stability.scale"),
        ("y = \"density_ratio\"", "y = \"density_ratio\"\ncolour = 1", "stability.colour"),
        ("\"grains[0].density\"", "\"grains[0].weight\"", "stability.vary[1]"),
        ("least = -0.5", "least = 0.6", "stability.limits[0]"),
    ];
    for (good, bad, key) in changes {
        assert!(SWEEP.contains(good), "{good}");
        let scene = folder.write("bad.toml", &SWEEP.replacen(good, bad, 1));
        let output = sweep(&scene, &folder.join("out"));
        let words = said(&output);
        assert_eq!(output.status.code(), Some(2), "{bad}: {words}");
        assert!(words.contains("bad.toml") && words.contains(key), "{bad}: {words}");
    }
    let plain = SWEEP.split("[stability]").next().expect("a scene");
    let output = sweep(&folder.write("none.toml", plain), &folder.join("out"));
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("stability"), "{}", said(&output));
}
