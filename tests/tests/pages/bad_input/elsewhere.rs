//! Faults outside the scene's text: files, `--set`, CSV rows, and a plan that breaks a bound.

use std::path::{Path, PathBuf};

use bedload_program::RunOptions;
use bedload_scene::{CheckedScene, SceneError, SceneSource};
use coupler::bounds::Bound;

use crate::bad_input::bases::{PLANE, SPACE};

/// A file in a folder of this process, removed with it.
pub(crate) struct File(pub(crate) PathBuf);

impl File {
    pub(crate) fn new(name: &str, text: &str) -> Self {
        let path = std::env::temp_dir().join(format!("bedload-bad-input-{}-{name}", std::process::id()));
        std::fs::write(&path, text).expect("writes a temporary file");
        Self(path)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn with_set(set: &str) -> SceneError {
    let source = SceneSource { file: "good.toml".into(), text: SPACE.into() };
    source.with_overrides(&[set.to_owned()]).and_then(CheckedScene::new).map(|_| ()).expect_err(set)
}

#[test]
fn a_missing_file_is_named() {
    let error = SceneSource::read(Path::new("no/such/scene.toml"), &[]).expect_err("no file");
    assert_eq!((error.file.as_str(), error.line), ("no/such/scene.toml", 0));
    assert!(error.message.contains("cannot read") && !error.remedy.is_empty(), "{error}");
    let folder = SceneSource::read(&std::env::temp_dir(), &[]).expect_err("a folder");
    assert!(folder.message.contains("cannot read"), "{folder}");
    let bytes = File::new("bytes.toml", "");
    std::fs::write(&bytes.0, [0xff, 0xfe, 0x00]).expect("writes");
    assert!(SceneSource::read(&bytes.0, &[]).expect_err("not text").message.contains("UTF-8"));
}

#[test]
fn an_override_that_does_not_fit_is_quoted() {
    for (set, word) in [
        ("nonsense", "has no `=`"),
        ("grains[7].density=4", "past the last of 2"),
        ("grains[0].position[3]=4", "past the last of 3"),
        ("until.end=4", "not a table"),
        ("medium[0]=4", "not an array"),
        ("grains[0]=4", "whole table"),
    ] {
        let error = with_set(set);
        assert_eq!((error.file.as_str(), error.line), ("--set", 0), "{set}");
        assert!(error.message.contains(set) && error.message.contains(word), "{set}: {error}");
        assert!(error.remedy.contains("--set"), "{set}");
    }
}

#[test]
fn an_override_that_is_wrong_is_found_like_any_key() {
    for (set, key) in [
        ("grains[0].radius=-1.0", "grains[0].radius"),
        ("medium.viscosity=thick", "medium.viscosity"),
        ("domain.sells=[8,8,8]", "domain.sells"),
    ] {
        let error = with_set(set);
        assert_eq!(error.key, key, "{error}");
        assert!(error.file.contains("--set") && error.line > 0 && !error.remedy.is_empty(), "{error}");
    }
}

#[test]
fn a_row_of_grains_that_is_wrong_is_named_by_line_and_column() {
    for (name, rows, words) in [
        ("number", "x,y,z,radius,density\n1,1,1.5,0.2,2\n1,1,two,0.2,2\n", [":3", "`two` in column z"]),
        ("nan", "x,y,z,radius,density\n1,1,1.5,nan,2\n", [":2", "`nan` in column radius"]),
        ("short", "x,y,z,radius,density\n1,1,1.5,0.2\n", [":2", "column density"]),
        ("column", "x,y,z,density\n1,1,1.5,2\n", ["no column", "`radius`"]),
        ("empty", "", ["the file", "empty"]),
        (
            "case",
            "x,y,z,radius,density,Vx\n1,1,1.5,0.2,2,0\n",
            [":1", "column 6 `Vx` would not be read: name it vx"],
        ),
        (
            "other",
            "x,y,z,radius,density,u\n1,1,1.5,0.2,2,0\n",
            [":1", "column 6 `u` would not be read: name it vx"],
        ),
        (
            "twice",
            "x,y,z,radius,density,radius\n1,1,1.5,0.2,2,1\n",
            [":1", "column 6 `radius` has the name of column 4"],
        ),
        (
            "surplus",
            "x,y,z,radius,density\n1,1,1.5,0.2,2,7\n",
            [":2", "`7` in column 6 is past the last column"],
        ),
    ] {
        let csv = File::new(&format!("{name}.csv"), rows);
        let text = SPACE.replace("[[walls]]", &format!("[[grain_files]]\nfile = {:?}\n[[walls]]", csv.0));
        let error =
            CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.clone() }).expect_err(name);
        let line = 1 + text.lines().position(|line| line.starts_with("file =")).expect("written above");
        assert_eq!((error.key.as_str(), error.line), ("grain_files[0].file", line), "{error}");
        assert!(words.iter().all(|word| error.message.contains(word)), "{name}: {error}");
        assert!(error.remedy.contains("CSV"), "{}", error.remedy);
    }
}

