//! The columns of `series.csv`: which there are, and their values after a window.

use bedload_scene::{
    Changing, CheckedScene, Geometry, Grain, Motion, Outline, OverTime, acts_along, changing,
};
use protocol::message::{Kinematics, Loads};

use crate::sample::{Extra, Sample, Sides, When};
use crate::totals::{Bed, Made, dem_values, fluid_values, servos};
use Form::{Scalar, Turn, Vector};

/// Grains with columns of their own where the scene does not say.
const GRAINS_BY_DEFAULT: usize = 16;

/// What `observe.energy` adds: a DEM alone gives the values in this order.
pub fn energy_columns() -> [Extra; 6] {
    [
        "elastic_energy",
        "potential_energy",
        "dissipated_normal",
        "dissipated_tangential",
        "dissipated_sliding",
        "dissipated_energy",
    ]
    .map(|name| Extra { name: name.to_owned(), unit: "J".to_owned(), when: When::End })
}

/// The mean pressure gradient that `medium.flow_rate` adds.
fn flow_rate_column(scene: &CheckedScene) -> Option<Extra> {
    let flow = scene.scene.medium.as_ref()?.flow_rate.as_ref()?;
    let name = format!("pressure_gradient_{}", ["x", "y", "z"][flow.axis.component()]);
    Some(Extra { name, unit: "Pa/m".to_owned(), when: When::Window })
}

/// Where a column's value comes from.
#[derive(Clone, Copy, Debug)]
enum Source {
    Run(When, fn(&Columns, &Sample) -> f64),
    Extra(When, usize),
    Bed(When, Made),
    /// Place of a value of the scene, component.
    Scene(usize, usize),
    /// Quantity, component and grain.
    Grain(&'static Quantity, usize, usize),
}

/// What is observed of a grain.
#[derive(Debug)]
struct Quantity {
    name: &'static str,
    unit: &'static str,
    is_seen: fn(Sides) -> bool,
    form: Form,
    value: Value,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Vector,
    /// A vector along the axis of a turn.
    Turn,
    Scalar,
}

/// What its components, 0 to 2, are read from.
#[derive(Debug)]
enum Value {
    Motion(fn(&Kinematics, usize) -> f64),
    /// What the DEM has averaged over the window.
    Averaged(fn(&Kinematics, usize) -> f64),
    /// The mean of its values at both ends of the window.
    Mean(fn(&Kinematics, usize) -> f64),
    Loads(fn(&Loads, usize) -> f64),
}

/// Of bodies that are not round.
const ANGLE: &str = "angle";

/// Name, unit, who must be there for it to be seen, form, and where it is read.
const QUANTITIES: [Quantity; 11] = [
    Quantity::new("position", "m", MOTION, Vector, Value::Motion(|m, c| m.position[c])),
    Quantity::new("velocity", "m/s", MOTION, Vector, Value::Motion(|m, c| m.velocity[c])),
    Quantity::new("spin", "rad/s", MOTION, Turn, Value::Motion(|m, c| m.spin[c])),
    Quantity::new(ANGLE, "rad", MOTION, Turn, Value::Motion(|m, _| about_y(m.orientation))),
    Quantity::new("mean_velocity", "m/s", MOTION, Vector, Value::Mean(|m, c| m.velocity[c])),
    Quantity::new("mean_spin", "rad/s", MOTION, Turn, Value::Mean(|m, c| m.spin[c])),
    Quantity::new("hydrodynamic_force", "N", LOADS, Vector, Value::Loads(|l, c| l.force[c])),
    Quantity::new("hydrodynamic_torque", "N m", LOADS, Turn, Value::Loads(|l, c| l.torque[c])),
    Quantity::new("contact_force", "N", CONTACT, Vector, Value::Averaged(|m, c| m.contact_force[c])),
    Quantity::new("lubrication_force", "N", CONTACT, Vector, Value::Averaged(|m, c| m.lubrication_force[c])),
    Quantity::new("gap", "m", CONTACT, Scalar, Value::Motion(|m, _| m.gap)),
];

const MOTION: fn(Sides) -> bool = |sides| sides.motion;
const LOADS: fn(Sides) -> bool = |sides| sides.loads;
const CONTACT: fn(Sides) -> bool = |sides| sides.contact;

impl Quantity {
    const fn new(
        name: &'static str,
        unit: &'static str,
        is_seen: fn(Sides) -> bool,
        form: Form,
        value: Value,
    ) -> Self {
        Self { name, unit, is_seen, form, value }
    }

