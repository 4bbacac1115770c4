//! `bedload ensemble`: a chain of scenes over two seeds, made again, and with a seed that fails.

use std::path::{Path, PathBuf};

use bedload_output::Series;
use tests::harness::{Folder, bedload, is_stale, metric, said};

fn scene(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/ensemble").join(name);
    path.to_str().expect("UTF-8").to_owned()
}

/// Rows of `ensemble.csv` of a part: name, at, runs, mean, standard error.
fn rows(out: &Path, part: &str) -> Vec<(String, f64, u32, f64, f64)> {
    let text = std::fs::read_to_string(out.join("ensemble.csv")).expect("ensemble.csv");
    let number = |text: &str| text.parse().unwrap_or(f64::NAN);
    let cells = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let of_part = cells.filter(|cells| cells[0] == part);
    let row = |c: Vec<&str>| (c[1].to_owned(), number(c[2]), number(c[3]) as u32, number(c[4]), number(c[5]));
    of_part.map(row).collect()
}

fn modified(path: PathBuf) -> std::time::SystemTime {
    std::fs::metadata(&path).and_then(|data| data.modified()).expect("a file")
}

#[test]
fn each_seed_goes_its_own_way_from_bed_to_flow() {
    let folder = Folder::new("ensemble");
    let out = folder.join("out");
    let (bed, flow, to) = (scene("bed.toml"), scene("flow.toml"), out.to_str().expect("UTF-8"));
    let short = ["--until", "0.6", "--set", "observe.planes={ every = 0.1, from = 0.2 }"];
    let start = ["ensemble", &bed, &flow, "--seeds", "2", "--out", to, "--jobs", "1"];
    let all = [&start[..], &short, &["--set", "bed:stop_when.kinetic_energy_per_grain_below=1e-5"]].concat();
    let output = bedload(&all);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let run = |seed: u32, name: &str| out.join(format!("seed-{seed}/{name}"));
    let table = |seed: u32| std::fs::read_to_string(run(seed, "bed/grains.csv")).expect("a bed");
    assert_ne!(table(0), table(1), "each seed has its bed");
    for seed in 0..2 {
        let started = std::fs::read_to_string(run(seed, "flow/scene.toml")).expect("scene.toml");
        assert!(started.contains(&format!("seed-{seed}/bed/grains.csv")), "{started}");
    }
    // The mean of two values, and half their distance.
    let by_hand = |a: f64, b: f64| (0.5 * (a + b), 0.5 * (a - b).abs());
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (a.abs() + b.abs());
    let metrics = rows(&out, "metric");
    let moved = metrics.iter().find(|row| row.0 == "mean_grain_velocity").expect("the metric");
    let values = [0, 1].map(|seed| metric(&run(seed, "flow"), "mean_grain_velocity"));
    let (mean, error) = by_hand(values[0], values[1]);
    assert!(moved.2 == 2 && near(moved.3, mean) && near(moved.4, error) && error > 0.0, "{moved:?}");
    let series = [0, 1].map(|seed| Series::read(&run(seed, "flow/series.csv")).expect("series"));
    let last = |series: &Series, name: &str| *series.column(name).expect(name).last().expect("rows");
    let energy = rows(&out, "series").into_iter().rfind(|row| row.0 == "kinetic_energy").expect("energy");
    let [a, b] = [0, 1].map(|seed| last(&series[seed], "kinetic_energy"));
    if last(&series[0], "t") == last(&series[1], "t") {
        assert!(near(energy.3, by_hand(a, b).0) && near(energy.4, by_hand(a, b).1), "{energy:?}");
    }
    let profile = rows(&out, "planes");
    assert_eq!(profile.iter().filter(|row| row.0 == "solid_fraction").count(), 60);
    let svg = std::fs::read_to_string(out.join("ensemble.svg")).expect("ensemble.svg");
    assert!(svg.contains("fluid_velocity_x") && svg.contains("kinetic_energy"));

    // Nothing is made twice; what starts from a run that is made again is made again.
    let summary = |seed: u32, name: &str| modified(run(seed, name).join("summary.json"));
    let before = [summary(0, "bed"), summary(0, "flow"), summary(1, "flow")];
    let output = bedload(&all);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!([summary(0, "bed"), summary(0, "flow"), summary(1, "flow")], before);
    // As a run that was killed leaves it: it goes on from its checkpoint.
    std::fs::remove_file(run(1, "bed/summary.json")).expect("a summary");
    let output = bedload(&all);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("seed-1/bed: goes on"), "{}", said(&output));
    assert_eq!([summary(0, "bed"), summary(0, "flow")], before[..2]);
    assert!(summary(1, "flow") > before[2]);
    // A mean of all seeds is not one of those that still have a table.
    std::fs::remove_file(run(0, "flow/series.csv")).expect("a series");
    let output = bedload(&all);
    assert!(
        output.status.code() == Some(2) && said(&output).contains("flow/series.csv is missing"),
        "{output:?}"
    );
}

