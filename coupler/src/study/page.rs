//! Pages and maps: HTML and SVG from templates. A page needs nothing but itself: no script, no outside style, font or picture.

use minijinja::{AutoEscape, Environment, Output, State, UndefinedBehavior, Value};
use serde::Serialize;

use crate::failure::Failure;

/// Templates by name; the style is one, too.
const TEMPLATES: [(&str, &str); 7] = [
    ("page.html", include_str!("templates/page.html")),
    ("parts.html", include_str!("templates/parts.html")),
    ("style.css", include_str!("templates/style.css")),
    ("report.html", include_str!("templates/report.html")),
    ("chart.html", include_str!("templates/chart.html")),
    ("stability.html", include_str!("templates/stability.html")),
    ("map.svg", include_str!("templates/map.svg")),
];

/// A table of a page.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Listing {
    /// Names of the columns; none: there is no header.
    head: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

/// Text in a table of a page.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Cell {
    text: String,
    class: &'static str,
}

/// A figure of a page.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Figure {
    /// `viewBox` of the SVG.
    pub(super) view: String,
    /// Read out in place of the picture.
    pub(super) label: String,
    pub(super) caption: String,
    /// Content of the `<svg>` element.
    pub(super) body: String,
    /// Names of the lines, if there are several.
    pub(super) keys: Vec<Key>,
}

/// A line and its colour.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Key {
    pub(super) name: String,
    pub(super) colour: &'static str,
}

impl Listing {
    pub(super) fn new<T: ToString>(head: &[T], rows: Vec<Vec<Cell>>) -> Self {
        Self { head: head.iter().map(T::to_string).collect(), rows }
    }

    /// The table, if it has rows.
    pub(super) fn any(self) -> Option<Self> {
        (!self.rows.is_empty()).then_some(self)
    }
}

impl Cell {
    /// With a class of the style: `good`, `bad`, `strong`, `code`.
    pub(super) fn classed(text: impl ToString, class: &'static str) -> Self {
        Self { text: text.to_string(), class }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), class: "" }
    }
}

/// A value as text, or a dash.
pub(super) fn or_dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), text)
}

/// The page of a template with these data.
///
/// # Errors
/// [`Failure::Run`] if the template and the data do not fit: a fault of this program.
pub(super) fn render(template: &str, data: impl Serialize) -> Result<String, Failure> {
    let page = || {
        let mut pages = Environment::new();
        pages.set_trim_blocks(true);
        pages.set_lstrip_blocks(true);
        pages.set_keep_trailing_newline(true);
        pages.set_undefined_behavior(UndefinedBehavior::SemiStrict);
        pages.set_auto_escape_callback(|name| {
            if name.ends_with(".css") { AutoEscape::None } else { AutoEscape::Html }
        });
        pages.set_formatter(write_escaped);
        for (name, text) in TEMPLATES {
            pages.add_template(name, text)?;
        }
        pages.get_template(template)?.render(data)
    };
    page().map_err(|error: minijinja::Error| Failure::Run(format!("the page {template} fails: {error:#}")))
}

/// Writes a value as [`escape`] has it, where a template does not say that it is safe.
fn write_escaped(out: &mut Output, state: &State, value: &Value) -> Result<(), minijinja::Error> {
    match value.as_str() {
        Some(text) if !value.is_safe() => out.write_str(&escape(text)).map_err(minijinja::Error::from),
        _ => minijinja::escape_formatter(out, state, value),
    }
}

/// Text as HTML or SVG, also within quotes.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            // Controls have no place in HTML.
            other if other.is_control() && !matches!(other, '\n' | '\t') => escaped.push('\u{fffd}'),
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_character_of_a_text_becomes_markup() {
        assert_eq!(escape("<a href=\"x\">'&\u{7}"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;\u{fffd}");
    }
}