    /// Components that the geometry leaves free: axial ones on an axis, turning about y in a plane.
    fn components(&self, geometry: Geometry) -> &'static [usize] {
        match (self.form, geometry) {
            (Scalar, _) => &[0],
            (_, Geometry::Space) => &[0, 1, 2],
            (Turn, Geometry::Plane) => &[1],
            (Vector, Geometry::Plane) => &[0, 2],
            (Turn, Geometry::Axisymmetric) => &[],
            (Vector, Geometry::Axisymmetric) => &[2],
        }
    }

    fn value(&self, axis: usize, grain: usize, sample: &Sample) -> Option<f64> {
        match self.value {
            Value::Motion(of) | Value::Averaged(of) | Value::Mean(of) => {
                sample.kinematics.get(grain).map(|motion| of(motion, axis))
            }
            Value::Loads(of) => sample.loads.get(grain).map(|loads| of(loads, axis)),
        }
    }
}

/// Angle about y, from z to x, above −π and up to π, of a body of the plane.
fn about_y([w, _, y, _]: [f64; 4]) -> f64 {
    let angle = 2.0 * y.atan2(w);
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn - 0.5).ceil()
}

/// The columns of a run and its present row. Nothing is allocated per window.
#[derive(Clone, Debug)]
pub struct Columns {
    names: Vec<String>,
    units: Vec<String>,
    sources: Vec<Source>,
    row: Vec<f64>,
    /// Values at the end of the window before of which means are asked, in the order of the columns; empty
    /// before the first window.
    ends: Vec<f64>,
    /// What the scene changes over time, where columns of it are asked for.
    changing: Vec<OverTime<[f64; 3]>>,
    free: Vec<FreeGrain>,
    /// Largest x of a free grain's surface at t = 0, m.
    front: f64,
    /// Lower face of the box along z, m.
    floor: f64,
    /// Number of grains that are there from the start.
    present: usize,
    /// What `observe.totals` asks for.
    bed: Option<Bed>,
}

/// What the sums over free grains need.
#[derive(Clone, Debug)]
struct FreeGrain {
    index: usize,
    radius: f64,
    mass: f64,
    inertia: f64,
    /// Of a body that is not round.
    outline: Option<Outline>,
}

impl FreeGrain {
    fn new(index: usize, grain: &Grain) -> Self {
        let mass = grain.mass();
        let (radius, outline) = (grain.radius, grain.outline());
        Self { index, radius, mass, inertia: grain.gyration() * mass, outline }
    }

    /// How far its surface reaches from its centre along `axis` as it is turned, m.
    fn reach(&self, motion: &Kinematics, axis: usize) -> f64 {
        let direction = if axis == 0 { [1.0, 0.0] } else { [0.0, 1.0] };
        let reach = |outline: &Outline| outline.reach_along(about_y(motion.orientation), direction);
        self.outline.as_ref().map_or(self.radius, reach)
    }
}

/// Grains that the scene wants columns of.
pub fn observed_grains(scene: &CheckedScene) -> Vec<usize> {
    let by_default = || (0..scene.grains.len().min(GRAINS_BY_DEFAULT)).collect();
    scene.scene.observe.grains.clone().unwrap_or_else(by_default)
}

impl Columns {
    /// The columns of `scene` as `sides` sees it; scalars first, then grain by grain.
    pub fn new(scene: &CheckedScene, sides: Sides) -> Self {
        let present = scene.present();
        let free = scene.grains.iter().enumerate().filter(|(_, grain)| grain.motion == Motion::Free);
        let free: Vec<FreeGrain> = free.map(|(index, grain)| FreeGrain::new(index, grain)).collect();
        let surface = |grain: &FreeGrain| {
            let grain = &scene.grains[grain.index];
            grain.position[0] + grain.reach_along([1.0, 0.0, 0.0])
        };
        let mut columns = Self {
            names: Vec::new(),
            units: Vec::new(),
            sources: Vec::new(),
            row: Vec::new(),
            ends: Vec::new(),
            changing: Vec::new(),
            front: free.iter().filter(|grain| grain.index < present).map(surface).fold(f64::NAN, f64::max),
            floor: scene.scene.domain.lower.last().copied().unwrap_or(0.0),
            free,
            present,
            bed: None,
        };
        let energies = scene.scene.observe.energy && sides == Sides::dry();
        let mut extras = if energies { energy_columns().to_vec() } else { Vec::new() };
        extras.extend(sides.loads.then(|| flow_rate_column(scene)).flatten());
        columns.add_scalars(scene.scene.domain.geometry, sides, &extras);
        columns.add_totals(scene, sides, extras.len());
        if scene.scene.observe.values_over_time {
            columns.add_changing(scene);
        }
        if sides.contact {
            columns.add_servos(scene, extras.len() + if sides.loads { fluid_values(scene).len() } else { 0 });
        }
        for grain in observed_grains(scene) {
            columns.add_grain(grain, scene, sides);
        }
        columns.row = vec![0.0; columns.names.len()];
        columns
    }

