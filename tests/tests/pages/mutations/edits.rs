//! Edits of a file's bytes, lines and numbers.

use proptest::collection::vec;
use proptest::prelude::*;

/// What an edit does.
#[derive(Clone, Copy, Debug)]
pub(crate) enum What {
    /// Another byte.
    Replace,
    /// One byte more.
    Insert,
    /// Some bytes fewer.
    Remove,
    /// The end is cut off.
    Cut,
    /// A line goes.
    DropLine,
    /// A line stands twice.
    DoubleLine,
    /// A line stands elsewhere, too.
    CopyLine,
    /// A number becomes another.
    Number,
}

/// An edit.
#[derive(Clone, Debug)]
pub(crate) struct Edit {
    pub(crate) what: What,
    /// Where, modulo what there is.
    pub(crate) place: u32,
    /// What with, modulo what there is.
    pub(crate) value: u32,
}

/// A few edits.
pub(crate) fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let what = prop_oneof![
        2 => Just(What::Replace),
        1 => Just(What::Insert),
        1 => Just(What::Remove),
        1 => Just(What::Cut),
        1 => Just(What::DropLine),
        1 => Just(What::DoubleLine),
        1 => Just(What::CopyLine),
        4 => Just(What::Number),
    ];
    let edit =
        (what, any::<u32>(), any::<u32>()).prop_map(|(what, place, value)| Edit { what, place, value });
    vec(edit, 1..4)
}

/// Numbers that a reader may not expect.
const NUMBERS: [&str; 20] = [
    "0",
    "-1",
    "1",
    "0.0",
    "-0.0",
    "1e308",
    "-1e308",
    "1e-308",
    "nan",
    "inf",
    "-inf",
    "1000000000",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "1e9",
    "1e-9",
    "0.5",
    "[]",
    "\"x\"",
];

/// The file with all edits.
pub(crate) fn apply(bytes: &[u8], edits: &[Edit]) -> Vec<u8> {
    edits.iter().fold(bytes.to_vec(), one)
}

fn one(mut bytes: Vec<u8>, edit: &Edit) -> Vec<u8> {
    if bytes.is_empty() {
        return bytes;
    }
    let (place, value) = (edit.place as usize % bytes.len(), edit.value as usize);
    match edit.what {
        What::Replace => bytes[place] = value as u8,
        What::Insert => bytes.insert(place, value as u8),
        What::Remove => drop(bytes.drain(place..bytes.len().min(place + 1 + value % 16))),
        What::Cut => bytes.truncate(place),
        What::Number => number(&mut bytes, edit),
        What::DropLine | What::DoubleLine | What::CopyLine => return lines(&bytes, edit),
    }
    bytes
}

fn lines(bytes: &[u8], edit: &Edit) -> Vec<u8> {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|byte| *byte == b'\n').collect();
    let place = edit.place as usize % lines.len();
    match edit.what {
        What::DropLine => drop(lines.remove(place)),
        What::DoubleLine => lines.insert(place, lines[place]),
        _ => lines.insert(edit.value as usize % lines.len(), lines[place]),
    }
    lines.concat()
}

/// Replaces a number; in a file without any, nothing.
fn number(bytes: &mut Vec<u8>, edit: &Edit) {
    let digit = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    let starts: Vec<usize> =
        (0..bytes.len()).filter(|at| digit(&bytes[*at]) && (*at == 0 || !digit(&bytes[at - 1]))).collect();
    if starts.is_empty() {
        return;
    }
    let start = starts[edit.place as usize % starts.len()];
    let end = start + bytes[start..].iter().take_while(|byte| digit(byte)).count();
    let new = NUMBERS[edit.value as usize % NUMBERS.len()];
    bytes.splice(start..end, new.bytes());
}
