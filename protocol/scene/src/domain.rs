//! The box: geometry, grid, boundaries, and the fluid that fills it.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::walls::Wall;
use bedload_over_time::OverTime;

/// How many axes, and with what metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Geometry {
    /// (x, z), per unit depth.
    Plane,
    /// (r, z), axis of symmetry at r = 0.
    Axisymmetric,
    /// (x, y, z).
    Space,
}

/// An axis of the laboratory frame as the grid sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Axis {
    X,
    Y,
    Z,
    R,
}

impl Axis {
    /// `x`, `y`, `z` or `r`.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::R => "r",
        }
    }

    /// Component of a laboratory vector along this axis; the radial one stands for x.
    pub fn component(self) -> usize {
        match self {
            Self::X | Self::R => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

impl Geometry {
    /// The grid's axes in order.
    pub fn axes(self) -> &'static [Axis] {
        match self {
            Self::Plane => &[Axis::X, Axis::Z],
            Self::Axisymmetric => &[Axis::R, Axis::Z],
            Self::Space => &[Axis::X, Axis::Y, Axis::Z],
        }
    }

    /// Component (0 = x, 1 = y, 2 = z) of a laboratory vector along grid axis `axis`; the radial
    /// axis maps to x.
    pub fn component(self, axis: usize) -> usize {
        self.axes()[axis].component()
    }
}

/// What happens at a face of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallKind {
    /// Joined to the opposite face.
    Periodic,
    /// The fluid has the wall's velocity; grains bounce.
    NoSlip,
    /// No flow through, no shear; grains pass unless `contact = true`.
    FreeSlip,
    /// Fluid enters with a given velocity; grains pass unless `contact = true`.
    Inflow,
    /// Fluid leaves as it comes (convective condition); grains pass unless `contact = true`.
    Outflow,
}

impl WallKind {
    /// Does fluid pass through?
    pub fn is_open(self) -> bool {
        matches!(self, Self::Inflow | Self::Outflow)
    }
}

/// How the velocity of an inflow is spread over its face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InflowProfile {
    /// The same everywhere.
    #[default]
    Uniform,
    /// Laminar: a parabola between no-slip walls or around the axis, a product of two in a duct.
    Parabolic,
}

impl InflowProfile {
    /// Is it [`InflowProfile::Uniform`]?
    pub fn is_uniform(&self) -> bool {
        *self == Self::Uniform
    }
}

/// One face, written either as a name (`"no-slip"`) or as a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Face {
    /// Kind.
    #[serde(rename = "type")]
    pub kind: WallKind,
    /// Velocity of a no-slip wall along itself, or mean velocity of an inflow (x, y, z), m/s.
    pub velocity: OverTime<[f64; 3]>,
    /// How an inflow is spread.
    #[serde(skip_serializing_if = "InflowProfile::is_uniform")]
    pub profile: InflowProfile,
    /// Do grains touch it? By default no-slip faces yes, others no.
    pub contact: bool,
}

/// A face written as a table.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FaceTable {
    /// Kind.
    #[serde(rename = "type")]
    kind: WallKind,
    /// Velocity of a no-slip wall along itself, or mean velocity of an inflow (x, y, z), m/s.
    #[serde(default)]
    velocity: OverTime<[f64; 3]>,
    /// How an inflow is spread.
    #[serde(default)]
    profile: InflowProfile,
    /// Do grains touch it? By default no-slip faces yes, others no.
    contact: Option<bool>,
}

/// One face, written either as a name (`"no-slip"`) or as a table.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[allow(dead_code)]
enum WrittenFace {
    Name(WallKind),
    Table(FaceTable),
}

impl JsonSchema for Face {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Face".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        WrittenFace::json_schema(generator)
    }
}

impl From<FaceTable> for Face {
    fn from(table: FaceTable) -> Self {
        let contact = table.contact.unwrap_or(table.kind == WallKind::NoSlip);
        Self { kind: table.kind, velocity: table.velocity, profile: table.profile, contact }
    }
}

impl<'de> Deserialize<'de> for Face {
    /// By hand rather than `untagged`, which would lose the place and the reason of an error.
    fn deserialize<De: serde::Deserializer<'de>>(input: De) -> Result<Self, De::Error> {
        struct FaceVisitor;
        impl<'de> serde::de::Visitor<'de> for FaceVisitor {
            type Value = Face;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(
                    "\"periodic\", \"no-slip\", \"free-slip\", \"outflow\" or { type, velocity, profile, contact }",
                )
            }

            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Face, E> {
                let kind = WallKind::deserialize(serde::de::value::StrDeserializer::new(name))?;
                let profile = InflowProfile::default();
                Ok(FaceTable { kind, velocity: OverTime::default(), profile, contact: None }.into())
            }

