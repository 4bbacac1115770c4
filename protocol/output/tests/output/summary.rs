//! `summary.json` against the key list that scripts rely on.

use bedload_output::{MetricValue, Summary, Tally};
use protocol::memory::peak_rss_bytes;
use serde_json::Value;

use crate::stage::{fresh, sphere, window};

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

fn sample() -> Summary {
    let mut summary = Summary::new(&sphere(""), "1.2.3");
    let mut tally = Tally::default();
    for (step, substeps) in [5, 2, 8].into_iter().enumerate() {
        tally.record(&window(step as u64, 0.5), substeps);
    }
    summary.time = tally.time(true, 0.02);
    summary.cost.fluid_cpu_s = 4.8;
    summary.cost.dem_cpu_s = 3.0;
    summary.set_unit_costs(1);
    summary.metrics.insert("a".into(), MetricValue::measured(1.5, "m/s", Some(-1.0), Some("exact".into())));
    summary.metrics.insert("b".into(), MetricValue::missing("there was no contact", "-", None, None));
    summary
}

#[test]
fn keys_are_those_of_the_interface() {
    let path = fresh("keys").join("summary.json");
    sample().write(&path).expect("writes");
    let json: Value = serde_json::from_str(&std::fs::read_to_string(&path).expect("text")).expect("JSON");
    assert_eq!(
        keys(&json),
        ["cost", "error", "metrics", "scene_sha256", "size", "status", "time", "version"]
    );
    assert_eq!(
        keys(&json["time"]),
        [
            "contact_time",
            "dem_substeps",
            "dt_dem",
            "dt_fluid",
            "fluid_steps",
            "simulated",
            "substeps_per_window"
        ]
    );
    assert_eq!(keys(&json["time"]["substeps_per_window"]), ["max", "mean", "min"]);
    assert_eq!(keys(&json["size"]), ["cells", "geometry", "grains"]);
    assert_eq!(
        keys(&json["cost"]),
        [
            "coupler_cpu_s",
            "dem_cpu_s",
            "exchange_s",
            "fluid_cpu_s",
            "ns_per_cell_step",
            "ns_per_grain_substep",
            "peak_rss_bytes",
            "record_s",
            "wall_s"
        ]
    );
    assert_eq!(keys(&json["cost"]["peak_rss_bytes"]), ["coupler", "dem", "fluid"]);
    assert_eq!(keys(&json["metrics"]["a"]), ["reference", "relative_error", "source", "unit", "value"]);
    assert_eq!(json["status"], "completed");
    assert_eq!(json["error"], Value::Null);
    assert_eq!(json["size"]["geometry"], "axisymmetric");
    assert_eq!(json["metrics"]["b"]["value"], Value::Null);
    assert_eq!(json["scene_sha256"].as_str().map(str::len), Some(64));
}

#[test]
fn values_are_worked_out_as_documented() {
    let summary = sample();
    assert_eq!(summary.time.simulated, 1.5);
    assert_eq!((summary.time.fluid_steps, summary.time.dem_substeps), (3, 15));
    assert_eq!((summary.time.dt_fluid, summary.time.dt_dem), (Some(0.5), Some(0.5 / 8.0)));
    assert_eq!((summary.time.substeps_per_window.min, summary.time.substeps_per_window.max), (2, 8));
    assert_eq!(summary.time.substeps_per_window.mean, 5.0);
    // 4.8 s over 1600 cells and 3 steps; 3 s over 1 grain and 15 sub-steps.
    assert_eq!(summary.cost.ns_per_cell_step, Some(1e6));
    assert_eq!(summary.cost.ns_per_grain_substep, Some(2e8));
    assert_eq!(summary.metrics["a"].relative_error, Some(2.5));
    assert_eq!(MetricValue::measured(0.1, "-", Some(0.0), None).relative_error, None);
    assert_eq!(MetricValue::measured(f64::NAN, "-", Some(1.0), None).value, None);
}

#[test]
fn the_file_reads_back() {
    let path = fresh("read").join("summary.json");
    let mut summary = sample();
    summary.fail(&"fluid died during window 3");
    summary.time.contact_time = None;
    summary.write(&path).expect("writes");
    assert_eq!(Summary::read(&path).expect("reads"), summary);
    std::fs::write(&path, "{\"status\": \"completed\"}").expect("writes");
    assert!(Summary::read(&path).expect_err("cut").to_string().contains("not a summary"));
}

#[test]
fn this_process_has_a_peak_memory() {
    if cfg!(target_os = "linux") {
        assert!(peak_rss_bytes() > 100_000);
    }
}
