//! Columns of `series.csv` about the whole bed (`observe.totals`).
//!
//! Sums over grains are made here, of the motion that everyone sees. What a solver alone knows it gives in
//! the order of [`fluid_values`] and [`dem_values`].

use bedload_scene::{CheckedScene, Domain, Face, Geometry, Motion, ObservedTotals, Total, WallKind};

use crate::balance::{StressBalance, weight_per_area};
use crate::sample::{Extra, Sample, Sides, When};

/// Letters of the components.
const LETTERS: [&str; 3] = ["x", "y", "z"];

fn asked(scene: &CheckedScene) -> Option<&ObservedTotals> {
    scene.scene.observe.totals.as_ref()
}

fn components(scene: &CheckedScene) -> Vec<usize> {
    let geometry = scene.scene.domain.geometry;
    (0..geometry.axes().len()).map(|axis| geometry.component(axis)).collect()
}

fn value(name: String, unit: &str) -> Extra {
    Extra { name, unit: unit.to_owned(), when: When::End }
}

fn mean(name: String, unit: &str) -> Extra {
    Extra { when: When::Window, ..value(name, unit) }
}

/// `<name>_<axis>_<side>_<component>` for each face of the box that `counts`.
fn at_faces(scene: &CheckedScene, name: &str, counts: impl Fn(&Face) -> bool) -> Vec<Extra> {
    let (domain, components) = (&scene.scene.domain, components(scene));
    let mut values = Vec::new();
    for (axis, a) in components.iter().enumerate() {
        let Some(faces) = domain.boundary(axis) else { continue };
        for (face, side) in [(faces.lower, "lower"), (Some(faces.upper), "upper")] {
            if face.as_ref().is_some_and(&counts) {
                let name = |c: &usize| format!("{name}_{}_{side}_{}", LETTERS[*a], LETTERS[*c]);
                values.extend(components.iter().map(|c| mean(name(c), "N")));
            }
        }
    }
    values
}

/// What the fluid gives after a window: its mean velocity over the box along each axis but that across the
/// bed, m/s, then its force on each face that is a wall, N (plane: per unit depth). Empty where none is asked
/// for.
pub fn fluid_values(scene: &CheckedScene) -> Vec<Extra> {
    let Some(totals) = asked(scene) else { return Vec::new() };
    let mut values = Vec::new();
    if totals.has(&[Total::FluidFlux]) {
        let along = components(scene).into_iter().filter(|c| *c != totals.axis.component());
        values.extend(along.map(|c| value(format!("mean_velocity_{}", LETTERS[c]), "m/s")));
    }
    if totals.has(&Total::ON_WALLS) {
        let is_wall = |face: &Face| matches!(face.kind, WallKind::NoSlip | WallKind::FreeSlip);
        values.extend(at_faces(scene, FLUID_ON, is_wall));
    }
    values
}

/// What the DEM gives after a window: contacts per free grain, then the mean force of contacts on each face
/// that grains touch over the window, N, in the order of [`bedload_scene::Domain::contact_faces`], that of
/// films, and [`servos`].
pub fn dem_values(scene: &CheckedScene) -> Vec<Extra> {
    let mut values = Vec::new();
    if let Some(totals) = asked(scene) {
        if totals.has(&[Total::CoordinationNumber]) {
            values.push(value(COORDINATION.to_owned(), "-"));
        }
        if totals.has(&Total::ON_WALLS) {
            values.extend(at_faces(scene, CONTACTS_ON, |face| face.contact));
        }
        if totals.has(&[Total::WallStress]) {
            values.extend(at_faces(scene, FILMS_ON, |face| face.contact));
        }
    }
    values.extend(servos(scene));
    values
}

/// What `observe.values_over_time` asks of the DEM about each wall with a servo: its way along the normal, m,
/// its speed there, m/s, and the mean force of contacts on it over the window, per area, Pa.
pub fn servos(scene: &CheckedScene) -> Vec<Extra> {
    let mut values = Vec::new();
    let walls = scene.scene.walls.iter().enumerate().filter(|(_, wall)| wall.servo.is_some());
    for (w, _) in walls.filter(|_| scene.scene.observe.values_over_time) {
        values.push(value(format!("servo_way[{w}]"), "m"));
        values.push(value(format!("servo_speed[{w}]"), "m/s"));
        let letters = components(scene).into_iter().map(|c| LETTERS[c]);
        values.extend(letters.map(|letter| mean(format!("servo_stress_{letter}[{w}]"), "Pa")));
    }
    values
}

