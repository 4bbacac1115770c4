//! `docs/scene.md` against the code: its scenes run through every check, and it names every key.

use std::collections::BTreeSet;
use std::path::PathBuf;

use bedload_output::{Columns, Metrics, Sides};
use bedload_scene::{CheckedScene, Scene, SceneSource, schema};
use coupler::config::Coupling;
use coupler::plan::{Participants, Plan};
use dem_solver::config::{Config, DemSection};
use fluid_solver::config::FluidSection;
use serde_json::Value;
use study::kind::Kind;
use study::section::Section;

fn page() -> String {
    document("scene.md")
}

fn document(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Fenced blocks with the line of their fence, as `(info string, line, text)`.
fn blocks(page: &str) -> Vec<(String, usize, String)> {
    let mut found: Vec<(String, usize, String)> = Vec::new();
    let mut open = false;
    for (number, line) in page.lines().enumerate() {
        match line.strip_prefix("```") {
            Some(info) if !open => {
                found.push((info.trim().to_owned(), number + 1, String::new()));
                open = true;
            }
            Some(_) => open = false,
            None if open => {
                let (.., text) = found.last_mut().expect("a block is open");
                text.push_str(line);
                text.push('\n');
            }
            None => {}
        }
    }
    assert!(!open, "a fence is not closed");
    found
}

/// As `bedload check` does: everything typed, checked and planned, and no bound broken.
fn check(name: &str, text: &str) {
    let source = SceneSource { file: name.to_owned(), text: text.to_owned() };
    let scene = CheckedScene::new(source).unwrap_or_else(|error| panic!("{error}"));
    let participants = Participants::of(&scene);
    let fluid = participants
        .has_fluid()
        .then(|| fluid_solver::facts::facts(&scene).unwrap_or_else(|error| panic!("{error}")));
    let dem =
        participants.has_dem().then(|| Config::new(&scene).unwrap_or_else(|error| panic!("{error}")).facts);
    let coupling = Coupling::read(&scene).unwrap_or_else(|error| panic!("{error}"));
    let plan = Plan::new(&scene, &coupling, fluid.as_ref(), dem.as_ref(), None)
        .unwrap_or_else(|error| panic!("{error}"));
    let broken: Vec<_> = plan.refusals().map(|bound| bound.relation()).collect();
    assert!(broken.is_empty(), "{name}: {broken:?}");
    let sides = match participants {
        Participants::Coupled => Sides::coupled(),
        Participants::Dem => Sides::dry(),
        Participants::Fluid => Sides::fluid_alone(true),
    };
    let columns = Columns::new(&scene, sides);
    Metrics::new(&scene, &columns, sides).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn every_whole_scene_is_accepted() {
    for (name, least) in [("scene.md", 5), ("own-scene.md", 1)] {
        let page = document(name);
        let scenes: Vec<_> = blocks(&page).into_iter().filter(|(info, ..)| info == "toml scene").collect();
        assert!(scenes.len() >= least, "{name}: {} whole scenes", scenes.len());
        for (_, line, text) in scenes {
            check(&format!("docs/{name}, block at line {line}"), &text);
        }
    }
}

#[test]
fn every_fragment_is_toml() {
    for (info, line, text) in blocks(&page()).iter().filter(|(info, ..)| info.starts_with("toml")) {
        let read: Result<toml::Table, _> = text.parse();
        assert!(read.is_ok(), "block `{info}` at line {line}: {read:?}");
    }
}

/// Words in `code` of the text, outside of fenced blocks: an example alone documents nothing.
fn words_in_code(page: &str) -> BTreeSet<String> {
    let outside: String = page.split("```").step_by(2).collect();
    let code = outside.split('`').skip(1).step_by(2);
    let words = code.flat_map(|span| span.split(|c: char| !(c.is_ascii_alphanumeric() || "_-".contains(c))));
    words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// Names of properties and of named choices anywhere in a JSON Schema.
fn names(schema: &Value, found: &mut BTreeSet<String>) {
    match schema {
        Value::Object(object) => {
            if let Some(Value::Object(properties)) = object.get("properties") {
                found.extend(properties.keys().cloned());
            }
            if let Some(Value::String(choice)) = object.get("const") {
                found.insert(choice.clone());
            }
            if let Some(Value::Array(choices)) = object.get("enum") {
                found.extend(choices.iter().filter_map(Value::as_str).map(str::to_owned));
            }
            object.values().for_each(|inner| names(inner, found));
        }
        Value::Array(items) => items.iter().for_each(|item| names(item, found)),
        _ => {}
    }
}

#[test]
fn every_key_and_every_choice_is_documented() {
    let known = words_in_code(&page());
    for (part, schema) in [
        ("scene", schema::<Scene>()),
        ("[fluid]", schema::<FluidSection>()),
        ("[dem]", schema::<DemSection>()),
        ("[coupling]", schema::<Coupling>()),
    ]
    .into_iter()
    .chain(Kind::ALL.map(|kind| (kind.name(), Section::schema(kind))))
    {
        let mut wanted = BTreeSet::new();
        names(&schema, &mut wanted);
        assert!(wanted.len() > 5, "{part}: {wanted:?}");
        let missing: Vec<_> = wanted.difference(&known).collect();
        assert!(missing.is_empty(), "docs/scene.md says nothing of {missing:?} of {part}");
    }
}

#[test]
fn bounds_that_can_be_forced_are_named_as_bedload_prints_them() {
    // docs/scene.md points to `bedload check`; docs/coupling.md lists the names.
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/coupling.md");
    let known = words_in_code(&std::fs::read_to_string(path).expect("docs/coupling.md"));
    let missing: Vec<_> = coupler::bounds::NAMES.iter().filter(|name| !known.contains(**name)).collect();
    assert!(missing.is_empty(), "docs/coupling.md says nothing of {missing:?}");
}
