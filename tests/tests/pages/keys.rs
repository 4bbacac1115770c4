//! Keys of the solvers that rules of the coupler name: each must be in the solvers' configuration.

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
        let meant = nodes.into_iter().flat_map(|node| meant(node, root));
        meant.filter_map(|node| node["properties"].get(part)).collect()
    })
}

#[test]
fn every_key_that_a_rule_names_is_in_the_configuration() {
    let output = bedload(&["schema"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let root: Value = serde_json::from_slice(&output.stdout).expect("a schema");
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