#[test]
fn a_grain_of_a_file_is_checked_like_any_other() {
    let csv = File::new("deep.csv", "x,y,z,radius,density\n1,1,1.5,0.2,2\n2,2,3.2,0.25,2\n");
    let text = SPACE.replace("[[walls]]", &format!("[[grain_files]]\nfile = {:?}\n[[walls]]", csv.0));
    let error = CheckedScene::new(SceneSource { file: "s.toml".into(), text }).expect_err("overlap");
    assert!(error.key == "grain_files" && error.message.contains("grains 1 and 3 overlap"), "{error}");
    let csv = File::new("turns.csv", "x,y,z,radius,density,wx\n1,0,15,0.5,2,1\n");
    let text = PLANE.replace("[[groups]]", &format!("[[grain_files]]\nfile = {:?}\n[[groups]]", csv.0));
    let error = CheckedScene::new(SceneSource { file: "s.toml".into(), text }).expect_err("a spin about x");
    assert!(error.key == "grain_files" && error.message.contains("spin of grain 1 is [1.0"), "{error}");
}

/// Names of the bounds that a scene breaks, and the message that a user reads.
fn broken(change: &[(&str, &str)]) -> (Vec<String>, String) {
    let text = change.iter().fold(SPACE.to_owned(), |text, (from, to)| text.replacen(from, to, 1));
    let plan = crate::bad_input::plan(&text).expect("a plan");
    let bounds: Vec<_> = plan.refusals().collect();
    let names = bounds.iter().map(|bound| bound.name.clone()).collect();
    for bound in &bounds {
        assert!(!bound.why.is_empty() && !bound.source.is_empty() && !bound.remedy.is_empty());
    }
    let failure = Bound::broken(&bounds);
    assert_eq!(failure.exit_code(), 2);
    (names, failure.to_string())
}

#[test]
fn a_plan_that_breaks_a_bound_names_it() {
    assert_eq!(broken(&[]).0, [""; 0], "the base must keep every bound");
    for (change, name, quantity) in [
        (&[("contact_time = 0.02", "contact_time = 5e-5")][..], "window-over-contact", "dt_fluid/t_c = 200"),
        (
            &[("[dem]", "[dem]\nsteps_per_contact = 2.0"), ("deadline = 5.0", "steps_per_contact = 2.0")],
            "contact-steps",
            "t_c/dt_dem = 2",
        ),
        (&[("density = 3.0", "density = 0.005")], "density-ratio", "ρ_p/ρ = 0.005"),
        (&[("radius = 0.4", "radius = 0.3")], "resolution", "D/Δx = 4.8"),
        (&[("radius = 0.5", "radius = 0.5\nvelocity = [0.0, 0.0, 40.0]")], "cfl", "u dt/Δx"),
    ] {
        let (names, text) = broken(change);
        assert!(names.iter().any(|other| other == name), "{name}: {names:?}");
        for word in [name, quantity, "must be", "why:", "remedy:", "coupling.force"] {
            assert!(text.contains(word), "{name} without {word}: {text}");
        }
    }
}

#[test]
fn an_end_given_by_an_option_is_checked_too() {
    let scene = File::new("until.toml", SPACE);
    let options = RunOptions { until: Some(-2.0), ..RunOptions::of_scene(&scene.0) };
    let error = options.read_scene().map(|_| ()).expect_err("backwards");
    assert!(error.key == "until" && error.message.contains("-2"), "{error}");
}
