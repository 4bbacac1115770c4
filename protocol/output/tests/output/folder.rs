//! The output folder: made, replaced, refused, resumed; an observer on it.

use std::fs;

use bedload_output::{
    Observer, OutputError, OutputFolder, RunStatus, Sample, Series, Sides, Summary, atomic_write,
};
use bedload_scene::CheckedScene;
use protocol::message::{Header, Loads};

use crate::stage::{falling, fresh, scene, sphere, window};

#[test]
fn the_resolved_scene_is_a_scene_and_the_same_one() {
    let root = fresh("resolved").join("run");
    let scene_read = sphere("locked = []\n");
    let folder = OutputFolder::create(&root, &scene_read, false).expect("creates");
    let sections = ["cfl = 0.5", "contact_time = 1e-3", "scheme = \"explicit\""];
    let sections = sections.map(|text| text.parse::<toml::Table>().expect("a table"));
    folder.write_scene(&scene_read, sections.each_ref().map(Some)).expect("writes");
    let text = fs::read_to_string(folder.scene()).expect("text");
    assert_eq!(bedload_output::state_of(&text), Some(scene_read.state_sha256().as_str()));
    assert_eq!(bedload_output::state_of(text.split_once('\n').expect("lines").1), None, "without the marker");
    let again = scene(&text);
    assert_eq!(again.grains, scene_read.grains);
    assert_eq!(again.scene.observe.grains, Some(vec![0]));
    assert_eq!(again.scene.fluid["cfl"].as_float(), Some(0.5));
    assert_eq!(again.scene.dem["contact_time"].as_float(), Some(1e-3));
    assert_eq!(again.scene.coupling["scheme"].as_str(), Some("explicit"));
}

#[test]
fn a_run_is_replaced_and_foreign_files_stay() {
    let root = fresh("replace");
    let folder = OutputFolder::create(&root, &sphere(""), false).expect("creates");
    let ours = [
        folder.summary(),
        folder.series(),
        folder.log(),
        folder.report(),
        folder.film(),
        folder.film_mp4(),
        folder.frame(3),
        folder.fields().join("fluid_00000001.vtr"),
        folder.checkpoint().join("fluid.checkpoint"),
        root.join("coarse-grain.csv"),
        root.join("verify-2/series.csv"),
    ];
    let foreign = [
        root.join("notes.txt"),
        folder.fields().join("movie.mp4"),
        folder.checkpoint().join("mine.txt"),
        folder.frames().join("mine.png"),
        root.join("verify-2/mine.txt"),
        root.join("verify-3/mine.txt"),
        root.join("verify-all/series.csv"),
    ];
    for grid in ["verify-1", "verify-2"] {
        drop(OutputFolder::create(&root.join(grid), &sphere(""), false).expect("creates"));
    }
    for made in ["film", "verify-3", "verify-all"] {
        fs::create_dir(root.join(made)).expect("makes");
    }
    for path in ours.iter().chain(&foreign) {
        fs::write(path, "x").expect("writes");
    }
    let error = OutputFolder::create(&root, &sphere(""), false).expect_err("in use");
    assert!(matches!(error, OutputError::InUse(_)), "{error}");
    assert!(matches!(OutputFolder::resume(&root), Err(OutputError::InUse(_))));
    assert!(ours.iter().all(|path| path.exists()), "who may not write removes nothing");
    drop(folder);
    let folder = OutputFolder::create(&root, &sphere(""), false).expect("replaces");
    assert!(ours.iter().all(|path| !path.exists()));
    assert!(foreign.iter().all(|path| path.exists()));
    assert!(folder.scene().exists());
    assert!(!root.join("verify-1").exists() && root.join("verify-2/scene.toml").exists());
    fs::remove_file(folder.frames().join("mine.png")).expect("removes");
    drop(folder);
    drop(OutputFolder::create(&root, &sphere(""), false).expect("replaces"));
    assert!(!root.join("film").exists());
}

#[test]
fn a_start_that_was_killed_is_no_obstacle() {
    let root = fresh("killed-start");
    fs::create_dir_all(&root).expect("creates");
    fs::write(root.join("scene.toml.tmp"), "# Bedlo").expect("writes");
    let folder = OutputFolder::create(&root, &sphere(""), false).expect("begins");
    // Killed before its sub-folders were there.
    for path in [folder.fields(), folder.checkpoint()] {
        fs::remove_dir(path).expect("removes");
    }
    drop(folder);
    let folder = OutputFolder::create(&root, &sphere(""), false).expect("begins again");
    assert!(folder.fields().is_dir() && folder.checkpoint().is_dir());
}

#[test]
fn a_finished_run_is_replaced_only_where_that_is_asked_for() {
    let root = fresh("finished");
    let create = |overwrite: bool| OutputFolder::create(&root, &sphere(""), overwrite);
    let summary = create(false).expect("creates").summary();
    fs::write(&summary, "{\"status\": \"interrupted\"}").expect("writes");
    drop(create(false).expect("one that cannot go on is replaced"));
    let begun = create(true).expect("replaces").checkpoint().join("0000000005");
    fs::create_dir(&begun).expect("makes");
    fs::write(protocol::checkpoint::path(&begun, "loop"), "x").expect("writes");
    for text in ["{\"status\": \"interrupted\"}", "cut off"] {
        fs::write(&summary, text).expect("writes");
        let error = create(false).expect_err("it can go on").to_string();
        assert!(error.contains("--resume") && error.contains("--overwrite"), "{error}");
        assert!(begun.exists());
    }
    fs::write(&summary, "{\"status\": \"unstable\"}").expect("writes");
    drop(create(false).expect("one that failed is replaced"));
    assert!(!begun.exists());
    let finished = "{\"status\": \"completed\"}";
    fs::write(&summary, finished).expect("writes");
    let error = create(false).expect_err("finished").to_string();
    assert!(error.contains("--overwrite") && error.contains("--out"), "{error}");
    assert_eq!(fs::read_to_string(&summary).expect("unharmed"), finished);
    drop(create(true).expect("replaces"));
    assert!(!summary.exists());
}