const COORDINATION: &str = "coordination_number";
const FLUID_ON: &str = "wall_force";
const CONTACTS_ON: &str = "wall_contact_force";
const FILMS_ON: &str = "film_force";

/// Planes of a dry box at most: a taller one has thicker planes.
const MOST_PLANES: f64 = 1e6;

/// How a column is made.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Made {
    /// Component.
    GrainFlux(usize),
    /// Component, and where the fluid's mean velocity stands among the extras.
    FluidFlux(usize, usize),
    /// Component.
    VelocityFlux(usize),
    Height,
    Moving,
    Shields,
    /// Where the forces of fluid, contacts and films on a face stand among the extras.
    WallStress([usize; 3]),
    /// By a solver: where it stands among the extras.
    Given(usize),
}

/// A grain as the bed counts it.
#[derive(Clone, Copy, Debug)]
struct Counted {
    volume: f64,
    /// Of the round body of that volume, m.
    radius: f64,
    free: bool,
}

/// The bed of a run, and its sums after a window.
#[derive(Clone, Debug)]
pub(crate) struct Bed {
    domain: Domain,
    /// Component across.
    across: usize,
    lower: f64,
    upper: f64,
    /// Area of the box across, m² (plane: m).
    area: f64,
    surface: f64,
    speed: f64,
    discs: bool,
    grains: Vec<Counted>,
    /// Of the grains from here on each is there once it is inserted.
    present: usize,
    stress: Option<Stress>,
    /// Solid in each plane, m³; its thickness is the same for all.
    solid: Vec<f64>,
    /// Mean radius, m: the height of a bin of centres, from the surface down.
    bin: f64,
    /// Sum of the velocities in each bin, m/s, and its grains.
    bins: Vec<([f64; 3], u32)>,
    flux: [f64; 3],
    velocity_flux: [f64; 3],
    height: f64,
    moving: usize,
}

/// What makes a Shields number.
#[derive(Clone, Debug)]
struct Stress {
    /// Forces on the mixture.
    balance: StressBalance,
    /// Component along which a flow rate is held: the gradient that holds it is the first extra.
    held: Option<usize>,
    /// (ρ_p − ρ) g D, Pa.
    weight: f64,
    /// Forces on the upper face by component, among the extras: of the fluid, and of contacts.
    top: [[usize; 2]; 3],
}

