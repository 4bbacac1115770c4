//! A grain as the fluid sees it: a rigid body with a given motion.

use crate::grid::Geometry;
use bedload_outline::Outline;
use protocol::message::Kinematics;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What never changes about a grain.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Radius, m; of a body that is not round, the largest distance of its surface from its centre.
    pub radius: f64,
    /// Outline of a body that is not round.
    pub outline: Option<Arc<Outline>>,
    /// Radius of its mask, m: see [`super::pores`].
    pub mask_radius: f64,
    /// Part of the wave in the distance that its mask has, 0 to 1: see [`super::pores`].
    pub wave: f64,
    /// Where its mask is open to what flows along its surface.
    pub patches: Vec<Patch>,
    /// Density of the grain, kg/m³.
    pub density: f64,
    /// Volume, m³ (plane: m² per metre of depth).
    pub volume: f64,
    /// Moment of inertia over mass, m²: 2R²/5 for a sphere, R²/2 for a disc.
    pub gyration: f64,
}

impl Shape {
    /// A round grain whose mask has its radius.
    pub const fn round(radius: f64, density: f64, volume: f64, gyration: f64) -> Self {
        Self {
            radius,
            outline: None,
            mask_radius: radius,
            wave: 1.0,
            patches: Vec::new(),
            density,
            volume,
            gyration,
        }
    }
}

/// Where a mask is open to what flows along the surface, before what is near: no force stays there in cells
/// that two masks seal (docs/equations-immersed.md, section 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Direction of what is near (laboratory axes).
    pub normal: [f64; 3],
    /// Distance from the centre in that direction from which on it is open, m.
    pub from: f64,
    /// Distance from the line through the centre in that direction up to which it is open, m.
    pub radius: f64,
    /// Largest mask ratio there.
    pub most: f64,
}

impl Patch {
    /// Lowers the mask ratios of places in it, whose arms from the centre are (x + `shift`, `y`, `z`), m
    /// (laboratory axes; r and z for x and z).
    #[inline(always)]
    pub(super) fn open(&self, ratios: &mut [f64], places: &[f64], [shift, y, z]: [f64; 3]) {
        let Self { normal: [a, b, c], from, radius, most } = *self;
        let (along, across) = (b * y + c * z, y * y + z * z - radius * radius);
        for (ratio, x) in ratios.iter_mut().zip(places) {
            let x = x + shift;
            let along = a * x + along;
            let inside = (along > from) & (x * x + across < along * along) & (*ratio > most);
            *ratio = if inside { most } else { *ratio };
        }
    }

    /// Between which y it holds places at `z` along the third axis, of a grain that reaches as far as
    /// `reach`, m: those of the part of a circle beyond a chord.
    #[inline(always)]
    pub(super) fn rows(&self, z: f64, reach: f64) -> Option<[f64; 2]> {
        let Self { normal: [a, b, c], from, .. } = *self;
        let (circle2, beyond, flat2) = (reach * reach - z * z, from - c * z, a * a + b * b);
        let half2 = circle2 * flat2 - beyond * beyond;
        if half2 <= 0.0 {
            return (beyond < 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
        }
        let (middle, half, end) = (b * beyond / flat2, a.abs() * half2.sqrt() / flat2, circle2.sqrt());
        let low = if -b * end > beyond { -end } else { middle - half };
        Some([low, if b * end > beyond { end } else { middle + half }])
    }

    /// Whether component `c` of the velocity (laboratory axes) lies along the surface rather than across it.
    pub(super) fn lies_along(&self, c: usize) -> bool {
        self.normal[c].abs() < 0.5
    }
}

/// Where a grain is and how it moves, laboratory frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Centre, m.
    pub centre: [f64; 3],
    /// Velocity of the centre, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
    /// Angle about y by which a body of the plane is turned, from z to x, rad.
    pub angle: f64,
}

/// An outline as a body holds it.
#[derive(Clone, Debug)]
pub struct Turned {
    outline: Arc<Outline>,
    /// Angle about y, rad.
    pub angle: f64,
    sine: f64,
    cosine: f64,
}

