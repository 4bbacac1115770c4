//! Insertions, rough walls, copies and hand-over from run to run, through the participant.
use bedload_program::alone::StandIn;
use bedload_scene::{CheckedScene, Motion, Rest, SceneError, SceneSource};
use dem_solver::config::Config;
use dem_solver::participant::DemParticipant;
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Participant, Window};
use std::path::Path;

const BOX: &str = "until = 10.0\ngravity = [0.0, 0.0, -9.81]\n\
    [domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [1.0, 1.0, 3.0]\n\
    boundary = { x = \"no-slip\", y = \"no-slip\", z = \"no-slip\" }\n\
    [dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.3\ncontact_time = 0.002\nfriction = 0.5\n";
const INSERTION: &str = "[[insertions]]\ncount = 60\nlower = [0.1, 0.1, 2.0]\nupper = [0.9, 0.9, 2.9]\nradius = 0.08\n\
    radius_spread = 0.2\ndensity = 1000.0\nvelocity = [0.0, 0.0, -1.0]\nrate = 200.0\nstart = 0.1\nseed = 4\n";

fn read(text: &str) -> Result<CheckedScene, SceneError> {
    CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.into() })
}

/// A large grain far away takes nothing from the film between small ones: four cells, at most 0.8 R.
#[test]
fn the_default_film_of_small_grains_is_theirs_beside_large_ones() {
    let film = |more: &str, pair: [f64; 2]| {
        let text = format!(
            "{}[medium]\ndensity = 1.0\nviscosity = 1.0\n[[grains]]\nposition = [0.3, 0.3, 0.3]\nradius = 0.05\n\
             density = 2.0\n{more}",
            BOX.replace("boundary", "cells = [100, 100, 300]\nboundary")
        );
        let spec = Config::new(&read(&text).expect("a scene")).expect("reads").spec;
        (spec.lubrication_model().expect("a film").law(pair[0], pair[1]).cut_off, spec.range())
    };
    let large = "[[grains]]\nposition = [0.5, 0.5, 2.0]\nradius = 0.4\ndensity = 2.0\nmotion = \"fixed\"\n";
    let small = "[[grains]]\nposition = [0.8, 0.8, 0.3]\nradius = 0.02\ndensity = 2.0\n";
    let near = |found: (f64, f64), wanted: [f64; 2]| {
        assert!((found.0 - wanted[0]).abs() < 1e-15 && (found.1 - wanted[1]).abs() < 1e-15, "{found:?}");
    };
    near(film("", [0.05, f64::INFINITY]), [0.04, 0.04]);
    near(film(large, [0.05, f64::INFINITY]), [0.04, 0.04]);
    near(film(large, [0.05, 0.4]), [0.04, 0.04]);
    near(film(small, [0.02, 0.02]), [0.016, 0.04]);
    near(film(small, [0.05, 0.05]), [0.04, 0.04]);
}

/// An empty folder, gone when the value is dropped.
struct Folder(tempfile::TempDir);

impl std::ops::Deref for Folder {
    type Target = Path;
    fn deref(&self) -> &Path {
        self.0.path()
    }
}

fn folder() -> Folder {
    Folder(tempfile::tempdir().expect("makes"))
}

struct Run {
    solver: DemParticipant,
    exchange: StandIn<Loads, Kinematics>,
    step: u64,
}

impl Run {
    fn new(scene: &CheckedScene, out: &Path) -> Self {
        let solver = DemParticipant::new(scene, out).expect("builds");
        let exchange = StandIn::new(solver.grains(), bedload_program::alone::buoyancy(scene));
        Self { solver, exchange, step: 0 }
    }

    fn go(&mut self, windows: u64) {
        for _ in 0..windows {
            let time = 0.01 * self.step as f64;
            let window = Window { step: self.step, attempt: 0, time, dt: 0.01, substeps: 100, output: false };
            self.solver.advance(&window, &mut self.exchange).expect("advances");
            self.step += 1;
        }
    }

    fn there(&self) -> usize {
        self.exchange.outgoing().1.iter().filter(|motion| motion.orientation != [0.0; 4]).count()
    }
}

