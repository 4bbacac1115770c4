//! `docs/coupling.md` against the code: layouts, codes, names and versions are those of this build.

use std::fmt::Write as _;
use std::path::PathBuf;

use protocol::channel::{
    CONNECT_VARIABLE, GRAINS_ATTRIBUTE, LAYOUT_ATTRIBUTE, PROTOCOL_ATTRIBUTE, Rendezvous,
};
use protocol::message::{
    Command, Header, Kinematics, Loads, Order, PROTOCOL_VERSION, Record, State, Status, layout_hash,
};

fn page() -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/coupling.md");
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The layout of a record as a table: offset, name, type, unit, meaning.
fn table<R: Record>() -> String {
    let mut text = String::from("| byte | field | type | unit | meaning |\n|---|---|---|---|---|\n");
    let mut offset = 0;
    for field in R::FIELDS {
        let kind = if field.words == 1 {
            field.kind.to_owned()
        } else {
            format!("{} × {}", field.words, field.kind)
        };
        let unit = if field.unit == "-" { "" } else { field.unit };
        let meaning = field.meaning.trim();
        writeln!(text, "| {offset} | `{}` | {kind} | {unit} | {meaning} |", field.name).expect("to a String");
        offset += 8 * field.words;
    }
    writeln!(text, "| {offset} | | | | end |").expect("to a String");
    text
}

/// Compares what stands between the markers of `name` with `wanted`, and prints the latter if it differs.
fn compare(name: &str, wanted: &str) {
    let page = page();
    let (begin, end) = (format!("<!-- generated: {name} -->"), "<!-- end -->");
    let rest = page.split_once(&begin).unwrap_or_else(|| panic!("docs/coupling.md has no marker {begin}")).1;
    let found = rest.split_once(end).unwrap_or_else(|| panic!("{begin} has no {end}")).0;
    assert_eq!(found.trim(), wanted.trim(), "\n\nput this after {begin}:\n\n{wanted}\n");
}

#[test]
fn layouts_are_those_of_this_build() {
    compare("Loads", &table::<Loads>());
    compare("Kinematics", &table::<Kinematics>());
    compare("Header", &table::<Header>());
    compare("Command", &table::<Command>());
    compare("Status", &table::<Status>());
}

#[test]
fn tables_end_where_the_records_end() {
    for (size, text) in [
        (size_of::<Loads>(), table::<Loads>()),
        (size_of::<Kinematics>(), table::<Kinematics>()),
        (size_of::<Header>(), table::<Header>()),
        (size_of::<Command>(), table::<Command>()),
        (size_of::<Status>(), table::<Status>()),
    ] {
        assert!(text.ends_with(&format!("| {size} | | | | end |\n")), "{size}\n{text}");
    }
}

#[test]
fn codes_are_those_of_this_build() {
    let page = page();
    // Codes are small; one that is added beyond 100 would be a change of style too.
    for code in 0..100 {
        if let Ok(order) = Order::try_from(code) {
            assert!(page.contains(&format!("| {code} | `{order:?}` |")), "order {code} {order:?}");
        }
        if let Ok(state) = State::try_from(code) {
            assert!(page.contains(&format!("| {code} | `{state:?}` |")), "state {code} {state:?}");
        }
    }
}

#[test]
fn versions_and_names_are_those_of_this_build() {
    compare(
        "versions",
        &format!("protocol version `{PROTOCOL_VERSION}`, layout hash `{:016x}`", layout_hash()),
    );
    let page = page();
    for name in [PROTOCOL_ATTRIBUTE, LAYOUT_ATTRIBUTE, GRAINS_ATTRIBUTE, CONNECT_VARIABLE] {
        assert!(page.contains(&format!("`{name}`")), "{name}");
    }
    for record in [Loads::NAME, Kinematics::NAME] {
        assert!(page.contains(&format!("`bedload/{}`", record.to_lowercase())), "{record}");
    }
}

#[test]
fn every_key_of_the_token_is_explained() {
    let token = Rendezvous::new(3).expect("a run").token();
    let keys: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&token).expect("JSON");
    let page = page();
    let missing: Vec<_> = keys.keys().filter(|key| !page.contains(&format!("| `{key}` |"))).collect();
    assert!(missing.is_empty(), "docs/coupling.md says nothing of {missing:?}");
}
