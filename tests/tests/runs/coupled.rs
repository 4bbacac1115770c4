//! The main job with the real programs: it completes, it is the same every time, it can be
//! interrupted, resumed and replayed, bit for bit.

use std::path::Path;
use std::process::Output;

use protocol::log::{Topic, flip_bit};
use tests::harness::{
    Folder, SMALL_BOUNCE, bedload, complete, metric, said, signal, start, summary, wait_until,
};

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn the_main_job_leaves_everything_it_promises() {
    let folder = Folder::new("main-job");
    let (scene, out) = (folder.write("bounce.toml", SMALL_BOUNCE), folder.join("out"));
    complete(&scene, &out, &[]);
    for name in
        ["scene.toml", "summary.json", "series.csv", "exchange.mcap", "report.html", "checkpoint", "fields"]
    {
        assert!(out.join(name).exists(), "{name} is missing");
    }
    let summary = summary(&out);
    assert_eq!(summary["status"], "completed");
    assert_eq!(summary["size"]["cells"], 512);
    assert!(summary["time"]["simulated"].as_f64().expect("a number") >= 3.0);
    // The sphere touches the wall slower than it fell, and comes back up.
    let impact = metric(&out, "impact_velocity_ratio");
    assert!((0.3..1.0).contains(&impact), "V_C/V_T = {impact}");
    assert!(metric(&out, "rebound_height_over_diameter") > 0.01);
}

#[test]
fn the_same_bits_for_any_number_of_threads_and_twice() {
    let folder = Folder::new("same-bits");
    let scene = folder.write("bounce.toml", SMALL_BOUNCE);
    let series: Vec<String> = [("a", "1"), ("b", "1"), ("c", "2"), ("d", "4")]
        .into_iter()
        .map(|(name, threads)| {
            let out = folder.join(name);
            complete(&scene, &out, &["--threads", threads, "--no-record"]);
            assert!(!out.join("exchange.mcap").exists(), "--no-record recorded");
            text(&out.join("series.csv"))
        })
        .collect();
    assert!(series[0].lines().count() > 100);
    assert!(series.iter().all(|other| *other == series[0]), "series.csv differs between runs");
}

