//! A run whose exchange alternates or grows ends as `unstable`, where a map says so, and nowhere else.

use std::path::{Path, PathBuf};

use bedload_output::{RunStatus, Summary};
use bedload_scene::{CheckedScene, SceneSource};
use study::kind::Kind;
use study::stability::classify::Class;
use study::stability::runs::imposed;
use study::study::Study;
use study::table::Table;
use tests::harness::{Folder, bedload, said};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// What every run of a map is told, but that the watch for alternation is left on.
fn told() -> Vec<String> {
    let told = imposed().map(|set| set.replace(", \"unstable\"", ""));
    assert!(told != imposed(), "the watch can be forced");
    told.to_vec()
}

/// Runs every `step`th run of a map; returns how many fired of those that should and of those that should
/// not, and which of the former did not.
fn fired(name: &str, first: usize, step: usize) -> ([(usize, usize); 2], Vec<String>) {
    let scene = root().join(format!("scenes/stability/{name}.toml"));
    let source = SceneSource::read(&scene, &[]).expect("a scene");
    let plan = Study::of_scene(&CheckedScene::new(source).expect("a scene"), &scene, Kind::Stability)
        .expect("a map");
    let table = Table::read(&root().join(format!("docs/maps/{name}.csv"))).expect("a table");
    let folder = Folder::new(&format!("unstable-{name}"));
    let (mut counts, mut missed) = ([(0, 0); 2], Vec::new());
    for point in plan.points.iter().skip(first).step_by(step) {
        let row = table.rows.iter().find(|row| row.label == point.label).expect("the map has the run");
        let out = folder.join("out");
        let words = |path: &Path| path.to_str().expect("UTF-8").to_owned();
        let mut arguments = vec![
            "run".to_owned(),
            words(&scene),
            "--out".into(),
            words(&out),
            "--overwrite".into(),
            "--threads".into(),
            "1".into(),
        ];
        for set in point.set.iter().chain(&told()) {
            arguments.extend(["--set".to_owned(), set.clone()]);
        }
        let output = bedload(&arguments);
        let should = row.class != Some(Class::Stable);
        let fires = output.status.code() == Some(4);
        assert!(should || !fires, "a false alarm: {}\n{}", row.label, said(&output));
        if should && !fires {
            missed.push(row.label.clone());
        }
        let summary = Summary::read(&out.join("summary.json")).expect("a summary");
        if fires {
            let error = summary.error.expect("an error");
            assert_eq!(summary.status, RunStatus::Unstable);
            assert!(error.contains("from window ") && error.contains("lower the fluid's dt"), "{error}");
        } else if !should {
            assert_eq!(summary.status, RunStatus::Completed, "{}", row.label);
        }
        let count = &mut counts[usize::from(!should)];
        *count = (count.0 + usize::from(fires), count.1 + 1);
    }
    (counts, missed)
}

#[test]
fn light_spheres_end_as_unstable_where_their_map_says_so_and_nowhere_else() {
    // 70 of the 140 runs: every other density ratio of each method and ν dt/D².
    let ([should, should_not], missed) = fired("light-axisymmetric", 0, 2);
    println!("fired {}/{}, false alarms {}/{}", should.0, should.1, should_not.0, should_not.1);
    assert!(should.1 >= 20 && should_not.1 >= 20, "{should:?} {should_not:?}");
    assert_eq!(should_not.0, 0);
    assert!(missed.is_empty(), "{missed:?}");
}