impl Turned {
    /// `outline`, turned by `angle`, rad.
    pub fn new(outline: &Arc<Outline>, angle: f64) -> Self {
        let (sine, cosine) = angle.sin_cos();
        Self { outline: Arc::clone(outline), angle, sine, cosine }
    }

    /// Distance of a point at `arm` (x, z) from the centre to the surface, negative inside, and the outward
    /// normal there, m and 1.
    pub fn distance(&self, [x, z]: [f64; 2]) -> (f64, [f64; 2]) {
        let Self { outline, sine, cosine, .. } = self;
        let (distance, [n, m]) = outline.distance([cosine * x - sine * z, sine * x + cosine * z]);
        (distance, [cosine * n + sine * m, cosine * m - sine * n])
    }
}

impl Motion {
    /// The coupling part of a message. What the geometry has no room for is dropped: motion off the
    /// plane, and all but the motion along the axis in an axisymmetric run.
    pub fn received(geometry: Geometry, from: &Kinematics) -> Self {
        let mut motion = Self { centre: from.position, velocity: from.velocity, spin: from.spin, angle: 0.0 };
        match geometry {
            Geometry::Space => {}
            Geometry::Plane => {
                (motion.centre[1], motion.velocity[1]) = (0.0, 0.0);
                (motion.spin[0], motion.spin[2]) = (0.0, 0.0);
                motion.angle = 2.0 * from.orientation[2].atan2(from.orientation[0]);
            }
            Geometry::Axisymmetric => {
                for c in 0..2 {
                    (motion.centre[c], motion.velocity[c]) = (0.0, 0.0);
                }
                motion.spin = [0.0; 3];
            }
        }
        motion
    }

    /// Where the motion leads within `dt` at constant velocity.
    pub fn predicted(&self, dt: f64) -> Self {
        let centre = std::array::from_fn(|c| self.centre[c] + dt * self.velocity[c]);
        Self { centre, angle: self.angle + dt * self.spin[1], ..*self }
    }

    /// Speed of the centre, m/s.
    pub fn speed(&self) -> f64 {
        self.velocity.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        [self.centre, self.velocity, self.spin].as_flattened().iter().all(|x| x.is_finite())
            && self.angle.is_finite()
    }

    /// Component `c` of the velocity at the arm `arm` from the centre: U + ω × r.
    #[inline(always)]
    pub fn velocity_at(&self, c: usize, arm: [f64; 3]) -> f64 {
        let (a, b) = ((c + 1) % 3, (c + 2) % 3);
        self.velocity[c] + self.spin[a] * arm[b] - self.spin[b] * arm[a]
    }

    /// How that component changes per metre along laboratory axis `axis`.
    #[inline(always)]
    pub fn slope(&self, c: usize, axis: usize) -> f64 {
        let (a, b) = ((c + 1) % 3, (c + 2) % 3);
        if axis == b {
            self.spin[a]
        } else if axis == a {
            -self.spin[b]
        } else {
            0.0
        }
    }
}

/// Laboratory component (0 x, 1 y, 2 z) of grid axis `axis`; the radial axis stands for x.
pub fn laboratory(geometry: Geometry, axis: usize) -> usize {
    match geometry {
        Geometry::Space => axis,
        Geometry::Plane | Geometry::Axisymmetric => 2 * axis,
    }
}

/// Components of a vector (laboratory axes) along the axes of the grid.
pub fn along_axes<const D: usize>(geometry: Geometry, vector: [f64; 3]) -> [f64; D] {
    std::array::from_fn(|a| vector[laboratory(geometry, a)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigid_velocity_is_the_cross_product() {
        let motion =
            Motion { centre: [0.0; 3], velocity: [1.0, 2.0, 3.0], spin: [0.5, -0.25, 2.0], angle: 0.0 };
        let arm = [0.1, 0.2, -0.3];
        let cross = nalgebra::Vector3::from(motion.spin).cross(&nalgebra::Vector3::from(arm));
        for c in 0..3 {
            let here = motion.velocity_at(c, arm);
            assert!((here - motion.velocity[c] - cross[c]).abs() < 1e-15);
            for axis in 0..3 {
                let mut further = arm;
                further[axis] += 1.0;
                let step = motion.velocity_at(c, further) - here;
                assert!((step - motion.slope(c, axis)).abs() < 1e-15);
            }
        }
    }
}
