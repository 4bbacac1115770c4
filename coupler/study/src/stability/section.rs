//! The `[stability]` section of a scene.

use bedload_output::Columns;
use bedload_scene::{CheckedScene, SceneError, SceneSource};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Column, SingleRun, Sweep, Vary};
use coupler::bounds;
use coupler::plan::Participants;

/// Any bound that refuses, whichever is nearest.
pub const ANY: &str = "any";

/// `[stability]`: which runs to make, what to judge them by, and which bound to hold against them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stability {
    /// One line above the map; by default the scene's title.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// What to know before reading the map.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// Column of `series.csv` that is judged, such as `velocity_z[0]`.
    pub signal: String,
    /// Size of the signal that counts as whole; by default its largest smooth value in the second
    /// half of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Name of the bound of `bedload check` that is drawn, or `any`: the one with the least margin.
    #[serde(default = "any")]
    pub bound: String,
    /// Name or key of the varied one along the horizontal axis.
    pub x: String,
    /// Name or key of the varied one along the vertical axis.
    pub y: String,
    /// What no run may leave.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<Limit>,
    /// Keys that are set in every run.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
    /// Lists of values; every combination is a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vary: Vec<Vary>,
    /// Single runs beside the combinations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<SingleRun>,
}

/// Range of a column outside of which a run is impossible, and so has failed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Column of `series.csv`.
    pub column: String,
    /// Least possible value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Largest possible value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// From this time on, s.
    #[serde(default)]
    pub from: f64,
}

fn any() -> String {
    ANY.to_owned()
}

/// The document as far as it is read here.
#[derive(Deserialize)]
struct Document {
    stability: Option<Stability>,
}

/// The section with its runs laid out.
#[derive(Clone, Debug)]
pub struct MapPlan {
    /// As written.
    pub section: Stability,
    /// The runs.
    pub sweep: Sweep,
    /// Number of the column along x.
    pub x: usize,
    /// Number of the column along y.
    pub y: usize,
}

impl MapPlan {
    /// Reads and checks the section, and lays out its runs.
    ///
    /// # Errors
    /// [`SceneError`] at the key that is missing, unknown or out of range.
    pub fn read(scene: &CheckedScene) -> Result<Self, SceneError> {
        let source = &scene.source;
        let section = Stability::of_text(source)?;
        section.check(scene)?;
        let sweep = Sweep::new(scene, "stability", &section.set, &section.vary, &section.runs)?;
        let x = axis(&sweep.columns, &section.x, "stability.x", source)?;
        let y = axis(&sweep.columns, &section.y, "stability.y", source)?;
        if x == y {
            return Err(source.error(
                "stability.y",
                format!("is {:?} as `x` is", section.y),
                "name another varied key; one that has a single value will do",
            ));
        }
        Ok(Self { section, sweep, x, y })
    }
}

impl Stability {
    /// Reads the section alone.
    ///
    /// # Errors
    /// [`SceneError`] if it is not there, or at a key that is unknown or of the wrong type.
    pub fn of_text(source: &SceneSource) -> Result<Self, SceneError> {
        source.section::<Document>()?.stability.ok_or_else(|| {
            source.error(
                "stability",
                "is missing: the scene says nothing about a sweep",
                "add [stability] with signal, x, y and [[stability.vary]] (docs/scene.md), or take a scene of scenes/stability",
            )
        })
    }

    fn check(&self, scene: &CheckedScene) -> Result<(), SceneError> {
        let wrong = |key: &str, message: &str, remedy: &str| Err(scene.source.error(key, message, remedy));
        if self.vary.is_empty() && self.runs.is_empty() {
            let remedy = "add [[stability.vary]] with key and values, or [[stability.runs]]";
            return wrong("stability", "names no runs", remedy);
        }
        let (bound, names) = (&self.bound, bounds::NAMES);
        if bound != ANY && !names.contains(&bound.as_str()) {
            let message = format!("is {bound:?}, which is no bound; allowed: any, {}", names.join(", "));
            return wrong(
                "stability.bound",
                &message,
                "name a bound that `bedload check` prints, or \"any\"",
            );
        }
        if let Some(scale) = self.scale.filter(|scale| !(*scale > 0.0 && scale.is_finite())) {
            let message = format!("is {scale}; allowed: a finite number > 0");
            let remedy = "give the size of the signal that counts as whole, or leave it out";
            return wrong("stability.scale", &message, remedy);
        }
        self.check_columns(scene)
    }

    fn check_columns(&self, scene: &CheckedScene) -> Result<(), SceneError> {
        let source = &scene.source;
        let columns = Columns::new(scene, Participants::of(scene).sides(), &[]);
        let known = |name: &str| columns.names().iter().any(|column| column == name);
        let unknown = |key: &str, name: &str| {
            source.error(
                key,
                format!(
                    "is {name:?}, which is no column of this scene's series.csv; there are {}",
                    columns.names().join(", ")
                ),
                "name one of these; observe.grains chooses the grains",
            )
        };
        if !known(&self.signal) {
            return Err(unknown("stability.signal", &self.signal));
        }
        for (number, limit) in self.limits.iter().enumerate() {
            let key = format!("stability.limits[{number}]");
            if !known(&limit.column) {
                return Err(unknown(&format!("{key}.column"), &limit.column));
            }
            let range = (limit.least.unwrap_or(f64::NEG_INFINITY), limit.most.unwrap_or(f64::INFINITY));
            let bounded = range.0.is_finite() || range.1.is_finite();
            if !(bounded && range.0 < range.1 && limit.from >= 0.0) {
                return Err(source.error(
                    &key,
                    format!("allows {} to {} from t = {}", range.0, range.1, limit.from),
                    "give `least`, `most` or both, least < most, and a time `from` ≥ 0",
                ));
            }
        }
        Ok(())
    }
}

/// Number of the varied key that an axis names, by its name or its key.
fn axis(columns: &[Column], wanted: &str, key: &str, source: &SceneSource) -> Result<usize, SceneError> {
    columns.iter().position(|column| column.name == wanted || column.key == wanted).ok_or_else(|| {
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        source.error(
            key,
            format!("is {wanted:?}, which does not vary; varied are {}", names.join(", ")),
            "name one of them",
        )
    })
}
