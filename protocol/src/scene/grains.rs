//! Grains as written: one by one, from files, in groups.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::domain::Geometry;
use super::walls::forever;

/// Form of a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Sphere (space and axisymmetric).
    #[default]
    Sphere,
    /// Disc (plane), mass per unit depth.
    Disc,
}

/// Velocity that swings in place of a constant one: amplitude·sin(2π frequency t + phase).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Oscillation {
    /// Amplitude of the velocity (x, y, z), m/s.
    pub amplitude: [f64; 3],
    /// Frequency, Hz.
    pub frequency: f64,
    /// Phase, rad.
    #[serde(default)]
    pub phase: f64,
}

/// Who decides the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Newton's equations.
    #[default]
    Free,
    /// Never moves.
    Fixed,
    /// Keeps its `velocity` and `spin`, whatever pushes it.
    Prescribed,
}

/// A degree of freedom that can be locked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Freedom {
    X,
    Y,
    Z,
    SpinX,
    SpinY,
    SpinZ,
}

/// One grain.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grain {
    /// `sphere`, or `disc` in the plane (the default there).
    #[serde(default)]
    pub shape: Shape,
    /// Centre (x, y, z), m. Plane: y = 0; axisymmetric: x = y = 0.
    pub position: [f64; 3],
    /// Velocity at t = 0, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Spin at t = 0, rad/s.
    #[serde(default)]
    pub spin: [f64; 3],
    /// Orientation at t = 0, unit quaternion (w, x, y, z).
    #[serde(default = "upright")]
    pub orientation: [f64; 4],
    /// Radius, m.
    pub radius: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// `free`, `fixed` or `prescribed`.
    #[serde(default)]
    pub motion: Motion,
    /// Swing of a prescribed grain, in place of its `velocity` and `spin`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub oscillation: Option<Oscillation>,
    /// Degrees of freedom that are locked, besides those that the geometry has not.
    #[serde(default)]
    pub locked: Vec<Freedom>,
}

fn upright() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

impl Grain {
    /// A free sphere at rest.
    #[must_use]
    pub fn at(position: [f64; 3], radius: f64, density: f64) -> Self {
        Self {
            shape: Shape::Sphere,
            position,
            velocity: [0.0; 3],
            spin: [0.0; 3],
            orientation: upright(),
            radius,
            density,
            motion: Motion::Free,
            oscillation: None,
            locked: Vec::new(),
        }
    }

    /// Volume (plane: per unit depth), m³ or m².
    #[must_use]
    pub fn volume(&self) -> f64 {
        use std::f64::consts::PI;
        match self.shape {
            Shape::Sphere => 4.0 / 3.0 * PI * self.radius.powi(3),
            Shape::Disc => PI * self.radius.powi(2),
        }
    }

    /// Mass (plane: per unit depth).
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.density * self.volume()
    }

    /// Is this degree of freedom free in `geometry`?
    #[must_use]
    pub fn is_free(&self, freedom: Freedom, geometry: Geometry) -> bool {
        let allowed: &[Freedom] = match geometry {
            Geometry::Plane => &[Freedom::X, Freedom::Z, Freedom::SpinY],
            Geometry::Axisymmetric => &[Freedom::Z],
            Geometry::Space => {
                &[Freedom::X, Freedom::Y, Freedom::Z, Freedom::SpinX, Freedom::SpinY, Freedom::SpinZ]
            }
        };
        self.motion == Motion::Free && allowed.contains(&freedom) && !self.locked.contains(&freedom)
    }
}

/// Grains from a CSV file with the columns x, y, z, radius, density and, if present, vx, vy, vz, wx,
/// wy, wz, motion: `grains.csv` of a run is such a file.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainFile {
    /// Path, from the scene's folder.
    pub file: PathBuf,
    /// How often: a packing can be laid again and again beside itself.
    #[serde(default = "once")]
    pub copies: usize,
    /// From one copy to the next (x, y, z), m.
    #[serde(default)]
    pub shift: [f64; 3],
    /// Only grains that lie below this height with their whole surface, m: a packing cut to a column of any
    /// height. Copies are cut too.
    #[serde(default = "forever")]
    pub below: f64,
}

fn once() -> usize {
    1
}

/// Grains placed at random without overlap, reproducible from the seed.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// How many.
    pub count: usize,
    /// Lower corner (x, y, z) of the region that holds them whole, m.
    pub lower: [f64; 3],
    /// Upper corner, m.
    pub upper: [f64; 3],
    /// Mean radius, m.
    pub radius: f64,
    /// Half-width of the uniform spread of radii, relative to the mean.
    #[serde(default)]
    pub radius_spread: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Standard deviation of each component of their velocities, m/s. The mean is zero.
    #[serde(default)]
    pub velocity_deviation: f64,
    /// `free` or `fixed`.
    #[serde(default)]
    pub motion: Motion,
    /// Degrees of freedom that are locked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<Freedom>,
}
