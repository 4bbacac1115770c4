//! Retired names.

use bedload_scene::{Retired, SceneSource};

const RETIRED: &[Retired] = &[
    Retired::key("flow.rungs", "flow.levels"),
    Retired::key("walls[].colour", "walls[].material"),
    Retired::value("flow.form", "old", "\"new\""),
    Retired::dropped("flow.colour", "leave it out: it is always blue"),
];

fn refusal(text: &str) -> Option<(usize, String, String)> {
    let source = SceneSource { file: "s.toml".into(), text: text.into() };
    let error = source.refuse_retired(RETIRED).err()?;
    Some((error.line, error.key, error.remedy))
}

#[test]
fn a_retired_name_is_refused_where_it_stands_and_the_new_one_is_named() {
    let (line, key, remedy) = refusal("[flow]\nform = \"new\"\nrungs = 4\n").expect("a retired key");
    assert_eq!((line, key.as_str()), (3, "flow.rungs"));
    assert!(remedy.contains("flow.levels"), "{remedy}");
    let (line, key, remedy) = refusal("[flow]\nform = \"old\"\n").expect("a retired value");
    assert_eq!((line, key.as_str()), (2, "flow.form"));
    assert!(remedy.contains("\"new\""), "{remedy}");
    let (line, key, remedy) = refusal("[flow]\ncolour = 1\n").expect("a key without a successor");
    assert_eq!((line, key.as_str(), remedy.as_str()), (2, "flow.colour", "leave it out: it is always blue"));
    let walls = "[[walls]]\nmaterial = 1\n[[walls]]\ncolour = 2\n";
    let (line, key, _) = refusal(walls).expect("a retired key of an item");
    assert_eq!((line, key.as_str()), (4, "walls[1].colour"));
}

#[test]
fn present_names_pass() {
    assert_eq!(refusal("[flow]\nform = \"new\"\nlevels = 4\n[[walls]]\nmaterial = 1\n"), None);
    assert_eq!(refusal("rungs = 4\nform = \"old\"\n"), None);
}
