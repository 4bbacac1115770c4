//! Schemas of the viewer channels as MCAP wants them: a serialised `FileDescriptorSet`.
//!
//! The `.proto` texts beside this file are what a reader reads; they use messages, enums inside
//! messages and plain or repeated fields, and that is all this compiler knows. So no `protoc` is
//! needed to build. `descriptor.proto` numbers the fields written here.

use super::proto::Proto;

const TIMESTAMP: (&str, &str) = ("google/protobuf/timestamp.proto", include_str!("timestamp.proto"));
const DURATION: (&str, &str) = ("google/protobuf/duration.proto", include_str!("duration.proto"));
const FOXGLOVE: (&str, &str) = ("foxglove/scene.proto", include_str!("foxglove.proto"));
const VIEWER: (&str, &str) = ("bedload/viewer.proto", include_str!("viewer.proto"));

/// Descriptor set of the `foxglove.*` messages.
pub(crate) fn foxglove() -> Vec<u8> {
    set(&[(TIMESTAMP, &[]), (DURATION, &[]), (FOXGLOVE, &[TIMESTAMP.0, DURATION.0])])
}

/// Descriptor set of the messages for plots.
pub(crate) fn viewer() -> Vec<u8> {
    set(&[(VIEWER, &[])])
}

type Source<'a> = ((&'a str, &'a str), &'a [&'a str]);

fn set(sources: &[Source<'_>]) -> Vec<u8> {
    let mut out = Vec::new();
    for ((name, text), needs) in sources {
        let file = parse(text);
        Proto(&mut out).message(1, |proto| write_file(proto, name, needs, &file));
    }
    out
}

struct File<'a> {
    package: &'a str,
    messages: Vec<Message<'a>>,
}

struct Message<'a> {
    name: &'a str,
    fields: Vec<Field<'a>>,
    enums: Vec<(&'a str, Vec<(&'a str, u64)>)>,
}

struct Field<'a> {
    repeated: bool,
    kind: &'a str,
    name: &'a str,
    number: u64,
}

/// Reads one of our own texts; a mistake in it is a mistake in this crate, and a test reads all.
fn parse(text: &str) -> File<'_> {
    let words = tokens(text);
    let mut at = words.iter().copied();
    let mut file = File { package: "", messages: Vec::new() };
    while let Some(word) = at.next() {
        match word {
            "package" => file.package = at.next().unwrap_or_default(),
            "message" => file.messages.push(message(&mut at)),
            _ => {}
        }
    }
    file
}

/// Words, and `{ } ; =` as words; comments and strings go.
fn tokens(text: &str) -> Vec<&str> {
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    code.flat_map(str::split_whitespace)
        .flat_map(|word| word.split_inclusive([';', '}']))
        .flat_map(|word| match word.strip_suffix([';', '}']) {
            Some(head) => [head, &word[head.len()..]],
            None => [word, ""],
        })
        .filter(|word| !word.is_empty())
        .collect()
}

fn message<'a>(at: &mut impl Iterator<Item = &'a str>) -> Message<'a> {
    let name = at.next().unwrap_or_default();
    let mut message = Message { name, fields: Vec::new(), enums: Vec::new() };
    at.next(); // {
    while let Some(word) = at.next().filter(|word| *word != "}") {
        match word {
            "enum" => message.enums.push(enumeration(at)),
            ";" => {}
            _ => {
                let repeated = word == "repeated";
                let kind = if repeated { at.next().unwrap_or_default() } else { word };
                let name = at.next().unwrap_or_default();
                message.fields.push(Field { repeated, kind, name, number: value(at) });
            }
        }
    }
    message
}

fn enumeration<'a>(at: &mut impl Iterator<Item = &'a str>) -> (&'a str, Vec<(&'a str, u64)>) {
    let name = at.next().unwrap_or_default();
    at.next(); // {
    let mut values = Vec::new();
    while let Some(word) = at.next().filter(|word| *word != "}") {
        if word != ";" {
            values.push((word, value(at)));
        }
    }
    (name, values)
}

