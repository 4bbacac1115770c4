//! What a chart says of each of its runs, as the classes use it: `data/*.toml`. A test makes them from
//! docs/charts and the scenes, and asks that they are the same.

use serde::{Deserialize, Serialize};

/// A chart.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Charted {
    /// Scene that was charted.
    pub(super) scene: String,
    /// Table of the chart.
    pub(super) table: String,
    /// The runs that have an error and a cost.
    pub(super) runs: Vec<Run>,
}

/// A run of a chart.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Run {
    pub(super) label: String,
    /// CPU time, s.
    pub(super) cost: f64,
    /// Relative error.
    pub(super) error: f64,
    /// How fine it is among the runs that share `others`.
    pub(super) fineness: f64,
    /// Values of what else was varied of the method.
    pub(super) others: Vec<String>,
    /// Numbers of its class: where it stands in the range of the chart.
    pub(super) numbers: Vec<f64>,
    /// D/Δx.
    pub(super) resolution: Option<f64>,
    /// Time step of the fluid in its class's own time.
    pub(super) step: Option<f64>,
    /// `KEY=VALUE` that make the run of the scene.
    pub(super) set: Vec<String>,
}

impl Charted {
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }
}