            fn visit_map<M: serde::de::MapAccess<'de>>(self, map: M) -> Result<Face, M::Error> {
                FaceTable::deserialize(serde::de::value::MapAccessDeserializer::new(map)).map(Face::from)
            }
        }
        input.deserialize_any(FaceVisitor)
    }
}

/// The two faces of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// At the smaller coordinate; `None` at the axis of symmetry.
    pub lower: Option<Face>,
    /// At the larger coordinate.
    pub upper: Face,
}

/// Faces by name: `x_lower`, `x_upper`, … or, for both at once, `x`.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct Faces {
    pub x: Option<Face>,
    pub x_lower: Option<Face>,
    pub x_upper: Option<Face>,
    pub y: Option<Face>,
    pub y_lower: Option<Face>,
    pub y_upper: Option<Face>,
    pub z: Option<Face>,
    pub z_lower: Option<Face>,
    pub z_upper: Option<Face>,
    pub r_upper: Option<Face>,
}

impl Faces {
    /// The velocity of each face that is written, with its name.
    pub(crate) fn velocities(&mut self) -> impl Iterator<Item = (&'static str, &mut OverTime<[f64; 3]>)> {
        let Self { x, x_lower, x_upper, y, y_lower, y_upper, z, z_lower, z_upper, r_upper } = self;
        let faces = [
            ("x", x),
            ("x_lower", x_lower),
            ("x_upper", x_upper),
            ("y", y),
            ("y_lower", y_lower),
            ("y_upper", y_upper),
            ("z", z),
            ("z_lower", z_lower),
            ("z_upper", z_upper),
            ("r_upper", r_upper),
        ];
        faces.into_iter().filter_map(|(name, face)| Some((name, &mut face.as_mut()?.velocity)))
    }

    /// (both, lower, upper) as written for an axis.
    pub fn of(&self, axis: Axis) -> (Option<Face>, Option<Face>, Option<Face>) {
        match axis {
            Axis::X => (self.x.clone(), self.x_lower.clone(), self.x_upper.clone()),
            Axis::Y => (self.y.clone(), self.y_lower.clone(), self.y_upper.clone()),
            Axis::Z => (self.z.clone(), self.z_lower.clone(), self.z_upper.clone()),
            Axis::R => (None, None, self.r_upper.clone()),
        }
    }
}

/// A stretched axis: constant spacing up to `uniform_to`, then widths in arithmetic progression to
/// the far face, the cells in all as `cells` says (Izard et al. 2014, §3.1, for the r axis).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stretching {
    /// Axis.
    pub axis: Axis,
    /// End of the uniform part, m.
    pub uniform_to: f64,
    /// Spacing in the uniform part, m.
    pub spacing: f64,
}

/// Box, grid and boundaries.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// `plane`, `axisymmetric` or `space`.
    pub geometry: Geometry,
    /// Lower corner along the grid's axes, m.
    pub lower: Vec<f64>,
    /// Upper corner, m.
    pub upper: Vec<f64>,
    /// Cells along the grid's axes; not needed in a dry scene.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cells: Vec<usize>,
    /// One stretched axis, if any.
    pub stretching: Option<Stretching>,
    /// What happens at each face.
    pub boundary: Faces,
}

impl Domain {
    /// Number of axes of the grid.
    pub fn dimensions(&self) -> usize {
        self.geometry.axes().len()
    }

    /// Faces of grid axis `axis`, once validated.
    pub fn boundary(&self, axis: usize) -> Option<Boundary> {
        let name = self.geometry.axes()[axis];
        let (both, lower, upper) = self.boundary.of(name);
        let lower = lower.or_else(|| both.clone());
        let upper = upper.or(both)?;
        if name != Axis::R && lower.is_none() {
            return None;
        }
        Some(Boundary { lower, upper })
    }

