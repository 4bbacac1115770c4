//! Pages, figures and reports: HTML, SVG and text from templates. A page needs nothing but itself: no
//! outside script, style, font or picture.
//!
//! | filter | writes |
//! |---|---|
//! | `number`, `percent`, `integer`, `measured` | a number, or a dash where there is none |
//! | `seconds`, `nanoseconds`, `mebibytes` | the same with its unit |
//! | `number_or_infinity` | a number; ∞ where there is none, as JSON has it |
//! | `over(b)` | a ratio, or a dash |
//! | `fixed(n)` | a number with n places |
//! | `right(n)` | a text at the right of n columns |

use minijinja::{AutoEscape, Environment, Output, State, UndefinedBehavior};
pub(super) use minijinja::{Value, context};
use serde::Serialize;

use coupler::failure::Failure;
use coupler::number;

/// Templates by name; the style is one, too.
const TEMPLATES: [(&str, &str); 11] = [
    ("page.html", include_str!("templates/page.html")),
    ("parts.html", include_str!("templates/parts.html")),
    ("style.css", include_str!("templates/style.css")),
    ("report.html", include_str!("templates/report.html")),
    ("player.js", include_str!("templates/player.js")),
    ("chart.html", include_str!("templates/chart.html")),
    ("chart.svg", include_str!("templates/chart.svg")),
    ("chart.txt", include_str!("templates/chart.txt")),
    ("stability.html", include_str!("templates/stability.html")),
    ("frames.svg", include_str!("templates/frames.svg")),
    ("validation.md", include_str!("templates/validation.md")),
];

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

type Text = fn(f64) -> String;

/// A value as text, or a dash.
pub(super) fn or_dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), text)
}

/// The text of a template with these data.
pub(super) fn render(template: &str, data: Value) -> Result<String, Failure> {
    let page = || {
        let mut pages = environment();
        for (name, text) in TEMPLATES {
            pages.add_template(name, text)?;
        }
        pages.get_template(template)?.render(data)
    };
    page().map_err(|error: minijinja::Error| Failure::Run(format!("the page {template} fails: {error:#}")))
}

fn environment() -> Environment<'static> {
    let mut pages = Environment::new();
    pages.set_trim_blocks(true);
    pages.set_lstrip_blocks(true);
    pages.set_keep_trailing_newline(true);
    pages.set_undefined_behavior(UndefinedBehavior::SemiStrict);
    pages.set_auto_escape_callback(|name| {
        if name.ends_with("ml") || name.ends_with(".svg") { AutoEscape::Html } else { AutoEscape::None }
    });
    pages.set_formatter(write_escaped);
    let filters: [(&str, Text); 7] = [
        ("number", number::number),
        ("percent", number::percent),
        ("integer", |count| number::integer(count as u64)),
        ("seconds", |time| format!("{} s", number::number(time))),
        ("nanoseconds", |time| format!("{} ns", number::number(time))),
        ("mebibytes", |bytes| format!("{} MiB", number::integer(bytes as u64 >> 20))),
        ("measured", number::measured),
    ];
    for (name, text) in filters {
        pages.add_filter(name, move |value: Option<f64>| or_dash(value, text));
    }
    pages.add_filter("number_or_infinity", |value: Option<f64>| value.map_or("∞".to_owned(), number::number));
    pages.add_filter("over", |over: Option<f64>, under: Option<f64>| {
        or_dash(over.zip(under).filter(|(_, under)| *under > 0.0), |(over, under)| {
            number::number(over / under)
        })
    });
    pages.add_filter("fixed", |value: f64, places: usize| format!("{value:.places$}"));
    pages.add_filter("right", |text: &str, width: usize| format!("{text:>width$}"));
    pages
}

/// Writes a value as [`escape`] has it, where a template does not say that it is safe.
fn write_escaped(out: &mut Output, state: &State, value: &Value) -> Result<(), minijinja::Error> {
    let escapes = !matches!(state.auto_escape(), AutoEscape::None);
    match value.as_str() {
        Some(text) if escapes && !value.is_safe() => {
            out.write_str(&escape(text)).map_err(minijinja::Error::from)
        }
        _ => minijinja::escape_formatter(out, state, value),
    }
}

/// Text as HTML or SVG, also within quotes.
fn escape(text: &str) -> String {
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
