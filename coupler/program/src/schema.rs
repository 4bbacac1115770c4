//! `bedload schema`: the JSON Schema of a whole scene.

use bedload_scene::{Scene, schema as schema_of};
use coupler::check::section_schema;
use coupler::config::Coupling;
use protocol::participant::Role;
use serde_json::Value;
use study::kind::Kind;
use study::section::Section;

/// The JSON Schema of a whole scene: the shared part, and each section from who owns it.
pub(crate) fn schema() -> Value {
    let mut whole = schema_of::<Scene>();
    whole["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    whole["properties"]["coupling"] = schema_of::<Coupling>();
    for kind in [Kind::Chart, Kind::Stability] {
        whole["properties"][kind.name()] = Section::schema(kind);
    }
    for role in [Role::Fluid, Role::Dem] {
        match section_schema(role) {
            Some(section) => whole["properties"][role.to_string()] = section,
            None => {
                protocol::say!(
                    "bedload: no schema of [{role}]: its solver is not beside bedload, nor on PATH"
                )
            }
        }
    }
    whole
}