    /// Is grid axis `axis` periodic?
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.boundary(axis).is_some_and(|faces| faces.upper.kind == WallKind::Periodic)
    }

    /// Lower end and length, m, along each component (x, y, z) that is periodic.
    pub fn periods(&self) -> [Option<(f64, f64)>; 3] {
        let mut periods = [None; 3];
        for axis in (0..self.dimensions()).filter(|axis| self.is_periodic(*axis)) {
            let lower = self.lower[axis];
            periods[self.geometry.component(axis)] = Some((lower, self.upper[axis] - lower));
        }
        periods
    }

    /// Those that the region between these corners spans from face to face; there it has no ends.
    pub(crate) fn spanned(&self, lower: &[f64; 3], upper: &[f64; 3]) -> [Option<(f64, f64)>; 3] {
        let mut spanned = self.periods();
        for axis in 0..self.dimensions() {
            let component = self.geometry.component(axis);
            let spans = lower[component] <= self.lower[axis] && upper[component] >= self.upper[axis];
            if !spans {
                spanned[component] = None;
            }
        }
        spanned
    }

    /// Does a face of grid axis `axis` hold the fluid?
    pub fn has_wall(&self, axis: usize) -> bool {
        let faces = self.boundary(axis);
        faces.is_some_and(|b| b.lower.iter().chain([&b.upper]).any(|f| f.kind == WallKind::NoSlip))
    }

    /// Largest over mean velocity of the inflow through a face of grid axis `axis`: 1 if uniform, 3/2
    /// for each pair of walls (or wall and free side) across, 2 in a tube.
    pub fn peak_over_mean(&self, axis: usize, face: &Face) -> f64 {
        if face.kind != WallKind::Inflow || face.profile.is_uniform() {
            return 1.0;
        }
        let across = (0..self.dimensions()).filter(|a| *a != axis && self.has_wall(*a));
        across.map(|a| if self.geometry.axes()[a] == Axis::R { 2.0 } else { 1.5 }).product()
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.iter().product()
    }

    /// Spacing near the grains along grid axis `axis`: of the uniform part where it is stretched.
    pub fn spacing(&self, axis: usize) -> f64 {
        match self.stretching {
            Some(stretching) if stretching.axis == self.geometry.axes()[axis] => stretching.spacing,
            _ => (self.upper[axis] - self.lower[axis]) / self.cells[axis] as f64,
        }
    }

    /// The least of [`Domain::spacing`] over the axes, m.
    pub fn smallest_spacing(&self) -> f64 {
        (0..self.dimensions()).map(|axis| self.spacing(axis)).fold(f64::INFINITY, f64::min)
    }

    /// Is `position` (x, y, z; m) beyond a face across `axis`?
    pub(crate) fn is_beyond(&self, axis: usize, position: &[f64; 3]) -> bool {
        !(self.lower[axis]..=self.upper[axis]).contains(&position[self.geometry.component(axis)])
    }

    /// Is a centre at `position` (x, y, z; m) in the box? Along periodic axes it always is.
    pub fn holds(&self, position: &[f64; 3]) -> bool {
        (0..self.dimensions()).all(|axis| self.is_periodic(axis) || !self.is_beyond(axis, position))
    }

    /// Lower and upper corner (x, y, z) of the box, m: y is 0 to 1 in the plane; the square about a tube.
    pub fn corners(&self) -> [[f64; 3]; 2] {
        let mut corners = [[0.0; 3], [1.0; 3]];
        for axis in 0..self.dimensions() {
            let c = self.geometry.component(axis);
            (corners[0][c], corners[1][c]) = (self.lower[axis], self.upper[axis]);
        }
        if self.geometry == Geometry::Axisymmetric {
            let radius = corners[1][0];
            (0..2).for_each(|c| (corners[0][c], corners[1][c]) = (-radius, radius));
        }
        corners
    }

    /// Why the region between two corners (x, y, z; m) is no part of the box, where it is none.
    pub fn no_part(&self, [lower, upper]: [[f64; 3]; 2]) -> Option<String> {
        let whole = self.corners();
        (0..3).filter(|c| *c != 1 || self.geometry != Geometry::Plane).find_map(|c| {
            let ([low, high], lower, upper) = (whole.map(|corner| corner[c]), lower[c], upper[c]);
            let slack = 1e-9 * (high - low);
            let inside = low - slack <= lower && lower < upper && upper <= high + slack;
            (!inside).then(|| {
                let name = ["x", "y", "z"][c];
                format!(
                    "spans {lower} to {upper} m along {name}; allowed: a part of the box, which spans {low} to \
                     {high} m"
                )
            })
        })
    }

    /// Lower and upper limit of each component (x, y, z) in the box, m; infinite along periodic axes, and
    /// where there is no axis.
    pub fn limits(&self) -> [[f64; 2]; 3] {
        let mut limits = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
        for axis in (0..self.dimensions()).filter(|axis| !self.is_periodic(*axis)) {
            limits[self.geometry.component(axis)] = [self.lower[axis], self.upper[axis]];
        }
        limits
    }

    /// The same where grains can leave: infinite too at faces that they touch.
    pub fn open_limits(&self) -> [[f64; 2]; 3] {
        let mut limits = self.limits();
        for wall in self.contact_faces() {
            for component in (0..3).filter(|c| wall.normal[*c] != 0.0) {
                let upper = wall.normal[component] < 0.0;
                limits[component][usize::from(upper)] = if upper { f64::INFINITY } else { f64::NEG_INFINITY };
            }
        }
        limits
    }

    /// The faces that grains touch, as plane walls.
    pub fn contact_faces(&self) -> Vec<Wall> {
        let mut walls = Vec::new();
        for axis in 0..self.dimensions() {
            let Some(faces) = self.boundary(axis) else { continue };
            let component = self.geometry.component(axis);
            let radial = self.geometry.axes()[axis] == Axis::R;
            let sides = [(faces.lower, self.lower[axis], 1.0), (Some(faces.upper), self.upper[axis], -1.0)];
            for (face, coordinate, sign) in sides {
                let Some(face) = face else { continue };
                // A grain on the axis cannot reach the outer cylinder.
                if !face.contact || radial {
                    continue;
                }
                let mut wall = Wall::at_rest([0.0; 3], [0.0; 3]);
                wall.point[component] = coordinate;
                wall.normal[component] = sign;
                // Only a wall moves: at an inflow face the velocity is that of the fluid that enters.
                if face.kind == WallKind::NoSlip {
                    wall.velocity = face.velocity.clone();
                }
                walls.push(wall);
            }
        }
        walls
    }
}

