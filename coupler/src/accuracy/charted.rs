//! What a chart says of each of its runs, as the classes use it: `data/*.toml`. A test makes them from
//! docs/charts and the scenes, and asks that they are the same.

use serde::{Deserialize, Serialize};

use crate::keys;

/// Columns that refine: a run with more of it is finer.
const REFINE: [&str; 2] = ["resolution", keys::CONTACT_STEPS];

/// Columns that vary the physics and not the method.
const CASES: [&str; 2] = ["case", "until"];

/// The rows of a `chart.csv` that have an error and a cost, but for a run that is the reference itself: its
/// error, 0, says nothing.
///
/// # Errors
/// The column that is missing.
pub fn measured(header: &[String], rows: &[Vec<String>]) -> Result<Vec<Run>, String> {
    let place = |name: &str| {
        header.iter().position(|column| column == name).ok_or_else(|| format!("has no column {name}"))
    };
    let (label, cost, error) = (place("label")?, place("cpu_s")?, place("error")?);
    let refining = header.iter().position(|column| REFINE.contains(&column.as_str()));
    let is_case = |column: usize| CASES.contains(&header[column].as_str());
    let row = |cells: &Vec<String>| {
        let number = |place: usize| cells[place].parse::<f64>().ok().filter(|value| value.is_finite());
        // The varied keys stand before the costs.
        let others = (0..cost).filter(|column| Some(*column) != refining && !is_case(*column));
        Some(Run {
            label: cells[label].clone(),
            cost: number(cost)?,
            error: number(error).filter(|error| *error > 0.0)?,
            fineness: refining.and_then(number).unwrap_or(0.0),
            others: others.map(|column| cells[column].clone()).collect(),
            numbers: Vec::new(),
            resolution: None,
            step: None,
            set: Vec::new(),
        })
    };
    Ok(rows.iter().filter_map(row).collect())
}

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
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
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
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }
}