/// `= 7`.
fn value<'a>(at: &mut impl Iterator<Item = &'a str>) -> u64 {
    at.next();
    at.next().and_then(|number| number.parse().ok()).unwrap_or_default()
}

fn write_file(proto: &mut Proto<'_>, name: &str, needs: &[&str], file: &File<'_>) {
    proto.bytes(1, name.as_bytes());
    proto.bytes(2, file.package.as_bytes());
    needs.iter().for_each(|need| proto.bytes(3, need.as_bytes()));
    for message in &file.messages {
        proto.message(4, |proto| write_message(proto, file.package, message));
    }
    proto.bytes(12, b"proto3");
}

fn write_message(proto: &mut Proto<'_>, package: &str, message: &Message<'_>) {
    proto.bytes(1, message.name.as_bytes());
    for field in &message.fields {
        proto.message(2, |proto| write_field(proto, package, message, field));
    }
    for (name, values) in &message.enums {
        proto.message(4, |proto| {
            proto.bytes(1, name.as_bytes());
            for (name, number) in values {
                proto.message(2, |proto| {
                    proto.bytes(1, name.as_bytes());
                    proto.integer(2, *number);
                });
            }
        });
    }
}

fn write_field(proto: &mut Proto<'_>, package: &str, message: &Message<'_>, field: &Field<'_>) {
    proto.bytes(1, field.name.as_bytes());
    proto.integer(3, field.number);
    proto.integer(4, if field.repeated { 3 } else { 1 });
    match scalar(field.kind) {
        Some(code) => proto.integer(5, code),
        None => {
            let is_enum = message.enums.iter().any(|(name, _)| *name == field.kind);
            proto.integer(5, if is_enum { 14 } else { 11 });
            proto.bytes(6, type_name(package, message, field.kind, is_enum).as_bytes());
        }
    }
}

/// Fully qualified name, with its leading dot.
fn type_name(package: &str, message: &Message<'_>, kind: &str, is_enum: bool) -> String {
    match (is_enum, kind.contains('.')) {
        (true, _) => format!(".{package}.{}.{kind}", message.name),
        (false, true) => format!(".{kind}"),
        (false, false) => format!(".{package}.{kind}"),
    }
}

/// Code of a scalar type in `descriptor.proto`.
fn scalar(kind: &str) -> Option<u64> {
    let codes = [
        ("double", 1),
        ("int64", 3),
        ("int32", 5),
        ("fixed32", 7),
        ("bool", 8),
        ("string", 9),
        ("bytes", 12),
    ];
    codes.iter().find(|(name, _)| *name == kind).map(|(_, code)| *code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_parses_with_fields_numbered_from_one() {
        for (name, text) in [TIMESTAMP, DURATION, FOXGLOVE, VIEWER] {
            let file = parse(text);
            assert!(!file.package.is_empty(), "{name}");
            let declared = text.matches("\nmessage ").count();
            assert_eq!(file.messages.len(), declared, "{name}");
            for message in &file.messages {
                let numbers: Vec<u64> = message.fields.iter().map(|field| field.number).collect();
                let expected: Vec<u64> = (1..=message.fields.len() as u64).collect();
                assert_eq!(numbers, expected, "{name}: {}", message.name);
            }
        }
    }

    #[test]
    fn every_named_type_exists() {
        let known: Vec<String> = [TIMESTAMP, DURATION, FOXGLOVE]
            .iter()
            .map(|(_, text)| parse(text))
            .flat_map(|file| {
                let package = file.package;
                file.messages.iter().map(|m| format!(".{package}.{}", m.name)).collect::<Vec<_>>()
            })
            .collect();
        for message in &parse(FOXGLOVE.1).messages {
            for field in &message.fields {
                let is_enum = message.enums.iter().any(|(name, _)| *name == field.kind);
                if scalar(field.kind).is_none() && !is_enum {
                    let name = type_name("foxglove", message, field.kind, false);
                    assert!(known.contains(&name), "{name}");
                }
            }
        }
    }
}
