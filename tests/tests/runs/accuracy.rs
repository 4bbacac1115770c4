//! `accuracy` keeps its word on cases that no chart was made of: the error against a fine run, or an exact
//! solution, is below what was asked for.

use std::path::Path;

use tests::harness::{Folder, bedload, is_stale, metric, said, summary};

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Runs a scene with more arguments; what it said.
fn run(scene: &Path, out: &Path, more: &[&str]) -> String {
    let mut arguments = vec!["run", path(scene), "--out", path(out), "--no-record", "--threads", "1"];
    arguments.extend(more);
    let output = bedload(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    said(&output)
}

/// A sphere of 2 mm in oil, ρ_p/ρ = 2.5, in SI units, in a box that is no multiple of D.
fn settling(viscosity: f64) -> String {
    format!(
        r#"
until = 0.14
gravity = [0.0, 0.0, -9.81]
[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [0.0163, 0.0489]
cells = [40, 120]
boundary = {{ r_upper = "free-slip", z = "free-slip" }}
[medium]
density = 1000.0
viscosity = {viscosity:?}
[[grains]]
position = [0.0, 0.0, 0.04]
radius = 0.001
density = 2500.0
[[metrics]]
name = "speed"
kind = "final"
column = "velocity_z[0]"
"#
    )
}

/// Is a chart stale, by docs/evidence.csv? Then a promise that rests on it is refused, with the command that
/// makes the chart again: there is nothing more to test of it.
fn refuses_stale(scene: &Path, accuracy: &str, chart: &str) -> bool {
    let stale = is_stale(chart);
    let output = bedload(&["check", path(scene), "--accuracy", accuracy]);
    let words = plain(&said(&output));
    assert_eq!(output.status.code(), Some(if stale { 2 } else { 0 }), "{}", said(&output));
    for part in [&format!("rests on {chart}, which is stale"), "bedload study scenes/"] {
        assert_eq!(words.contains(&plain(part)), stale, "{part}: {words}");
    }
    stale
}

/// What `accuracy` gives at 5 and 2 % against a run of 24 cells per diameter.
fn keeps_its_word(name: &str, viscosity: f64, chart: &str) {
    let folder = Folder::new(name);
    let scene = folder.write("scene.toml", &settling(viscosity));
    if refuses_stale(&scene, "5%", chart) {
        return;
    }
    let fine = ["--set", "domain.cells=[200, 600]", "--set", "fluid.time.dt=2e-4"];
    run(&scene, &folder.join("fine"), &fine);
    let exact = metric(&folder.join("fine"), "speed");
    let mut cells = Vec::new();
    for (text, target) in [("5%", 0.05), ("2%", 0.02)] {
        let out = folder.join(text);
        let words = run(&scene, &out, &["--accuracy", text]);
        assert!(words.contains(chart), "{words}");
        let error = metric(&out, "speed") / exact - 1.0;
        println!("{text}: {:+.2} % with {} cells", 100.0 * error, summary(&out)["size"]["cells"]);
        assert!(error.abs() < target, "{text}: {error}\n{words}");
        cells.push(summary(&out)["size"]["cells"].as_u64().expect("a number"));
    }
    assert!(cells[0] < cells[1], "{cells:?}");
}

#[test]
fn a_sphere_of_other_size_and_weight_settles_as_exactly_as_asked() {
    keeps_its_word("accuracy-settling", 0.01534, "docs/charts/settling-axis.csv"); // Ar = 500
}

#[test]
fn a_slow_sphere_settles_as_exactly_as_asked() {
    keeps_its_word("accuracy-slow", 0.0343, "docs/charts/settling-axis.csv"); // Ar = 100
}

#[test]
fn a_denser_array_has_the_drag_of_zick_and_homsy() {
    // K = 4.292 (Zick & Homsy 1982, table 2); Re = 0.14.
    let folder = Folder::new("accuracy-array");
    let radius = (0.125 * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    let force = 6.0 * std::f64::consts::PI * radius;
    let scene = folder.write(
        "scene.toml",
        &format!(
            r#"
until = 1.0
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [1.0, 1.0, 1.0]
cells = [10, 10, 10]
boundary = {{ x = "periodic", y = "periodic", z = "periodic" }}
[medium]
density = 1.0
viscosity = 1.0
body_force = [0.0, 0.0, {force:?}]
[[grains]]
position = [0.5, 0.5, 0.5]
radius = {radius:?}
density = 1.0
motion = "fixed"
"#
        ),
    );
    let out = folder.join("out");
    let words = run(&scene, &out, &["--accuracy", "5%"]);
    let error = metric(&out, "superficial_velocity_z") * 4.292 - 1.0;
    println!("K: {:+.2} %\n{words}", 100.0 * error);
    assert!(error.abs() < 0.05, "{error}");
}

/// A sphere that falls on a wall, St about 100.
const BOUNCE: &str = r#"
until = 0.26
gravity = [0.0, 0.0, -9.81]
[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [0.021, 0.04]
cells = [36, 64]
boundary = { r_upper = "free-slip", z_lower = "no-slip", z_upper = "free-slip" }
[medium]
density = 1000.0
viscosity = 0.018
[[grains]]
position = [0.0, 0.0, 0.0275]
radius = 0.0025
density = 7000.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.97
contact_time = 9e-5
friction = 0.25
[[metrics]]
name = "restitution"
kind = "restitution-at-gap"
gap = 0.1
[[metrics]]
name = "height"
kind = "rebound-height"
"#;

#[test]
fn a_bounce_is_as_exact_as_asked() {
    let folder = Folder::new("accuracy-bounce");
    let scene = folder.write("scene.toml", BOUNCE);
    if refuses_stale(&scene, "30%", "docs/charts/bounce.csv") {
        return;
    }
    run(&scene, &folder.join("fine"), &["--set", "domain.cells=[135, 256]"]);
    let out = folder.join("out");
    let words = run(&scene, &out, &["--accuracy", "30%"]);
    assert!(words.contains("docs/charts/bounce.csv"), "{words}");
    for name in ["restitution", "height"] {
        let (value, exact) = (metric(&out, name), metric(&folder.join("fine"), name));
        println!("{name}: {value:.4} for {exact:.4}\n{words}");
        assert!((value / exact - 1.0).abs() < 0.3, "{name}: {value} for {exact}");
    }
}

/// Words without the breaks of lines.
fn plain(words: &str) -> String {
    words.chars().filter(|c| !c.is_whitespace() && *c != '│').collect()
}

#[test]
fn what_lies_outside_of_a_chart_is_refused_by_its_numbers() {
    let folder = Folder::new("accuracy-outside");
    let settles = settling(0.01534);
    let thrown = BOUNCE.replace("density = 7000.0", "density = 7000.0\nvelocity = [0.0, 0.0, -0.25]");
    let cases = [
        (settling(0.0004), "Ar = |ρ_p/ρ − 1| g D³/ν² is"),
        (
            settles.replace("0.0163", "0.002"),
            "the distance of the centre from the sides over D is 1, charted from 1.5",
        ),
        (settles.replace("density = 2500.0", "density = 20000.0"), "ρ_p/ρ is 20, charted from 1.5 to 8"),
        (settles.replace("until = 0.14", "until = 0.005"), "the run over"),
        (settles.replace("until = 0.14", "until = 0.9"), "the room left in front of the sphere over D is"),
        (
            format!("{settles}[fluid]\nmethod = \"izard-2014\"\n"),
            "nothing was charted with fluid.method = \"izard-2014\"",
        ),
        (thrown, "a sphere that is at rest at first was charted"),
        (BOUNCE.replace("viscosity = 0.018", "viscosity = 0.0018"), "St = (ρ_p + ρ/2) V D/(9 μ)"),
        (
            format!("{BOUNCE}[dem.lubrication]\nroughness = 1e-2\n"),
            "η/R is 0.01, charted from 2.000e-4 to 0.001",
        ),
    ];
    for (text, words) in cases {
        let scene = folder.write("scene.toml", &text);
        let output = bedload(&["check", path(&scene), "--accuracy", "50%"]);
        assert_eq!(output.status.code(), Some(2), "{words}: {}", said(&output));
        assert!(plain(&said(&output)).contains(&plain(words)), "{words}:\n{}", said(&output));
        let output = bedload(&["check", path(&scene)]);
        assert!(!said(&output).contains("cheaper: coarser"), "{words}:\n{}", said(&output));
    }
}

#[test]
fn defaults_that_a_scene_writes_out_are_no_settings_of_its_own() {
    let folder = Folder::new("accuracy-defaults");
    let scene = folder.write("scene.toml", &settling(0.01534));
    if refuses_stale(&scene, "20%", "docs/charts/settling-axis.csv") {
        return;
    }
    let expected = |arguments: &[&str]| {
        let output = bedload(&[&["check"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        said(&output).lines().find(|line| line.contains("whose error is")).expect("a promise").to_owned()
    };
    let plain = expected(&[path(&scene), "--accuracy", "20%"]);
    let written = expected(&[path(&scene), "--accuracy", "20%", "--set", "fluid.method=\"calibrated\""]);
    assert_eq!(written, plain);
    // The scene that a run leaves has every default written out.
    let out = folder.join("out");
    run(&scene, &out, &["--accuracy", "20%"]);
    let left = out.join("scene.toml");
    assert_eq!(expected(&[path(&left)]), plain);
    // What a scene writes out of another grid is a setting.
    let output = bedload(&["check", path(&left), "--set", "accuracy=\"2%\""]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(self::plain(&said(&output)).contains("chartedwithdem.lubrication."), "{}", said(&output));
}

#[test]
fn a_bed_is_promised_nothing() {
    let folder = Folder::new("accuracy-bed");
    let mut text = settling(0.01534).replace("axisymmetric", "space").replace("r_upper", "x");
    text = text.replace("z = ", "y = \"periodic\", z = ").replace("x = \"free-slip\"", "x = \"periodic\"");
    text = text.replace("lower = [0.0, 0.0]", "lower = [0.0, 0.0, 0.0]");
    text = text.replace("[0.0163, 0.0489]", "[0.006, 0.006, 0.012]").replace("[40, 120]", "[24, 24, 48]");
    let (begin, end) = (text.find("[[grains]]").expect("grains"), text.find("[[metrics]]").expect("metrics"));
    let grain = |place: u8| {
        let [x, y, z] = [place % 3, place / 3 % 3, place / 9].map(|k| 0.001 + 0.002 * f64::from(k));
        format!("[[grains]]\nposition = [{x:?}, {y:?}, {z:?}]\nradius = 0.00099\ndensity = 2500.0\n")
    };
    text.replace_range(begin..end, &(0..27).map(grain).collect::<String>());
    let scene = folder.write("scene.toml", &text);
    let output = bedload(&["check", path(&scene), "--accuracy", "5%"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        plain(&said(&output)).contains(&plain("one sphere was charted, the scene has 27")),
        "{}",
        said(&output)
    );
}

#[test]
fn what_no_chart_can_promise_is_refused_with_what_it_can() {
    let folder = Folder::new("accuracy-refused");
    let scene = folder.write("scene.toml", &settling(0.01534));
    for (text, words) in [("0.02%", "but the best of"), ("a lot", "0.01 % to 50 %")] {
        let output = bedload(&["check", path(&scene), "--accuracy", text]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(words) && said(&output).contains("accuracy"), "{}", said(&output));
    }
    if refuses_stale(&scene, "5%", "docs/charts/settling-axis.csv") {
        return;
    }
    // `--set` wins over what accuracy chooses, which then promises nothing.
    let output = bedload(&["check", path(&scene), "--accuracy", "5%", "--set", "fluid.time.dt=1.25e-4"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("dt fluid       1.250e-4 s"), "{}", said(&output));
    assert!(said(&output).contains("nothing is promised: --set changes fluid.time.dt="), "{}", said(&output));
    let output = bedload(&["check", path(&scene), "--accuracy", "5%", "--set", "observe.every=0.01"]);
    assert!(said(&output).contains("whose error is"), "{}", said(&output));
}
