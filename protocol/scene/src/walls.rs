//! Plane walls as written.

use bedload_over_time::{OverTime, length};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A plane that grains touch.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// A point of the plane at t = 0, m.
    pub point: [f64; 3],
    /// Normal at t = 0, into the room of the grains (any length).
    pub normal: [f64; 3],
    /// Velocity, m/s.
    #[serde(default)]
    pub velocity: OverTime<[f64; 3]>,
    /// Angular velocity about an axis that keeps its direction, rad/s: the plane turns.
    #[serde(default)]
    pub spin: OverTime<[f64; 3]>,
    /// A point of the axis at t = 0, m, which moves with `velocity`; `point` if absent.
    pub about: Option<[f64; 3]>,
    /// Moves along its normal so that the grains press it as given.
    pub servo: Option<Servo>,
    /// The wall is there from this time on, s; it moves from time zero on all the same, a servo from this
    /// time.
    #[serde(default)]
    pub from: f64,
    /// The wall vanishes at this time, s (a gate).
    #[serde(default = "forever")]
    pub until: f64,
}

/// What a wall along its normal follows.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// Normal force of the contacts per area that it comes to, Pa (plane: N/m per unit depth).
    pub pressure: OverTime<f64>,
    /// Speed along the normal at most, m/s.
    pub largest_speed: f64,
    /// Area, m² (plane: m); by default the cross-section of the box, where the normal lies along an axis.
    pub area: Option<f64>,
}

/// Walls that begin to act during a run, and when, s.
#[derive(Clone, Debug)]
pub struct Appearing(Vec<(usize, f64)>);

impl Appearing {
    /// Of the walls of a scene.
    pub fn of(walls: &[Wall]) -> Self {
        let late = walls.iter().enumerate().filter(|(_, wall)| wall.from > 0.0);
        Self(late.map(|(index, wall)| (index, wall.from)).collect())
    }

    /// Whether one appears from `start` to `end`, s.
    pub fn any(&self, start: f64, end: f64) -> bool {
        self.0.iter().any(|(_, from)| (start..=end).contains(from))
    }

    /// What may be behind a fault up to `time`, s, for its message: the last wall that appeared. Empty where
    /// none did.
    pub fn words(&self, time: f64) -> String {
        let last = self.0.iter().filter(|(_, from)| *from <= time).max_by(|a, b| a.1.total_cmp(&b.1));
        last.map_or(String::new(), |(index, from)| {
            format!(
                "; walls[{index}] acts from t = {from} s on, when grains in its place or behind it are thrown out or \
                 lost: let it begin where there are none"
            )
        })
    }
}

pub(crate) fn forever() -> f64 {
    f64::INFINITY
}

impl Wall {
    /// A wall that stays.
    pub fn at_rest(point: [f64; 3], normal: [f64; 3]) -> Self {
        let (velocity, spin) = (OverTime::default(), OverTime::default());
        let (about, servo, until) = (None, None, forever());
        Self { point, normal, velocity, spin, about, servo, from: 0.0, until }
    }

    /// Whether it ever moves.
    pub fn moves(&self) -> bool {
        !self.velocity.is_zero() || !self.spin.is_zero() || self.servo.is_some()
    }

    /// A point of the plane and its unit normal at time `t`, s; a servo has not moved it.
    pub fn at(&self, t: f64) -> [[f64; 3]; 2] {
        let (about, moved) = (self.about.unwrap_or(self.point), self.velocity.integral(t));
        let arm = self.spin.turn(&std::array::from_fn(|c| self.point[c] - about[c]), t);
        let size = length(&self.normal);
        let point = std::array::from_fn(|c| about[c] + moved[c] + arm[c]);
        [point, self.spin.turn(&self.normal.map(|n| n / size), t)]
    }
}