    fn add(&mut self, name: &str, unit: &str, source: Source) {
        self.names.push(name.to_owned());
        self.units.push(unit.to_owned());
        self.sources.push(source);
    }

    fn add_run(&mut self, name: &str, unit: &str, when: When, value: fn(&Self, &Sample) -> f64) {
        self.add(name, unit, Source::Run(when, value));
    }

    fn add_scalars(&mut self, geometry: Geometry, sides: Sides, extras: &[Extra]) {
        self.add_run("t", "s", When::End, |_, sample| sample.time());
        self.add_run("dt", "s", When::Window, |_, sample| sample.window.dt);
        if sides.contact {
            self.add_run("substeps", "-", When::Window, |_, sample| sample.header.substeps as f64);
            self.add_run("smallest_gap", "m", When::Window, |_, sample| sample.header.smallest_gap);
            self.add_run("largest_overlap", "m", When::Window, |_, sample| sample.header.largest_overlap);
        }
        if sides.motion && !self.free.is_empty() {
            self.add_run("kinetic_energy", "J", When::End, Self::kinetic_energy);
        }
        if sides.motion && self.free.len() > 1 && geometry != Geometry::Axisymmetric {
            self.add_run("run_out", "m", When::End, |own, sample| own.extent(sample, 0) - own.front);
            self.add_run("height", "m", When::End, |own, sample| own.extent(sample, 2) - own.floor);
        }
        for (index, extra) in extras.iter().enumerate() {
            self.add(&extra.name, &extra.unit, Source::Extra(extra.when, index));
        }
    }

    /// Columns of the bed; `before`: number of the other extras.
    fn add_totals(&mut self, scene: &CheckedScene, sides: Sides, before: usize) {
        let Some((bed, columns)) = Bed::new(scene, sides, before) else { return };
        for (extra, made) in columns {
            self.add(&extra.name, &extra.unit, Source::Bed(extra.when, made));
        }
        self.bed = Some(bed);
    }

    /// Columns of walls with a servo; `before`: number of the extras before those of the DEM.
    fn add_servos(&mut self, scene: &CheckedScene, before: usize) {
        let servos = servos(scene);
        let before = before + dem_values(scene).len() - servos.len();
        for (place, extra) in servos.iter().enumerate() {
            self.add(&extra.name, &extra.unit, Source::Extra(extra.when, before + place));
        }
    }

    /// The components that a value ever has.
    fn add_changing(&mut self, scene: &CheckedScene) {
        for Changing { name: [before, behind], unit, value, scalar, .. } in changing(scene) {
            for component in (0..3).filter(|component| acts_along(&value, *component)) {
                let letter = if scalar { "" } else { ["_x", "_y", "_z"][component] };
                let source = Source::Scene(self.changing.len(), component);
                self.add(&format!("{before}{letter}{behind}"), unit, source);
            }
            self.changing.push(value);
        }
    }

    fn add_grain(&mut self, grain: usize, scene: &CheckedScene, sides: Sides) {
        let geometry = scene.scene.domain.geometry;
        let round = scene.grains.get(grain).is_none_or(|grain| grain.shape.is_round());
        let means = scene.scene.observe.mean_velocity;
        let seen = |q: &&Quantity| {
            let asked = means || !matches!(q.value, Value::Mean(_));
            (q.is_seen)(sides) && asked && !(round && q.name == ANGLE)
        };
        for quantity in QUANTITIES.iter().filter(seen) {
            for axis in quantity.components(geometry) {
                let component = if quantity.form == Scalar { "" } else { ["_x", "_y", "_z"][*axis] };
                let name = format!("{}{component}[{grain}]", quantity.name);
                self.add(&name, quantity.unit, Source::Grain(quantity, *axis, grain));
            }
        }
    }

