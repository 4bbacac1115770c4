//! Runs of the DEM alone, through `bedload run`.

use std::process::Command;

use tests::harness::{Folder, bedload, column, complete, program, said, summary};

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

/// A box without weight, the given grains in it, and the rest of a scene.
fn weightless(grains: &str, dem: &str) -> String {
    format!(
        r#"
until = 1.0
gravity = [0.0, 0.0, -0.01]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [20.0, 20.0, 20.0]
boundary = {{ x = "periodic", y = "periodic", z = "free-slip" }}
{grains}
[dem]
{dem}
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.3
contact_time = 0.01
friction = 0.3
[observe]
every = 0.1
"#
    )
}

/// Rows of `grains.csv` at the end: x, and the velocity along x.
fn ends(folder: &std::path::Path) -> Vec<[f64; 2]> {
    let text = std::fs::read_to_string(folder.join("grains.csv")).expect("grains.csv");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let number = |cells: &[&str], at: usize| cells[at].parse().expect("a number");
    rows.map(|row| row.split(',').collect::<Vec<_>>())
        .map(|cells| [number(&cells, 1), number(&cells, 6)])
        .collect()
}

/// The state of a run at 30 m/s, far above what the next scene's weight leads to, starts a scene that fixes,
/// locks and leads some of the grains.
#[test]
fn what_a_scene_holds_stays_so_in_the_state_of_another() {
    let folder = Folder::new("held");
    let grain = |y: f64, more: &str| {
        format!("[[grains]]\nposition = [6.0, {y}, 5.0]\nradius = 0.5\ndensity = 1.0\n{more}\n")
    };
    let fast = "velocity = [30.0, 0.0, 0.0]\nspin = [0.0, 0.0, 2.0]";
    let first: String = [3.0, 6.0, 9.0, 12.0, 15.0].map(|y| grain(y, fast)).concat();
    let held = [
        grain(3.0, ""),
        grain(6.0, "motion = \"fixed\""),
        grain(9.0, "locked = [\"x\", \"spin-z\"]"),
        grain(12.0, "motion = \"prescribed\""),
        grain(15.0, "motion = \"prescribed\"\nvelocity = [1.0, 0.0, 0.0]"),
    ];
    let run = |name: &str, text: &str| {
        let out = folder.join(name);
        complete(&folder.write(&format!("{name}.toml"), text), &out, &[]);
        ends(&out)
    };
    let before = run("first", &weightless(&first, ""));
    let after = run("second", &weightless(&held.concat(), "initial_state = \"first\""));
    for (grain, (speed, moved)) in
        [(30.0, 30.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (1.0, 1.0)].into_iter().enumerate()
    {
        let way = (after[grain][0] - before[grain][0]).rem_euclid(20.0);
        let moved: f64 = f64::rem_euclid(moved, 20.0);
        assert!((way - moved).abs() < 1e-6, "grain {grain}: {way} for {moved}");
        assert!((after[grain][1] - speed).abs() < 1e-9, "grain {grain}: {:?}", after[grain]);
    }
}

/// By the radius of the large grains the small one between them would overlap by 5 %.
#[test]
fn a_small_grain_does_not_vanish_between_large_ones() {
    let folder = Folder::new("swallowed");
    let grain = |z: f64, radius: f64, more: &str| {
        format!("[[grains]]\nposition = [5.0, 5.0, {z}]\nradius = {radius}\ndensity = 1.0\n{more}\n")
    };
    let grains = [grain(1.0, 1.0, "motion = \"fixed\""), grain(2.05, 0.05, ""), grain(3.1, 1.0, "")].concat();
    let heavy = weightless(&grains, "").replace("-0.01", "-1.0").replace("until = 1.0", "until = 3.0");
    let (scene, out) = (folder.write("heavy.toml", &heavy), folder.join("out"));
    let output = bedload(&["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    let text = said(&output);
    assert!(output.status.code() != Some(0) && text.contains("of the smaller radius"), "{text}");
}

/// A plane stands in the region: grains come where they touch nothing, and nothing sets them in motion.
#[test]
fn insertions_keep_clear_of_walls() {
    let folder = Folder::new("insert-wall");
    let insertion = "[[insertions]]\ncount = 6\nlower = [0.0, 0.0, 1.0]\nupper = [20.0, 20.0, 1.9]\n\
        radius = 0.4\ndensity = 1.0\nseed = 2\nrate = 10.0\nstart = 0.1\n[[walls]]\npoint = [0.0, 0.0, 1.03]\n\
        normal = [0.0, 0.0, 1.0]\n";
    let text = weightless(insertion, "").replace("-0.01", "0.0");
    let out = folder.join("out");
    complete(&folder.write("insert.toml", &text), &out, &[]);
    // A box without a grain has no height.
    assert_eq!(column(&out, "height")[0], "NaN");
    let table = std::fs::read_to_string(out.join("grains.csv")).expect("grains.csv");
    let rows: Vec<&str> = table.lines().filter(|line| !line.starts_with('#')).skip(1).collect();
    assert_eq!(rows.len(), 6, "{table}");
    for row in rows {
        let speeds: Vec<f64> = row.split(',').skip(6).take(3).map(|v| v.parse().expect("a number")).collect();
        assert_eq!(speeds, [0.0; 3], "{row}");
    }
}

/// A plane that appears where grains stand throws them out: the message names it.
#[test]
fn a_wall_that_appears_in_grains_is_named() {
    let folder = Folder::new("appears");
    let bead = |z: &str| format!("[[grains]]\nposition = [9.0, 9.0, {z}]\nradius = 1.0\ndensity = 2.0\n");
    let wall = "[[walls]]\npoint = [0.0, 0.0, 3.0]\nnormal = [0.0, 0.0, 1.0]\nfrom = 0.1\n";
    let text =
        weightless(&format!("{}{}{wall}", bead("1.0"), bead("3.0")), "").replace("free-slip", "no-slip");
    let scene = folder.write("appears.toml", &text.replace("-0.01", "-9.81"));
    let output =
        bedload(&["run".as_ref(), scene.as_os_str(), "--out".as_ref(), folder.join("out").as_os_str()]);
    let text = said(&output);
    assert!(output.status.code() != Some(0) && text.contains("walls[0] acts from t = 0.1 s on"), "{text}");
}

/// The plane begins a tenth of a radius within a sphere at rest, which it throws up: no law is too soft.
#[test]
fn a_wall_that_appears_a_little_within_a_grain_is_named() {
    let folder = Folder::new("appears-within");
    let more = "[[grains]]\nposition = [5.0, 5.0, 2.0]\nradius = 0.5\ndensity = 2.0\n[[walls]]\n\
                point = [0.0, 0.0, 1.55]\nnormal = [0.0, 0.0, 1.0]\nfrom = 0.1\n";
    let scene = folder.write("within.toml", &weightless(more, "").replace("-0.01", "0.0"));
    let output =
        bedload(&["run".as_ref(), scene.as_os_str(), "--out".as_ref(), folder.join("out").as_os_str()]);
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    assert!(
        text.contains("or in a wall in window") && text.contains("walls[0] acts from t = 0.1 s on"),
        "{text}"
    );
    assert!(!text.contains("softer"), "{text}");
}

/// Of two entries the later one has room: the message says which one holds it up.
#[test]
fn an_entry_without_room_is_named() {
    let folder = Folder::new("insert-full");
    let entry = |lower: f64, count: u32, start: f64| {
        let [upper, top] = [lower + 2.1, 3.0];
        format!(
            "[[insertions]]\ncount = {count}\nlower = [{lower:?}, 1.0, 1.0]\nupper = [{upper:?}, 3.1, {top:?}]\n\
             radius = 1.0\ndensity = 1.0\nseed = 2\nrate = 10.0\nstart = {start:?}\n"
        )
    };
    let text = weightless(&[entry(1.0, 2, 0.1), entry(9.0, 1, 0.5)].concat(), "").replace("-0.01", "0.0");
    let scene = folder.write("full.toml", &text);
    let output =
        bedload(&["run".as_ref(), scene.as_os_str(), "--out".as_ref(), folder.join("out").as_os_str()]);
    let text = said(&output);
    assert!(text.contains("2 grains were not inserted: grain 1 of insertions[0], due at t = 0.2"), "{text}");
}

/// Beads let go in mid-air are slow at first, and do not rest.
#[test]
fn what_is_let_go_does_not_rest_at_once() {
    let folder = Folder::new("let-go");
    let bead = "[[grains]]\nposition = [0.5, 0.5, 0.5]\nradius = 0.05\ndensity = 2.0\n";
    let stop = "[stop_when]\nkinetic_energy_per_grain_below = 1e-5\n";
    let text = weightless(bead, "").replace("-0.01", "-9.81").replace("[dem]\n", &format!("{stop}[dem]\n"));
    let text = text.replace("restitution = 0.3", "restitution = 0.2").replace("free-slip", "no-slip");
    let out = folder.join("out");
    complete(&folder.write("fall.toml", &text), &out, &[]);
    // 0.45 m of free fall take 0.3 s.
    assert!(summary(&out)["time"]["simulated"].as_f64().expect("a time") > 0.3);
}

/// A box of 4 × 4 × 3 with a floor and weight 1, grains of radius 0.5.
fn on_a_floor(grains: &str, more: &str) -> String {
    format!(
        "until = 4.0\ngravity = [0.0, 0.0, -1.0]\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\n\
         upper = [4.0, 4.0, 3.0]\nboundary = {{ x = \"free-slip\", y = \"free-slip\", z_lower = \"no-slip\", \
         z_upper = \"free-slip\" }}\n{grains}[dem.contact]\nlaw = \"linear-spring-dashpot\"\n\
         restitution = 0.3\ncontact_time = 0.02\nfriction = 0.5\n{more}"
    )
}

/// Walls are judged by where the grains of a state are, not by where the scene has them.
#[test]
fn a_state_is_judged_at_the_walls_of_the_scene_that_goes_on() {
    let folder = Folder::new("state-at-walls");
    let grain = "[[grains]]\nposition = [1.0, 1.0, 2.4]\nradius = 0.5\ndensity = 1.0\n";
    complete(&folder.write("first.toml", &on_a_floor(grain, "")), &folder.join("first"), &[]);
    let go_on = |wall: &str| {
        let more = format!("[dem]\ninitial_state = \"first\"\n[[walls]]\n{wall}\n");
        let scene =
            folder.write("next.toml", &on_a_floor(grain, &more).replace("until = 4.0", "until = 0.1"));
        let out = folder.join("next");
        let [scene, out] = [&scene, &out].map(|path| path.to_str().expect("UTF-8"));
        bedload(&["run", scene, "--out", out, "--overwrite"])
    };
    let lid = go_on("point = [0.0, 0.0, 2.0]\nnormal = [0.0, 0.0, -1.0]");
    assert_eq!(lid.status.code(), Some(0), "{}", said(&lid));
    for cuts in [
        "point = [0.0, 0.0, 1.2]\nnormal = [0.0, 0.0, 1.0]",
        "point = [2.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]",
    ] {
        let output = go_on(cuts);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("dem.initial_state") && text.contains("m into a wall; allowed"), "{text}");
    }
}

/// A grain that has rolled out of the box along its floor has a contact still, which counts no more.
#[test]
fn grains_that_left_do_not_raise_the_coordination_number() {
    let folder = Folder::new("coordination");
    let grains = "[[grains]]\nposition = [1.0, 1.0, 0.5]\nradius = 0.5\ndensity = 1.0\n[[grains]]\n\
        position = [3.5, 1.0, 0.5]\nvelocity = [2.0, 0.0, 0.0]\nspin = [0.0, 4.0, 0.0]\nradius = 0.5\n\
        density = 1.0\n";
    let observe = "[observe]\nevery = 0.1\ntotals = { columns = [\"coordination-number\"] }\n";
    let text = on_a_floor(grains, observe).replace("until = 4.0", "until = 1.0");
    let out = folder.join("out");
    complete(&folder.write("rolls.toml", &text), &out, &[]);
    let numbers = column(&out, "coordination_number");
    assert!(numbers.iter().skip(1).all(|number| number == "1"), "{numbers:?}");
}

/// Records as short as a sub-step do not change the motion.
#[test]
fn a_bounce_does_not_depend_on_how_often_it_is_recorded() {
    let folder = Folder::new("recorded");
    let grain = "[[grains]]\nposition = [1.0, 1.0, 1.0]\nradius = 0.5\ndensity = 1.0\n";
    let ends = [1, 10].map(|substeps| {
        // A sub-step is 1/50 of the contact time.
        let observe = format!("[observe]\nevery = {}\n", 4e-4 * f64::from(substeps));
        let (name, out) = (format!("every-{substeps}.toml"), folder.join(&format!("every-{substeps}")));
        complete(&folder.write(&name, &on_a_floor(grain, &observe)), &out, &[]);
        column(&out, "position_z[0]").last().expect("rows").parse::<f64>().expect("a number")
    });
    assert!((ends[0] - ends[1]).abs() < 1e-9, "{ends:?}");
}

/// Plates of a fiftieth of their length that meet fast: the overlap counts over the half thickness.
#[test]
fn plates_do_not_pass_through_each_other_without_a_word() {
    let folder = Folder::new("plates");
    let text = "until = 0.3\n[domain]\ngeometry = \"plane\"\nlower = [-5.0, -5.0]\nupper = [5.0, 5.0]\n\
        boundary = { x = \"free-slip\", z = \"free-slip\" }\n[[grains]]\nshape = \"rectangle\"\n\
        sides = [1.0, 0.02]\nposition = [0.0, 0.0, 0.0]\ndensity = 1.0\nmotion = \"fixed\"\n[[grains]]\n\
        shape = \"rectangle\"\nsides = [1.0, 0.02]\nposition = [0.03, 0.0, 0.07]\nvelocity = [0.0, 0.0, -3.0]\n\
        density = 1.0\n[dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.8\ncontact_time = 0.02\n\
        friction = 0.3\n[observe]\nevery = 0.002\n";
    let scene = folder.write("plates.toml", text);
    let [scene, out] = [scene, folder.join("out")].map(|path| path.to_str().expect("UTF-8").to_owned());
    let output = bedload(&["run", &scene, "--out", &out]);
    let text = said(&output);
    assert!(output.status.code() != Some(0) && text.contains("overlap: grains lie"), "{text}");
}

/// What is asked of averages is checked, and no file of anybody is replaced.
#[test]
fn averages_of_no_sense_are_refused() {
    let folder = Folder::new("coarse-grain");
    let text = TWO_GRAINS.replace("until = 1.0", "until = 0.1");
    let space = folder.join("space");
    complete(&folder.write("space.toml", &text), &space, &[]);
    let flat = text.replace("\"space\"", "\"plane\"").replace("y = \"free-slip\", ", "");
    let flat = flat.replace("[0.0, 0.0, 0.0]\nupper = [1.0, 1.0, 1.0]", "[0.0, 0.0]\nupper = [1.0, 1.0]");
    let flat =
        flat.replace("[0.5, 0.5, 0.5]", "[0.5, 0.0, 0.5]").replace("[0.8, 0.2, 0.5]", "[0.8, 0.0, 0.5]");
    let plane = folder.join("plane");
    complete(&folder.write("plane.toml", &flat), &plane, &[]);
    let average = |out: &std::path::Path, more: &str| {
        let mut command = Command::new(program("bedload-dem"));
        let output = command.arg("coarse-grain").arg(out).args(more.split(' ')).output().expect("starts");
        (output.status.code(), said(&output))
    };
    let dear = folder.write("dear.txt", "dear");
    let taken = format!("--slabs 4 --out {}", dear.display());
    for (out, more, words) in [
        (&space, "--cells 4,4,4 --width 0", "--width 0: allowed: 0.0005 m"),
        (&space, "--cells 4,4,4 --width nan", "--width NaN: allowed"),
        (&space, "--cells 4,4,4 --width 1e9", "to 1 m"),
        (&space, "--cells 0,4,4", "--cells [0, 4, 4]: allowed: 1 at least"),
        (&space, "--cells 1000000,1000000,1000000", "10000000 in all"),
        (&space, "--slabs 0", "--slabs 0: allowed: 1 to 100000"),
        (
            &space,
            "--slabs 4 --lower 0,0,1 --upper 1,1,0",
            "spans 1 to 0 m along z; allowed: a part of the box",
        ),
        (&space, "--cells 4,4,4 --lower nan,0,0", "spans NaN to 1 m along x"),
        (&space, "--slabs 4 --upper 0,1,1", "spans 0 to 0 m along x"),
        (&space, "--slabs 4 --upper 2,1,1", "the box, which spans 0 to 1 m"),
        (&space, "--slabs 4 --width 0.1", "cannot be used with"),
        (&space, "--cells 4,4,4 --axis x", "cannot be used with"),
        (&space, &taken, "exists: name another file"),
        (&plane, "--slabs 4 --axis y", "allowed: x, z"),
        (&plane, "--cells 4,2,4", "1 along y in the plane"),
    ] {
        let (code, said) = average(out, more);
        assert!(code == Some(2) && said.contains(words), "{more}: {code:?} {said}");
    }
    assert_eq!(std::fs::read(&dear).expect("there"), b"dear");
    for (out, more) in
        [(&plane, "--slabs 4 --axis x"), (&plane, "--cells 4,1,4 --upper 1,0,1"), (&space, "--slabs 4")]
    {
        assert_eq!(average(out, more).0, Some(0), "{more}: {}", average(out, more).1);
    }
}
