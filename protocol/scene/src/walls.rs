//! Plane walls as written.

use bedload_over_time::OverTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A plane that grains touch.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// A point of the plane, m.
    pub point: [f64; 3],
    /// Normal, into the room of the grains (any length).
    pub normal: [f64; 3],
    /// Velocity, m/s.
    #[serde(default)]
    pub velocity: OverTime<[f64; 3]>,
    /// The wall is there from this time on, s; it moves from time zero on all the same.
    #[serde(default)]
    pub from: f64,
    /// The wall vanishes at this time, s (a gate).
    #[serde(default = "forever")]
    pub until: f64,
}

pub(crate) fn forever() -> f64 {
    f64::INFINITY
}

impl Wall {
    /// A wall that stays.
    pub fn at_rest(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self { point, normal, velocity: OverTime::default(), from: 0.0, until: f64::INFINITY }
    }
}
