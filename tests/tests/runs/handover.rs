//! A coupled run handed over to another scene, grains, springs and fluid, with the real programs: on the same
//! grid it goes on with the same bits, on another one it starts from the same flow.

use std::path::Path;

use bedload_scene::{CheckedScene, SceneSource};
use fluid_solver::field::for_each_unknown;
use fluid_solver::solver::Solver;
use tests::harness::{Folder, bedload, column, complete, said, summary};

/// Discs that fall, two of them in touch from early on; none reaches the wall. Windows and ends are binary
/// numbers.
const FALLING: &str = r#"
until = 1.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [4.0, 6.0]
cells = [32, 48]
boundary = { x = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.05
GRAINS
[fluid.time]
dt = 0.0078125
[dem]
STATE
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.8
contact_time = 8e-3
friction = 0.3
[dem.lubrication]
form = "none"
"#;

const GRAINS: &str = r#"
[[grains]]
position = [1.0, 0.0, 3.0]
radius = 0.5
density = 2.5
[[grains]]
position = [1.4, 0.0, 3.917]
radius = 0.5
density = 6.0
[[grains]]
position = [2.9, 0.0, 3.2]
radius = 0.5
density = 2.0
"#;

/// The scene with grains of its own.
fn first() -> String {
    FALLING.replace("GRAINS", GRAINS).replace("STATE", "")
}

/// The scene that takes everything from the run in `a`, beside it.
fn second() -> String {
    FALLING
        .replace(
            "GRAINS",
            "initial = { type = \"run\", folder = \"a\" }\n[[grain_files]]\nfile = \"a/grains.csv\"\n",
        )
        .replace("STATE", "initial_state = \"a\"")
}

/// The grains at the end, without the comment that tells the time.
fn grains(out: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(out.join("grains.csv")).expect("grains.csv");
    text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect()
}

/// What the newest checkpoint of a role holds behind the first `head` bytes of its payload.
fn state(out: &Path, role: &str, head: usize) -> Vec<u8> {
    let folder = protocol::checkpoints::newest_of_run(out);
    let bytes = std::fs::read(protocol::checkpoint::path(&folder, role)).expect("a checkpoint");
    // The frame, and the identity behind its length.
    let identity = u64::from_le_bytes(bytes[56..64].try_into().expect("a length")) as usize;
    bytes[64 + identity + head..].to_vec()
}

#[test]
fn on_the_same_grid_the_run_goes_on_bit_for_bit() {
    let folder = Folder::new("handover-same");
    let (first, second) = (folder.write("first.toml", &first()), folder.write("second.toml", &second()));
    let (whole, a, b) = (folder.join("whole"), folder.join("a"), folder.join("b"));
    // Half of it ends in a touch.
    complete(&first, &whole, &["--until", "1.03125"]);
    complete(&first, &a, &["--until", "0.515625"]);
    complete(&second, &b, &["--until", "0.515625"]);
    assert_eq!(summary(&b)["time"]["simulated"], 0.515625);
    let touches: f64 = column(&a, "largest_overlap").last().expect("a row").parse().expect("a number");
    assert!(touches > 0.0, "no spring is handed over");
    assert_eq!(grains(&b), grains(&whole));
    for name in ["position_z[0]", "velocity_z[1]", "hydrodynamic_force_z[1]", "velocity_x[2]"] {
        let [whole, b] = [&whole, &b].map(|out| column(out, name));
        assert!(whole.len() == 2 * b.len() && whole.ends_with(&b), "{name}: {whole:?} {b:?}");
    }
    // Cells, then time, step and number of steps, which begin anew; the last step is the same.
    let [whole_fluid, fluid] = [&whole, &b].map(|out| state(out, "fluid", 24 + 24));
    assert!(whole_fluid == fluid, "the fluid differs");
    // Without its fluid the same scene goes another way.
    let still = folder.write("still.toml", &second_without_fluid());
    let c = folder.join("c");
    complete(&still, &c, &["--until", "0.515625"]);
    assert_ne!(grains(&c), grains(&whole));
    // The log has the whole path.
    let log = b.join("exchange.mcap");
    for side in ["dem", "fluid"] {
        let output = bedload(&["replay", log.to_str().expect("UTF-8"), "--drive", side, "--verify"]);
        assert_eq!(output.status.code(), Some(0), "{side}: {}", said(&output));
    }
}

fn second_without_fluid() -> String {
    second().replace("initial = { type = \"run\", folder = \"a\" }", "")
}

/// Kinetic energy over density and mean velocity along both axes of the fluid with which a scene starts.
fn start(path: &Path, overrides: &[&str]) -> (Solver<2>, f64, [f64; 2]) {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let scene = SceneSource::read(path, &overrides).and_then(CheckedScene::new).expect("a scene");
    let solver = Solver::<2>::new(&scene).expect("a fluid");
    let (mut energy, mut mean) = (0.0, [0.0; 2]);
    for (d, mean) in mean.iter_mut().enumerate() {
        let (grid, u) = (solver.grid(), &solver.stepper().state().velocity[d]);
        for_each_unknown(grid, d, |at, index| {
            energy += 0.5 * grid.control_volume(d, at) * u[index].powi(2);
            *mean += grid.control_volume(d, at) * u[index] / 24.0;
        });
    }
    (solver, energy, mean)
}

#[test]
fn a_grid_twice_as_fine_starts_with_the_same_flow_and_goes_on() {
    let folder = Folder::new("handover-finer");
    let (first, second) = (folder.write("first.toml", &first()), folder.write("second.toml", &second()));
    complete(&first, &folder.join("a"), &["--until", "0.5"]);
    let finer = ["domain.cells=[64, 96]"];
    let (coarse, energy, mean) = start(&second, &[]);
    let (fine, finer_energy, finer_mean) = start(&second, &finer);
    println!("kinetic energy {energy:.6} → {finer_energy:.6}, mean velocity {mean:?} → {finer_mean:?}");
    assert!(energy > 0.01 && (finer_energy / energy - 1.0).abs() < 0.01, "{energy} → {finer_energy}");
    let speed = (energy / 12.0).sqrt();
    assert!((0..2).all(|d| (finer_mean[d] - mean[d]).abs() < 0.02 * speed), "{mean:?} → {finer_mean:?}");
    let numbers = |solver: &Solver<2>| -> Vec<[[f64; 3]; 3]> {
        solver.motions().iter().map(|m| [m.centre, m.velocity, m.spin]).collect()
    };
    assert_eq!(numbers(&fine), numbers(&coarse));
    let rows: Vec<String> = grains(&folder.join("a"));
    assert_eq!(rows.len(), 1 + fine.motions().len());
    // The fluid in a grain has its velocity.
    for motion in fine.motions() {
        let (grid, u) = (fine.grid(), &fine.stepper().state().velocity[1]);
        let at = [motion.centre[0] / 0.0625, motion.centre[2] / 0.0625].map(|cell| cell as isize);
        let inside = u[grid.index(at)];
        let fall = motion.velocity[2];
        assert!((inside / fall - 1.0).abs() < 0.1, "{inside} in a grain that moves with {fall}");
    }
    let out = folder.join("c");
    let cells = ["--set", "domain.cells=[64, 96]", "--set", "fluid.time.dt=0.00390625", "--until", "0.125"];
    complete(&second, &out, &cells);
    assert_eq!(summary(&out)["status"], "completed");
    let falls: Vec<f64> =
        column(&out, "velocity_z[1]").iter().map(|v| v.parse().expect("a number")).collect();
    let before: Vec<f64> =
        column(&folder.join("a"), "velocity_z[1]").iter().map(|v| v.parse().expect("a number")).collect();
    let [last, next] = [before[before.len() - 1], falls[0]];
    println!("grain 1 falls with {last:.5}, then {:.5?}", &falls[..4]);
    assert!((next / last - 1.0).abs() < 0.02, "{last} then {next}");
}

/// A run that is to go on elsewhere is not emptied for it, not even with `--overwrite`.
#[test]
fn a_run_is_not_replaced_by_one_that_starts_from_it() {
    let folder = Folder::new("handover-onto");
    let (first, second) = (folder.write("first.toml", &first()), folder.write("second.toml", &second()));
    let a = folder.join("a");
    complete(&first, &a, &["--until", "0.125"]);
    let before = grains(&a);
    let onto = ["run", second.to_str().expect("UTF-8"), "--out", a.to_str().expect("UTF-8"), "--overwrite"];
    let output = bedload(&onto);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    let words = said(&output);
    assert!(words.contains("nothing was changed") && words.contains("a/grains.csv"), "{words}");
    assert_eq!(grains(&a), before);
    assert_eq!(summary(&a)["status"], "completed");
}

#[test]
fn check_names_the_folder_and_what_is_wrong_with_it() {
    let folder = Folder::new("handover-check");
    // Springs are the DEM's to look for.
    let text = second_without_fluid().replace("[[grain_files]]\nfile = \"a/grains.csv\"\n", "");
    let text = text
        .replace("initial_state = \"a\"", "")
        .replace("viscosity = 0.05\n", "viscosity = 0.05\ninitial = { type = \"run\", folder = \"a\" }\n");
    let scene = folder.write("scene.toml", &format!("{text}\n{GRAINS}"));
    let check = |words: &[&str]| {
        let output = bedload(&["check", scene.to_str().expect("UTF-8")]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        let said: String = said(&output).split_whitespace().collect::<Vec<_>>().join(" ");
        for word in ["medium.initial.folder", "scene.toml"].iter().chain(words) {
            assert!(said.contains(word), "no {word:?} in {said}");
        }
    };
    check(&["is no folder"]);
    std::fs::create_dir(folder.join("a")).expect("a folder");
    check(&["holds no scene.toml"]);
}

/// Two discs in a stream that leaves through a face; the first one is near it. Windows and ends are binary
/// numbers.
const LEAVING: &str = r#"
until = 0.29296875
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [0.08, 0.02]
cells = [64, 16]
[domain.boundary]
x_lower = { type = "inflow", velocity = [0.2, 0.0, 0.0], profile = "parabolic" }
x_upper = "outflow"
z = "no-slip"
[medium]
density = 1000.0
viscosity = 0.01
GRAINS
[fluid.time]
dt = 0.0009765625
[dem]
STATE
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 1e-3
"#;

#[test]
fn grains_leave_through_an_outflow_and_those_that_stay_go_on_and_start_another_run() {
    let folder = Folder::new("handover-leaving");
    let grain = |x: f64, z: f64| {
        format!("[[grains]]\nposition = [{x}, 0.0, {z}]\nradius = 0.004\ndensity = 1010.0\n")
    };
    let both = LEAVING.replace("GRAINS", &(grain(0.05, 0.01) + &grain(0.02, 0.008))).replace("STATE", "");
    let next = LEAVING
        .replace(
            "GRAINS",
            "initial = { type = \"run\", folder = \"a\" }\n[[grain_files]]\nfile = \"a/grains.csv\"\n",
        )
        .replace("STATE", "initial_state = \"a\"");
    let (first, second) = (folder.write("first.toml", &both), folder.write("second.toml", &next));
    let (a, b, whole) = (folder.join("a"), folder.join("b"), folder.join("whole"));
    complete(&first, &a, &["--until", "0.1953125"]);
    // The first is out, and keeps the velocity with which it left; the other is still in the stream.
    let left = grains(&a);
    assert!(left.len() == 2 && left[1].starts_with("1,"), "{left:?}");
    let speeds = column(&a, "velocity_x[0]");
    let places: Vec<f64> =
        column(&a, "position_x[0]").iter().map(|place| place.parse().expect("a number")).collect();
    let out = places.iter().position(|place| *place > 0.084).expect("it leaves");
    assert!(speeds.len() > out + 10 && speeds[out + 1..].iter().all(|speed| *speed == speeds[out + 1]));
    complete(&second, &b, &["--until", "0.048828125"]);
    assert_eq!(column(&b, "position_x[0]").len(), column(&b, "t").len());
    // Resumed, the other leaves, too: the same bits as in one go.
    complete(&first, &whole, &[]);
    complete(&first, &a, &["--resume"]);
    assert_eq!(grains(&a), grains(&whole));
    assert_eq!(grains(&a).len(), 1, "the head alone");
    assert_eq!(column(&a, "position_x[1]"), column(&whole, "position_x[1]"));
}

/// Discs that settle dry on the floor, to rest.
const BED: &str = r#"
until = 40.0
gravity = [0.0, 0.0, -1.0]
WHEN
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [6.0, 10.0]
boundary = { x = "no-slip", z = "no-slip" }
GRAINS
[dem]
STATE
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.3
contact_time = 0.02
friction = 0.5
rolling = { friction = 0.1 }
[observe]
every = 0.05
"#;

/// What rests on springs lets some of them go when walls are others: no speed that grains can have is called
/// unstable. A first state that is not there is refused before a finished run is replaced.
#[test]
fn a_bed_at_rest_goes_on_and_a_state_that_is_not_there_costs_no_run() {
    let folder = Folder::new("at-rest");
    let group = "[[groups]]\ncount = 20\nlower = [0.0, 0.0, 0.0]\nupper = [6.0, 0.0, 8.0]\nradius = 0.4\n\
                 radius_spread = 0.1\ndensity = 1.0\nseed = 2\n";
    let rests = "stop_when = { kinetic_energy_per_grain_below = 1e-6, after = 1.0 }";
    let settle = BED.replace("WHEN", rests).replace("GRAINS", group).replace("STATE", "");
    let settle = folder.write("settle.toml", &settle);
    complete(&settle, &folder.join("a"), &[]);
    let file = "[[grain_files]]\nfile = \"a/grains.csv\"\n";
    let on = BED.replace("WHEN", "").replace("GRAINS", file).replace("STATE", "initial_state = \"a\"");
    let on = folder.write("on.toml", &on);
    complete(&on, &folder.join("b"), &["--until", "1"]);

    let rows = std::fs::read(folder.join("b").join("series.csv")).expect("rows");
    let (scene, out) = (on.to_str().expect("UTF-8"), folder.join("b"));
    let out = out.to_str().expect("UTF-8");
    let nothing = "dem.initial_state=\"nowhere\"";
    let checked = bedload(&["check", scene, "--set", nothing]);
    assert!(
        checked.status.code() == Some(2) && said(&checked).contains("dem.initial_state"),
        "{}",
        said(&checked)
    );
    let again = bedload(&["run", scene, "--until", "1", "--out", out, "--overwrite", "--set", nothing]);
    assert_eq!(again.status.code(), Some(2), "{}", said(&again));
    assert!(
        std::fs::read(folder.join("b").join("series.csv")).is_ok_and(|now| now == rows),
        "the run is gone"
    );
}

/// A scene whose grains move otherwise than the state that it starts from would give the fluid another start
/// than the grains.
#[test]
fn a_motion_that_is_not_that_of_the_state_is_refused() {
    let folder = Folder::new("other-motion");
    complete(&folder.write("first.toml", &first()), &folder.join("a"), &["--until", "0.5"]);
    let table = std::fs::read_to_string(folder.join("a").join("grains.csv")).expect("a table");
    let mut rows: Vec<Vec<String>> = Vec::new();
    for line in table.lines().filter(|line| !line.starts_with('#')) {
        rows.push(line.split(',').map(str::to_owned).collect());
    }
    let column = rows[0].iter().position(|name| name == "vz").expect("a column");
    rows[1][column] = "-0.25".to_owned();
    let text: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    folder.write("moved.csv", &text.join("\n"));
    let scene = folder.write("second.toml", &second().replace("a/grains.csv", "moved.csv"));
    let output = bedload(&["check", scene.to_str().expect("UTF-8")]);
    assert!(output.status.code() == Some(2) && said(&output).contains("velocity"), "{}", said(&output));
}
