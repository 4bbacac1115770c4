//! The speeds that follow from a scene before it runs: what it names, and what its forces lead to. Each is
//! an estimate from above, the least of what resistance, room and time allow.

use std::collections::HashMap;

use crate::checked::CheckedScene;
use crate::domain::{Face, Geometry, InitialVelocity, WallKind};
use crate::grains::{Freedom, Grain, Motion, Shape};
use crate::shared::Scene;
use crate::walls::Wall;
use bedload_over_time::peak_of_sum;

/// Solid fraction of grains that came to rest on each other.
const PACKED: f64 = 0.6;

/// Re up to which Schiller & Naumann (1935) holds; beyond it C_D = 0.44.
const SCHILLER_NAUMANN: f64 = 1000.0;

/// Speeds of a scene, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Speeds {
    /// Largest of the fluid: faces, flow at the start, drive.
    pub flow: f64,
    /// Largest of a grain: thrown, settling, falling.
    pub grain: f64,
    /// Largest of two grains against each other, or of one against a wall at rest.
    pub approach: f64,
    /// The largest, without what a drive leads the fluid to: what resists it is known least.
    pub undriven: f64,
    /// Largest of grains against each other or a wall that the scene itself gives them.
    pub named_approach: f64,
}

impl Speeds {
    /// Of a scene.
    pub fn of(scene: &CheckedScene) -> Self {
        let start = start(scene);
        let named = named_flow(scene, start);
        let flow = named.max(start + driven(scene));
        let falls = falls(scene).into_iter().fold(0.0, f64::max);
        let until = scene.scene.until;
        let surface = |grain: &Grain| grain.surface_speed(until);
        // The spin of what is not round moves it against others.
        let turns = |grain: &Grain| if grain.shape.is_round() { 0.0 } else { surface(grain) };
        let thrown = |grain: &Grain| grain.velocity.largest(until) + turns(grain);
        let mut thrown: Vec<f64> = scene.grains.iter().map(thrown).collect();
        thrown.sort_by(|a, b| b.total_cmp(a));
        let [fastest, second] = [0, 1].map(|place| thrown.get(place).copied().unwrap_or(0.0));
        let meeting = fastest + second.max(scene.wall_speed(until));
        // Walls that slide along themselves meet nothing.
        let walls = scene.contact_walls();
        let nearing =
            walls.iter().map(|wall| wall.nearing_speed(&scene.scene.domain, until)).fold(0.0, f64::max);
        let grain = fastest.max(falls);
        let undriven = scene.grains.iter().map(surface).fold(named.max(grain), f64::max);
        Self {
            flow,
            grain,
            approach: meeting.max(falls),
            undriven,
            named_approach: fastest + second.max(nearing),
        }
    }

    /// The largest.
    pub fn largest(&self) -> f64 {
        self.flow.max(self.grain)
    }
}