/// Velocity of the fluid at t = 0.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum InitialVelocity {
    /// At rest.
    #[default]
    Rest,
    /// The same everywhere.
    Uniform {
        /// (x, y, z), m/s.
        velocity: [f64; 3],
    },
    /// Simple shear: velocity `rate`·(distance from `origin` along `gradient`) along `direction`.
    Shear {
        /// Axis of the velocity.
        direction: Axis,
        /// Axis along which it changes.
        gradient: Axis,
        /// Rate, 1/s.
        rate: f64,
        /// Coordinate of zero velocity, m.
        origin: f64,
    },
    /// Taylor–Green vortices that fill the box: u = A sin(kx) cos(kz), w = −A cos(kx) sin(kz).
    TaylorGreen {
        /// Amplitude A, m/s.
        amplitude: f64,
    },
    /// The last state of another run, interpolated where its grid is another one.
    Run {
        /// Output folder of that run; a scene's own is looked up from its folder.
        folder: PathBuf,
    },
}

impl InitialVelocity {
    /// Velocity, m/s, and half the vorticity, rad/s, in the box of `domain` at `x` (x, y, z); at rest where
    /// another run says it.
    pub fn at(&self, domain: &Domain, x: [f64; 3]) -> [[f64; 3]; 2] {
        let [mut velocity, mut spin] = [[0.0; 3]; 2];
        match *self {
            Self::Rest | Self::Run { .. } => {}
            Self::Uniform { velocity: everywhere } => velocity = everywhere,
            Self::Shear { direction, gradient, rate, origin } => {
                let (c, g) = (direction.component(), gradient.component());
                velocity[c] = rate * (x[g] - origin);
                if c != g {
                    spin[3 - c - g] = if (g + 1) % 3 == c { 0.5 * rate } else { -0.5 * rate };
                }
            }
            Self::TaylorGreen { amplitude } => {
                // In space (x, z) too; the wave fills the box along both.
                let last = domain.dimensions() - 1;
                let k = |a: usize| std::f64::consts::TAU / (domain.upper[a] - domain.lower[a]);
                let (kx, kz) = (k(0), k(last));
                let ((sx, cx), (sz, cz)) = ((kx * x[0]).sin_cos(), (kz * x[2]).sin_cos());
                velocity = [amplitude * sx * cz, 0.0, -amplitude * kx / kz * cx * sz];
                spin[1] = -0.5 * amplitude * (kz + kx * kx / kz) * sx * sz;
            }
        }
        [velocity, spin]
    }
}

/// The fluid.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Medium {
    /// Density, kg/m³.
    pub density: f64,
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
    /// Velocity at t = 0.
    #[serde(default)]
    pub initial: InitialVelocity,
    /// Uniform body force on the fluid per unit mass, besides gravity, m/s². Gravity itself is
    /// carried by the hydrostatic pressure, except along periodic axes, where nothing balances it.
    #[serde(default)]
    pub body_force: OverTime<[f64; 3]>,
    /// Mean pressure gradient ∂p/∂x, Pa/m: drives the flow along periodic axes.
    #[serde(default)]
    pub pressure_gradient: OverTime<[f64; 3]>,
    /// Flow that is held along a periodic axis by a mean pressure gradient which follows from it.
    pub flow_rate: Option<FlowRate>,
}

/// A flow rate that is held.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlowRate {
    /// Axis along which the fluid flows; it must be periodic.
    pub axis: Axis,
    /// Mean velocity over the whole box (bulk velocity), grains included, m/s.
    pub mean_velocity: OverTime<f64>,
}

impl Medium {
    /// Kinematic viscosity ν = μ/ρ, m²/s.
    pub fn kinematic_viscosity(&self) -> f64 {
        self.viscosity / self.density
    }
}
