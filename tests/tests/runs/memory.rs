//! What `check` says of memory and of slow lengths, against what a run takes and does.

use tests::harness::{Folder, bedload, said, summary};

/// Fluid in space with a fixed sphere that fills it: what a force is kept for counts only where there is one.
fn scene(cells: &str, viscosity: &str) -> String {
    format!(
        r#"
until = 2e-6

[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [1.0, 1.0, 1.0]
cells = {cells}
boundary = {{ x = "periodic", y = "periodic", z = "no-slip" }}

[medium]
density = 1.0
viscosity = 1.0

[[grains]]
position = [0.5, 0.5, 0.5]
radius = 0.48
density = 1.0
motion = "fixed"

[fluid.time]
viscosity = "{viscosity}"
dt = 1e-6
"#
    )
}

#[test]
fn the_estimate_of_memory_is_what_a_run_takes() {
    let folder = Folder::new("memory");
    for viscosity in ["explicit", "implicit"] {
        let scene = folder.write("scene.toml", &scene("[96, 96, 96]", viscosity));
        let (scene, out) = (scene.to_str().expect("UTF-8"), folder.join(viscosity));
        let output = bedload(&["check", scene, "--json"]);
        let plan: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let estimate = plan["memory"].as_f64().expect("a number");
        let output = bedload(&["run", scene, "--out", out.to_str().expect("UTF-8")]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        let taken = summary(&out)["cost"]["peak_rss_bytes"]["fluid"].as_f64().expect("a number");
        println!("{viscosity}: estimate {estimate:.4e}, taken {taken:.4e}");
        assert!((estimate / taken - 1.0).abs() < 0.15, "{viscosity}: {estimate:e} for {taken:e} bytes");
    }
}

#[test]
fn a_slow_length_is_said_once_and_runs() {
    let folder = Folder::new("slow-length");
    // z has walls: it is swept, not transformed, and any length is as good.
    let scene = folder.write("scene.toml", &scene("[23, 24, 29]", "explicit"));
    let (scene, out) = (scene.to_str().expect("UTF-8"), folder.join("out"));
    let output = bedload(&["run", scene, "--out", out.to_str().expect("UTF-8")]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert_eq!(text.matches("slow transforms").count(), 1, "{text}");
    assert!(text.contains("axis x has 23 cells") && text.contains("20 or 24 would be fast"), "{text}");
}