#[test]
fn grains_come_at_their_rate_without_overlap_and_rest() {
    let scene = read(&format!("{BOX}stop = 1\n").replace("stop = 1\n", INSERTION)).expect("reads");
    assert_eq!((scene.present(), scene.grains.len()), (0, 60));
    let mut run = Run::new(&scene, &folder());
    run.go(10);
    assert_eq!(run.there(), 0, "the first is due at t = 0.1");
    run.go(10);
    let early = run.there();
    assert!((15..=20).contains(&early), "{early} of 20 due by t = 0.19");
    run.go(60);
    assert_eq!(run.there(), 60);
    let radius: Vec<f64> = scene.grains.iter().map(|grain| grain.radius).collect();
    assert!(radius.iter().all(|r| (0.064..=0.096).contains(r)) && radius[0] != radius[1]);
    run.go(400);
    // One that lies alone on the smooth floor rolls on: 1e-8 is for beds.
    let text = format!("stop_when = {{ kinetic_energy_per_grain_below = 1e-4 }}\n{BOX}{INSERTION}");
    let rest = Rest::new(&read(&text).expect("reads")).expect("asked for");
    let last = run.exchange.outgoing().1;
    let energy = rest.energy(last).expect("all are there");
    let mut since = None;
    assert!(!rest.reached(5.0, last, &mut since), "not at once");
    assert!(rest.reached(6.0, last, &mut since), "{energy}");
    let mut moving = last.to_vec();
    moving[3].velocity[0] = 1.0;
    assert!(!rest.reached(7.0, &moving, &mut since) && !rest.reached(8.0, last, &mut since));
    moving[59].orientation = [0.0; 4];
    assert_eq!(rest.energy(&moving), None, "one is still to come");
}

#[test]
fn a_region_rises_with_the_bed() {
    let low = INSERTION
        .replace("2.0]", "0.2]")
        .replace("2.9]", "0.6]")
        .replace("rate", "rise = [0.0, 0.0, 5.0]\nrate");
    let scene =
        read(&format!("{BOX}{low}").replace("gravity = [0.0, 0.0, -9.81]", "gravity = [0.0, 0.0, 0.0]"))
            .expect("reads");
    let mut run = Run::new(&scene, &folder());
    run.go(41);
    assert_eq!(run.there(), 60);
    // No gravity: each falls at 1 m/s from where it appeared, 5 m/s higher the later.
    for (number, motion) in run.exchange.outgoing().1.iter().enumerate() {
        let due = 0.1 + number as f64 / 200.0;
        let (fallen, shift) = (run.solver.dem().time() - due, 5.0 * (due - 0.1));
        let appeared = motion.position[2] + fallen;
        assert!(
            motion.velocity[2] != -1.0 || (appeared - shift - 0.4).abs() < 0.35,
            "{number}: {appeared} {shift}"
        );
    }
}

#[test]
fn a_full_region_delays_grains_and_loses_none() {
    let tight = INSERTION
        .replace("lower = [0.1, 0.1, 2.0]", "lower = [0.4, 0.4, 2.6]")
        .replace("upper = [0.9, 0.9", "upper = [0.62, 0.62");
    let scene = read(&format!("{BOX}{tight}")).expect("reads");
    let mut run = Run::new(&scene, &folder());
    run.go(41);
    let early = run.there();
    assert!(early < 30, "{early}: there is room for one at a time");
    run.go(600);
    assert_eq!(run.there(), 60);
}

#[test]
fn a_restart_while_inserting_has_the_same_bits() {
    let scene = read(&format!("{BOX}{INSERTION}")).expect("reads");
    let out = folder();
    let mut run = Run::new(&scene, &out);
    run.go(25);
    let there = run.there();
    assert!(there > 10 && there < 60, "{there}");
    run.solver.write_checkpoint(&out).expect("writes");
    run.solver.save();
    run.go(20);
    let expected = run.solver.dem().save();
    run.solver.restore();
    run.step = 25;
    run.go(20);
    assert_eq!(run.solver.dem().save(), expected, "repeated");
    let mut again = Run::new(&scene, &out);
    again.solver.read_checkpoint(&out).expect("reads");
    again.step = 25;
    again.go(20);
    assert_eq!(again.solver.dem().save(), expected, "restarted");
}

/// `--threads` reaches the bulk engine, also while grains join, and changes no bit.
#[test]
fn threads_of_a_run_are_those_of_its_pool() {
    let insertion =
        INSERTION.replace("60", "9000").replace("0.08", "0.02").replace("rate = 200.0", "rate = 40000.0");
    let scene = read(&format!("{BOX}{insertion}[observe]\ngrains = []\n")).expect("reads");
    let go = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("builds");
        pool.install(|| {
            let mut run = Run::new(&scene, &folder());
            run.go(50);
            (run.solver.dem().threads(), run.solver.dem().save())
        })
    };
    let ((one, expected), (two, state)) = (go(1), go(2));
    assert_eq!((one, two), (1, 2), "{} grains", expected.position.len());
    assert!(state == expected);
}

