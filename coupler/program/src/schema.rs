//! `bedload schema`: the JSON Schema of a whole scene.

use coupler::check::section_schema;
use coupler::config::Coupling;
use coupler::failure::Failure;
use protocol::participant::Role;
use serde_json::{Map, Value};
use study::kind::Kind;
use study::section::Section;

/// The JSON Schema of a whole scene: the shared part, and each section from who owns it.
pub(crate) fn schema() -> Result<Value, Failure> {
    let failed = |error: serde_json::Error| Failure::Run(error.to_string());
    let mut whole = serde_json::to_value(schemars::schema_for!(bedload_scene::Scene)).map_err(failed)?;
    let coupling = serde_json::to_value(schemars::schema_for!(Coupling)).map_err(failed)?;
    graft(&mut whole, "coupling", coupling);
    for kind in [Kind::Chart, Kind::Stability] {
        graft(&mut whole, kind.name(), Section::schema(kind));
    }
    for role in [Role::Fluid, Role::Dem] {
        match section_schema(role) {
            Some(section) => graft(&mut whole, &role.to_string(), section),
            None => {
                protocol::say!(
                    "bedload: no schema of [{role}]: its solver is not beside bedload, nor on PATH"
                )
            }
        }
    }
    Ok(whole)
}

/// Puts the schema of `section` into `whole`. Its definitions go to the root under names of their
/// own, because references are counted from the root.
fn graft(whole: &mut Value, section: &str, mut part: Value) {
    rename_references(&mut part, section);
    let definitions = part.as_object_mut().and_then(|object| {
        object.remove("$schema");
        object.remove("$defs")
    });
    let Some(root) = whole.as_object_mut() else { return };
    let shared = root.entry("$defs").or_insert_with(|| Map::new().into());
    if let (Some(shared), Some(Value::Object(definitions))) = (shared.as_object_mut(), definitions) {
        shared.extend(definitions.into_iter().map(|(name, value)| (format!("{section}.{name}"), value)));
    }
    if let Some(properties) = root.get_mut("properties").and_then(Value::as_object_mut) {
        properties.insert(section.to_owned(), part);
    }
}

fn rename_references(value: &mut Value, section: &str) {
    match value {
        Value::Object(object) => {
            for (key, inner) in object.iter_mut() {
                match inner {
                    Value::String(target) if key == "$ref" => {
                        *target = target.replacen("#/$defs/", &format!("#/$defs/{section}."), 1);
                    }
                    _ => rename_references(inner, section),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| rename_references(item, section)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every `$ref` of a schema, as the definition that it names.
    fn references(value: &Value, found: &mut Vec<String>) {
        match value {
            Value::Object(object) => {
                if let Some(Value::String(target)) = object.get("$ref") {
                    found.push(target.clone());
                }
                object.values().for_each(|inner| references(inner, found));
            }
            Value::Array(items) => items.iter().for_each(|item| references(item, found)),
            _ => {}
        }
    }

    #[test]
    fn every_reference_of_the_merged_schema_has_its_definition() {
        let mut whole = serde_json::to_value(schemars::schema_for!(bedload_scene::Scene)).unwrap();
        graft(&mut whole, "coupling", serde_json::to_value(schemars::schema_for!(Coupling)).unwrap());
        graft(&mut whole, "chart", Section::schema(Kind::Chart));
        let mut found = Vec::new();
        references(&whole, &mut found);
        assert!(found.iter().any(|target| target.contains("coupling.Substeps")), "{found:?}");
        assert!(found.iter().any(|target| target.contains("chart.Vary")), "{found:?}");
        for target in found {
            let name = target.strip_prefix("#/$defs/").expect("a local reference");
            assert!(whole["$defs"].get(name).is_some(), "{target} is not defined");
        }
        assert!(whole["properties"]["coupling"]["properties"]["deadline"].is_object());
    }
}
