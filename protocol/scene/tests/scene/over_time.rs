//! Values over time in a scene: files, checks, and what changes.

use bedload_scene::{CheckedScene, OverTime, SceneError, SceneSource, changing};
use std::sync::atomic::{AtomicUsize, Ordering};

const TEXT: &str = "until = 4.0\ngravity = { file = \"tilt.csv\" }\n[domain]\ngeometry = \"space\"\n\
    lower = [0.0, 0.0, 0.0]\nupper = [4.0, 4.0, 4.0]\ncells = [16, 16, 16]\n\
    [domain.boundary]\nx = \"periodic\"\ny = \"periodic\"\nz_lower = \"no-slip\"\n\
    z_upper = { type = \"no-slip\", velocity = [[0.0, [0.0, 0.0, 0.0]], [1.0, [2.0, 0.0, 0.0]]] }\n\
    [medium]\ndensity = 1.0\nviscosity = 1.0\n[medium.flow_rate]\naxis = \"x\"\n\
    mean_velocity = { amplitude = 0.5, frequency = 2.0 }\n[[grains]]\nposition = [2.0, 2.0, 2.0]\nradius = 0.5\n\
    density = 2.0\nmotion = \"prescribed\"\nspin = [[0.0, [0.0, 0.0, 0.0]], [1.0, [0.0, 3.0, 0.0]]]\n";

const TABLE: &str = "# a slope that is tilted\nt, x, z\n0.0, 0.0, -1.0\n\n2.0, 1.0, -1.0\n";

fn read(text: &str, table: &str) -> Result<CheckedScene, SceneError> {
    // The tests of this program run at the same time: each reading has a folder of its own.
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let own = format!("{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(format!("bedload-over-time-{own}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("tilt.csv"), table).expect("a table");
    let file = folder.join("scene.toml").display().to_string();
    let scene = CheckedScene::new(SceneSource { file, text: text.to_owned() });
    std::fs::remove_dir_all(&folder).expect("it goes");
    scene
}

#[test]
fn files_and_tables_are_read() {
    let scene = read(TEXT, TABLE).expect("a scene");
    assert_eq!(scene.scene.gravity.at(1.0), [0.5, 0.0, -1.0]);
    assert_eq!(scene.scene.peak_gravity(), [1.0, 0.0, -1.0]);
    let keys: Vec<String> = changing(&scene).into_iter().map(|value| value.key).collect();
    let all =
        ["gravity", "domain.boundary.z_upper.velocity", "grains[0].spin", "medium.flow_rate.mean_velocity"];
    assert_eq!(keys, all);
    // The lid drags, and does not move through itself.
    let walls = scene.contact_walls();
    assert_eq!(walls.last().expect("a lid").velocity.at(0.5), [1.0, 0.0, 0.0]);
    // What is written out needs no file.
    let text = toml::to_string(&scene.scene).expect("text");
    let again =
        CheckedScene::new(SceneSource { file: "elsewhere.toml".into(), text }).expect("the same scene");
    assert_eq!(again.scene.gravity.at(1.5), scene.scene.gravity.at(1.5));
    let swing =
        &again.scene.medium.as_ref().expect("a fluid").flow_rate.as_ref().expect("held").mean_velocity;
    assert!(matches!(swing, OverTime::Sine(_)) && swing.largest(1.0) == 0.5);
}

#[test]
fn wrong_tables_and_values_are_named() {
    for (from, to, key, words) in [
        ("0.0, 0.0, -1.0", "0.0, 0.0", "gravity", "tilt.csv:3: `` is not a number"),
        ("0.0, 0.0, -1.0", "0.0, north, -1.0", "gravity", "`north`"),
        ("t, x, z", "t, x, w", "gravity", "column `w`"),
        ("t, x, z", "time, x, z", "gravity", "no column `t`; it has `time`, `x`, `z`"),
        (TABLE, "", "gravity", "is empty: there is no column `t`"),
        ("t, x, z", "t, x, x", "gravity", "tilt.csv:2: column 3 `x` has the name of column 2"),
        ("0.0, 0.0, -1.0", "0.0, 0.0, -1.0, 5", "gravity", "tilt.csv:3: `5` in column 4"),
        ("2.0, 1.0", "0.0, 1.0", "gravity", "row 2"),
        (
            "[[0.0, [0.0, 0.0, 0.0]], [1.0, [2.0, 0.0, 0.0]]]",
            "[[0.0, [0.0, 0.0, 1.0]]]",
            "domain.boundary.z_upper.velocity",
            "through itself",
        ),
        ("motion = \"prescribed\"\n", "", "grains[0].spin", "not prescribed"),
        (
            "[1.0, [0.0, 3.0, 0.0]]",
            "[1.0, [0.0, 3.0, 0.0]], [2.0, [1.0, 3.0, 0.0]]",
            "grains[0].spin",
            "axis that changes",
        ),
        ("frequency = 2.0", "frequency = -2.0", "medium.flow_rate.mean_velocity.frequency", "-2"),
        (
            "z_lower = \"no-slip\"",
            "z_lower = { type = \"inflow\", velocity = { amplitude = [0.0, 0.0, 1.0], frequency = 1.0 } }",
            "domain.boundary.z_lower.velocity",
            "an inflow enters the box",
        ),
        (
            "x = \"periodic\"",
            "x = { type = \"free-slip\", velocity = [[0.0, [0.0, 1.0, 0.0]]] }",
            "domain.boundary.x.velocity",
            "not no-slip",
        ),
    ] {
        let (text, table) = (TEXT.replace(from, to), TABLE.replace(from, to));
        let error = read(&text, &table).err().unwrap_or_else(|| panic!("{to} is allowed"));
        assert!(error.key == key && error.message.contains(words), "{to}: {} {}", error.key, error.message);
        assert!(!error.remedy.is_empty());
    }
}
