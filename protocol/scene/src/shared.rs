//! The scene as written, shared part.

use bedload_over_time::OverTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::{Domain, Medium};
use crate::grains::{Grain, GrainFile, Group};
use crate::insertions::Insertion;
use crate::metric::Metric;
use crate::observe::Observe;
use crate::rough_walls::RoughWall;
use crate::walls::Wall;

/// End of a dry run before `until`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopWhen {
    /// Σ ½ m v² over the free grains is below this part of Σ m g R. Without spin: nothing resists a
    /// caged grain that turns about the line through its contacts, so it turns for ever, and moves
    /// nobody.
    pub kinetic_energy_per_grain_below: f64,
    /// Not before this time, s, nor before all grains have been inserted.
    #[serde(default)]
    pub after: f64,
}

/// A scene as written, shared part. The sections of the solvers stay raw tables here.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// One line for reports.
    #[serde(default)]
    pub title: String,
    /// Where the case comes from (author, year, figure).
    #[serde(default)]
    pub source: String,
    /// Error that is good enough, such as `"2%"`: `bedload` then takes resolution, step and method from the
    /// chart of this class of scenes.
    pub accuracy: Option<String>,
    /// End of the run, s.
    pub until: f64,
    /// End the run earlier, once the grains rest.
    pub stop_when: Option<StopWhen>,
    /// Acceleration of gravity (x, y, z), m/s². Axisymmetric: (0, 0, z).
    #[serde(default)]
    pub gravity: OverTime<[f64; 3]>,
    /// Box, grid and boundaries.
    pub domain: Domain,
    /// The fluid; without it the scene is dry and no fluid process is started.
    pub medium: Option<Medium>,
    /// Grains, one by one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grains: Vec<Grain>,
    /// Grains from CSV files.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grain_files: Vec<GrainFile>,
    /// Rough walls of fixed grains.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rough_walls: Vec<RoughWall>,
    /// Grains placed at random.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<Group>,
    /// Grains inserted while the run goes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub insertions: Vec<Insertion>,
    /// Plane walls, besides the domain's no-slip faces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<Wall>,
    /// What is written to `series.csv` and `fields/`.
    #[serde(default)]
    pub observe: Observe,
    /// Numbers for `summary.json`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub metrics: Vec<Metric>,
    /// The fluid solver's own keys.
    #[serde(default)]
    #[schemars(with = "serde_json::Value")]
    pub fluid: toml::Table,
    /// The DEM solver's own keys.
    #[serde(default)]
    #[schemars(with = "serde_json::Value")]
    pub dem: toml::Table,
    /// The coupler's own keys.
    #[serde(default)]
    #[schemars(with = "serde_json::Value")]
    pub coupling: toml::Table,
    /// The sweep of `bedload chart`.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "serde_json::Value")]
    pub chart: toml::Table,
    /// The sweep of `bedload stability`.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "serde_json::Value")]
    pub stability: toml::Table,
}

impl Scene {
    /// Each component of gravity where it is largest in size, m/s².
    pub fn peak_gravity(&self) -> [f64; 3] {
        self.gravity.peak(self.until)
    }

    /// The largest gravity of the run, m/s².
    pub fn largest_gravity(&self) -> f64 {
        self.gravity.largest(self.until)
    }
}
