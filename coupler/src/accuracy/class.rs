//! Classes of scenes that have a chart, and what a scene must be to belong to one.

use bedload_scene::{
    Axis, CheckedScene, Face, Geometry, Grain, InitialVelocity, Metric, MetricKind, Motion, OverTime, Shape,
    WallKind,
};

use super::charted::Charted;
use super::numbers::{Number, Side};
use super::written::{Setting, settings};
use crate::keys;
use bedload_scene::speeds::{Speeds, drive};

/// A class of scenes whose errors one chart tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// One sphere that settles along the axis of an r–z box.
    Axis,
    /// One sphere that settles in space.
    Space,
    /// One sphere whose rebound is measured, in r–z.
    Bounce,
    /// One fixed sphere in a periodic cube that a force drives the fluid through.
    Lattice,
    /// Collisions of spheres without a fluid.
    Collision,
}

/// Name for people, name of chart, scene and data, and the data.
macro_rules! known {
    ($name:literal, $stem:literal) => {
        ($name, $stem, include_str!(concat!("data/", $stem, ".toml")))
    };
}

/// Of all classes, in their order.
const KNOWN: [(&str, &str, &str); 5] = [
    known!("one sphere that settles in r-z", "settling-axis"),
    known!("one sphere that settles in space", "settling-space"),
    known!("one sphere whose first rebound is measured, in r-z", "bounce"),
    known!("one fixed sphere in a periodic cube of driven fluid", "lattice"),
    known!("collisions of spheres without a fluid", "oblique-collision"),
];

/// Why a scene is in no class.
type Reason = String;

/// Why a scene with this setting is in none.
pub(super) fn nothing_with((key, value): &Setting) -> Reason {
    format!("nothing was charted with {key} = {value}")
}

/// The first of the reasons that holds.
fn first<const N: usize>(reasons: [(bool, &str); N]) -> Option<Reason> {
    reasons.into_iter().find(|(holds, _)| *holds).map(|(_, reason)| reason.to_owned())
}

/// Is a rebound measured?
pub(crate) fn bounces(scene: &CheckedScene) -> bool {
    scene.scene.metrics.iter().any(|metric| {
        matches!(
            metric.kind,
            MetricKind::ReboundVelocityRatio { .. }
                | MetricKind::RestitutionAtGap { .. }
                | MetricKind::ReboundHeight { .. }
                | MetricKind::SecondReboundHeight { .. }
                | MetricKind::ReboundRiseTime { .. }
                | MetricKind::ReboundDuration { .. }
        )
    })
}

/// Ar = |ρ_p/ρ − 1| g D³/ν² of a grain.
fn archimedes(scene: &CheckedScene, grain: &Grain) -> f64 {
    let Some(medium) = &scene.scene.medium else { return f64::INFINITY };
    let excess = (grain.density / medium.density - 1.0).abs();
    excess * scene.scene.largest_gravity() * (2.0 * grain.radius).powi(3)
        / medium.kinematic_viscosity().powi(2)
}

/// Number of `[dem.contact]`, `default` where the scene leaves it out.
fn contact(scene: &CheckedScene, key: &str, default: f64) -> f64 {
    let value = keys::look_up(scene, keys::CONTACT).and_then(|contact| contact.get(key));
    value.and_then(|value| value.as_float().or(value.as_integer().map(|n| n as f64))).unwrap_or(default)
}

