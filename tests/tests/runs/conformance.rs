//! Our own solvers keep the protocol that others are tested against.

use tests::harness::{Folder, SMALL_BOUNCE, bedload, metric, program, said, summary};

/// Every case of one of our solvers in the role that it takes by itself; the other one is passed over.
fn keeps_it(name: &str, role: usize, more: &[&str]) {
    let solver = program(name);
    let arguments = [&["conformance", "--json"], more, &["--", solver.to_str().expect("UTF-8")]].concat();
    let output = bedload(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let reports: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let cases = reports[role]["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 14, "{reports:#}");
    for case in cases {
        assert_eq!(case["outcome"], "pass", "{case:#}");
    }
    assert!(reports[1 - role]["passed_over"].is_string(), "{reports:#}");
}

#[test]
fn the_fluid_keeps_the_protocol() {
    keeps_it("bedload-fluid", 0, &[]);
}

#[test]
fn the_dem_keeps_the_protocol() {
    keeps_it("bedload-dem", 1, &[]);
}

/// Each case of `--physics`, and whether it passed.
fn physics(solver: &str, more: &[&str]) -> Vec<(String, bool)> {
    let solver = program(solver);
    let fixed = ["conformance", "--json", "--physics", "--role", "dem"];
    let output = bedload(&[&fixed, more, &["--", solver.to_str().expect("UTF-8")]].concat());
    let reports: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let cases = reports[0]["cases"].as_array().expect("cases");
    let read = |case: &serde_json::Value| {
        (case["name"].as_str().expect("a name").to_owned(), case["outcome"] == "pass")
    };
    cases[14..].iter().map(read).collect()
}

#[test]
fn the_physics_part_passes_our_dem_and_catches_what_the_minimal_one_lacks() {
    let of = |fails: &[&str]| {
        ["fall", "bounce", "rest", "collision", "spin"]
            .map(|name| (name.to_owned(), !fails.contains(&name)))
            .to_vec()
    };
    assert_eq!(physics("bedload-dem", &[]), of(&[]));
    // It has neither contacts between grains nor spins.
    assert_eq!(physics(MINIMAL, &["--set", "dem.dt=1e-3"]), of(&["collision", "spin"]));
}

/// `protocol/examples/minimal_dem.rs`, which knows the contract and nothing else.
const MINIMAL: &str = "examples/minimal_dem";

#[test]
fn the_minimal_dem_keeps_the_protocol() {
    keeps_it(MINIMAL, 1, &["--set", "dem.dt=1e-3"]);
}

/// Without lubrication the two DEMs solve the same equations with different sub-steps at the touch.
#[test]
fn the_minimal_dem_carries_the_bouncing_sphere() {
    let folder = Folder::new("minimal-dem");
    let scene = folder.write("bounce.toml", SMALL_BOUNCE);
    let solver = program(MINIMAL);
    let command = format!("dem.command=[{:?}]", solver.to_str().expect("UTF-8"));
    let height = |name: &str, more: &[&str]| {
        let out = folder.join(name);
        let paths = [scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
        let output = bedload(&[&["run", "--no-record"], &paths[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert_eq!(summary(&out)["status"], "completed");
        metric(&out, "rebound_height_over_diameter")
    };
    let ours = height("ours", &["--set", "dem.lubrication.form=none"]);
    let theirs = height("theirs", &["--set", &command, "--set", "dem.dt=2e-5"]);
    assert!(ours > 0.1 && (theirs / ours - 1.0).abs() < 0.02, "rebound {theirs}, bedload-dem {ours}");
}
