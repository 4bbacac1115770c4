//! Runs of the DEM alone, through `bedload run`.

use tests::harness::{Folder, bedload, said, summary};

/// One grain at rest, one that leaves the box at t = 0.8.
const TWO_GRAINS: &str = r#"
until = 1.0
gravity = [0.0, 0.0, 0.0]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [1.0, 1.0, 1.0]
boundary = { x = "free-slip", y = "free-slip", z = "free-slip" }
[[grains]]
position = [0.5, 0.5, 0.5]
radius = 0.05
density = 2.0
[[grains]]
position = [0.8, 0.2, 0.5]
velocity = [0.25, 0.0, 0.0]
radius = 0.05
density = 2.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 0.01
[observe]
every = 0.1
"#;

#[test]
fn a_grain_that_leaves_the_box_is_named_when_it_leaves_and_counted_at_the_end() {
    let folder = Folder::new("leaves");
    let out = folder.join("out");
    let scene = folder.write("leaves.toml", TWO_GRAINS);
    // Enough grains take the bulk engine, a film or another integrator the general one.
    let bed = "[[groups]]\ncount = 300\nlower = [0.0, 0.0, 0.0]\nupper = [0.4, 1.0, 0.4]\nradius = 0.01\n\
        density = 2.0\nseed = 1\n";
    let many =
        folder.write("many.toml", &TWO_GRAINS.replace("[dem.contact]", &format!("{bed}[dem.contact]")));
    for scene in [scene, many] {
        let (scene, out) = (scene.to_str().expect("UTF-8"), out.to_str().expect("UTF-8"));
        let output = bedload(&["run", scene, "--out", out, "--overwrite"]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(0), "{text}");
        // Its centre passes x = 1 at t = 0.8 s.
        let when = text.find("grain 1 left the box in window").expect(&text);
        let time = text[when..].split("(t = ").nth(1).and_then(|rest| rest.split(' ').next());
        let time: f64 = time.and_then(|time| time.parse().ok()).expect(&text);
        assert!((0.8..0.95).contains(&time), "{text}");
        assert!(text.contains("m with [0.25, 0.0, 0.0] m/s"), "{text}");
        assert!(text.contains("1 grain(s) are outside the box at the end"), "{text}");
        assert!(!text.contains("grain 0 "), "{text}");
    }
}

#[test]
fn a_finished_run_goes_on_past_its_end() {
    let folder = Folder::new("dry-later-end");
    let scene = folder.write("leaves.toml", TWO_GRAINS);
    let run = |name: &str, until: &str, more: &[&str]| {
        let out = folder.join(name);
        let paths = ["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
        // Windows of 2 t_c: both ends are whole numbers of them, without a rounding.
        let time = "dem.contact.contact_time=0.0078125";
        let keys = ["--set", time, "--set", "observe.mean_velocity=true", "--until", until];
        let output = bedload(&[&paths, &keys[..], more].concat());
        (output.status.code(), said(&output), out)
    };
    let series = |out: &std::path::Path| std::fs::read_to_string(out.join("series.csv")).expect("text");
    let (_, _, whole) = run("whole", "1.0", &[]);
    let (code, text, parts) = run("parts", "0.5", &[]);
    assert_eq!((code, &summary(&parts)["time"]["simulated"]), (Some(0), &0.5.into()), "{text}");
    let (code, text, _) = run("parts", "1.0", &["--resume"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("grain 1 left the box"), "{text}");
    assert!(series(&parts) == series(&whole), "series.csv differs");
    let (code, text, _) = run("parts", "0.5", &["--resume"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("until") && text.contains("t = 1 s"), "{text}");
    assert!(series(&parts) == series(&whole), "what is refused changes nothing");
}

/// A kill between the solver's file of a checkpoint and the one that makes it whole.
#[test]
fn a_checkpoint_that_was_cut_short_is_passed_over() {
    let folder = Folder::new("dry-cut-short");
    let scene = folder.write("leaves.toml", TWO_GRAINS);
    let run = |name: &str, until: &str, more: &[&str]| {
        let out = folder.join(name);
        let paths = ["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
        let output = bedload(
            &[&paths, &["--set", "dem.contact.contact_time=0.0078125", "--until", until], more].concat(),
        );
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        out
    };
    let whole = run("whole", "1.0", &[]);
    let parts = run("parts", "0.5", &[]);
    let newest = protocol::checkpoints::newest(&whole.join("checkpoint")).expect("a whole checkpoint");
    let cut = parts.join("checkpoint").join(newest.file_name().expect("a step"));
    std::fs::create_dir(&cut).expect("a folder");
    std::fs::copy(newest.join("dem.checkpoint"), cut.join("dem.checkpoint")).expect("a copy");
    run("parts", "1.0", &["--resume"]);
    for file in ["series.csv", "grains.csv"] {
        let read = |out: &std::path::Path| std::fs::read(out.join(file)).expect("a file");
        assert!(read(&parts) == read(&whole), "{file} differs");
    }
}

/// Grains that fall onto a plane and come to rest there.
const BED: &str = r#"
until = 1.0
gravity = [0.0, 0.0, -9.81]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [0.06, 0.06, 0.3]
boundary = { x = "periodic", y = "periodic", z_lower = "no-slip", z_upper = "free-slip" }
[[groups]]
count = 200
lower = [0.0, 0.0, 0.006]
upper = [0.06, 0.06, 0.25]
radius = 0.005
density = 2000.0
seed = 1
[dem]
allow_coarse_dt = true
[dem.contact]
law = "linear-spring-dashpot"
form = "izard-2014"
restitution = 0.5
contact_time = 1e-3
friction = 0.3
[coupling]
force = ["contact-dashpot"]
[observe]
every = 0.02
"#;

#[test]
fn a_sub_step_that_makes_energy_ends_a_run_as_unstable() {
    let folder = Folder::new("dry-unstable");
    let scene = folder.write("bed.toml", BED);
    let run = |steps: f64, more: &[&str]| {
        let out = folder.join(&format!("out-{steps}"));
        let steps = format!("dem.steps_per_contact={steps}");
        let paths = ["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
        let output = bedload(&[&paths, &["--overwrite", "--set", &steps][..], more].concat());
        (output.status.code(), said(&output), out)
    };
    // Some jump out of the bed, and nothing is faster than it may be; a pile of them is.
    for (steps, what) in [(2.2, "the grains have gained"), (1.5, "more than 20 times what forces")] {
        let (code, text, out) = run(steps, &[]);
        assert_eq!(code, Some(4), "{text}");
        let error = summary(&out)["error"].as_str().expect("an error").to_owned();
        assert_eq!(summary(&out)["status"], "unstable");
        assert!(error.contains(what) && error.contains("dem.steps_per_contact"), "{error}");
    }
    let (code, text, _) = run(2.2, &["--set", "coupling.force=[\"contact-dashpot\", \"unstable\"]"]);
    assert_eq!(code, Some(0), "{text}");
    let (code, text, _) = run(10.0, &[]);
    assert_eq!(code, Some(0), "{text}");
}