/// Discs that fall beside each other; grain 3 of some seeds finds no room beside the others.
const DISCS: &str = r#"
until = 0.2
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [6.0, 4.0]
boundary = { x = "no-slip", z_lower = "no-slip", z_upper = "free-slip" }
[[groups]]
count = 4
lower = [0.0, 0.0, 1.0]
upper = [5.2, 0.0, 2.01]
radius = 0.5
density = 1.0
seed = 1
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 1e-2
[[metrics]]
name = "height"
kind = "final"
column = "height"
"#;

#[test]
fn a_seed_that_fails_is_named_and_the_others_count() {
    let folder = Folder::new("ensemble-fails");
    let scene = folder.write("discs.toml", DISCS);
    let out = folder.join("out");
    let [scene, to] = [&scene, &out].map(|path| path.to_str().expect("UTF-8"));
    // With 6 the first does.
    for seed in [1, 6] {
        let set = format!("groups[0].seed={seed}");
        let output = bedload(&["ensemble", scene, "--seeds", "6", "--out", to, "--set", &set]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(1), "{text}");
        let failed: Vec<usize> = (0..6).filter(|seed| text.contains(&format!("seed-{seed}: "))).collect();
        assert!(!failed.is_empty() && failed.len() < 5 && failed.contains(&0) == (seed == 6), "{text}");
        assert!(
            text.contains(&format!("{} of 6 seeds failed", failed.len())) && text.contains("no room"),
            "{text}"
        );
        assert_eq!(rows(&out, "metric")[0].2 as usize, 6 - failed.len());
    }
    // Without any there is no table, of earlier runs neither.
    let output =
        bedload(&["ensemble", scene, "--seeds", "2", "--out", to, "--set", "dem.steps_per_contact=4"]);
    let text = said(&output);
    assert!(
        output.status.code() == Some(1) && text.contains("2 of 2 seeds failed; there is no table"),
        "{text}"
    );
    assert!(!out.join("ensemble.csv").exists() && !out.join("ensemble.svg").exists());
    // Where no seed has room the command is at fault.
    let output = bedload(&["ensemble", scene, "--seeds", "2", "--out", to, "--set", "groups[0].count=40"]);
    let text = said(&output);
    assert!(output.status.code() == Some(2) && text.contains("no room"), "{text}");
}

/// Grains without a fluid, whose settings `accuracy` chooses.
const GAS: &str = r#"
until = 0.002
accuracy = "5%"
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [0.02, 0.02, 0.02]
boundary = { x = "periodic", y = "periodic", z = "periodic" }
[[groups]]
count = 10
lower = [0.0, 0.0, 0.0]
upper = [0.02, 0.02, 0.02]
radius = 0.002
density = 2500.0
velocity_deviation = 0.1
seed = 1
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.87
contact_time = 1e-4
friction = 0.25
[[metrics]]
name = "energy"
kind = "final"
column = "kinetic_energy"
"#;

#[test]
fn runs_whose_settings_accuracy_chooses_are_known_again() {
    if is_stale("docs/charts/oblique-collision.csv") {
        return;
    }
    let folder = Folder::new("ensemble-accuracy");
    let (scene, out) = (folder.write("gas.toml", GAS), folder.join("out"));
    let [scene, to] = [&scene, &out].map(|path| path.to_str().expect("UTF-8"));
    for before in [0, 2] {
        let output = bedload(&["ensemble", scene, "--seeds", "2", "--out", to, "--jobs", "1"]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert_eq!(said(&output).matches("finished before").count(), before, "{}", said(&output));
    }
    assert_eq!(rows(&out, "metric")[0].2, 2);
}

#[test]
fn what_is_no_ensemble_is_refused() {
    let folder = Folder::new("ensemble-refused");
    let discs = folder.write("discs.toml", DISCS);
    let again = folder.write("again.toml", DISCS);
    let group = DISCS.find("[[groups]]").expect("a group")..DISCS.find("[dem.contact]").expect("a law");
    let one = "[[grains]]\nposition = [3.0, 0.0, 1.0]\nradius = 0.5\ndensity = 1.0\n";
    let alone = folder.write("alone.toml", &DISCS.replace(&DISCS[group], one));
    let wrong = folder.write("wrong.toml", &DISCS.replace("until", "untill"));
    for (scenes, seeds, words) in [
        (&[&alone][..], "2", "no scene has anything random"),
        (&[&discs, &again], "2", "starts from no scene before it"),
        (&[&discs, &discs], "2", "two scenes have the name discs"),
        (&[&wrong], "2", "untill"),
        (&[&discs], "1", "1 is not in 2..=1000"),
    ] {
        let scenes = scenes.iter().map(|path| path.to_str().expect("UTF-8"));
        let out = folder.join("out");
        let more = ["--seeds", seeds, "--out", out.to_str().expect("UTF-8")];
        let output = bedload(&["ensemble"].into_iter().chain(scenes).chain(more).collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(words), "{words}: {}", said(&output));
    }
    // A prefix that is no scene: at once, not once per seed; a value may have a colon.
    let set = |text: &str| {
        let discs = discs.to_str().expect("UTF-8");
        bedload(&["ensemble", discs, "--seeds", "2", "--out", "/dev/null/out", "--set", text])
    };
    let output = set("fl:until=0.1");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("no scene is called fl; the scenes are: discs"), "{}", said(&output));
    assert!(!said(&set("title=\"a:b\"")).contains("no scene is called"));
}
