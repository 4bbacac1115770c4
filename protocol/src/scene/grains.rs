//! Grains and walls as written, and laid out one by one.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;
use super::domain::Geometry;
use super::error::SceneError;
use super::pours::{self, Poured};
use super::random::SplitMix64;
use super::source::SceneSource;
use super::table;

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
    /// Path, from the folder in which the command runs.
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
    pub velocity: [f64; 3],
    /// The wall is there from this time on, s; it moves from time zero on all the same.
    #[serde(default)]
    pub from: f64,
    /// The wall vanishes at this time, s (a gate).
    #[serde(default = "forever")]
    pub until: f64,
}

pub(super) fn forever() -> f64 {
    f64::INFINITY
}

impl Wall {
    /// A wall that stays.
    #[must_use]
    pub fn at_rest(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self { point, normal, velocity: [0.0; 3], from: 0.0, until: f64::INFINITY }
    }
}

/// Every grain of the scene in message order: `grains`, `grain_files`, `layers`, `groups`, and, in
/// order of their times, `pours`.
pub(super) fn lay_out(scene: &Scene, source: &SceneSource) -> Result<(Vec<Grain>, Vec<Poured>), SceneError> {
    let geometry = scene.domain.geometry;
    let mut grains = scene.grains.clone();
    for (index, from) in scene.grain_files.iter().enumerate() {
        grains.extend(table::read(from).map_err(|why| {
            source.error(
                &format!("grain_files[{index}].file"),
                why,
                "give a CSV file with the header x,y,z,radius,density[,vx,vy,vz][,wx,wy,wz][,motion] and one row per grain",
            )
        })?);
    }
    for layer in &scene.layers {
        layer.lay(geometry, &mut grains);
    }
    for (index, group) in scene.groups.iter().enumerate() {
        place(group, geometry, &mut grains).map_err(|why| {
            source.error(
                &format!("groups[{index}]"),
                why,
                "make the region larger, or the count or the radius smaller",
            )
        })?;
    }
    let (more, poured) = pours::lay_out(&scene.pours, geometry);
    grains.extend(more);
    let grains = grains.into_iter().map(|grain| with_shape(grain, geometry)).collect();
    Ok((grains, poured))
}

fn with_shape(mut grain: Grain, geometry: Geometry) -> Grain {
    if geometry == Geometry::Plane {
        grain.shape = Shape::Disc;
    }
    grain
}

/// Random sequential placement: draw, keep if free of every grain so far. Neighbours are found
/// through a table of cells as wide as the largest grain, so that n grains cost O(n).
fn place(group: &Group, geometry: Geometry, grains: &mut Vec<Grain>) -> Result<(), String> {
    let largest =
        grains.iter().map(|grain| grain.radius).fold(group.radius * (1.0 + group.radius_spread), f64::max);
    let cell = |position: &[f64; 3]| position.map(|x| (x / (2.0 * largest)).floor() as i64);
    let mut table: std::collections::HashMap<[i64; 3], Vec<usize>> = std::collections::HashMap::new();
    for (index, grain) in grains.iter().enumerate() {
        table.entry(cell(&grain.position)).or_default().push(index);
    }
    let mut random = SplitMix64(group.seed);
    for number in 0..group.count {
        let radius = random.about(group.radius, group.radius_spread);
        let position = (0..1_000)
            .map(|_| random.place(geometry, &group.lower, &group.upper, radius))
            .find(|position| is_clear(position, radius, cell(position), &table, grains))
            .ok_or(format!("no room for grain {} of {} after 1000 tries", number + 1, group.count))?;
        table.entry(cell(&position)).or_default().push(grains.len());
        let (motion, locked) = (group.motion, group.locked.clone());
        grains.push(Grain { motion, locked, ..Grain::at(position, radius, group.density) });
    }
    if group.velocity_deviation > 0.0 {
        let first = grains.len() - group.count;
        stir(group, geometry, &mut grains[first..]);
    }
    Ok(())
}

/// Random velocities: each component a sum of twelve uniform numbers (Irwin–Hall), which is nearly Gaussian
/// and the same on every machine, less the mean, and scaled to the standard deviation asked for.
fn stir(group: &Group, geometry: Geometry, grains: &mut [Grain]) {
    // A stream of its own: the places do not depend on it.
    let mut random = SplitMix64(group.seed ^ 0x6a09_e667_f3bc_c908);
    for (axis, freedom) in [Freedom::X, Freedom::Y, Freedom::Z].into_iter().enumerate() {
        let drawn: Vec<f64> = grains.iter().map(|_| (0..12).map(|_| random.unit()).sum::<f64>()).collect();
        let count = drawn.len().max(1) as f64;
        let mean = drawn.iter().sum::<f64>() / count;
        let square = drawn.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        let scale = if square > 0.0 { group.velocity_deviation / square.sqrt() } else { 0.0 };
        for (grain, value) in grains.iter_mut().zip(drawn) {
            if grain.is_free(freedom, geometry) {
                grain.velocity[axis] = (value - mean) * scale;
            }
        }
    }
}

fn is_clear(
    position: &[f64; 3],
    radius: f64,
    home: [i64; 3],
    table: &std::collections::HashMap<[i64; 3], Vec<usize>>,
    grains: &[Grain],
) -> bool {
    let near = (0..27i64).map(|n| [home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1]);
    near.filter_map(|cell| table.get(&cell)).flatten().all(|other| {
        let other = &grains[*other];
        let distance2: f64 = (0..3).map(|axis| (position[axis] - other.position[axis]).powi(2)).sum();
        distance2 >= (radius + other.radius).powi(2)
    })
}