#[test]
fn links_are_not_followed() {
    let (root, other) = (fresh("links"), fresh("links-aim"));
    drop(OutputFolder::create(&root, &sphere(""), false).expect("creates"));
    let dear = other.join("dear.vtp");
    fs::write(&dear, "dear").expect("writes");
    fs::remove_dir(root.join("fields")).expect("empty");
    std::os::unix::fs::symlink(&other, root.join("fields")).expect("links");
    let error = OutputFolder::create(&root, &sphere(""), false).expect_err("a link");
    assert!(matches!(error, OutputError::Link(_)), "{error}");
    std::os::unix::fs::symlink(&dear, root.join("summary.json.tmp")).expect("links");
    atomic_write(&root.join("summary.json"), b"{}").expect("writes");
    assert_eq!(fs::read(&dear).expect("there"), b"dear");
}

#[test]
fn a_foreign_folder_is_refused_and_untouched() {
    let root = fresh("foreign");
    for (name, text) in [("summary.json", "{}"), ("scene.toml", "until = 1.0\n"), ("thesis.tex", "x")] {
        fs::write(root.join(name), text).expect("writes");
    }
    let error = OutputFolder::create(&root, &sphere(""), false).expect_err("refuses");
    assert!(matches!(error, OutputError::Foreign { .. }), "{error}");
    assert_eq!(fs::read_dir(&root).expect("folder").count(), 3);
    assert!(matches!(OutputFolder::open(&root), Err(OutputError::NoRun(_))));
    assert!(matches!(OutputFolder::resume(&root), Err(OutputError::NothingToResume(_))));
}

#[test]
fn a_file_is_written_whole_and_nothing_is_left_beside_it() {
    let root = fresh("atomic");
    let path = root.join("a.json");
    atomic_write(&path, b"first").expect("writes");
    atomic_write(&path, b"second").expect("writes");
    assert_eq!(fs::read(&path).expect("reads"), b"second");
    assert_eq!(fs::read_dir(&root).expect("folder").count(), 1);
    assert!(atomic_write(&root.join("none/a.json"), b"x").is_err());
}

fn watch(observer: &mut Observer, steps: std::ops::Range<u64>) {
    for step in steps {
        let window = window(step, 0.5);
        let header = Header { substeps: 3 + step, ..window.header() };
        let motion = falling(-(step as f64), 10.0 - step as f64);
        let loads = [Loads { force: [0.0, 0.0, 0.1 * step as f64], ..Loads::default() }];
        let sample =
            Sample { window: &window, loads: &loads, header: &header, kinematics: &[motion], extras: &[] };
        observer.record(&sample).expect("records");
    }
}

fn run(root: &std::path::Path, scene: &CheckedScene, cut: Option<u64>) -> (Vec<u8>, Summary) {
    let mut folder = OutputFolder::create(root, scene, false).expect("creates");
    let mut observer = Observer::create(&folder, scene, Sides::coupled()).expect("observes");
    if let Some(cut) = cut {
        watch(&mut observer, 0..cut);
        let state = observer.state().expect("state");
        // Windows after the checkpoint, lost with the process.
        watch(&mut observer, cut..cut + 3);
        drop((observer, folder));
        folder = OutputFolder::resume(root).expect("opens");
        observer = Observer::resume(&folder, scene, Sides::coupled(), state, None).expect("resumes");
        watch(&mut observer, cut..20);
    } else {
        watch(&mut observer, 0..20);
    }
    let mut summary = Summary::new(scene, "0");
    observer.finish(&mut summary, f64::INFINITY).expect("finishes");
    (fs::read(folder.series()).expect("series"), summary)
}

#[test]
fn a_resumed_run_leaves_the_same_files() {
    let scene = sphere("[observe]\nevery = 1.0\n[[metrics]]\nname = \"re\"\nkind = \"terminal-reynolds\"\n");
    let (series, summary) = run(&fresh("whole"), &scene, None);
    assert_eq!(summary.status, RunStatus::Completed);
    assert_eq!(summary.time.substeps_per_window.min, 3);
    assert_eq!(summary.time.substeps_per_window.max, 22);
    assert_eq!(summary.time.substeps_per_window.mean, 12.5);
    assert_eq!(summary.time.contact_time, None);
    // Last tenth of 10 s: the last two windows, from a speed of 17 through 18 to 19.
    assert_eq!(summary.metrics["re"].value, Some(18.0 * 2.0 / 0.5));
    let text = String::from_utf8(series.clone()).expect("text");
    assert_eq!(Series::parse(&text).expect("series").len(), 10);
    for cut in [0, 1, 7, 19] {
        assert_eq!(run(&fresh("cut"), &scene, Some(cut)), (series.clone(), summary.clone()), "cut at {cut}");
    }
}