/// Runs a scene and interrupts it somewhere in the middle.
fn interrupt(scene: &Path, out: &Path) -> Output {
    let child = start(&["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    // when the series has grown, or the log when rows wait in a buffer
    let begun = || std::fs::metadata(out.join("exchange.mcap")).is_ok_and(|data| data.len() > 20_000);
    wait_until(30.0, begun).expect("the run begins");
    signal(child.id(), "INT");
    child.wait_with_output().expect("it ends")
}

#[test]
fn the_same_bits_after_an_interrupt_and_resume() {
    let folder = Folder::new("resume");
    let scene = folder.write("bounce.toml", SMALL_BOUNCE);
    let (whole, parts) = (folder.join("whole"), folder.join("parts"));
    complete(&scene, &whole, &[]);
    // On a machine that stands still at the wrong moment the run is over before the signal comes: once more,
    // then.
    let mut output = interrupt(&scene, &parts);
    for _ in 0..4 {
        if output.status.code() == Some(0) {
            std::fs::remove_dir_all(&parts).expect("removes");
            output = interrupt(&scene, &parts);
        }
    }
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert_eq!(summary(&parts)["status"], "interrupted");
    let reached = summary(&parts)["time"]["simulated"].as_f64().expect("a number");
    assert!(reached > 0.0 && reached < 3.0, "interrupted at t = {reached}");
    let log = bedload(&["log", "info", parts.join("exchange.mcap").to_str().expect("UTF-8")]);
    assert_eq!(log.status.code(), Some(0), "{}", said(&log));
    complete(&scene, &parts, &["--resume"]);
    assert_eq!(text(&parts.join("series.csv")), text(&whole.join("series.csv")));
    assert_eq!(summary(&parts)["metrics"], summary(&whole)["metrics"]);
}

#[test]
fn a_finished_run_goes_on_past_its_end() {
    let folder = Folder::new("later-end");
    let scene = folder.write("bounce.toml", SMALL_BOUNCE);
    let (whole, parts) = (folder.join("whole"), folder.join("parts"));
    // Both ends are whole numbers of windows, without a rounding.
    let dt = ["--set", "fluid.time.dt=0.0078125"];
    complete(&scene, &whole, &dt);
    complete(&scene, &parts, &[&dt[..], &["--until", "1.5"]].concat());
    assert_eq!(summary(&parts)["time"]["simulated"], 1.5);
    complete(&scene, &parts, &[&dt[..], &["--resume"]].concat());
    assert!(text(&parts.join("series.csv")) == text(&whole.join("series.csv")), "series.csv differs");
    assert_eq!(summary(&parts)["metrics"], summary(&whole)["metrics"]);
    assert_eq!(text(&parts.join("scene.toml")), text(&whole.join("scene.toml")));
    // Back is no way, nor is anything else a scene of the same state.
    let (scene, parts) = (scene.to_str().expect("UTF-8"), parts.to_str().expect("UTF-8"));
    let other = ["--set", "medium.viscosity=0.06"];
    for (more, words) in
        [(&["--until", "2.0"][..], ["until", "t = 3"]), (&other[..], ["another scene", "--until"])]
    {
        let output = bedload(&[&["run", scene, "--out", parts, "--resume"], &dt[..], more].concat());
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(words.iter().all(|word| said(&output).contains(word)), "{}", said(&output));
    }
}

#[test]
fn a_log_replays_bit_for_bit_in_both_directions_and_a_flipped_bit_is_named() {
    let folder = Folder::new("replay");
    let (scene, out) = (folder.write("bounce.toml", SMALL_BOUNCE), folder.join("out"));
    complete(&scene, &out, &[]);
    let log = out.join("exchange.mcap");
    let replay = |log: &Path, side: &str| {
        bedload(&["replay", log.to_str().expect("UTF-8"), "--drive", side, "--verify"])
    };
    for side in ["dem", "fluid"] {
        let output = replay(&log, side);
        assert_eq!(output.status.code(), Some(0), "{side}: {}", said(&output));
    }
    // Word 5 of the loads: torque about z, which nothing on the axis uses, so only the record differs.
    let flipped = folder.join("flipped.mcap");
    let bit = (7 + 1 + 2) * 64 + 30;
    flip_bit(&log, &flipped, Topic::Loads, 120, 0, bit).expect("flips");
    let output = replay(&flipped, "fluid");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    for word in ["step 120", "grain 0", "force[2]"] {
        assert!(said(&output).contains(word), "no {word:?} in {}", said(&output));
    }
}

/// Three spheres: one comes to rest on the floor, one on a sphere that is fixed there.
const AT_REST: &str = r#"
until = 24.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [3.0, 3.0, 4.0]
cells = [24, 24, 32]
boundary = { x = "periodic", y = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.03
[[grains]]
position = [0.7, 0.77, 1.3]
radius = 0.5
density = 1.5
[[grains]]
position = [2.22, 0.75, 0.5]
radius = 0.5
density = 1.5
motion = "fixed"
[[grains]]
position = [2.22, 0.75, 2.2]
radius = 0.5
density = 1.5
locked = ["x", "y"]
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.8
contact_time = 0.01
friction = 0.2
[observe]
every = 0.0
[[metrics]]
name = "floor"
kind = "resting-force-ratio"
[[metrics]]
name = "sphere"
kind = "resting-force-ratio"
grain = 2
"#;

/// Four spheres that fall onto four, all of which touch: the pores between them are narrow.
#[test]
fn a_bed_that_has_come_to_rest_presses_with_its_weight() {
    let folder = Folder::new("at-rest-bed");
    let head = AT_REST.split_once("[[grains]]").expect("grains").0;
    let head = head.replace("[3.0, 3.0, 4.0]", "[2.0, 2.0, 3.0]").replace("[24, 24, 32]", "[16, 16, 24]");
    let places = [[0.5, 0.5, 0.5], [0.5, 1.5, 0.5], [1.5, 0.5, 0.5], [1.5, 1.5, 0.5]];
    let above = places.map(|[x, y, _]| [x + 0.5, y + 0.5, 1.6]);
    let grain = |[x, y, z]: &[f64; 3]| {
        format!("[[grains]]\nposition = [{x}, {y}, {z}]\nradius = 0.5\ndensity = 1.5\n")
    };
    let grains: String = places.iter().chain(&above).map(grain).collect();
    let contact = "[dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.7\ncontact_time = 0.02\n\
        friction = 0.3\n[dem.lubrication]\nform = \"none\"\n";
    let metrics: String = (0..8)
        .map(|n| format!("[[metrics]]\nname = \"g{n}\"\nkind = \"resting-force-ratio\"\ngrain = {n}\n"))
        .collect();
    let text = format!("{head}{grains}{contact}{metrics}").replace("0.03", "0.02").replace("24.0", "40.0");
    let (scene, out) = (folder.write("bed.toml", &text), folder.join("out"));
    complete(&scene, &out, &[]);
    let mean = (0..8).map(|n| metric(&out, &format!("g{n}"))).sum::<f64>() / 8.0;
    println!("contact over submerged weight {mean:.4}");
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
}

/// The force of the approach does not stay in the cells that grains seal with what they rest on; a run that
/// goes on where they have just come to rest is the same to the last bit.
#[test]
fn several_spheres_that_have_come_to_rest_press_with_their_weight() {
    let folder = Folder::new("at-rest-several");
    let (scene, out) = (folder.write("rest.toml", AT_REST), folder.join("out"));
    complete(&scene, &out, &[]);
    for name in ["floor", "sphere"] {
        let rest = metric(&out, name);
        println!("{name}: contact over submerged weight {rest:.4}");
        assert!((rest - 1.0).abs() < 0.01, "{name}: {rest}");
    }
    let fixed = |until| ["--set", "fluid.time.dt=0.125", "--until", until];
    let whole = folder.join("whole");
    complete(&scene, &whole, &fixed("12"));
    for until in ["8", "9"] {
        let parts = folder.join(&format!("until-{until}"));
        complete(&scene, &parts, &fixed(until));
        complete(&scene, &parts, &[&fixed("12")[..], &["--resume"]].concat());
        assert_eq!(text(&parts.join("series.csv")), text(&whole.join("series.csv")), "cut at {until}");
    }
}

/// Two spheres that hardly move towards each other, a fifth of a cell apart, for 400 windows: both masks seal
/// the cells between them where the place lies on a face of the cells, and the force must not grow there. It
/// was 1.2 times that of half a cell off, and went on growing.
#[test]
fn the_force_of_a_slow_approach_does_not_hang_on_the_place() {
    let folder = Folder::new("slow-approach");
    let forces = [3.0, 3.1].map(|middle: f64| {
        let sphere = |side: f64| {
            let (at, speed) = (middle + side * 1.02, -side * 1e-6);
            format!(
                "[[grains]]\nposition = [2.6, 2.6, {at}]\nvelocity = [0.0, 0.0, {speed}]\nradius = 1.0\n\
                 density = 1e7\n"
            )
        };
        let metric_of = |name: &str| {
            format!("[[metrics]]\nname = \"{name}\"\nkind = \"final\"\ncolumn = \"{name}[0]\"\n")
        };
        let names = ["hydrodynamic_force_z", "lubrication_force_z"];
        let text = format!(
            "until = 3.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [5.2, 5.2, 6.0]\n\
             cells = [26, 26, 30]\nboundary = {{ x = \"periodic\", y = \"periodic\", z = \"free-slip\" }}\n\
             [medium]\ndensity = 1.0\nviscosity = 10.0\n{}{}[fluid.time]\nconvection = false\n\
             [dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 1e-2\n\
             [dem.lubrication]\nform = \"complement\"\nroughness = 1e-7\n[observe]\nevery = 0.1\n{}{}",
            sphere(-1.0),
            sphere(1.0),
            metric_of(names[0]),
            metric_of(names[1]),
        );
        let (scene, out) = (folder.write("pair.toml", &text), folder.join(&format!("{middle}")));
        complete(&scene, &out, &[]);
        names.iter().map(|name| metric(&out, name)).sum::<f64>()
    });
    println!("on a face {:e}, half a cell off {:e}", forces[0], forces[1]);
    assert!((forces[0] / forces[1] - 1.0).abs() < 0.07, "{forces:?}");
}

/// The mask of a disc seals in short steps, too: 0.83 and 0.93 of the weight were left.
#[test]
fn discs_in_short_steps_that_have_come_to_rest_press_with_their_weight() {
    let folder = Folder::new("at-rest-discs");
    let disc =
        |x: f64, z: f64| format!("[[grains]]\nposition = [{x}, 0.0, {z}]\nradius = 0.5\ndensity = 1.5\n");
    let metric_of =
        |n: usize| format!("[[metrics]]\nname = \"g{n}\"\nkind = \"resting-force-ratio\"\ngrain = {n}\n");
    let text = format!(
        "until = 12.0\ngravity = [0.0, 0.0, -1.0]\n\
         [domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [6.0, 4.0]\ncells = [96, 64]\n\
         boundary = {{ x = \"no-slip\", z = \"no-slip\" }}\n\
         [medium]\ndensity = 1.0\nviscosity = 0.02\n{}{}\
         [fluid.time]\ndt = 0.01\n\
         [dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.5\ncontact_time = 1e-2\n\
         friction = 0.3\n[dem.lubrication]\nform = \"none\"\n{}{}",
        disc(1.8, 1.77),
        disc(4.1, 0.9),
        metric_of(0),
        metric_of(1)
    );
    let (scene, out) = (folder.write("rest.toml", &text), folder.join("out"));
    complete(&scene, &out, &[]);
    for name in ["g0", "g1"] {
        let rest = metric(&out, name);
        println!("{name}: contact over submerged weight {rest:.4}");
        assert!((rest - 1.0).abs() < 0.03, "{name}: {rest}");
    }
}

/// In the longest steps the force of the approach would stay in the cells that it seals, and bear a third of
/// a sphere, or of one that floats up, for good.
#[test]
fn a_sphere_that_has_come_to_rest_presses_with_its_weight() {
    let folder = Folder::new("at-rest");
    for density in [1.5, 0.5] {
        let text = format!(
            r#"
until = 14.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [1.5, 3.0]
cells = [24, 48]
boundary = {{ r_upper = "no-slip", z = "no-slip" }}
[medium]
density = 1.0
viscosity = 0.02
[[grains]]
position = [0.0, 0.0, 1.5]
radius = 0.5
density = {density}
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.8
contact_time = 0.005
[observe]
every = 0.0
[[metrics]]
name = "rest"
kind = "resting-force-ratio"
"#
        );
        let (scene, out) = (folder.write("rest.toml", &text), folder.join(&format!("out-{density}")));
        complete(&scene, &out, &[]);
        let rest = metric(&out, "rest");
        println!("density {density}: contact over submerged weight {rest:.4}");
        assert!((rest - 1.0).abs() < 0.01, "{density}: {rest}");
    }
}