impl Class {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Axis, Self::Space, Self::Bounce, Self::Lattice, Self::Collision];

    /// The class of a scene, or why it is in none.
    pub fn of(scene: &CheckedScene) -> Result<Self, Reason> {
        let class = Self::of_problem(scene)?;
        class.uncharted(scene).first().map_or(Ok(class), |other| Err(nothing_with(other)))
    }

    /// The same by all that the scene says but the settings of its solvers.
    pub(super) fn of_problem(scene: &CheckedScene) -> Result<Self, Reason> {
        let free = scene.has_free_grains();
        let class = match (&scene.scene.medium, scene.scene.domain.geometry) {
            (None, _) => Self::Collision,
            (Some(_), Geometry::Plane) => return Err("flows in the plane have no chart".to_owned()),
            (Some(_), Geometry::Axisymmetric) if free && bounces(scene) => Self::Bounce,
            (Some(_), Geometry::Axisymmetric) if free => Self::Axis,
            (Some(_), Geometry::Space) if free && bounces(scene) => {
                return Err("bounces are charted in r-z alone".to_owned());
            }
            (Some(_), Geometry::Space) if free => Self::Space,
            (Some(_), Geometry::Space) => Self::Lattice,
            (Some(_), Geometry::Axisymmetric) => {
                return Err("held grains are charted in space alone".to_owned());
            }
        };
        class.asks_for(scene).map_or(Ok(class), Err)
    }

    /// Its name for people.
    pub fn name(self) -> &'static str {
        KNOWN[self as usize].0
    }

    /// Name of its chart, of its scene and of its data.
    pub fn stem(self) -> &'static str {
        KNOWN[self as usize].1
    }

    /// File of its chart.
    pub fn chart_file(self) -> String {
        format!("docs/charts/{}.csv", self.stem())
    }

    /// Its chart, as data.
    pub fn data(self) -> &'static str {
        KNOWN[self as usize].2
    }

    /// Its chart.
    pub fn charted(self) -> Result<Charted, String> {
        Charted::parse(self.data())
            .map_err(|error| format!("has an unusable chart, {}: {error}", self.chart_file()))
    }

    /// Its own time, s, in which time steps are transferred: of settling (D/|ρ_p/ρ − 1| g)^½ or of viscosity
    /// D²/ν, the shorter. None where steps follow a Courant number or contacts.
    pub fn time(self, scene: &CheckedScene) -> Option<f64> {
        let medium = scene.scene.medium.as_ref()?;
        let grain = scene.grains.first()?;
        let diameter = 2.0 * grain.radius;
        let viscous = diameter * diameter / medium.kinematic_viscosity();
        // D/(|ρ_p/ρ − 1| g) = (D²/ν)²/Ar.
        let settling = viscous / archimedes(scene, grain).sqrt();
        match self {
            Self::Axis | Self::Space => Some(settling.min(viscous)),
            Self::Lattice => Some(viscous),
            Self::Bounce | Self::Collision => None,
        }
        .filter(|time| *time > 0.0 && time.is_finite())
    }

    /// What of the scene the chart has none of.
    fn asks_for(self, scene: &CheckedScene) -> Option<Reason> {
        match self {
            Self::Collision => collision(scene),
            Self::Axis | Self::Space | Self::Bounce => alone(scene).or_else(|| settling(scene, self)),
            Self::Lattice => alone(scene).or_else(|| lattice(scene)),
        }
    }

    /// What the scene says of the settings of its solvers, and no chart varies.
    pub(super) fn uncharted(self, scene: &CheckedScene) -> Vec<Setting> {
        let sections =
            [("fluid", &scene.scene.fluid), ("dem", &scene.scene.dem), ("coupling", &scene.scene.coupling)];
        let given = sections.into_iter().flat_map(|(name, section)| settings(section, name));
        let is = |value: &toml::Value, text: &str| value.as_str() == Some(text);
        let is_charted = |(key, value): &Setting| match key.as_str() {
            keys::CFL => true,
            keys::FLUID_DT => self != Self::Bounce,
            keys::TIME_SCHEME => is(value, keys::AB2),
            keys::INTEGRATOR | keys::CONTACT_STEPS => self == Self::Collision,
            keys::FILM => is(value, keys::COMPLEMENT),
            keys::ROUGHNESS => true,
            "dem.contact.law" => is(value, keys::LINEAR),
            other => other.starts_with("dem.contact.") || other.starts_with("coupling.deadline"),
        };
        given.filter(|setting| !is_charted(setting)).collect()
    }

    /// Its numbers: the first is the one between whose charted values a scene's errors are looked up.
    pub fn numbers(self, scene: &CheckedScene) -> Vec<Number> {
        let between = |name, value| Number { name, value, side: Side::Between };
        let from = |name, value| Number { name, value, side: Side::FromSmallest };
        let up_to = |name, value| Number { name, value, side: Side::UpToLargest };
        let Some(grain) = scene.grains.first() else { return Vec::new() };
        let diameter = 2.0 * grain.radius;
        let restitution = between("restitution", contact(scene, "restitution", 1.0));
        if self == Self::Collision {
            return vec![restitution, between("friction", contact(scene, "friction", 0.0))];
        }
        let Some(medium) = &scene.scene.medium else { return Vec::new() };
        let nu = medium.kinematic_viscosity();
        let speeds = Speeds::of(scene);
        let (domain, until) = (&scene.scene.domain, scene.scene.until);
        let density = between("ρ_p/ρ", grain.density / medium.density);
        let z = domain.geometry.axes().len() - 1;
        let down = if scene.scene.peak_gravity()[2] * (density.value - 1.0) < 0.0 { -1.0 } else { 1.0 };
        let to = |edge: f64| (edge - grain.position[2]).abs() / diameter - 0.5;
        let (below, above) = if down < 0.0 {
            (to(domain.lower[z]), to(domain.upper[z]))
        } else {
            (to(domain.upper[z]), to(domain.lower[z]))
        };
        let time = self.time(scene).unwrap_or(f64::NAN);
        let sides = from("the distance of the centre from the sides over D", aside(scene, grain) / diameter);
        match self {
            Self::Axis | Self::Space => {
                let left = below - speeds.grain * until / diameter;
                vec![
                    between("Ar = |ρ_p/ρ − 1| g D³/ν²", archimedes(scene, grain)),
                    density,
                    if self == Self::Axis { Number { side: Side::Between, ..sides } } else { sides },
                    from("the run over (D/|ρ_p/ρ − 1| g)^½ or D²/ν", until / time),
                    from("the room left in front of the sphere over D", left),
                    from("the room behind the sphere over D", above),
                ]
            }
            Self::Bounce => {
                let stokes = (density.value + 0.5) * speeds.grain * diameter / (9.0 * nu);
                let roughness = keys::look_up(scene, keys::ROUGHNESS);
                let roughness = roughness.map_or(Some(keys::ROUGHNESS_BY_DEFAULT), toml::Value::as_float);
                let contact_time = contact(scene, "contact_time", f64::NAN);
                vec![
                    between(
                        "St = (ρ_p + ρ/2) V D/(9 μ), V being the speed of Schiller & Naumann or of the fall",
                        stokes,
                    ),
                    density,
                    between("η/R", roughness.unwrap_or(f64::NAN)),
                    restitution,
                    from("the fall over D", below),
                    sides,
                    up_to("V t_c/D", speeds.grain * contact_time / diameter),
                ]
            }
            Self::Lattice => vec![
                between("the solid fraction", grain.volume() / bedload_scene::speeds::volume(scene)),
                up_to("Re = U D/ν, U being estimated", speeds.flow * diameter / nu),
                from("the run over D²/ν", until / time),
            ],
            Self::Collision => Vec::new(),
        }
    }
}

