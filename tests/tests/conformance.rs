//! Our own solvers keep the protocol that others are tested against.

use tests::harness::{bedload, program, said};

/// Every case of one of our solvers in the role that it takes by itself; the other one is passed over.
fn keeps_it(name: &str, role: usize) {
    let solver = program(name);
    let output = bedload(&["conformance", "--json", "--", solver.to_str().expect("UTF-8")]);
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
    keeps_it("bedload-fluid", 0);
}

#[test]
fn the_dem_keeps_the_protocol() {
    keeps_it("bedload-dem", 1);
}