/// Enough grains for several blocks, fixed ones among them, that join the bulk engine in place.
#[test]
fn a_restart_while_inserting_into_blocks_has_the_same_bits() {
    let layer = "[[rough_walls]]\nlower = [0.0, 0.0, 0.05]\nupper = [1.0, 1.0, 0.05]\nradius = 0.02\ndensity = 1000.0\n\
                 seed = 3\n[observe]\ngrains = []\n";
    let insertion =
        INSERTION.replace("60", "4000").replace("0.08", "0.02").replace("rate = 200.0", "rate = 6000.0");
    let scene = read(&format!("{BOX}{insertion}{layer}")).expect("reads");
    assert!(scene.present() > 512, "{}", scene.present());
    let out = folder();
    let mut run = Run::new(&scene, &out);
    run.go(40);
    let there = run.solver.dem().grains.len() - scene.present();
    assert!(run.solver.dem().is_bulk() && there > 1100 && there < 3000, "{there}");
    run.solver.write_checkpoint(&out).expect("writes");
    let order = run.solver.dem().save().order;
    run.go(30);
    let expected = run.solver.dem().save();
    assert!(expected.position.len() > order.len() + 512);
    let mut again = Run::new(&scene, &out);
    again.solver.read_checkpoint(&out).expect("reads");
    assert_eq!(again.solver.dem().save().order, order);
    again.step = 40;
    again.go(30);
    assert!(again.solver.dem().save() == expected, "restarted");
}

#[test]
fn layers_cover_their_rectangle() {
    let layer = "[[rough_walls]]\nlower = [0.0, 0.0, 0.5]\nupper = [1.0, 1.0, 0.5]\nradius = 0.05\n\
        radius_spread = 0.1\n\
                 density = 1.0\nseed = 3\n";
    let scene = read(&format!("{BOX}{layer}")).expect("reads");
    // rows of 11 and 10 sites at a distance of 0.1·√3/2: 12 rows in 1 m
    assert_eq!(scene.grains.len(), 6 * 11 + 6 * 10);
    assert!(scene.grains.iter().all(|grain| grain.motion == Motion::Fixed && grain.position[2] == 0.5));
    let square = format!("{BOX}{layer}arrangement = \"square\"\nspacing = 0.25\n");
    assert_eq!(read(&square).expect("reads").grains.len(), 25);
    for (from, to, key, words) in [
        ("upper = [1.0, 1.0, 0.5]", "upper = [1.0, 1.0, 0.6]", "rough_walls[0].upper", "rectangle"),
        ("radius_spread = 0.1", "radius_spread = 1.0", "rough_walls[0].radius_spread", "spread < 1"),
        ("radius = 0.05", "radius = 0.05\nspacing = 0.0", "rough_walls[0].spacing", "> 0"),
        ("radius = 0.05", "radius = 0.05\nspacing = 1e-9", "rough_walls", "more than"),
        ("upper = [1.0, 1.0, 0.5]", "upper = [1.5, 1.0, 0.5]", "rough_walls", "outside the box"),
    ] {
        let error = read(&format!("{BOX}{}", layer.replace(from, to))).expect_err(to);
        assert!(error.key == key && error.message.contains(words), "{to}: {error}");
    }
}

#[test]
fn bad_insertions_and_stops_are_refused() {
    for (from, to, key, words) in [
        ("radius_spread = 0.2", "radius_spread = 1.0", "insertions[0].radius_spread", "spread < 1"),
        ("rate = 200.0", "rate = 0.0", "insertions[0].rate", "> 0"),
        ("start = 0.1", "start = -1.0", "insertions[0].start", "≥ 0"),
        ("upper = [0.9, 0.9, 2.9]", "upper = [0.9, 0.9, 3.9]", "insertions[0].upper", "outside the box"),
        (
            "start = 0.1",
            "start = 0.1\nrise = [0.0, 0.0, 0.4]",
            "insertions[0].upper",
            "outside the box, moving",
        ),
        ("upper = [0.9, 0.9, 2.9]", "upper = [0.2, 0.9, 2.9]", "insertions[0].upper", "no room"),
        (
            "until = 10.0",
            "until = 10.0\nstop_when = { kinetic_energy_per_grain_below = 0.0 }",
            "stop_when.kinetic_energy_per_grain_below",
            "> 0",
        ),
        (
            "gravity = [0.0, 0.0, -9.81]",
            "stop_when = { kinetic_energy_per_grain_below = 1.0 }",
            "stop_when",
            "no gravity",
        ),
    ] {
        let error = read(&format!("{BOX}{INSERTION}").replace(from, to)).expect_err(to);
        assert!(error.key == key && error.message.contains(words), "{to}: {error}");
    }
}

