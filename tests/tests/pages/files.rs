//! Files that a scene names are looked up from the scene's folder, wherever the command runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bedload_scene::{CheckedScene, Motion, SceneSource};
use tests::harness::{Folder, program, said};

/// Two spheres of a table fall through a fluid.
const SCENE: &str = r#"
until = 0.05
gravity = [0.0, 0.0, -1.0]
grain_files = [{ file = "tables/two.csv" }]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [6.0, 3.0, 4.0]
cells = [36, 18, 24]
boundary = { x = "periodic", y = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.1
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.02
"#;

const TABLE: &str = "x,y,z,radius,density\n1,1,2,0.5,2\n4,1,2,0.5,2\n";

/// Runs `bedload` in a folder of its own.
fn bedload_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(program("bedload")).current_dir(folder).args(arguments).output().expect("bedload starts")
}

/// A folder with the scene in it and, below another one, a place to stand.
fn folders(name: &str) -> (Folder, PathBuf) {
    let folder = Folder::new(name);
    std::fs::create_dir_all(folder.join("scenes/tables")).expect("a folder");
    let elsewhere = folder.join("else/where");
    std::fs::create_dir_all(&elsewhere).expect("a folder");
    let _ = folder.write("scenes/two.toml", SCENE);
    let _ = folder.write("scenes/tables/two.csv", TABLE);
    (folder, elsewhere)
}

fn ends_well(output: &Output) {
    assert!(output.status.success(), "{}", said(output));
}

#[test]
fn a_run_its_log_its_checkpoint_and_its_resolved_scene_work_from_any_folder() {
    let (folder, elsewhere) = folders("files-run");
    ends_well(&bedload_in(&elsewhere, &["check", "../../scenes/two.toml"]));
    ends_well(&bedload_in(&elsewhere, &["run", "../../scenes/two.toml", "--out", "first"]));
    let series = |out: &str| std::fs::read_to_string(elsewhere.join(out).join("series.csv")).expect("series");
    // The log holds the resolved scene, and is read from where no table is.
    let top = folder.join("");
    ends_well(&bedload_in(&top, &["replay", "else/where/first/exchange.mcap", "--drive", "dem", "--verify"]));
    let again = ["run", "else/where/first/scene.toml", "--out", "else/where/again"];
    ends_well(&bedload_in(&top, &again));
    assert_eq!(series("first"), series("again"));
    let further = ["run", "scenes/two.toml", "--out", "else/where/first", "--resume", "--until", "0.1"];
    ends_well(&bedload_in(&top, &further));
    assert!(series("first").lines().count() > series("again").lines().count());
}

#[test]
fn a_table_that_is_not_there_is_named_as_it_was_looked_up() {
    let (folder, elsewhere) = folders("files-missing");
    // It is where the command runs, but that does not count.
    std::fs::write(elsewhere.join("three.csv"), TABLE).expect("a file");
    for command in ["check", "run"] {
        let set = ["--set", "grain_files[0].file=three.csv"];
        let output = bedload_in(&elsewhere, &[&[command, "../../scenes/two.toml"], &set[..]].concat());
        let words = said(&output).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{words}");
        assert!(words.contains("grain_files[0].file"), "{words}");
        assert!(words.contains("scenes/three.csv"), "{words}");
        assert!(words.contains("paths count from the scene's folder"), "{words}");
    }
    std::fs::copy(elsewhere.join("three.csv"), folder.join("scenes/three.csv")).expect("a copy");
    ends_well(&bedload_in(
        &elsewhere,
        &["check", "../../scenes/two.toml", "--set", "grain_files[0].file=three.csv"],
    ));
}

#[test]
fn a_cheaper_scene_names_its_files_from_any_folder() {
    let (_folder, elsewhere) = folders("files-cheaper");
    let full = ["--set", "coupling.substeps=\"full\""];
    let arguments = [&["check", "../../scenes/two.toml", "--cheaper", "one-sub-step"], &full[..]].concat();
    let output = bedload_in(&elsewhere, &arguments);
    ends_well(&output);
    std::fs::write(elsewhere.join("cheaper.toml"), &output.stdout).expect("a file");
    ends_well(&bedload_in(&elsewhere, &["check", "cheaper.toml"]));
}

#[test]
fn the_scenes_of_this_repository_find_their_files_from_any_folder() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let elsewhere = Folder::new("files-ours");
    let mut with_files = 0;
    for folder in [scenes.clone(), scenes.join("bench")] {
        for entry in std::fs::read_dir(folder).expect("scenes").flatten() {
            let path = entry.path();
            let text = std::fs::read_to_string(&path).unwrap_or_default();
            if path.extension().is_some_and(|end| end == "toml") && text.contains("\nfile = ") {
                with_files += 1;
                let scene = path.to_str().expect("UTF-8");
                ends_well(&bedload_in(
                    &elsewhere.join(""),
                    &["check", scene, "--set", "coupling.force=[\"memory\"]"],
                ));
            }
        }
    }
    assert!(with_files >= 8, "{with_files} scenes name files");
}

#[test]
fn the_regime_of_the_inclined_bed_is_that_of_its_scene() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let source = SceneSource::read(&root.join("scenes/inclined-bed.toml"), &[]).expect("a scene");
    let scene = CheckedScene::new(source).expect("a scene");
    let medium = scene.scene.medium.as_ref().expect("a fluid");
    let grain = scene.grains.iter().find(|grain| grain.motion == Motion::Free).expect("a free grain");
    let along = scene.scene.gravity.at(0.0)[0];
    // The paper's D is 1: the mean of sizes within 5 %.
    let stokes = (grain.density * (grain.density - medium.density) * along).sqrt()
        / (18.0 * 2.0f64.sqrt() * medium.viscosity);
    let ratio = (grain.density / medium.density).sqrt();
    let page = std::fs::read_to_string(root.join("docs/inclined-bed.md")).expect("a page");
    let words = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for told in [
        format!("= {stokes:.2} and"),
        format!("= {ratio:.2},"),
        format!("St/r = {:.2} < 2.5", stokes / ratio),
    ] {
        assert!(words.contains(&told), "{told}");
    }
}
