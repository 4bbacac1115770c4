//! Makes the coupler's `accuracy/data/*.toml` and `bounds/drag.toml` from docs/charts and the scenes, and
//! checks that they are the same. Compiled for tests only.

use std::path::{Path, PathBuf};

use bedload_scene::{CheckedScene, SceneSource};

use coupler::accuracy::{Charted, Class, Run};
use coupler::bounds::DragChart;
use coupler::{keys, resolution};

use crate::kind::Kind;
use crate::study::Study;
use crate::table::{Row, Table, parse_csv};

/// Columns that refine: a run with more of it is finer.
const REFINE: [&str; 2] = ["resolution", keys::CONTACT_STEPS];

/// Columns that vary the physics and not the method.
const CASES: [&str; 2] = ["case", "until"];

/// The runs that have an error and a cost, but for one that is the reference itself: its error, 0, says
/// nothing.
fn measured(table: &Table) -> Vec<Run> {
    let refining = table.keys.iter().position(|key| REFINE.contains(&key.as_str()));
    let run = |(number, row): (usize, &Row)| {
        let others = table.keys.iter().zip(&row.values).enumerate();
        let others = others
            .filter(|(column, (key, _))| Some(*column) != refining && !CASES.contains(&key.as_str()))
            .map(|(_, (_, value))| value.clone());
        Some(Run {
            label: row.label.clone(),
            cost: row.cpu?.median,
            error: row.error.filter(|error| *error > 0.0 && error.is_finite())?,
            fineness: refining.and_then(|column| table.number(number, column)).unwrap_or(0.0),
            others: others.collect(),
            ..Run::default()
        })
    };
    table.rows.iter().enumerate().filter_map(run).collect()
}

/// The data of a class, anew.
fn made(class: Class, root: &Path, scene: &str) -> Charted {
    let source = SceneSource::read(&root.join(scene), &[]).unwrap();
    let base = CheckedScene::new(source.clone()).unwrap();
    let points = Study::of_scene(&base, &root.join(scene), Kind::Chart).unwrap().points;
    let file = class.chart_file();
    let mut runs = measured(&Table::read(&root.join(&file)).unwrap());
    for run in &mut runs {
        let point = points.iter().find(|point| point.label == run.label).expect(&run.label);
        let scene = CheckedScene::new(source.clone().with_overrides(&point.set).unwrap()).unwrap();
        assert_eq!(Class::of(&scene), Ok(class), "{}", run.label);
        let numbers = class.numbers(&scene);
        assert!(numbers.iter().all(|number| number.value.is_finite()), "{}: {numbers:?}", run.label);
        run.numbers = numbers.iter().map(|number| number.value).collect();
        run.resolution = resolution::of(&scene);
        let dt = keys::look_up(&scene, keys::FLUID_DT).and_then(toml::Value::as_float);
        run.step = dt.zip(class.time(&scene)).map(|(dt, time)| dt / time);
        run.set.clone_from(&point.set);
    }
    let stale = stale(&file, root);
    Charted { scene: scene.to_owned(), table: file, stale, runs }
}

/// Why a table is stale, if it is.
fn stale(file: &str, root: &Path) -> Option<String> {
    let evidence = std::fs::read_to_string(root.join(crate::evidence::FILE)).unwrap();
    let (_, tables) = parse_csv(&evidence).unwrap();
    let known = tables.iter().find(|cells| cells[0] == file).expect(file);
    known.last().filter(|stale| !stale.is_empty()).cloned()
}

/// The chart of a towed sphere: every run with an error, whatever else was varied.
fn drag(root: &Path) -> DragChart {
    let file = "docs/charts/towed-sphere.csv";
    let table = Table::read(&root.join(file)).unwrap();
    let [re, resolution] =
        ["Re", "resolution"].map(|key| table.keys.iter().position(|other| other == key).expect(key));
    let row = |(number, row): (usize, &Row)| {
        let error = row.error.filter(|error| error.is_finite())?;
        Some([table.number(number, re)?, table.number(number, resolution)?, error])
    };
    let rows: Vec<[f64; 3]> = table.rows.iter().enumerate().filter_map(row).collect();
    DragChart::new(file, stale(file, root), &rows)
}

/// `made` as the text of a file that the coupler holds; written where `BEDLOAD_MAKE_DATA` is set.
fn written<T: serde::Serialize>(made: &T, path: &Path) -> bool {
    let asked = std::env::var_os("BEDLOAD_MAKE_DATA").is_some();
    if asked {
        let text = format!("# Made by a test, study/src/made.rs.\n{}", toml::to_string(made).unwrap());
        std::fs::write(path, text).unwrap();
    }
    asked
}

#[test]
fn runs_with_an_error_and_a_cost_count_but_for_the_reference() {
    let text = "case,method,resolution,cpu_s,error,pareto,label\nslow,good,8,4.0,0.01,0,b\n\
                slow,broken,8,1.0,,0,g\nslow,good,32,20.0,0,0,the reference\n";
    let runs = measured(&Table::parse(text).unwrap());
    assert_eq!(runs.len(), 1);
    assert_eq!(
        (runs[0].label.as_str(), runs[0].cost, runs[0].error, runs[0].fineness),
        ("b", 4.0, 0.01, 8.0)
    );
    assert_eq!(runs[0].others, ["good"], "not the case");
}

/// With `BEDLOAD_MAKE_DATA` set, writes them: `BEDLOAD_MAKE_DATA=1 cargo test -p bedload-study --lib made`.
#[test]
fn the_data_are_those_of_the_charts() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root: PathBuf = package.join("../..");
    if !root.join("docs/charts").is_dir() {
        return; // The package alone has no charts to compare with.
    }
    for class in Class::ALL {
        let stem = class.stem();
        let scene = &match class {
            Class::Collision => format!("scenes/{stem}.toml"),
            _ => format!("scenes/accuracy/{stem}.toml"),
        };
        let made = made(class, &root, scene);
        let name = Path::new(scene).file_name().unwrap();
        if written(&made, &package.join("../src/accuracy/data").join(name)) {
            continue;
        }
        let there = Charted::parse(class.data()).unwrap();
        assert_eq!(there, made, "{}: run this test with BEDLOAD_MAKE_DATA=1", made.scene);
    }
    let made = drag(&root);
    if !written(&made, &package.join("../src/bounds/drag.toml")) {
        let there = DragChart::parse(DragChart::TEXT).unwrap();
        assert_eq!(there, made, "run this test with BEDLOAD_MAKE_DATA=1");
    }
}
