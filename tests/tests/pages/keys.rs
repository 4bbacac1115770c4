//! Keys of the solvers that rules of the coupler name: each must be in the solvers' configuration.

use std::path::Path;

use coupler::keys::ALL;
use serde_json::Value;
use tests::harness::{bedload, said};

/// The schemas that a node may mean: itself, what it refers to, its alternatives.
fn meant<'a>(node: &'a Value, root: &'a Value) -> Vec<&'a Value> {
    let reference = node["$ref"].as_str().and_then(|path| root.pointer(path.trim_start_matches('#')));
    let alternatives = ["anyOf", "oneOf", "allOf"].iter().filter_map(|word| node[*word].as_array()).flatten();
    let deeper = reference.into_iter().chain(alternatives).flat_map(|next| meant(next, root));
    std::iter::once(node).chain(deeper).collect()
}

/// What the schema says of a dotted key: nothing where there is no such key.
fn found<'a>(key: &str, root: &'a Value) -> Vec<&'a Value> {
    key.split('.').fold(vec![root], |nodes, part| {
        let (name, element) = part.split_once('[').map_or((part, false), |(name, _)| (name, true));
        let of = |node: &'a Value, what: &str| -> Vec<&'a Value> {
            meant(node, root).into_iter().filter_map(|node| node.get(what)).collect()
        };
        let named = nodes.into_iter().flat_map(|node| meant(node, root));
        // Of a table of free names each is one.
        let named = named.filter_map(|node| {
            let free = node.get("additionalProperties").filter(|free| free.is_object());
            node["properties"].get(name).or(free)
        });
        if element { named.flat_map(|node| of(node, "items")).collect() } else { named.collect() }
    })
}

/// The schema of a scene.
fn schema() -> Value {
    let output = bedload(&["schema"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    serde_json::from_slice(&output.stdout).expect("a schema")
}

/// The words of a command line; quotes hold blanks.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for character in line.chars().chain([' ']) {
        match (character, quote) {
            ('\'' | '"', None) => quote = Some(character),
            (_, Some(open)) if character == open => quote = None,
            (' ', None) if word.is_empty() => {}
            (' ', None) => words.push(std::mem::take(&mut word)),
            _ => word.push(character),
        }
    }
    words
}

/// What is wrong with the file and the keys that a printed command names; `root` is the schema of a scene.
fn faults(command: &str, root: &Value) -> Vec<String> {
    let words = words(command);
    let mut faults = Vec::new();
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for file in words.iter().filter(|word| word.starts_with("scenes/") && word.ends_with(".toml")) {
        if !repository.join(file).is_file() {
            faults.push(format!("there is no {file}"));
        }
    }
    for pair in words.windows(2).filter(|pair| pair[0] == "--set") {
        let Some((key, value)) = pair[1].split_once('=').filter(|(key, _)| *key != "KEY") else { continue };
        let nodes = found(key, root);
        if nodes.is_empty() {
            faults.push(format!("{key} is no key"));
        }
        let meant: Vec<&Value> = nodes.iter().flat_map(|node| meant(node, root)).collect();
        let named = |node: &&Value| node.get("enum").is_some() || node.get("const").is_some();
        let free = |node: &&Value| {
            node.get("type").is_some() && node.get("enum").is_none() && node.get("const").is_none()
        };
        let word = value.trim_matches('"');
        let listed: String = meant.iter().filter(|node| named(node)).map(|node| node.to_string()).collect();
        if !listed.is_empty() && !meant.iter().any(free) && !listed.contains(&format!("{word:?}")) {
            faults.push(format!("{key} does not take {value}"));
        }
    }
    faults
}

#[test]
fn printed_commands_name_scenes_and_keys_that_there_are() {
    let root = schema();
    let good =
        "bedload run scenes/silo.toml --set 'grains[0].density=2.0' --set 'fluid.method=\"izard-2014\"'";
    assert_eq!(faults(good, &root), [""; 0]);
    let bad = "bedload run scenes/solo.toml --set fluid.immersed.method=direct --set fluid.method=direct";
    assert_eq!(faults(bad, &root).len(), 3, "{:?}", faults(bad, &root));
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = std::fs::read_dir(repository.join("docs"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path());
    let mut wrong = Vec::new();
    let mut commands = 0;
    for page in docs
        .filter(|path| path.extension().is_some_and(|kind| kind == "md"))
        .chain([repository.join("README.md")])
    {
        let text = std::fs::read_to_string(&page).expect("text");
        for line in text.replace("\\\n", " ").lines().filter(|line| line.contains("bedload run scenes/")) {
            commands += 1;
            wrong.extend(
                faults(line, &root).iter().map(|fault| format!("{}: {fault}: {line:.120}", page.display())),
            );
        }
    }
    assert!(commands > 100, "{commands} commands");
    assert!(wrong.is_empty(), "{} of {commands}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_key_that_a_rule_names_is_in_the_configuration() {
    let root = schema();
    for (key, values) in ALL {
        let nodes = found(key, &root);
        assert!(!nodes.is_empty(), "{key} is no key of the solvers any more: coupler/src/keys.rs");
        for value in values {
            let known = nodes.iter().flat_map(|node| meant(node, &root));
            let said: String = known.map(Value::to_string).collect();
            assert!(said.contains(&format!("{value:?}")), "{key} does not take {value:?} any more: {said}");
        }
    }
    assert!(found("fluid.time.convections", &root).is_empty());
}
