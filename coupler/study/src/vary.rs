//! Varied keys as the scene writes them: `[[chart.vary]]`, `[[chart.runs]]`, and the same under
//! `[stability]`.

use std::fmt;
use std::path::PathBuf;

use bedload_scene::{SceneError, SceneSource};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// D/Δx of the smallest grain: scales the grid.
pub(super) const RESOLUTION: &str = "resolution";

pub(super) const THREADS: &str = "threads";

/// A list of values of one key, or of bundles of keys.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vary {
    /// Dotted key of the scene, `resolution` (D/Δx of the smallest grain) or `threads`. May be left
    /// out where every value is a bundle.
    pub key: Option<String>,
    /// Name on axes and pages; by default the key.
    pub name: Option<String>,
    /// Values, of any type that the key takes. `{ name = "…", set = { KEY = VALUE, … } }` is a bundle:
    /// several keys at once.
    #[schemars(with = "Vec<serde_json::Value>")]
    pub values: Vec<toml::Value>,
}

/// One run beside the combinations.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SingleRun {
    /// Name, also of its folder.
    pub label: String,
    /// What the run sets: dotted keys with their values, or texts KEY=VALUE as `--set` takes them.
    #[serde(default)]
    pub set: Set,
    /// Of a case: its scene, seen from the file, where it is not the one of all runs.
    pub scene: Option<PathBuf>,
    /// Of a case: is it made with `--quick`, too?
    #[serde(default)]
    pub quick: bool,
    /// Of a case: its abscissa in a figure whose x is no metric.
    pub at: Option<f64>,
}

/// What a run sets.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "expected a table of keys, or a list of KEY=VALUE")]
pub enum Set {
    /// Dotted keys with their values.
    Keys(#[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")] toml::Table),
    /// `KEY=VALUE`, as `--set` takes them: a table there replaces the whole table.
    Texts(Vec<String>),
}

impl Default for Set {
    fn default() -> Self {
        Self::Texts(Vec::new())
    }
}

impl Set {
    /// Its entries; `place` is where it stands.
    pub(super) fn settings(&self, place: &str) -> Vec<Setting> {
        match self {
            Self::Keys(table) => settings(table, place),
            Self::Texts(texts) => texts.iter().map(|text| written(text, place)).collect(),
        }
    }
}

/// A setting from `KEY=VALUE`; a value that is no TOML is a string.
fn written(text: &str, place: &str) -> Setting {
    let (key, value) = text.split_once('=').unwrap_or((text, ""));
    let (key, value) = (key.trim().to_owned(), value.trim());
    let read = toml::from_str::<toml::Table>(&format!("value = {value}")).ok();
    let read = read.filter(|table| table.len() == 1).and_then(|mut table| table.remove("value"));
    let value = read.unwrap_or_else(|| value.into());
    Setting { key, value, place: place.to_owned() }
}

/// A key with its value, and where in the scene that stands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Setting {
    pub(super) key: String,
    pub(super) value: toml::Value,
    pub(super) place: String,
}

impl fmt::Display for Setting {
    /// `KEY=VALUE`, as `--set` takes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

/// One value of a [`Vary`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    /// As it stands in tables.
    pub(super) text: String,
    pub(super) settings: Vec<Setting>,
    pub(super) is_bundle: bool,
}

impl Vary {
    /// Header of its column: the key, or the name of the bundles.
    pub(super) fn header(&self) -> &str {
        self.key.as_deref().or(self.name.as_deref()).unwrap_or("")
    }

    /// Its name for people.
    pub(super) fn title(&self) -> &str {
        self.name.as_deref().or(self.key.as_deref()).unwrap_or("")
    }

    /// Its values, checked; `place` is its key in the scene, `chart.vary[0]`.
    pub(super) fn choices(&self, place: &str, source: &SceneSource) -> Result<Vec<Choice>, SceneError> {
        let wrong = |key: &str, message: &str, remedy: &str| Err(source.error(key, message, remedy));
        if self.values.is_empty() {
            let message = "is empty; a varied key has one value at least";
            return wrong(&format!("{place}.values"), message, "list the values, such as [8, 10, 16]");
        }
        let header = self.header();
        if header.trim().is_empty() || header.contains([',', '\n', '"', '#']) {
            let message = format!("has the key or name {header:?}, which makes no column of a table");
            let remedy = "give `key`, a dotted key of the scene; bundles alone need a `name` without commas and quotes";
            return wrong(place, &message, remedy);
        }
        if super::table::is_column(header) {
            let message = format!("has the key or name {header:?}, which is a column of the table itself");
            return wrong(place, &message, "give it another `name`");
        }
        let choice = |(index, value)| self.choice(value, &format!("{place}.values[{index}]"), source);
        let choices: Vec<Choice> = self.values.iter().enumerate().map(choice).collect::<Result<_, _>>()?;
        for (index, choice) in choices.iter().enumerate() {
            if choices[..index].iter().any(|other| other.text == choice.text) {
                let message = format!("is {} a second time", choice.text);
                return wrong(&format!("{place}.values[{index}]"), &message, "list every value once");
            }
        }
        Ok(choices)
    }

    fn choice(&self, value: &toml::Value, place: &str, source: &SceneSource) -> Result<Choice, SceneError> {
        let bundle = value.as_table().filter(|table| table.contains_key("set"));
        if let Some(table) = bundle {
            return bundled(table, place, source);
        }
        let Some(key) = &self.key else {
            return Err(source.error(
                place,
                format!("is {value} without a key that takes it"),
                "name the `key` beside `values`, or write a bundle { name = \"...\", set = { KEY = VALUE } }",
            ));
        };
        let setting = Setting { key: key.clone(), value: value.clone(), place: place.to_owned() };
        Ok(Choice { text: text(value), settings: vec![setting], is_bundle: false })
    }
}

fn bundled(table: &toml::Table, place: &str, source: &SceneSource) -> Result<Choice, SceneError> {
    let name = table
        .get("name")
        .and_then(toml::Value::as_str)
        .map(super::table::cell)
        .filter(|name| !name.is_empty());
    let (Some(text), Some(set), 2) = (name, table.get("set").and_then(toml::Value::as_table), table.len())
    else {
        return Err(source.error(
            place,
            "is no bundle of keys: it has `set`, but not just a `name` and a table `set`",
            "write { name = \"...\", set = { \"dotted.key\" = value } }",
        ));
    };
    Ok(Choice { text, settings: settings(set, place), is_bundle: true })
}

/// The entries of a `set` table.
pub(super) fn settings(set: &toml::Table, place: &str) -> Vec<Setting> {
    let mut all = Vec::new();
    collect("", set, place, &mut all);
    all
}

/// A key may be written dotted, `fluid.time.dt = 1`, quoted or not: both mean the same.
fn collect(path: &str, table: &toml::Table, place: &str, all: &mut Vec<Setting>) {
    for (name, value) in table {
        let key = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match value {
            toml::Value::Table(inside) if !inside.is_empty() => collect(&key, inside, place, all),
            _ => all.push(Setting { key, value: value.clone(), place: place.to_owned() }),
        }
    }
}

/// A value in a table: strings without quotes.
pub(super) fn text(value: &toml::Value) -> String {
    super::table::cell(&value.as_str().map_or_else(|| value.to_string(), str::to_owned))
}
