//! Grains as written: one by one, from files, in groups.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::Geometry;
use crate::walls::forever;
use bedload_outline::Outline;
use bedload_over_time::OverTime;

/// Form of a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Sphere (space and axisymmetric).
    #[default]
    Sphere,
    /// Disc (plane), mass per unit depth.
    Disc,
    /// Rectangle of two `sides` (plane).
    Rectangle,
    /// Ellipse of two `semi_axes` (plane).
    Ellipse,
    /// Convex polygon of `vertices` (plane).
    Polygon,
}

impl Shape {
    /// Whether it is a sphere or a disc.
    pub fn is_round(self) -> bool {
        matches!(self, Self::Sphere | Self::Disc)
    }
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

impl Freedom {
    /// All of them, in this order.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::SpinX, Self::SpinY, Self::SpinZ];
}

/// One grain.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grain {
    /// `sphere`, or `disc` in the plane (the default there); in the plane also `rectangle`, `ellipse` or
    /// `polygon`.
    #[serde(default)]
    pub shape: Shape,
    /// Sides of a rectangle along x and z in the frame of the body, m.
    pub sides: Option<[f64; 2]>,
    /// Semi-axes of an ellipse along x and z in the frame of the body, m.
    pub semi_axes: Option<[f64; 2]>,
    /// Vertices (x, z) of a convex polygon in the frame of the body, one after the other, m. `position` is
    /// where its centre of mass stands, wherever the vertices' own origin lies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vertices: Vec<[f64; 2]>,
    /// Centre (x, y, z), m. Plane: y = 0; axisymmetric: x = y = 0.
    pub position: [f64; 3],
    /// Velocity at t = 0, m/s; at all times of a prescribed grain.
    #[serde(default)]
    pub velocity: OverTime<[f64; 3]>,
    /// Spin at t = 0, rad/s; at all times of a prescribed grain, about an axis that does not turn.
    #[serde(default)]
    pub spin: OverTime<[f64; 3]>,
    /// Orientation at t = 0, unit quaternion (w, x, y, z).
    #[serde(default = "upright")]
    pub orientation: [f64; 4],
    /// Radius, m. Of a body that is not round it is not given: it becomes the largest distance of its surface
    /// from its centre.
    #[serde(default = "not_given")]
    pub radius: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// `free`, `fixed` or `prescribed`.
    #[serde(default)]
    pub motion: Motion,
    /// Degrees of freedom that are locked, besides those that the geometry has not.
    #[serde(default)]
    pub locked: Vec<Freedom>,
    /// Does it start as the fluid moves and turns at its centre? `velocity` and `spin` come on top.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub with_fluid: bool,
    /// The wall that it goes with, where a rough wall says so.
    #[serde(skip)]
    pub wall: Option<usize>,
}

fn upright() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

fn not_given() -> f64 {
    f64::NAN
}

impl Grain {
    /// A free sphere at rest.
    pub fn at(position: [f64; 3], radius: f64, density: f64) -> Self {
        Self {
            shape: Shape::Sphere,
            sides: None,
            semi_axes: None,
            vertices: Vec::new(),
            position,
            velocity: OverTime::default(),
            spin: OverTime::default(),
            orientation: upright(),
            radius,
            density,
            motion: Motion::Free,
            locked: Vec::new(),
            with_fluid: false,
            wall: None,
        }
    }

    /// Largest speed of its surface about its centre up to `until` by the spin that it is given, m/s.
    pub fn surface_speed(&self, until: f64) -> f64 {
        self.spin.largest(until) * self.radius
    }

    /// Volume (plane: per unit depth), m³ or m².
    pub fn volume(&self) -> f64 {
        use std::f64::consts::PI;
        match self.shape {
            Shape::Sphere => 4.0 / 3.0 * PI * self.radius.powi(3),
            Shape::Disc => PI * self.radius.powi(2),
            _ => self.outline().map_or(0.0, |outline| outline.area()),
        }
    }

    /// Moment of inertia over mass, m²: 2R²/5 for a sphere, R²/2 for a disc.
    pub fn gyration(&self) -> f64 {
        match self.shape {
            Shape::Sphere => 0.4 * self.radius * self.radius,
            Shape::Disc => 0.5 * self.radius * self.radius,
            _ => self.outline().map_or(0.0, |outline| outline.gyration()),
        }
    }

    /// Outline of a body that is not round; of a scene that was checked every such body has one.
    pub fn outline(&self) -> Option<Outline> {
        match self.shape {
            Shape::Sphere | Shape::Disc => None,
            Shape::Rectangle => self.sides.map(Outline::rectangle),
            Shape::Ellipse => self.semi_axes.map(|semi_axes| Outline::Ellipse { semi_axes }),
            Shape::Polygon => Outline::polygon(&self.vertices).ok(),
        }
    }

    /// Angle by which the body is turned about y, from z to x, rad.
    pub fn angle(&self) -> f64 {
        2.0 * self.orientation[2].atan2(self.orientation[0])
    }

    /// How far the surface reaches from the centre along `direction`, a unit vector of the laboratory, m.
    pub fn reach_along(&self, direction: [f64; 3]) -> f64 {
        let [x, _, z] = direction;
        self.outline().map_or(self.radius, |outline| outline.reach_along(self.angle(), [x, z]))
    }

    /// Diameter of the round body of the same volume, m.
    pub fn equivalent_diameter(&self) -> f64 {
        if self.shape.is_round() {
            2.0 * self.radius
        } else {
            2.0 * (self.volume() / std::f64::consts::PI).sqrt()
        }
    }

    /// Least width of the body, m.
    pub fn thickness(&self) -> f64 {
        self.outline().map_or(2.0 * self.radius, |outline| outline.thickness())
    }

    /// Half of it, m: what overlaps are judged by. The radius of what is round.
    pub fn half_width(&self) -> f64 {
        0.5 * self.thickness()
    }

    /// Mass (plane: per unit depth).
    pub fn mass(&self) -> f64 {
        self.density * self.volume()
    }

    /// Whether it never moves: fixed, or, which is the same, prescribed or locked in all freedoms at rest.
    pub fn stays(&self, geometry: Geometry) -> bool {
        let rests = || self.velocity.is_zero() && self.spin.is_zero();
        let free = |freedom: &Freedom| self.is_free(*freedom, geometry);
        self.motion == Motion::Fixed || (rests() && !Freedom::ALL.iter().any(free))
    }

    /// Is this degree of freedom free in `geometry`?
    pub fn is_free(&self, freedom: Freedom, geometry: Geometry) -> bool {
        let allowed: &[Freedom] = match geometry {
            Geometry::Plane => &[Freedom::X, Freedom::Z, Freedom::SpinY],
            Geometry::Axisymmetric => &[Freedom::Z],
            Geometry::Space => &Freedom::ALL,
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
    /// Do they start as the fluid moves and turns at their centres? Velocities of the table come on top.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub with_fluid: bool,
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
    /// Lower corner (x, y, z) of the region that holds them whole, m; along a periodic axis that it spans it
    /// holds their centres.
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
    /// Do they start as the fluid moves and turns at their centres? Random velocities come on top.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub with_fluid: bool,
}