impl Bed {
    /// The bed of `scene`, with its columns in order. What solvers give of it stands behind `before` others
    /// among the extras.
    pub(crate) fn new(
        scene: &CheckedScene,
        sides: Sides,
        before: usize,
    ) -> Option<(Self, Vec<(Extra, Made)>)> {
        let totals = asked(scene)?;
        let domain = &scene.scene.domain;
        let axis = domain.geometry.axes().iter().position(|axis| *axis == totals.axis)?;
        let across = totals.axis.component();
        let (lower, upper) = (domain.lower[axis], domain.upper[axis]);
        let area = (0..domain.dimensions()).filter(|a| *a != axis).map(|a| domain.upper[a] - domain.lower[a]);
        let mut given = if sides.loads { fluid_values(scene) } else { Vec::new() };
        given.extend(if sides.contact { dem_values(scene) } else { Vec::new() });
        let at = |name: &str| given.iter().position(|known| known.name == name).map(|place| before + place);
        let all = components(scene);
        let along = || all.iter().copied().filter(|c| *c != across);
        let mut columns = Vec::new();
        for column in &totals.columns {
            let mut make = |name: &str, unit: &str, made| columns.push((value(name.to_owned(), unit), made));
            match column {
                Total::GrainFlux if sides.motion => along().for_each(|c| {
                    make(&format!("grain_flux_{}", LETTERS[c]), "m^2/s", Made::GrainFlux(c));
                }),
                Total::FluidFlux if sides.loads => along().for_each(|c| {
                    if let Some(place) = at(&format!("mean_velocity_{}", LETTERS[c])) {
                        make(&format!("fluid_flux_{}", LETTERS[c]), "m^2/s", Made::FluidFlux(c, place));
                    }
                }),
                Total::VelocityFlux if sides.motion => along().for_each(|c| {
                    make(&format!("velocity_flux_{}", LETTERS[c]), "m^2/s", Made::VelocityFlux(c));
                }),
                Total::WallStress => {
                    for (side, c) in ["lower", "upper"].iter().flat_map(|s| all.iter().map(move |c| (s, *c)))
                    {
                        let face = format!("{}_{side}_{}", LETTERS[across], LETTERS[c]);
                        let place = |name| at(&format!("{name}_{face}")).unwrap_or(usize::MAX);
                        let places = [FLUID_ON, CONTACTS_ON, FILMS_ON].map(place);
                        // A face that nothing acts on has none.
                        if places.iter().any(|place| *place != usize::MAX) {
                            columns
                                .push((mean(format!("wall_stress_{face}"), "Pa"), Made::WallStress(places)));
                        }
                    }
                }
                Total::BedHeight if sides.motion => make("bed_height", "m", Made::Height),
                Total::MovingGrains if sides.motion => make("moving_grains", "-", Made::Moving),
                Total::Shields if sides.loads && sides.motion => make("shields", "-", Made::Shields),
                Total::CoordinationNumber | Total::WallForce => {
                    let name = if *column == Total::WallForce { "wall_" } else { COORDINATION };
                    let named = given.iter().enumerate().filter(|(_, known)| known.name.starts_with(name));
                    columns.extend(named.map(|(place, known)| (known.clone(), Made::Given(before + place))));
                }
                _ => {}
            }
        }
        let at_top = |name: &str, c: usize| at(&format!("{name}_{}_upper_{}", LETTERS[across], LETTERS[c]));
        let top = |c: usize| [FLUID_ON, CONTACTS_ON].map(|name| at_top(name, c).unwrap_or(usize::MAX));
        let flow = scene.scene.medium.as_ref().and_then(|medium| medium.flow_rate.as_ref());
        let stress = totals.has(&[Total::Shields]).then(|| Stress {
            balance: StressBalance::of(scene, totals.axis),
            held: flow.map(|flow| flow.axis.component()),
            weight: weight_per_area(scene),
            top: [0, 1, 2].map(top),
        });
        let counted = |grain: &bedload_scene::Grain| Counted {
            volume: grain.volume(),
            radius: 0.5 * grain.equivalent_diameter(),
            free: grain.motion == Motion::Free,
        };
        let grains: Vec<Counted> = scene.grains.iter().map(counted).collect();
        // Of those that are there at the start; where none is, of all.
        let known = Some(&grains[..scene.present()]).filter(|there| !there.is_empty()).unwrap_or(&grains);
        let mean = known.iter().map(|grain| grain.radius).sum::<f64>() / known.len().max(1) as f64;
        let bins = if mean > 0.0 { ((upper - lower) / mean).ceil().min(MOST_PLANES) as usize } else { 0 };
        let thickness = if domain.cells.is_empty() { mean } else { domain.spacing(axis) };
        let planes = if thickness > 0.0 { ((upper - lower) / thickness).round().max(1.0) } else { 1.0 };
        let planes = planes.min(MOST_PLANES) as usize;
        let bed = Self {
            domain: domain.clone(),
            across,
            lower,
            upper,
            area: area.product(),
            surface: totals.surface,
            speed: totals.speed.unwrap_or(f64::INFINITY),
            discs: domain.geometry == Geometry::Plane,
            grains,
            present: scene.present(),
            stress,
            solid: vec![0.0; planes],
            bin: mean,
            bins: vec![([0.0; 3], 0); bins],
            velocity_flux: [0.0; 3],
            flux: [0.0; 3],
            height: 0.0,
            moving: 0,
        };
        Some((bed, columns))
    }

    /// Makes the sums of a window.
    pub(crate) fn look(&mut self, sample: &Sample) {
        let Self { domain, across, lower, solid, grains, .. } = self;
        let thickness = (self.upper - *lower) / solid.len() as f64;
        solid.fill(0.0);
        (self.flux, self.moving) = ([0.0; 3], 0);
        for (index, (grain, motion)) in grains.iter().zip(sample.kinematics).enumerate() {
            let is_there = index < self.present || motion.is_there();
            if !is_there || !domain.holds(&motion.position) {
                continue;
            }
            for (flux, v) in self.flux.iter_mut().zip(motion.velocity) {
                *flux += grain.volume * v / self.area;
            }
            let square: f64 = motion.velocity.iter().map(|v| v * v).sum();
            self.moving += usize::from(grain.free && square.sqrt() >= self.speed);
            let Counted { volume, radius, .. } = *grain;
            let at = (motion.position[*across] - *lower) / thickness;
            let (first, last) = (at - radius / thickness, at + radius / thickness);
            let most = solid.len() as f64;
            let span = first.floor().clamp(0.0, most) as usize..last.ceil().clamp(0.0, most) as usize;
            for k in span {
                let below = |face: f64| part_below((face - at) * thickness / radius, self.discs);
                solid[k] += volume * (below(k as f64 + 1.0) - below(k as f64));
            }
        }
        self.height = self.surface_height(thickness);
        self.sum_velocities(sample);
    }

