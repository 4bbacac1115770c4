//! The text of a scene: `--set`, sweeps in it, places of errors.

use bedload_scene::{CheckedScene, SceneSource};

fn source(text: &str) -> SceneSource {
    SceneSource { file: "s.toml".into(), text: text.into() }
}

#[test]
fn overrides_reach_tables_arrays_and_new_keys() {
    let text = "until = 1.0\n[[grains]]\ndensity = 2.0\nposition = [0.0, 0.0, 1.0]\n";
    let changed = source(text)
        .with_overrides(&[
            "grains[0].density=4".into(),
            "grains.0.position[2]=7.5".into(),
            "fluid.time.scheme=ab2".into(),
            "until=3".into(),
        ])
        .expect("fits");
    let table: toml::Table = changed.text.parse().expect("TOML");
    assert_eq!(table["grains"][0]["density"].as_integer(), Some(4));
    assert_eq!(table["grains"][0]["position"][2].as_float(), Some(7.5));
    assert_eq!(table["fluid"]["time"]["scheme"].as_str(), Some("ab2"));
    assert_eq!(table["until"].as_integer(), Some(3));
    assert!(source(text).with_overrides(&["grains[3].density=4".into()]).is_err());
    assert!(source(text).with_overrides(&["nonsense".into()]).is_err());
    // a key more of an inline table, and of one within it
    let inline = source("observe = { every = 0.01 }\n")
        .with_overrides(&["observe.planes.every=0.05".into(), "observe.energy=true".into()])
        .expect("two keys more");
    let read: toml::Table = inline.text.parse().expect("TOML");
    assert_eq!(
        read.to_string(),
        "[observe]\nenergy = true\nevery = 0.01\n\n[observe.planes]\nevery = 0.05\n"
    );
}

#[test]
fn sweeps_are_no_part_of_the_scene_that_they_sweep() {
    let plain = "until = 1.0\n\n[domain]\ncells = [4] # few\n";
    assert_eq!(source(plain).without_sweeps(), plain);
    let chart = "\n# A ladder.\n[chart]\nmetric = \"e\"\n[[chart.vary]]\nkey = \"until\"\nvalues = [1, 2]\n";
    let stability = "\n[stability]\nmetric = \"e\"\n";
    assert_eq!(source(&format!("{plain}{chart}")).without_sweeps(), plain);
    assert_eq!(source(&format!("{plain}{stability}{chart}")).without_sweeps(), plain);
    let inside = format!("until = 1.0\n{chart}\n[domain]\ncells = [4] # few\n");
    assert_eq!(source(&inside).without_sweeps(), plain);
    assert_eq!(source("chart.metric = 1\nuntil = 1.0\n").without_sweeps(), "until = 1.0\n");
    let other = source(&format!("{plain}{chart}")).with_overrides(&["until=2".into()]).expect("fits");
    assert_eq!(other.without_sweeps(), plain.replace("1.0", "2"));
}

#[test]
fn errors_point_at_the_line_and_name_the_key() {
    let text = "until = 1.0\n\n[[grains]]\nradius = -1.0\n";
    let error = source(text).error("grains[0].radius", "is -1", "give a positive radius");
    assert_eq!((error.line, error.key.as_str()), (4, "grains[0].radius"));
    assert_eq!(&error.text[error.span.clone()], "-1.0");
}

#[derive(Debug, serde::Deserialize)]
struct Doc {
    #[allow(dead_code)]
    part: Part,
}
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code)]
struct Part {
    size: f64,
    law: Law,
}
#[derive(Debug, serde::Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(dead_code)]
enum Law {
    Linear { stiffness: f64 },
}

#[test]
fn serde_errors_carry_key_and_line() {
    let wrong_type = source("[part]\nsize = \"big\"\n").section::<Doc>().expect_err("type");
    assert_eq!((wrong_type.line, wrong_type.key.as_str()), (2, "part.size"));
    let unknown =
        source("[part]\nsize = 1.0\n[part.law]\nform = \"linear\"\nstiffness = 1.0\nstifness = 2.0\n")
            .section::<Doc>()
            .expect_err("unknown");
    assert_eq!((unknown.line, unknown.key.as_str()), (6, "part.law.stifness"));
    let missing = source("[part]\nsize = 1.0\n").section::<Doc>().expect_err("missing");
    assert!(missing.message.contains("law"), "{missing}");
}

#[test]
fn a_state_is_of_a_scene_whatever_its_end() {
    let state = |text: &str| CheckedScene::new(source(text)).expect("a scene").state_sha256();
    let domain = "[medium]\ndensity = 1.0\nviscosity = 0.1\n[domain]\ngeometry = \"plane\"\nlower = [0, 0]\n\
                  upper = [1, 1]\nboundary = { x = \"periodic\", z = \"no-slip\" }\ncells = [8, 8]";
    let text = format!("until = 1.0\n\n{domain} # few\n");
    let later = format!("# longer\nuntil = 2\n[chart]\nmetric = \"e\"\n{domain}\n");
    assert_eq!(state(&text), state(&later));
    assert_ne!(state(&text), state(&text.replace("[8, 8]", "[8, 4]")));
    // How long is waited changes nothing; a run that met a deadline goes on with a longer one.
    let patient =
        format!("{text}[coupling]\ndeadline = 30.0\nstartup_deadline = 30.0\ncheckpoint_every = 9.0\n");
    assert_eq!(state(&text), state(&patient));
    assert_ne!(state(&text), state(&format!("{patient}scheme = \"semi-implicit\"\n")));
}
