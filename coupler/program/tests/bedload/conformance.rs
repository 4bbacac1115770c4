//! `bedload conformance` on solvers that keep the protocol, and on some that break it.

use std::collections::BTreeMap;
use std::process::Output;

/// `bedload` to its end.
fn bedload(arguments: &[&str]) -> Output {
    crate::fake_solvers::bedload(arguments).output().expect("bedload starts")
}

/// Tests this executable as a solver of `role` that misbehaves as told.
fn test(role: &str, misbehaviour: &str, more: &[&str]) -> Output {
    let script = crate::fake_solvers::script(role, misbehaviour);
    // A solver that does not know `check` is planned from its section, which must hold dt.
    let dt = if role == "dem" { "dem.dt=1e-3" } else { "fluid.dt=1e-2" };
    let mut arguments =
        vec!["conformance", "--role", role, "--set", dt, "--set", "coupling.deadline=2.0", "--json"];
    arguments.extend(more);
    arguments.extend(["--", "sh", "-c", &script, "sh"]);
    bedload(&arguments)
}

/// What was seen of every case that was not passed.
fn missed(output: &Output) -> BTreeMap<String, String> {
    let text = String::from_utf8_lossy(&output.stdout);
    let reports: serde_json::Value = serde_json::from_str(&text)
        .unwrap_or_else(|error| panic!("{error}: {text}\n{}", String::from_utf8_lossy(&output.stderr)));
    let cases = reports[0]["cases"].as_array().expect("cases");
    let word = |case: &serde_json::Value, key: &str| case[key].as_str().expect("a text").to_owned();
    assert!(!cases.is_empty(), "{text}");
    cases
        .iter()
        .filter(|case| case["outcome"] != "pass")
        .map(|case| (word(case, "name"), format!("{}: {}", word(case, "outcome"), word(case, "seen"))))
        .collect()
}

/// It has unit masses and keeps no state to go back to; all else it does as it should.
#[test]
fn a_dem_of_unit_masses_without_memory_is_told_so() {
    let output = test("dem", "", &[]);
    let missed = missed(&output);
    assert_eq!(output.status.code(), Some(1), "{missed:?}");
    let names: Vec<&str> = missed.keys().map(String::as_str).collect();
    assert_eq!(names, ["not-finite", "repeat", "units"], "{missed:?}");
    assert!(missed["units"].starts_with("fail: grain 0 has velocity[2]"), "{missed:?}");
    assert!(missed["repeat"].starts_with("lacks: "), "{missed:?}");
}

/// It drags grains towards rest and knows no buoyancy.
#[test]
fn a_fluid_without_buoyancy_is_told_so() {
    let output = test("fluid", "", &[]);
    let missed = missed(&output);
    assert_eq!(output.status.code(), Some(1), "{missed:?}");
    assert!(missed["units"].contains("buoyancy"), "{missed:?}");
    assert!(missed.values().all(|seen| seen.starts_with("lacks") || seen.contains("buoyancy")), "{missed:?}");
}

#[test]
fn wrong_substeps_are_found() {
    let missed = missed(&test("dem", "miscount:1", &[]));
    assert!(missed["windows"].contains("header of window 1 has substeps = 7, the command 8"), "{missed:?}");
    assert!(missed["ahead"].contains("substeps"), "{missed:?}");
}

#[test]
fn a_value_that_is_not_a_number_is_found() {
    let missed = missed(&test("dem", "nan:2", &[]));
    assert!(missed["windows"].contains("velocity[2] of grain 1 is NaN"), "{missed:?}");
}

#[test]
fn a_solver_that_dies_is_found_with_its_last_words() {
    let missed = missed(&test("dem", "die:1", &[]));
    assert!(missed["windows"].contains("signal: 6"), "{missed:?}");
    assert!(missed["windows"].contains("farewell"), "{missed:?}");
    // these end before its window comes
    assert!(!missed.contains_key("ready") && !missed.contains_key("other-layout"), "{missed:?}");
}

#[test]
fn what_is_no_solver_takes_no_role() {
    let sets = ["--set", "dem.dt=1e-3", "--set", "fluid.dt=1e-2"];
    let output = bedload(&[&["conformance"], &sets[..], &["--", "sh", "-c", "exit 7"]].concat());
    let text =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert_eq!(text.matches("passed over").count(), 2, "{text}");
    assert!(text.contains("takes neither role"), "{text}");
}

#[test]
fn a_missing_program_and_a_bad_scene_are_named() {
    let sets = ["--set", "dem.dt=1e-3", "--set", "fluid.dt=1e-2"];
    let output = bedload(&[&["conformance"], &sets[..], &["--", "/no/such/solver"]].concat());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("/no/such/solver"), "{text}");
    let output = bedload(&["conformance", "--scene", "/no/such/scene.toml", "--", "sh", "-c", "exit 7"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("/no/such/scene.toml"));
    let output = bedload(&["conformance", "--role", "fluid", "--physics", "--", "sh", "-c", "exit 7"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--role dem"));
    let output = bedload(&["conformance", "--"]);
    assert_eq!(output.status.code(), Some(2), "no command at all");
}