/// Length of a vector.
pub fn norm(v: &[f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Acceleration that drives the fluid as a whole: body force, mean pressure gradient, and gravity along
/// periodic axes, each at its largest, m/s². Where a flow rate is held, a mean pressure gradient balances
/// them.
pub fn drive(scene: &Scene) -> [f64; 3] {
    let Some(medium) = &scene.medium else { return [0.0; 3] };
    let domain = &scene.domain;
    let component = |axis: usize| domain.geometry.component(axis);
    std::array::from_fn(|c| {
        let axis = (0..domain.dimensions()).find(|axis| component(*axis) == c && domain.is_periodic(*axis));
        let held = medium.flow_rate.as_ref().map(|flow| flow.axis);
        if axis.is_some_and(|axis| held == Some(domain.geometry.axes()[axis])) {
            return 0.0;
        }
        let body = medium.body_force.map(|f| f[c]);
        let gradient = medium.pressure_gradient.map(|g| -g[c] / medium.density);
        let gravity = axis.map(|_| scene.gravity.map(|g| g[c])).unwrap_or_default();
        peak_of_sum(&[body, gradient, gravity], scene.until)
    })
}

/// Largest speed of the fluid at the start, m/s; of a flow from another run zero: it is not known here.
pub fn start(scene: &CheckedScene) -> f64 {
    let Some(medium) = &scene.scene.medium else { return 0.0 };
    let domain = &scene.scene.domain;
    match &medium.initial {
        // Only the fluid can look into another run; its first step and its bound `cfl` are of that speed.
        InitialVelocity::Rest | InitialVelocity::Run { .. } => 0.0,
        InitialVelocity::Uniform { velocity } => norm(velocity),
        InitialVelocity::TaylorGreen { amplitude } => {
            let [along, across] = [0, domain.dimensions() - 1].map(|a| domain.upper[a] - domain.lower[a]);
            amplitude.abs() * (across / along).max(1.0)
        }
        InitialVelocity::Shear { gradient, rate, origin, .. } => {
            let axis = domain.geometry.axes().iter().position(|axis| axis == gradient).unwrap_or(0);
            rate.abs() * (domain.upper[axis] - origin).abs().max((domain.lower[axis] - origin).abs())
        }
    }
}

/// Largest speed of the fluid that the scene names: at the start, at faces, and the mean that is held.
fn named_flow(scene: &CheckedScene, start: f64) -> f64 {
    let Some(medium) = &scene.scene.medium else { return 0.0 };
    let domain = &scene.scene.domain;
    let faces = (0..domain.dimensions()).filter_map(|axis| domain.boundary(axis).map(|faces| (axis, faces)));
    let peak = |axis: usize, face: &Face| {
        domain.peak_over_mean(axis, face) * face.velocity.largest(scene.scene.until)
    };
    let faces = faces.flat_map(|(axis, faces)| {
        [faces.lower.as_ref().map_or(0.0, |lower| peak(axis, lower)), peak(axis, &faces.upper)]
    });
    let held = medium.flow_rate.as_ref().map_or(0.0, |flow| flow.mean_velocity.largest(scene.scene.until));
    faces.fold(start.max(held), f64::max)
}

/// What a drive leads to: until the end without resistance, laminar between walls, or against held grains.
fn driven(scene: &CheckedScene) -> f64 {
    let Some(medium) = &scene.scene.medium else { return 0.0 };
    let drive = drive(&scene.scene);
    let size = norm(&drive);
    if size == 0.0 {
        return 0.0;
    }
    let (domain, nu) = (&scene.scene.domain, medium.kinematic_viscosity());
    let solid: f64 = scene.grains.iter().map(Grain::volume).sum();
    let mut least = size * scene.scene.until;
    for axis in 0..domain.dimensions() {
        let Some(faces) = domain.boundary(axis) else { continue };
        let extent = domain.upper[axis] - domain.lower[axis];
        // A bed takes its part of the width.
        let width = (extent - solid / PACKED / (volume(scene) / extent)).max(0.1 * extent);
        let walls = faces.lower.iter().chain([&faces.upper]);
        let still = walls.filter(|face| face.kind == WallKind::NoSlip).count();
        let radial = domain.geometry == Geometry::Axisymmetric && axis == 0;
        let laminar = match (still, radial) {
            (0, _) => f64::INFINITY,
            (_, true) => extent * extent / (4.0 * nu),
            (1, _) => width * width / (2.0 * nu),
            _ => width * width / (8.0 * nu),
        };
        least = least.min(size * laminar);
    }
    let held: Vec<&Grain> = scene.grains.iter().filter(|grain| grain.motion != Motion::Free).collect();
    if let Some(smallest) = held.iter().min_by(|a, b| a.radius.total_cmp(&b.radius)) {
        // Each bears its part of the drive; alone it would do so at the largest speed.
        let force = size * volume(scene) / held.len() as f64;
        least = least.min(speed_under(force, smallest.shape, 2.0 * smallest.radius, nu));
    }
    least
}

/// Volume of the box, m³; its area in the plane, m².
pub fn volume(scene: &CheckedScene) -> f64 {
    let domain = &scene.scene.domain;
    let extent = |axis: usize| domain.upper[axis] - domain.lower[axis];
    match domain.geometry {
        Geometry::Axisymmetric => std::f64::consts::PI * domain.upper[0].powi(2) * extent(1),
        _ => (0..domain.dimensions()).map(extent).product(),
    }
}

/// Drag of a sphere over Stokes's (Schiller & Naumann 1935).
pub fn over_stokes(reynolds: f64) -> f64 {
    1.0 + 0.15 * reynolds.powf(0.687)
}

/// Speed at which drag balances `force` over the fluid's density, m⁴/s² (plane: m³/s²): of a sphere C_D =
/// 24/Re (1 + 0.15 Re^0.687), 0.44 from Re = 1000 on (Schiller & Naumann 1935); of a body of the plane, as of
/// a cylinder that surrounds it, C_D = 1 + 10 Re^(−2/3) (White 1991, eq. 3-225).
pub fn speed_under(force: f64, shape: Shape, diameter: f64, nu: f64) -> f64 {
    let drag = |speed: f64| {
        let re = speed * diameter / nu;
        let (coefficient, area) = match shape {
            Shape::Sphere if re > SCHILLER_NAUMANN => {
                (0.44, 0.25 * std::f64::consts::PI * diameter * diameter)
            }
            Shape::Sphere => (24.0 / re * over_stokes(re), 0.25 * std::f64::consts::PI * diameter * diameter),
            _ => (1.0 + 10.0 * re.powf(-2.0 / 3.0), diameter),
        };
        0.5 * coefficient * area * speed * speed
    };
    if !(force > 0.0 && force.is_finite()) {
        return if force > 0.0 { f64::INFINITY } else { 0.0 };
    }
    // The logarithm of the speed by bisection: drag grows with it.
    let (mut low, mut high) = (-100.0_f64, 100.0_f64);
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        if drag(middle.exp()) < force { low = middle } else { high = middle }
    }
    high.exp()
}

/// Speed that gravity gives each free grain: its terminal velocity in a fluid at rest, if there is time and
/// room for it, or that of its fall.
fn falls(scene: &CheckedScene) -> Vec<f64> {
    let until = scene.scene.until;
    let medium = scene.scene.medium.as_ref();
    let below = Below::new(scene);
    let fall = |grain: &Grain| {
        let inertia = medium.map_or(1.0, |medium| 1.0 + 0.5 * medium.density / grain.density);
        let along = |component: usize, weight: f64| {
            if weight == 0.0 {
                return 0.0;
            }
            let room = below.room(grain, component, weight);
            let start = grain.velocity.start()[component] * weight.signum();
            let by_time = (start + weight.abs() / inertia * until).max(0.0);
            let by_room = (start * start + 2.0 * weight.abs() / inertia * room).sqrt();
            by_time.min(by_room).powi(2)
        };
        let speed2: f64 = (0..3)
            .map(|component| {
                let [low, high] = weights(scene, grain, component).map(|weight| along(component, weight));
                low.max(high)
            })
            .sum();
        let terminal = medium.map_or(f64::INFINITY, |medium| {
            let pull = norm(&std::array::from_fn(|component| {
                let [low, high] = weights(scene, grain, component);
                low.abs().max(high.abs())
            }));
            let force = pull * grain.mass() / medium.density;
            speed_under(force, grain.shape, 2.0 * grain.radius, medium.kinematic_viscosity())
        });
        speed2.sqrt().min(terminal)
    };
    scene.grains.iter().filter(|grain| grain.motion == Motion::Free).map(fall).collect()
}

/// Gravity less buoyancy along x, y or z (`component` 0, 1, 2) over the grain's mass, m/s², at its lowest and
/// highest; 0 where the grain is held.
pub fn weights(scene: &CheckedScene, grain: &Grain, component: usize) -> [f64; 2] {
    let freedom = [Freedom::X, Freedom::Y, Freedom::Z][component];
    if !grain.is_free(freedom, scene.scene.domain.geometry) {
        return [0.0; 2];
    }
    let floats = scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density / grain.density);
    scene.scene.gravity.range(scene.scene.until).map(|gravity| gravity[component] * (1.0 - floats))
}