/// Least distance of a grain's centre from what stands beside its way: a wall, or half of the way to its own
/// image.
fn aside(scene: &CheckedScene, grain: &Grain) -> f64 {
    let domain = &scene.scene.domain;
    if domain.geometry == Geometry::Axisymmetric {
        return domain.upper[0];
    }
    let of = |axis: usize| {
        let (lower, upper) = (domain.lower[axis], domain.upper[axis]);
        if domain.is_periodic(axis) {
            0.5 * (upper - lower)
        } else {
            (grain.position[axis] - lower).min(upper - grain.position[axis])
        }
    };
    of(0).min(of(1))
}

/// What all charts of a fluid share: one sphere, a fluid that rests at first between faces that rest.
fn alone(scene: &CheckedScene) -> Option<Reason> {
    let Some(medium) = &scene.scene.medium else { return Some("there is no fluid".to_owned()) };
    let domain = &scene.scene.domain;
    if scene.grains.len() != 1 || !scene.scene.insertions.is_empty() {
        return Some(format!("one sphere was charted, the scene has {}", scene.grains.len()));
    }
    let grain = &scene.grains[0];
    let moves = !grain.velocity.is_zero() || !grain.spin.is_zero();
    let faces = || (0..domain.dimensions()).filter_map(|axis| domain.boundary(axis));
    let mut faces = faces().flat_map(|both| [both.lower, Some(both.upper)]).flatten();
    let closed = [WallKind::Periodic, WallKind::NoSlip, WallKind::FreeSlip];
    let flows = medium.initial != InitialVelocity::Rest || medium.flow_rate.is_some();
    let open = faces.any(|face| !face.velocity.is_zero() || !closed.contains(&face.kind));
    let more = !scene.scene.walls.is_empty() || scene.scene.stop_when.is_some();
    let drives = [&scene.scene.gravity, &medium.body_force, &medium.pressure_gradient];
    first([
        (grain.shape != Shape::Sphere, "a sphere was charted"),
        (drives.into_iter().any(OverTime::varies), "constant gravity and drives were charted"),
        (moves, "a sphere that is at rest at first was charted"),
        (flows, "a fluid that is at rest at first was charted, and no flow rate is held"),
        (open, "closed faces at rest were charted"),
        (more, "nothing was charted with [[walls]] or stop_when"),
    ])
}

