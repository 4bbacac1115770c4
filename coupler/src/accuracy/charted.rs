//! What a chart says of each of its runs, as the classes use it: `data/*.toml`. A test makes them from
//! docs/charts and the scenes, and asks that they are the same.

use serde::{Deserialize, Serialize};

/// A chart.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Charted {
    /// Scene that was charted.
    pub scene: String,
    /// Table of the chart.
    pub table: String,
    /// Why the table is stale: what a sample of it gives with the build. None: the build gives what the table
    /// holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stale: Option<String>,
    /// The runs that have an error and a cost.
    pub runs: Vec<Run>,
}

/// A run of a chart.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Its label in the table.
    pub label: String,
    /// CPU time, s.
    pub cost: f64,
    /// Relative error.
    pub error: f64,
    /// How fine it is among the runs that share `others`.
    pub fineness: f64,
    /// Values of what else was varied of the method.
    pub others: Vec<String>,
    /// Numbers of its class: where it stands in the range of the chart.
    pub numbers: Vec<f64>,
    /// D/Δx.
    pub resolution: Option<f64>,
    /// Time step of the fluid in its class's own time.
    pub step: Option<f64>,
    /// `KEY=VALUE` that make the run of the scene.
    pub set: Vec<String>,
}

impl Charted {
    /// From its text.
    pub fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }
}