/// Cell of a grain across an axis, by the other two coordinates.
fn column(grain: &Grain, axis: usize, cell: f64) -> [i64; 2] {
    let across = [(axis + 1) % 3, (axis + 2) % 3];
    across.map(|component| (grain.position[component] / cell).floor() as i64)
}

/// What a grain may fall onto.
struct Below<'a> {
    scene: &'a CheckedScene,
    /// Coordinates of free grains along each axis, ascending, with the volume up to each.
    filled: [Vec<(f64, f64)>; 3],
    /// Held grains by their column along each axis: cells of the other two coordinates.
    held: [HashMap<[i64; 2], Vec<&'a Grain>>; 3],
    /// Side of a cell, m: no two grains reach farther.
    cell: f64,
}

impl<'a> Below<'a> {
    fn new(scene: &'a CheckedScene) -> Self {
        let free = || scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
        let filled = std::array::from_fn(|component| {
            let mut places: Vec<(f64, f64)> =
                free().map(|grain| (grain.position[component], grain.volume())).collect();
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut sum = 0.0;
            places.iter_mut().for_each(|(_, volume)| {
                sum += *volume;
                *volume = sum;
            });
            places
        });
        let cell = 2.0 * scene.grains.iter().map(|grain| grain.radius).fold(f64::MIN_POSITIVE, f64::max);
        let mut held: [HashMap<_, Vec<_>>; 3] = Default::default();
        // What is led bears nothing for long.
        let stays = |grain: &&Grain| grain.motion != Motion::Free && grain.velocity.is_zero();
        for grain in scene.grains.iter().filter(stays) {
            for (component, columns) in held.iter_mut().enumerate() {
                columns.entry(column(grain, component, cell)).or_default().push(grain);
            }
        }
        Self { scene, filled, held, cell }
    }

