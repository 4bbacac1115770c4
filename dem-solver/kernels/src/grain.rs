//! Shape of the grains, and one grain at time zero.

use crate::error::SpecError;
use crate::motion::{Freedom, Motion};
use bedload_outline::Outline;
use std::f64::consts::PI;

/// Shape of all grains of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// Solid sphere: m = 4/3 π R³ ρ, I = 2/5 m R².
    #[default]
    Sphere,
    /// Disc of a plane scene: m = π R² ρ per unit length, I = 1/2 m R².
    Disc,
}

impl Shape {
    /// Mass, kg (per unit length for a disc).
    #[must_use]
    pub fn mass(self, radius: f64, density: f64) -> f64 {
        match self {
            Self::Sphere => 4.0 / 3.0 * PI * radius.powi(3) * density,
            Self::Disc => PI * radius * radius * density,
        }
    }

    /// Moment of inertia about the centre, kg m².
    #[must_use]
    pub fn inertia(self, mass: f64, radius: f64) -> f64 {
        match self {
            Self::Sphere => 0.4 * mass * radius * radius,
            Self::Disc => 0.5 * mass * radius * radius,
        }
    }
}

/// One grain at time zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Grain {
    /// Centre, m.
    pub position: [f64; 3],
    /// Velocity of a free grain, m/s; others have theirs in `motion`.
    pub velocity: [f64; 3],
    /// Angular velocity of a free grain, rad/s.
    pub spin: [f64; 3],
    /// Orientation, unit quaternion (w, x, y, z), body to laboratory.
    pub orientation: [f64; 4],
    /// Radius, m; of a body that is not round the largest distance of its surface from its centre.
    pub radius: f64,
    /// Outline of a body that is not round: its place in [`crate::DemSpec::outlines`].
    pub outline: Option<u32>,
    /// Density, kg/m³.
    pub density: f64,
    /// Who moves it.
    pub motion: Motion,
    /// Wall that a grain goes with which forces do not move: a servo adds its speed to the motion, and takes
    /// the contact forces on the grain for its own.
    pub wall: Option<u32>,
    /// What is left free of a free grain.
    pub free: Freedom,
}

impl Grain {
    /// A free grain at rest.
    #[must_use]
    pub fn new(position: [f64; 3], radius: f64, density: f64) -> Self {
        Self {
            position,
            velocity: [0.0; 3],
            spin: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            radius,
            outline: None,
            density,
            motion: Motion::Free,
            wall: None,
            free: Freedom::SPACE,
        }
    }

    /// Mass and moment of inertia about the centre; the outline of a body that is not round is one of
    /// `outlines`.
    #[must_use]
    pub fn mass_and_inertia(&self, shape: Shape, outlines: &[Outline]) -> (f64, f64) {
        match self.outline.and_then(|place| outlines.get(place as usize)) {
            Some(outline) => {
                let mass = outline.area() * self.density;
                (mass, mass * outline.gyration())
            }
            None => {
                let mass = shape.mass(self.radius, self.density);
                (mass, shape.inertia(mass, self.radius))
            }
        }
    }

    pub(crate) fn validate(&self, grain: usize) -> Result<(), SpecError> {
        let bad = |quantity, value, allowed| Err(SpecError::Grain { grain, quantity, value, allowed });
        for (quantity, values) in [
            ("position", &self.position[..]),
            ("velocity", &self.velocity),
            ("spin", &self.spin),
            ("motion", &self.motion.values()),
        ] {
            if let Some(&value) = values.iter().find(|c| !c.is_finite()) {
                return bad(quantity, value, "finite");
            }
        }
        for (quantity, value) in [("radius", self.radius), ("density", self.density)] {
            if !(value > 0.0 && value.is_finite()) {
                return bad(quantity, value, "positive and finite");
            }
        }
        let norm = self.orientation.iter().map(|c| c * c).sum::<f64>().sqrt();
        if norm.is_nan() || (norm - 1.0).abs() > 1e-6 {
            return bad("length of the orientation quaternion", norm, "1 (to 1e-6)");
        }
        Ok(())
    }
}
