//! The scene: the one file a user writes. Shared facts are typed here; `[fluid]`, `[dem]` and
//! `[coupling]` belong to their crates, which read them with [`SceneSource::section`].
//!
//! SI units, or any consistent set. `docs/scene.md` documents every key.

mod domain;
mod error;
mod grains;
mod layers;
mod observe;
mod open;
mod pours;
mod random;
mod rest;
mod retired;
mod source;
mod table;
mod validate;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use domain::{
    Axis, Boundary, Domain, Face, Faces, FlowRate, Geometry, InflowProfile, InitialVelocity, Medium,
    Stretching, WallKind,
};
pub use error::SceneError;
pub use grains::{Freedom, Grain, GrainFile, Group, Motion, Oscillation, Shape, Wall};
pub use layers::{Arrangement, Layer};
pub use observe::{
    Column, HeapEnd, HeapReference, HeapSlope, Metric, MetricKind, Observe, ObservedPlanes, Profile, Span,
};
pub use pours::{Pour, Poured};
pub use rest::{Rest, StopWhen};
pub use retired::Retired;
pub use source::SceneSource;

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
    /// Error that is good enough, such as `"2%"`: `bedload` then takes resolution, step and method from the chart
    /// of this class of scenes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<String>,
    /// End of the run, s.
    pub until: f64,
    /// End the run earlier, once the grains rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_when: Option<StopWhen>,
    /// Acceleration of gravity (x, y, z), m/s². Axisymmetric: (0, 0, z).
    #[serde(default)]
    pub gravity: [f64; 3],
    /// Box, grid and boundaries.
    pub domain: Domain,
    /// The fluid; without it the scene is dry and no fluid process is started.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub medium: Option<Medium>,
    /// Grains, one by one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grains: Vec<Grain>,
    /// Grains from CSV files.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grain_files: Vec<GrainFile>,
    /// Rough walls of fixed grains.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<Layer>,
    /// Grains placed at random.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<Group>,
    /// Grains poured in while the run goes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pours: Vec<Pour>,
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
    /// The ladder of `bedload chart`.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "serde_json::Value")]
    pub chart: toml::Table,
    /// The sweep of `bedload stability`.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "serde_json::Value")]
    pub stability: toml::Table,
}

/// A scene that passed every check, with its grains laid out.
#[derive(Clone, Debug)]
pub struct CheckedScene {
    /// As written, defaults filled in.
    pub scene: Scene,
    /// Every grain, in message order: `grains`, `grain_files`, `layers`, `groups`, `pours`.
    pub grains: Vec<Grain>,
    /// Of the last of them: when they are poured in, ascending.
    pub poured: Vec<Poured>,
    /// The text, for errors of the sections.
    pub source: SceneSource,
}

impl CheckedScene {
    /// Reads, types and checks the shared part.
    ///
    /// # Errors
    /// [`SceneError`] at the first fault.
    pub fn new(source: SceneSource) -> Result<Self, SceneError> {
        let scene: Scene = source.section()?;
        validate::shared(&scene, &source)?;
        let (grains, poured) = grains::lay_out(&scene, &source)?;
        validate::grains(&scene, &grains, grains.len() - poured.len(), &source)?;
        validate::metrics(&scene, grains.len(), &source)?;
        Ok(Self { scene, grains, poured, source })
    }

    /// Number of grains that are there from the start.
    #[must_use]
    pub fn present(&self) -> usize {
        self.grains.len() - self.poured.len()
    }

    /// Is any grain free, so that a DEM is needed?
    #[must_use]
    pub fn has_free_grains(&self) -> bool {
        self.grains.iter().any(|grain| matches!(grain.motion, Motion::Free))
    }

    /// The planes that grains touch: explicit walls, then the domain's faces that are walls.
    #[must_use]
    pub fn contact_walls(&self) -> Vec<Wall> {
        let mut walls = self.scene.walls.clone();
        walls.extend(self.scene.domain.contact_faces());
        walls
    }

    /// SHA-256 of the text in hexadecimal: the identity of the scene. `[chart]` and `[stability]` do
    /// not count: they say which other runs to make, and nothing about this one.
    #[must_use]
    pub fn sha256(&self) -> String {
        hexadecimal(&self.source.without_sweeps())
    }

    /// SHA-256 in hexadecimal of what the scene says, its end aside: what a checkpoint is of. So a run goes on past
    /// the end that it had, and with other comments.
    #[must_use]
    pub fn state_sha256(&self) -> String {
        hexadecimal(&self.source.without_end())
    }

    /// Refuses to go on from `time`, s, if that is past the end.
    ///
    /// # Errors
    /// At `until`.
    pub fn goes_on_from(&self, time: f64) -> Result<(), SceneError> {
        let until = self.scene.until;
        if time <= until {
            return Ok(());
        }
        Err(self.source.error(
            "until",
            format!("is {until} s, but the run stands at t = {time} s already"),
            "give a later --until, or start anew without --resume",
        ))
    }
}

/// SHA-256 of a text.
fn hexadecimal(text: &str) -> String {
    use sha2::Digest;
    sha2::Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}
