//! Makes the coupler's `accuracy/data/*.toml` from docs/charts and the scenes, and checks that they are the
//! same. Compiled for tests only.

use std::path::{Path, PathBuf};

use bedload_scene::{CheckedScene, SceneSource};

use coupler::accuracy::{Charted, Class, measured};
use coupler::{keys, resolution};

use crate::kind::Kind;
use crate::study::Study;
use crate::table::parse_csv;

/// The data of a class, anew.
fn made(class: Class, root: &Path, scene: &str) -> Charted {
    let source = SceneSource::read(&root.join(scene), &[]).unwrap();
    let base = CheckedScene::new(source.clone()).unwrap();
    let points = Study::of_scene(&base, &root.join(scene), Kind::Chart).unwrap().points;
    let file = class.chart_file();
    let table = std::fs::read_to_string(root.join(&file)).expect(&file);
    let (header, rows) = parse_csv(&table).unwrap();
    let mut runs = measured(&header, &rows).unwrap();
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
    let evidence = std::fs::read_to_string(root.join(crate::evidence::FILE)).unwrap();
    let (_, tables) = parse_csv(&evidence).unwrap();
    let known = tables.iter().find(|cells| cells[0] == file).expect(&file);
    let stale = known.last().filter(|stale| !stale.is_empty()).cloned();
    Charted { scene: scene.to_owned(), table: file, stale, runs }
}

/// With `BEDLOAD_MAKE_DATA` set, writes them.
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
        if std::env::var_os("BEDLOAD_MAKE_DATA").is_some() {
            let name = Path::new(scene).file_name().unwrap();
            let text = format!("# Made by a test, accuracy/made.rs.\n{}", toml::to_string(&made).unwrap());
            std::fs::write(package.join("../src/accuracy/data").join(name), text).unwrap();
            continue;
        }
        let there = Charted::parse(class.data()).unwrap();
        assert_eq!(there, made, "{}: run this test with BEDLOAD_MAKE_DATA=1", made.scene);
    }
}