    /// Way down to the next held grain that is in the way.
    fn held(&self, grain: &Grain, component: usize, down: f64) -> f64 {
        let way = |held: &&Grain| {
            let reach = grain.radius + held.radius;
            let aside =
                (0..3).filter(|c| *c != component).map(|c| (grain.position[c] - held.position[c]).powi(2));
            let ahead = down * (held.position[component] - grain.position[component]);
            (ahead > 0.0 && aside.sum::<f64>() < reach * reach).then_some((ahead - reach).max(0.0))
        };
        let [a, b] = column(grain, component, self.cell);
        let near = (0..9).map(|n| [a.saturating_add(n / 3 - 1), b.saturating_add(n % 3 - 1)]);
        let held = near.filter_map(|column| self.held[component].get(&column)).flatten();
        held.filter_map(way).fold(f64::INFINITY, f64::min)
    }

    /// Way down along an axis: to the wall there, less what the grains before it fill at rest.
    fn room(&self, grain: &Grain, component: usize, weight: f64) -> f64 {
        let down = weight.signum();
        let at = grain.position[component];
        let walls = self.scene.contact_walls();
        let lasts = |wall: &&Wall| wall.from == 0.0 && wall.until >= self.scene.scene.until;
        let facing = walls.iter().filter(lasts).filter(|wall| wall.normal[component] * down < 0.0);
        let distance = |wall: &Wall| {
            let offset: f64 = (0..3).map(|c| wall.normal[c] * (grain.position[c] - wall.point[c])).sum();
            offset / wall.normal[component].abs() - grain.radius
        };
        let floor = facing.map(distance).fold(self.held(grain, component, down), f64::min);
        let domain = &self.scene.scene.domain;
        let axis = (0..domain.dimensions()).find(|axis| domain.geometry.component(*axis) == component);
        let Some(axis) = axis.filter(|_| floor.is_finite()) else { return floor };
        let area = volume(self.scene) / (domain.upper[axis] - domain.lower[axis]);
        let places = &self.filled[component];
        let before = places.partition_point(|(place, _)| *place < at);
        let upto = |count: usize| if count == 0 { 0.0 } else { places[count - 1].1 };
        let ahead =
            if down < 0.0 { upto(before) } else { upto(places.len()) - upto(before) - grain.volume() };
        (floor - ahead / PACKED / area).max(0.0)
    }
}
