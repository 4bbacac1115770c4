//! `--accuracy … --verify` serves a scene that no chart does, keeps its word, and says why where it does not.

use tests::harness::{Folder, bedload, metric, said, summary};

/// A heavy sphere in a tube that no chart has: ρ_p/ρ = 11, sides at 2 D, e_n = 0.6.
const HEAVY: &str = r#"
until = 0.03
gravity = [0.0, 0.0, -9.81]
[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [0.004, 0.016]
cells = [16, 64]
boundary = { r_upper = "no-slip", z = "no-slip" }
[medium]
density = 1000.0
viscosity = 0.05
[[grains]]
position = [0.0, 0.0, 0.012]
radius = 0.001
density = 11000.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.6
contact_time = 1e-4
"#;

const SPEED: &str = "[[metrics]]\nname = \"speed\"\nkind = \"final\"\ncolumn = \"velocity_z[0]\"\n";

#[test]
fn a_scene_without_a_chart_is_served_as_exactly_as_asked() {
    let folder = Folder::new("verify-served");
    let scene = folder.write("scene.toml", &format!("{HEAVY}{SPEED}"));
    let (scene, out) = (scene.to_str().expect("UTF-8"), folder.join("out"));
    let out_text = out.to_str().expect("UTF-8");
    let asked = ["run", scene, "--out", out_text, "--threads", "1", "--accuracy", "5%"];
    let output = bedload(&asked);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    let output = bedload(&[&asked[..], &["--verify"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let words = said(&output);
    // The price comes before the first run.
    let at = |part: &str| words.find(part).unwrap_or_else(|| panic!("{part}: {words}"));
    assert!(at("grid 2: D/Δx") < at("grid 1 of at most"), "{words}");
    let left = summary(&out);
    let (verification, count) = (&left["verification"], left["verification"]["grids"].as_array());
    let count = count.expect("grids").len();
    assert!(count >= 2 && left["status"] == "completed", "{left}");
    let values = verification["metrics"]["speed"]["values"].as_array().expect("values");
    assert_eq!(values.len(), count);
    assert_eq!(values[count - 1].as_f64(), Some(metric(&out, "speed")), "the finest run is the result");
    assert!(out.join("series.csv").is_file() && out.join("report.html").is_file());
    assert!(out.join("verify-1/summary.json").is_file() && !out.join(format!("verify-{count}")).exists());
    // Against a run of 32 cells per diameter.
    let fine = folder.join("fine");
    let fine_text = fine.to_str().expect("UTF-8");
    let grid = "domain.cells=[64, 256]";
    let output = bedload(&["run", scene, "--out", fine_text, "--threads", "1", "--no-record", "--set", grid]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let error = (metric(&out, "speed") / metric(&fine, "speed") - 1.0).abs();
    let estimate = verification["error"].as_f64().expect("an estimate");
    println!("{count} grids, error {error:.4}, by estimate {estimate:.4}");
    assert!(error <= estimate && estimate <= 0.05, "{error} {estimate}");
    // It goes on with what was printed, though no chart serves it.
    let printed = words.split("to go on:").nth(1).expect("what to set");
    let set = printed.split('\'').skip(1).step_by(2).flat_map(|set| ["--set", set]);
    let on = ["run", scene, "--out", out_text, "--threads", "1", "--resume", "--until", "0.031"];
    let output = bedload(&on.into_iter().chain(set).collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("the run goes on with what is set"), "{}", said(&output));
    let reached = summary(&out)["time"]["simulated"].as_f64().expect("a time");
    assert!((reached - 0.031).abs() < 1e-9, "{reached}");
}

#[test]
fn what_cannot_be_measured_is_refused_in_words() {
    let folder = Folder::new("verify-refused");
    let still = HEAVY.split("[[grains]]").next().expect("a head").to_owned();
    let dry = "until = 1.0\n\
               grains = [{ position = [0.5, 0.5, 0.5], radius = 0.1, density = 2.0 }]\n[domain]\n\
               geometry = \"space\"\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n\
               boundary = { x = \"no-slip\", y = \"no-slip\", z = \"no-slip\" }\n";
    let cases: [(&str, &[&str], i32, &str); 5] = [
        (HEAVY, &[], 2, "add --accuracy 5%"),
        (HEAVY, &["--accuracy", "5%", "--resume"], 2, "begins anew"),
        (HEAVY, &["--accuracy", "a lot"], 2, "0.01 % to 50 %"),
        (&still, &["--accuracy", "5%"], 2, "nothing to compare"),
        (dry, &["--accuracy", "5%"], 2, "the scene has none"),
    ];
    for (text, more, code, words) in cases {
        let scene = folder.write("scene.toml", text);
        let out = folder.join("out");
        let first =
            ["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8"), "--verify"];
        let output = bedload(&[&first[..], more].concat());
        let said = said(&output).replace(['\n', '│'], " ");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(code), "{words}: {said}");
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn a_scene_that_no_grid_makes_exact_enough_is_told_by_how_much() {
    let folder = Folder::new("verify-short");
    // ν dt/Δx² of direct forcing is at its bound from D/Δx = 20 on, where steps are as long as this.
    let forced = "[fluid]\nmethod = \"izard-2014\"\ntime = { dt = 1e-3 }\n";
    let scene = folder.write("scene.toml", &format!("{HEAVY}{SPEED}{forced}"));
    let (scene, out) = (scene.to_str().expect("UTF-8"), folder.join("out"));
    let out_text = out.to_str().expect("UTF-8");
    let arguments = ["run", scene, "--out", out_text, "--threads", "1", "--verify", "--accuracy", "0.1%"];
    let output = bedload(&arguments);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("not as exact as asked: speed is within"), "{}", said(&output));
    let left = summary(&out);
    assert_eq!(left["status"], "failed");
    assert!(left["verification"]["error"].as_f64().expect("an estimate") > 1e-4, "{left}");
}
