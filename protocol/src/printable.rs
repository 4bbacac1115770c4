//! Text of others on a terminal: what a solver says, a log or a scene holds must not steer it.

use std::borrow::Cow;

/// The text with what is no character to be seen written out, such as `\u{1b}`; line breaks and tabs stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_seen) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_seen(character) { out.push(character) } else { out.extend(character.escape_default()) }
    }
    Cow::Owned(out)
}

/// The same with a question mark for each byte of it, so that places in the text stay.
pub fn printable_in_place(text: &str) -> String {
    let shown = |c: char| if is_seen(c) { c.to_string() } else { "?".repeat(c.len_utf8()) };
    text.chars().map(shown).collect()
}

/// Neither a control character nor one that turns the direction of writing.
fn is_seen(character: char) -> bool {
    let turns =
        matches!(character, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    matches!(character, '\n' | '\t') || !(character.is_control() || turns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_written_out() {
        let plain = "Reynolds 19.6, ν = 0.01 m²/s\n\t— ok";
        assert!(matches!(printable(plain), Cow::Borrowed(text) if text == plain));
        let hostile = "a\u{1b}[31mred\u{1b}]0;title\u{7}\r\u{9b}2J\u{202e}b\u{7f}";
        let shown = printable(hostile);
        assert_eq!(shown, "a\\u{1b}[31mred\\u{1b}]0;title\\u{7}\\r\\u{9b}2J\\u{202e}b\\u{7f}");
        assert_eq!(printable_in_place(hostile).len(), hostile.len());
        assert!(printable_in_place(hostile).chars().all(is_seen));
    }
}