/// A few grains that have come to rest, and the folder that they left.
fn settled() -> (Run, Folder) {
    let scene = read(&format!("{BOX}{INSERTION}")).expect("reads");
    let out = folder();
    let mut run = Run::new(&scene, &out);
    run.go(300);
    run.solver.write_checkpoint(&out.join("checkpoint")).expect("writes");
    (run, out)
}

#[test]
fn a_table_of_grains_reads_back_to_the_same_bits_and_a_damaged_one_is_refused() {
    let (run, out) = settled();
    let dem = run.solver.dem();
    let text = dem_solver::output::grain_files::table(dem.time(), &dem.grains, run.solver.spec(), &[]);
    let file = out.join("grains.csv");
    let with = |text: &str, more: &str| {
        std::fs::write(&file, text).expect("writes");
        read(&format!("{BOX}[[grain_files]]\nfile = {:?}\n{more}", file.display().to_string()))
    };
    let scene = with(&text, "").expect("reads");
    let next = Run::new(&scene, &out);
    assert_eq!(next.solver.dem().grains.position, dem.grains.position);
    assert_eq!(next.solver.dem().grains.velocity, dem.grains.velocity);
    assert_eq!(next.solver.dem().grains.spin, dem.grains.spin);
    assert_eq!(next.solver.dem().grains.mass, dem.grains.mass);
    let line = text.lines().nth(5).expect("a grain").to_owned();
    let cells: Vec<&str> = line.split(',').collect();
    let put = |place: usize, value: &str| {
        let mut cells = cells.clone();
        cells[place] = value;
        text.replace(&line, &cells.join(","))
    };
    let cut = &text[..text.len() * 2 / 3];
    let whole_lines = &cut[..=cut.rfind('\n').expect("lines")];
    for (damaged, words) in [
        (put(1, "NaN"), "`NaN` in column x is not a finite number"),
        (put(4, "-0.1"), "allowed: a finite number > 0"),
        (put(3, "7.0"), "outside the box"),
        (put(12, "flying"), "allowed: free, fixed"),
        (whole_lines.to_owned(), "says that it holds 60 grains"),
        (cut.to_owned(), "grains.csv:"),
        ("PK\u{3}\u{4}".to_owned(), "has no column `x`"),
        (String::new(), "is empty"),
    ] {
        let error = with(&damaged, "").expect_err(words);
        assert!(error.message.contains(words), "{words}: {error}");
    }
    std::fs::write(&file, [0xff, 0xfe, 0x00]).expect("writes");
    let binary = read(&format!("{BOX}[[grain_files]]\nfile = {:?}\n", file.display().to_string()));
    assert!(binary.expect_err("binary").message.contains("is not text"));
    let close = "x,y,z,radius,density\n0.5,0.5,0.5,0.1,1.0\n0.5,0.5,0.69,0.1,1.0\n";
    assert!(with(close, "").expect_err("overlap").message.contains("allowed: 1 %"));
    let twice = with("x,y,z,radius,density\n0.5,0.5,0.5,0.1,1.0\n", "copies = 3\nshift = [0.0, 0.0, 0.25]\n");
    let heights: Vec<f64> = twice.expect("reads").grains.iter().map(|grain| grain.position[2]).collect();
    assert_eq!(heights, [0.5, 0.75, 1.0]);
}