    /// Names, `t` first.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Place and unit of a column.
    pub fn find(&self, name: &str) -> Option<(usize, &str)> {
        let place = self.names.iter().position(|known| known == name)?;
        Some((place, &self.units[place]))
    }

    /// When the values of the column at `place` are of.
    pub(crate) fn when(&self, place: usize) -> When {
        match self.sources[place] {
            Source::Run(when, _) | Source::Extra(when, _) | Source::Bed(when, _) => when,
            Source::Scene(..) => When::End,
            Source::Grain(Quantity { value: Value::Motion(_), .. }, ..) => When::End,
            Source::Grain(..) => When::Window,
        }
    }

    /// The grain that the column at `place` is of, where that is inserted during the run.
    pub(crate) fn inserted(&self, place: usize) -> Option<usize> {
        match self.sources[place] {
            Source::Grain(_, _, grain) if grain >= self.present => Some(grain),
            _ => None,
        }
    }

    /// Value of a column in the last row.
    pub fn latest(&self, name: &str) -> Option<f64> {
        self.find(name).map(|(place, _)| self.row[place])
    }

    /// What the next row needs of this one: part of a checkpoint.
    pub(crate) fn ends(&self) -> &[f64] {
        &self.ends
    }

    /// Goes on from a checkpoint of the same columns.
    pub(crate) fn resume(&mut self, ends: Vec<f64>) {
        self.ends = ends;
    }

    /// The row after a window. What was not observed is NaN, and so are a grain that is still to be inserted
    /// and a mean of both ends of the first one.
    ///
    /// `run_out` is the way that the foremost surface of a free grain has gained along x since
    /// t = 0, `height` that of the topmost one above the lower z face of the box.
    pub fn fill(&mut self, sample: &Sample) -> &[f64] {
        let mut means = 0;
        self.bed.iter_mut().for_each(|bed| bed.look(sample));
        for place in 0..self.row.len() {
            self.row[place] = match self.sources[place] {
                Source::Run(_, value) => value(self, sample),
                Source::Scene(value, component) => self.changing[value].at(sample.time())[component],
                Source::Extra(_, index) => sample.extras.get(index).copied().unwrap_or(f64::NAN),
                Source::Bed(_, made) => self.bed.as_ref().map_or(f64::NAN, |bed| bed.value(made, sample)),
                Source::Grain(quantity, axis, grain) => {
                    let there = !sample.lacks(grain, self.present);
                    let value = there.then(|| quantity.value(axis, grain, sample)).flatten();
                    let value = value.unwrap_or(f64::NAN);
                    if let Value::Mean(_) = quantity.value {
                        means += 1;
                        self.mean(means - 1, value)
                    } else {
                        value
                    }
                }
            };
        }
        &self.row
    }

    /// Mean of the value at the end of this window and of the one before, of the column `place` of means.
    fn mean(&mut self, place: usize, value: f64) -> f64 {
        match self.ends.get_mut(place) {
            Some(end) => 0.5 * (std::mem::replace(end, value) + value),
            None => {
                self.ends.push(value);
                f64::NAN
            }
        }
    }

    /// Σ ½ m v² + ½ I ω² over the free grains, J (plane: per unit depth).
    fn kinetic_energy(&self, sample: &Sample) -> f64 {
        let energy = |grain: &FreeGrain| {
            let motion = sample.kinematics.get(grain.index);
            motion.map_or(f64::NAN, |motion| motion.kinetic_energy(grain.mass, grain.inertia))
        };
        self.free.iter().map(energy).sum()
    }

    /// Largest coordinate of a free grain's surface along `axis`, m; NaN before there is one.
    fn extent(&self, sample: &Sample, axis: usize) -> f64 {
        let surface = |grain: &FreeGrain| {
            let motion = sample.kinematics.get(grain.index)?;
            let there = !sample.lacks(grain.index, self.present);
            there.then(|| motion.position[axis] + grain.reach(motion, axis))
        };
        self.free.iter().filter_map(surface).fold(f64::NAN, f64::max)
    }
}
