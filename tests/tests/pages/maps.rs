//! The bounds of `check` against the committed maps: every run of `docs/maps/*.csv` is planned anew,
//! with the functions that `check` uses, and no run that failed may be accepted.

use std::path::{Path, PathBuf};

use bedload_scene::{CheckedScene, SceneSource};
use coupler::config::Coupling;
use coupler::plan::{Participants, Plan};
use dem_solver::config::Config;
use study::kind::Kind;
use study::stability::classify::Class;
use study::stability::counts::Counts;
use study::stability::runs::{held, imposed};
use study::study::Study;
use study::sweep::Point;
use study::table::{Row, Table};

/// A stable run may be refused only where its margin is above one over this; in maps that are not named here,
/// nowhere.
const MARGINS: [(&str, f64); 13] = [
    // With a mask bodies that are not round take the limits of discs, of which one that only turns fails
    // below 0.8 at ν dt/D² = 0.8; a body that falls does not.
    ("bodies", 80.1),
    // A run whose sphere is let go in windows of ν dt/D² = 0.8 ends as unstable below 0.3: not in these maps,
    // whose spheres are thrown.
    ("light-axisymmetric", 30.1),
    ("light-space", 30.1),
    // The same as of bodies, of a disc that falls.
    ("light-plane", 80.1),
    // With izard-2014 a disc that only turns is judged as one that falls: 2 for 1.5.
    ("light-rotation", 1.34),
    // The limits of one disc alone hold in a bed, too, whose discs hold each other.
    ("light-bed", 30.1),
    // Held by each other, discs of 0.01 are stable where one of 0.2 is not.
    ("fictitious-domain-bed", 50.1),
    // The volume fraction has the limits of a disc that falls, of which one along a wall fails less.
    ("light-wall", 30.1),
    // A grain at rest bears what a falling one does not: izard-2014 at 1.05 for 2; and windows of 300 contact
    // times, where 100 is the default that a scene may raise.
    ("resting", 3.01),
    // From 10 sub-steps on a rebound is right to 1 %; the map asks for 2 %, which 6 give always, 5 often
    // and 3 once.
    ("contact-steps", 3.34),
    // One number for all methods: izard-2014 bears 0.5 (AB2) and 1.4, calibrated 0.4 and 1.2.
    ("courant-plane", 1.26),
    // A stream goes round a sphere less fast than past a disc: 0.6 for 0.5, 1.6 for 1.2.
    ("courant-space", 1.34),
    // Between 0.15 and 0.192 nothing of the map fails.
    ("packing", 1.28),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Bounds of a run, as `check` has them: solvers asked in place, without processes.
fn plan(source: SceneSource) -> Plan {
    let scene = CheckedScene::new(source).unwrap_or_else(|error| panic!("{error}"));
    let participants = Participants::of(&scene);
    let facts = || fluid_solver::facts::facts(&scene).unwrap_or_else(|error| panic!("{error}"));
    let fluid = participants.has_fluid().then(facts);
    let dem =
        participants.has_dem().then(|| Config::new(&scene).unwrap_or_else(|error| panic!("{error}")).facts);
    let coupling = Coupling::read(&scene).unwrap_or_else(|error| panic!("{error}"));
    Plan::new(&scene, &coupling, fluid.as_ref(), dem.as_ref(), None).unwrap_or_else(|error| panic!("{error}"))
}

/// Names of the committed maps.
fn names() -> Vec<String> {
    let entries = std::fs::read_dir(root().join("docs/maps")).expect("docs/maps");
    let stem = |path: PathBuf| path.file_stem().map(|name| name.to_string_lossy().into_owned());
    let mut names: Vec<String> = entries.flatten().filter_map(|entry| stem(entry.path())).collect();
    names.sort();
    names
}

/// The rows of a map with margin and refusal as they are now.
///
/// # Panics
/// If the committed table says another refusal: it must be made anew.
fn judged_now(name: &str) -> Vec<Row> {
    let path = root().join(format!("scenes/stability/{name}.toml"));
    let source = SceneSource::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
    let scene = CheckedScene::new(source.clone()).unwrap_or_else(|error| panic!("{error}"));
    let map = Study::of_scene(&scene, &path, Kind::Stability).unwrap_or_else(|error| panic!("{error}"));
    let table =
        Table::read(&root().join(format!("docs/maps/{name}.csv"))).unwrap_or_else(|error| panic!("{error}"));
    let labels: Vec<&String> = table.rows.iter().map(|row| &row.label).collect();
    let points: Vec<&String> = map.points.iter().map(|point| &point.label).collect();
    assert_eq!(
        labels, points,
        "docs/maps/{name}.csv has not the runs of scenes/stability/{name}.toml: make it anew"
    );
    let now = |(row, point): (&Row, &Point)| {
        let set: Vec<String> = point.set.iter().cloned().chain(imposed()).collect();
        let source = source.clone().with_overrides(&set).unwrap_or_else(|error| panic!("{error}"));
        let (margin, refused) = held(&plan(source).bounds, &map.section.bound);
        assert_eq!(row.refused, refused, "{name}: {}: run `bedload stability` again", row.label);
        Row { margin: Some(margin), refused, ..row.clone() }
    };
    table.rows.iter().zip(&map.points).map(now).collect()
}

#[test]
fn check_refuses_every_run_that_failed_and_few_that_were_stable() {
    let mut total = Vec::new();
    let mut wrong = Vec::new();
    for name in names() {
        let rows = judged_now(&name);
        let counts = Counts::of(&rows);
        println!("{name}: {counts}");
        let margin = MARGINS.iter().find(|(map, _)| *map == name).map_or(1.0, |(_, margin)| *margin);
        for row in &rows {
            let accepted = row.class == Some(Class::Failed) && !row.refused;
            let near = row.margin.unwrap_or(f64::NAN) * margin >= 1.0 - 1e-9;
            let far = row.class == Some(Class::Stable) && row.refused && !near;
            if accepted || far {
                let words =
                    if accepted { "failed and accepted" } else { "stable and refused, far from the bound" };
                wrong.push(format!(
                    "{name}: {} ({words}; margin {:.3})",
                    row.label,
                    row.margin.unwrap_or(f64::NAN)
                ));
            }
        }
        total.extend(rows);
    }
    println!("all: {}", Counts::of(&total));
    assert!(wrong.is_empty(), "{} runs:\n{}", wrong.len(), wrong.join("\n"));
    assert!(total.len() > 1000, "only {} runs: the maps are missing", total.len());
}