#[test]
fn a_run_starts_from_the_state_of_another_with_its_springs() {
    let (run, out) = settled();
    let text = format!("{BOX}{INSERTION}");
    let from = |text: &str, out: &Path| {
        let key = format!("[dem]\ninitial_state = {:?}\n[dem.contact]", out.display().to_string());
        let scene = read(&text.replace("[dem.contact]", &key)).expect("reads");
        DemParticipant::new(&scene, out).err()
    };
    // The grains of the other scene are all there at the start: as many, from its table.
    let table = dem_solver::output::grain_files::table(0.0, &run.solver.dem().grains, run.solver.spec(), &[]);
    std::fs::write(out.join("grains.csv"), table).expect("writes");
    let again = format!("{BOX}[[grain_files]]\nfile = {:?}\n", out.join("grains.csv").display().to_string());
    let key = format!("[dem]\ninitial_state = {:?}\n[dem.contact]", out.display().to_string());
    let scene = read(&again.replace("[dem.contact]", &key)).expect("reads");
    let next = Run::new(&scene, &out);
    let (old, new) = (run.solver.dem().save(), next.solver.dem().save());
    assert_eq!((old.position, old.contacts), (new.position, new.contacts));
    assert_eq!((new.time, new.substeps, new.wall_contacts.len()), (0.0, 0, 0));
    // Two rows change places, with their ids and without; then a grain is another.
    let table = std::fs::read_to_string(out.join("grains.csv")).expect("there");
    let swapped = out.join("swapped.csv");
    let mut lines: Vec<&str> = table.lines().collect();
    let last = lines.len() - 1;
    lines.swap(last, last - 1);
    let elsewhere = again.replace("grains.csv", "swapped.csv");
    std::fs::write(&swapped, lines.join("\n")).expect("writes");
    let refused = from(&elsewhere, &out).expect("another order");
    assert!(refused.message.contains("has grain 58 of radius"), "{refused}");
    let cells: Vec<&str> = lines[last].split(',').collect();
    let denser = [&cells[..5], &["9.5"], &cells[6..]].concat().join(",");
    (lines[last], lines[last - 1]) = (lines[last - 1], &denser);
    std::fs::write(&swapped, lines.join("\n")).expect("writes");
    let refused = from(&elsewhere, &out).expect("another density");
    assert!(refused.message.contains("this scene has") && refused.message.contains("9.5 kg/m³"), "{refused}");
    let wrong = from(&text, &out).expect("none is there at the start");
    assert!(
        wrong.key == "dem.initial_state" && wrong.message.contains("holds 60 grains, this scene 0"),
        "{wrong}"
    );
    let missing = from(&again, &out.join("nowhere")).expect("no folder");
    assert!(missing.key == "dem.initial_state", "{missing}");
    let file = out.join("checkpoint/dem.checkpoint");
    let bytes = std::fs::read(&file).expect("there");
    std::fs::write(&file, &bytes[..bytes.len() / 2]).expect("writes");
    let cut = from(&again, &out).expect("cut short");
    assert!(cut.message.contains("truncated or damaged"), "{cut}");
    std::fs::write(&file, b"not a checkpoint at all, of whatever length it may be, 64 bytes..")
        .expect("writes");
    assert!(from(&again, &out).expect("foreign").message.contains("not a Bedload checkpoint"));
}

#[test]
fn retired_names_of_insertions_and_rough_walls_are_refused_with_the_new_ones() {
    for (old, new) in [("pours", "[[insertions]]"), ("layers", "[[rough_walls]]")] {
        let error = read(&format!("{BOX}[[{old}]]\nradius = 0.1\n")).expect_err(old);
        assert!(error.key.starts_with(old) && error.remedy.contains(new), "{error}");
    }
}

#[test]
fn a_fault_names_its_own_cause() {
    let out = folder();
    let pair = "[[grains]]\nposition = [0.25, 0.5, 1.0]\nradius = 0.2\ndensity = 1000.0\n\
                [[grains]]\nposition = [0.25, 0.5, 2.0]\nradius = 0.2\ndensity = 1000.0\n";
    let narrow = BOX.replace("upper = [1.0", "upper = [0.5").replace("x = \"no-slip\"", "x = \"periodic\"");
    let error = DemParticipant::new(&read(&format!("{narrow}{pair}")).expect("reads"), &out).err();
    let error = error.expect("images of a pair");
    assert!(!format!("{error} {}", error.remedy).contains("cut"), "a dry scene has no film: {error:?}");
    let fast = pair.replace("radius", "velocity = [0.0, 0.0, -400.0]\nradius");
    let soft = BOX.replace("contact_time = 0.002", "contact_time = 0.2");
    let mut run = Run::new(&read(&format!("{soft}{fast}")).expect("reads"), &out);
    let window = Window { step: 0, attempt: 0, time: 0.0, dt: 0.01, substeps: 100, output: false };
    let error = run.solver.advance(&window, &mut run.exchange).expect_err("through the floor").to_string();
    assert!(error.contains("dem.contact.contact_time") && !error.contains("[dem] dt"), "{error}");
}