/// What settling and bouncing spheres share besides.
fn settling(scene: &CheckedScene, class: Class) -> Option<Reason> {
    let grain = &scene.grains[0];
    let gravity = scene.scene.peak_gravity();
    let along_z = gravity[2] != 0.0 && gravity[0] == 0.0 && gravity[1] == 0.0;
    let domain = &scene.scene.domain;
    let stretched = domain.stretching.map(|stretching| stretching.axis);
    let floor = domain.boundary(domain.dimensions() - 1);
    let held = grain.motion != Motion::Free || !grain.locked.is_empty();
    let other_drive = !along_z || drive(&scene.scene) != [0.0; 3];
    let other_grid = stretched.is_some_and(|axis| class == Class::Space || axis != Axis::R);
    let is_floor = |floor: Face| floor.kind == WallKind::NoSlip;
    let floored = floor.and_then(|floor| floor.lower).is_some_and(is_floor) && gravity[2] <= 0.0;
    first([
        (held, "a free sphere was charted"),
        (other_drive, "gravity along z, between walls in z, was charted, and nothing drives the fluid"),
        (other_grid, "grids stretched along r were charted"),
        (
            class == Class::Bounce && !floored,
            "bounces on a no-slip floor, gravity pointing down, were charted",
        ),
    ])
    .or_else(|| {
        let second = |metric: &&Metric| {
            class == Class::Bounce
                && matches!(
                    metric.kind,
                    MetricKind::SecondReboundHeight { .. } | MetricKind::ReboundVelocityRatio { .. }
                )
        };
        let named = scene.scene.metrics.iter().find(second);
        named.map(|metric| format!("the metric {} was not charted", metric.name))
    })
}

fn lattice(scene: &CheckedScene) -> Option<Reason> {
    let domain = &scene.scene.domain;
    let side = |axis: usize| domain.upper[axis] - domain.lower[axis];
    let is_cube = (1..3).all(|axis| (side(axis) / side(0) - 1.0).abs() < 0.02);
    let driven = drive(&scene.scene).iter().filter(|component| **component != 0.0).count();
    let periodic = (0..3).all(|axis| domain.is_periodic(axis));
    first([
        (scene.grains[0].motion != Motion::Fixed, "a fixed sphere was charted"),
        (!periodic || !is_cube || domain.stretching.is_some(), "a periodic cube was charted"),
        (driven != 1, "a force along one axis was charted"),
    ])
}

/// Grains of the chart of collisions.
const COLLIDING: usize = 30;

fn collision(scene: &CheckedScene) -> Option<Reason> {
    let many = scene.grains.len() > COLLIDING || !scene.scene.insertions.is_empty();
    let plain = scene.scene.walls.is_empty() && scene.scene.stop_when.is_none();
    if many || scene.grains.iter().any(|grain| grain.shape != Shape::Sphere || grain.motion != Motion::Free) {
        Some(format!("collisions of {COLLIDING} free spheres were charted"))
    } else {
        first([(
            scene.scene.largest_gravity() > 0.0 || !plain,
            "collisions without gravity and walls were charted",
        )])
    }
}
