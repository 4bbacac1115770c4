//! Infinite planes, which may move and may vanish (a gate).

use crate::error::SpecError;
use crate::motion::Vec3;
use bedload_over_time::OverTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A plane. It bounds the half space that `normal` points into.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// A point of the plane at time zero, m.
    pub point: [f64; 3],
    /// Normal towards the grains; any length but zero.
    pub normal: [f64; 3],
    /// Velocity, m/s: the normal part moves the plane, the tangential part drags grains along.
    #[serde(default)]
    pub velocity: OverTime<[f64; 3]>,
    /// Time from which the wall is there, s; it moves from time zero on all the same.
    #[serde(default)]
    pub from: f64,
    /// Time at which the wall vanishes, s; never if absent.
    #[serde(default)]
    pub until: Option<f64>,
}

impl Wall {
    /// A wall at rest that stays.
    #[must_use]
    pub fn new(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self { point, normal, velocity: OverTime::default(), from: 0.0, until: None }
    }

    /// Checks values and directions; a wall may not cut a periodic direction obliquely.
    pub fn validate(&self, wall: usize, periodic: [bool; 3]) -> Result<(), SpecError> {
        let bad = |quantity, value, allowed| Err(SpecError::Wall { wall, quantity, value, allowed });
        let velocities = self.velocity.extremes().map(|velocity| ("velocity", velocity));
        for (quantity, vector) in
            [("point", self.point), ("normal", self.normal)].into_iter().chain(velocities)
        {
            if let Some(value) = vector.into_iter().find(|c| !c.is_finite()) {
                return bad(quantity, value, "finite");
            }
        }
        let length = Vec3::from(self.normal).norm();
        if !(length > 0.0 && length.is_finite()) {
            return bad("length of the normal", length, "positive and finite");
        }
        let across = periodic.into_iter().zip(self.normal).find(|(periodic, n)| *periodic && *n != 0.0);
        if let Some((_, value)) = across {
            return bad("component of the normal along a periodic axis", value, "zero");
        }
        if self.from.is_nan() {
            return bad("from", self.from, "a time");
        }
        match self.until {
            Some(time) if time.is_nan() => bad("until", time, "a time"),
            _ => Ok(()),
        }
    }
}

/// A wall as the loops use it.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Point at time zero, m.
    pub point: Vec3,
    /// Unit normal towards the grains.
    pub normal: Vec3,
    /// Velocity, m/s.
    pub velocity: OverTime<[f64; 3]>,
    /// Its part along the normal, m/s.
    pub along: OverTime<f64>,
    /// Time of appearing, s.
    pub from: f64,
    /// Time of vanishing, s; infinite if it stays.
    pub until: f64,
}

impl From<&Wall> for Plane {
    fn from(wall: &Wall) -> Self {
        let normal = Vec3::from(wall.normal).normalize();
        Self {
            point: wall.point.into(),
            normal,
            velocity: wall.velocity.clone(),
            along: wall.velocity.map(|velocity| Vec3::from(*velocity).dot(&normal)),
            from: wall.from,
            until: wall.until.unwrap_or(f64::INFINITY),
        }
    }
}

impl Plane {
    /// Gap between the plane and a grain at time `t`, m.
    #[inline(always)]
    #[must_use]
    pub fn gap(&self, position: &Vec3, radius: f64, t: f64) -> f64 {
        (position - self.point).dot(&self.normal) - self.moved(t) - radius
    }

    /// Way of the plane along its normal up to time `t`, m.
    #[inline(always)]
    #[must_use]
    pub fn moved(&self, t: f64) -> f64 {
        match &self.along {
            OverTime::Constant(speed) => speed * t,
            varies => varies.integral(t),
        }
    }

    /// Velocity at time `t`, m/s.
    #[inline(always)]
    #[must_use]
    pub fn velocity_at(&self, t: f64) -> Vec3 {
        self.velocity.at(t).into()
    }

    /// Largest speed along the normal, m/s.
    #[must_use]
    pub fn approach(&self) -> f64 {
        self.along.largest(f64::INFINITY)
    }

    /// Whether grains feel the wall at time `t`.
    #[inline(always)]
    #[must_use]
    pub fn acts(&self, t: f64) -> bool {
        self.from <= t && self.stands(t)
    }

    /// Whether the wall is not gone at time `t`: lists hold it also before it acts.
    #[inline(always)]
    #[must_use]
    pub fn stands(&self, t: f64) -> bool {
        t < self.until
    }
}
