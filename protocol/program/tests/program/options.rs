//! The options of a run, as typed.

use bedload_program::RunOptions;
use clap::Parser;

/// One sphere in an axisymmetric box of fluid.
const SPHERE: &str = r#"
until = 10.0
gravity = [0.0, 0.0, -10.0]
[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [10.0, 40.0]
cells = [20, 80]
[domain.boundary]
r_upper = "free-slip"
z_lower = "no-slip"
z_upper = "no-slip"
[medium]
density = 1.0
viscosity = 0.5
[[grains]]
position = [0.0, 0.0, 20.0]
radius = 1.0
density = 3.0
"#;

#[derive(Parser)]
struct Program {
    #[command(flatten)]
    run: RunOptions,
}

fn parse(words: &[&str]) -> Result<RunOptions, clap::Error> {
    Program::try_parse_from(std::iter::once(&"bedload").chain(words)).map(|program| program.run)
}

#[test]
fn every_option_is_understood() {
    let options = parse(&[
        "scenes/a.toml",
        "--out",
        "d",
        "--until",
        "2",
        "--set",
        "a.b=1",
        "--set",
        "c=x",
        "--threads",
        "3",
        "--resume",
        "--no-record",
    ])
    .expect("parses");
    assert_eq!(options.out_path(), std::path::Path::new("d"));
    assert_eq!(options.all_overrides(), ["a.b=1", "c=x", "until=2.0"]);
    assert_eq!(options.threads(), 3);
    assert!(options.resume && options.no_record);
    let plain = parse(&["scenes/a.toml"]).expect("parses");
    assert_eq!(plain.out_path(), std::path::Path::new("out/a"));
    assert!(plain.threads() >= 1 && plain.all_overrides().is_empty());
    assert_eq!(plain, RunOptions::of_scene("scenes/a.toml".as_ref()));
}

#[test]
fn nonsense_is_refused() {
    assert!(parse(&[]).is_err());
    assert!(parse(&["a.toml", "--threads", "0"]).is_err());
    assert!(parse(&["a.toml", "--until", "soon"]).is_err());
}

#[test]
fn overrides_reach_the_scene_and_its_identity() {
    let folder = std::env::temp_dir().join(format!("bedload-options-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder below the temporary one");
    let path = folder.join("scene.toml");
    std::fs::write(&path, SPHERE).expect("writes");
    let mut options = RunOptions::of_scene(&path);
    let before = options.read_scene().expect("reads");
    options.overrides = vec!["grains[0].density=2.5".into(), "until=3.0".into()];
    options.until = Some(7.0);
    let after = options.read_scene().expect("reads");
    assert_eq!((after.scene.until, after.grains[0].density), (7.0, 2.5));
    assert_ne!(after.sha256(), before.sha256());
    options.overrides.extend(["chart.metric=e".into(), "stability.metric=e".into()]);
    assert_eq!(options.read_scene().expect("reads").sha256(), after.sha256(), "sweeps do not count");
    options.until = Some(-1.0);
    assert!(options.read_scene().expect_err("negative").to_string().contains("until"));
    options.until = Some(f64::NAN);
    let why = options.read_scene().expect_err("not a number").to_string();
    assert!(why.contains("until") && !why.contains("type"), "{why}");
    std::fs::remove_dir_all(folder).expect("removed");
}
