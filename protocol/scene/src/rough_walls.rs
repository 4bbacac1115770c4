//! Rough walls: flat layers of fixed grains.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::{Domain, Geometry};
use crate::grains::{Grain, Motion};
use crate::random::SplitMix64;
use crate::walls::Wall;

/// Arrangement of the centres of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Arrangement {
    /// Rows half a spacing apart along, √3/2 across.
    #[default]
    Hexagonal,
    /// Rows side by side.
    Square,
}

/// A rough wall: grains that stay, or go with a wall, whose centres fill a rectangle (plane: a line).
///
/// They may overlap each other.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoughWall {
    /// Lower corner (x, y, z) of the rectangle of centres: equal to `upper` along one axis, m.
    pub lower: [f64; 3],
    /// Upper corner, m.
    pub upper: [f64; 3],
    /// Mean radius, m.
    pub radius: f64,
    /// Half-width of the uniform spread of radii, relative to the mean.
    #[serde(default)]
    pub radius_spread: f64,
    /// Distance between neighbouring centres, m; by default two mean radii.
    pub spacing: Option<f64>,
    /// Arrangement of the centres.
    #[serde(default)]
    pub arrangement: Arrangement,
    /// Density, kg/m³; it has no meaning for fixed grains, but every grain has one.
    pub density: f64,
    /// Seed of the radii.
    #[serde(default)]
    pub seed: u64,
    /// Number of the wall that it goes with (`walls`), from 0: it moves as that does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall: Option<usize>,
}

impl RoughWall {
    /// Axes of the rectangle: the first along the rows, the second across (none in the plane).
    /// `None` unless the layer is flat, its lower corner below the upper one.
    fn axes(&self, geometry: Geometry) -> Option<(usize, Option<usize>)> {
        if (0..3).any(|axis| self.upper[axis] < self.lower[axis]) {
            return None;
        }
        let wide = |axis: &usize| self.upper[*axis] > self.lower[*axis];
        let plane = geometry == Geometry::Plane;
        let mut along = (0..3).filter(|axis| !(plane && *axis == 1)).filter(wide);
        let first = along.next()?;
        let second = if plane { None } else { Some(along.next()?) };
        along.next().is_none().then_some((first, second))
    }

    /// Centre-to-centre distance, m.
    pub fn spacing(&self) -> f64 {
        self.spacing.unwrap_or(2.0 * self.radius)
    }

    /// From row to row, m.
    fn across(&self) -> f64 {
        if self.arrangement == Arrangement::Hexagonal {
            0.75f64.sqrt() * self.spacing()
        } else {
            self.spacing()
        }
    }

    /// Whether it is flat: a rectangle, or a line in the plane.
    pub fn is_flat(&self, geometry: Geometry) -> bool {
        self.axes(geometry).is_some()
    }

    /// An axis along which the last grain of a row lies on the image of the first.
    pub(crate) fn meets_itself(&self, domain: &Domain) -> Option<usize> {
        let (first, second) = self.axes(domain.geometry)?;
        let meets = |axis: usize, step: f64| {
            let sites = ((self.upper[axis] - self.lower[axis]) / step * (1.0 + 1e-12)).floor();
            domain.periods()[axis].is_some_and(|(_, length)| (sites * step - length).abs() < 1e-9 * step)
        };
        let rows = second.map(|second| (second, self.across()));
        let mut steps = [(first, self.spacing())].into_iter().chain(rows);
        steps.find(|(axis, step)| meets(*axis, *step)).map(|(axis, _)| axis)
    }

    /// Number of grains it may have at most.
    pub(crate) fn count(&self, geometry: Geometry) -> f64 {
        let Some((first, second)) = self.axes(geometry) else { return 0.0 };
        let sites = |axis: usize| ((self.upper[axis] - self.lower[axis]) / self.spacing()).floor() + 1.0;
        sites(first) * second.map_or(1.0, |second| 1.2 * sites(second) + 1.0)
    }

    /// Appends the grains.
    pub(crate) fn lay(&self, geometry: Geometry, walls: &[Wall], grains: &mut Vec<Grain>) {
        let wall = self.wall.and_then(|number| walls.get(number));
        let motion = if wall.is_some() { Motion::Prescribed } else { Motion::Fixed };
        let velocity = wall.map(|wall| wall.velocity.clone()).unwrap_or_default();
        let Some((first, second)) = self.axes(geometry) else { return };
        let mut random = SplitMix64(self.seed);
        let (step, across) = (self.spacing(), self.across());
        let hexagonal = self.arrangement == Arrangement::Hexagonal;
        // A remainder of rounding is no reason to lose the last row.
        let fits = |length: f64, step: f64| (length / step * (1.0 + 1e-12)).floor() as usize;
        let rows = second.map_or(0, |second| fits(self.upper[second] - self.lower[second], across));
        for row in 0..=rows {
            let offset = if hexagonal && row % 2 == 1 { 0.5 * step } else { 0.0 };
            let length = self.upper[first] - self.lower[first] - offset;
            if length < 0.0 {
                continue;
            }
            for site in 0..=fits(length, step) {
                let mut position = self.lower;
                position[first] += offset + site as f64 * step;
                if let Some(second) = second {
                    position[second] += row as f64 * across;
                }
                let radius = random.about(self.radius, self.radius_spread);
                let (velocity, wall) = (velocity.clone(), self.wall);
                grains.push(Grain { motion, velocity, wall, ..Grain::at(position, radius, self.density) });
            }
        }
    }
}