    /// q_v = Σ v̄ R, v̄ the mean velocity of the grains whose centres lie in a bin (Biegert et al. 2017, eq.
    /// 34 and section 6.2).
    fn sum_velocities(&mut self, sample: &Sample) {
        let Self { domain, across, lower, height, bin, bins, grains, present, .. } = self;
        bins.fill(([0.0; 3], 0));
        for (index, motion) in sample.kinematics.iter().enumerate().take(grains.len()) {
            let depth = (*lower + *height - motion.position[*across]) / *bin;
            if depth >= 0.0
                && (index < *present || motion.is_there())
                && domain.holds(&motion.position)
                && let Some((sum, number)) = bins.get_mut(depth as usize)
            {
                sum.iter_mut().zip(motion.velocity).for_each(|(sum, v)| *sum += v);
                *number += 1;
            }
        }
        let filled = || bins.iter().filter(|(_, number)| *number > 0);
        self.velocity_flux =
            std::array::from_fn(|c| filled().map(|(sum, number)| sum[c] / f64::from(*number) * *bin).sum());
    }

    /// Where the solid fraction falls below that of the surface for the last time, above the lower face, m:
    /// linear between the middles of planes.
    fn surface_height(&self, thickness: f64) -> f64 {
        let fraction = |k: usize| self.solid[k] / (self.area * thickness);
        let Some(k) = (0..self.solid.len()).rposition(|k| fraction(k) >= self.surface) else { return 0.0 };
        if k + 1 == self.solid.len() {
            return self.upper - self.lower;
        }
        let (below, above) = (fraction(k), fraction(k + 1));
        (k as f64 + 0.5 + (below - self.surface) / (below - above)) * thickness
    }

    /// The value of a column; NaN where what it needs was not observed.
    pub(crate) fn value(&self, made: Made, sample: &Sample) -> f64 {
        let extra = |place: usize| sample.extras.get(place).copied();
        match made {
            Made::Given(place) => extra(place).unwrap_or(f64::NAN),
            Made::WallStress(places) => {
                let force = places.into_iter().filter_map(extra).reduce(|a, b| a + b);
                force.unwrap_or(f64::NAN) / self.area
            }
            _ if sample.kinematics.len() != self.grains.len() => f64::NAN,
            Made::GrainFlux(c) => self.flux[c],
            Made::FluidFlux(c, place) => {
                extra(place).map_or(f64::NAN, |mean| mean * (self.upper - self.lower) - self.flux[c])
            }
            Made::VelocityFlux(c) => self.velocity_flux[c],
            Made::Height => self.height,
            Made::Moving => self.moving as f64,
            Made::Shields => self.stress.as_ref().map_or(f64::NAN, |stress| {
                let above = self.upper - self.lower - self.height;
                let [drive, _] = stress.balance.drive(sample.time());
                let along = (0..3).filter(|c| *c != self.across && !(self.discs && *c == 1));
                let square = along.map(|c| {
                    let held = if stress.held == Some(c) { extra(0).unwrap_or(f64::NAN) } else { 0.0 };
                    let [fluid, contacts] = stress.top[c];
                    let top = extra(fluid).unwrap_or(f64::NAN) + extra(contacts).unwrap_or(0.0);
                    ((drive[c] - held) * above - top / self.area).powi(2)
                });
                let stress_here = square.sum::<f64>().sqrt();
                if stress.weight > 0.0 { stress_here / stress.weight } else { f64::NAN }
            }),
        }
    }
}

/// Part of a sphere or disc of radius 1 below the height `h` of its centre.
pub fn part_below(h: f64, disc: bool) -> f64 {
    let h = h.clamp(-1.0, 1.0);
    if disc {
        0.5 + (h * (1.0 - h * h).max(0.0).sqrt() + h.asin()) / std::f64::consts::PI
    } else {
        0.25 * (2.0 - h) * (1.0 + h) * (1.0 + h)
    }
}
