//! What a picture shows: a field and the grains on a plane at one instant, from the files of a run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bedload_output::Summary;
use bedload_output::vtk::{self, Appended, Vtr};
use bedload_program::alone::motion_at;
use bedload_scene::{CheckedScene, Geometry};

use crate::folder::files;
use coupler::number::AXES;

/// Corners of the outline of a round grain.
const CORNERS: u32 = 48;

/// What is coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quantity {
    /// As `--field` takes it.
    name: &'static str,
    /// Array of the field files; none: the grains themselves.
    array: Option<&'static str>,
    /// Component, none: the length of the vector.
    component: Option<usize>,
}

impl Quantity {
    pub(crate) const SPEED: Self = Self { name: "speed", array: Some("velocity"), component: None };
    pub(crate) const GRAINS: Self = Self { name: "grains", array: None, component: None };
    pub(crate) const VORTICITY: Self =
        Self { name: "vorticity", array: Some("vorticity"), component: Some(1) };
    pub(crate) const PRESSURE: Self = Self { name: "pressure", array: Some("pressure"), component: Some(0) };
    const ALL: [Self; 10] = [
        Self::SPEED,
        Self { name: "velocity-x", array: Some("velocity"), component: Some(0) },
        Self { name: "velocity-y", array: Some("velocity"), component: Some(1) },
        Self { name: "velocity-z", array: Some("velocity"), component: Some(2) },
        Self { name: "vorticity-x", array: Some("vorticity"), component: Some(0) },
        Self::VORTICITY,
        Self { name: "vorticity-z", array: Some("vorticity"), component: Some(2) },
        Self::PRESSURE,
        Self { name: "solid", array: Some("solid"), component: Some(0) },
        Self::GRAINS,
    ];

    /// Of `--field`, for a run in that geometry.
    pub(crate) fn parse(text: &str, geometry: Geometry) -> Result<Self, String> {
        let all = || Self::ALL.into_iter().filter(|quantity| quantity.is_in(geometry));
        all().find(|quantity| quantity.name == text).ok_or_else(|| {
            let names: Vec<&str> = all().map(|quantity| quantity.name).collect();
            let run = format!("{geometry:?}").to_lowercase();
            format!(
                "--field {text}: a run with geometry {run:?} has no such field; allowed: {}",
                names.join(", ")
            )
        })
    }

    /// Across a plane a flow has no velocity, and turns about its normal alone.
    fn is_in(self, geometry: Geometry) -> bool {
        let across = matches!(
            (self.array, self.component),
            (Some("velocity"), Some(1)) | (Some("vorticity"), Some(0 | 2))
        );
        geometry == Geometry::Space || !across
    }

    /// Are the grains coloured by their speed, and nothing else?
    pub(crate) fn is_of_grains(self) -> bool {
        self.array.is_none()
    }

    pub(crate) fn unit(self) -> &'static str {
        match self.array {
            Some("vorticity") => "1/s",
            Some("pressure") => "Pa",
            Some("solid") => "1",
            _ => "m/s",
        }
    }

    pub(crate) fn label(self) -> &'static str {
        if self.is_of_grains() { "speed" } else { self.name }
    }
}

/// A plane normal to an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slice {
    pub(crate) axis: usize,
    pub(crate) position: f64,
}

impl Slice {
    /// Of `--slice`, such as `y=0.5`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(axis, position)| {
            let axis = AXES.iter().position(|name| *name == axis.trim())?;
            let position: f64 = position.trim().parse().ok()?;
            position.is_finite().then_some(Self { axis, position })
        });
        parts.ok_or_else(|| {
            format!("--slice {text}: not a plane; allowed: x=…, y=… or z=… with its position in m")
        })
    }

    /// Axes of the picture: to the right and upwards.
    fn seen(axis: usize) -> [usize; 2] {
        [[1, 2], [0, 2], [0, 1]][axis]
    }
}

/// The box of the run, and its bodies as the scene has them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape<'a> {
    /// Does the picture show both sides of an axis?
    pub(crate) mirrored: bool,
    /// Components along which it is periodic.
    pub(crate) periodic: [bool; 3],
    /// Its ends along each component, m; none where the scene cannot be read.
    pub(crate) ends: Option<[(f64, f64); 3]>,
    /// Drawn where a fluid ran alone: no file has them.
    pub(crate) grains: &'a [bedload_scene::Grain],
}

impl<'a> Shape<'a> {
    /// A box of which nothing is known.
    pub(crate) const UNKNOWN: Self = Self { mirrored: false, periodic: [false; 3], ends: None, grains: &[] };

    /// Of a run; without periodic sides where its scene cannot be read here any more.
    pub(crate) fn of(summary: &Summary, scene: Option<&'a CheckedScene>) -> Self {
        let mirrored = summary.size.geometry == Geometry::Axisymmetric;
        let mut shape = Self { mirrored, ..Self::UNKNOWN };
        let Some(CheckedScene { scene, grains, .. }) = scene else { return shape };
        shape.ends = Some([(0.0, 0.0); 3]);
        shape.grains = grains;
        let domain = &scene.domain;
        for axis in 0..domain.dimensions() {
            let component = domain.geometry.component(axis);
            shape.periodic[component] = domain.is_periodic(axis);
            if let Some(ends) = &mut shape.ends {
                ends[component] = (domain.lower[axis], domain.upper[axis]);
            }
        }
        shape
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Instant {
    fluid: Option<PathBuf>,
    grains: Option<PathBuf>,
    bodies: Option<PathBuf>,
}

impl Instant {
    /// Of the grains of a file alone.
    pub(crate) fn of_grains(path: &Path) -> Self {
        Self { grains: Some(path.to_owned()), ..Self::default() }
    }

    pub(crate) fn has_fluid(&self) -> bool {
        self.fluid.is_some()
    }

    /// Size of its files.
    pub(crate) fn bytes(&self) -> u64 {
        let paths = [&self.fluid, &self.grains, &self.bodies].into_iter().flatten();
        paths.map(|path| std::fs::metadata(path).map_or(0, |data| data.len())).sum()
    }

    pub(crate) fn name(&self) -> String {
        let path = self.fluid.as_ref().or(self.grains.as_ref());
        path.map_or_else(String::new, |path| path.display().to_string())
    }
}

/// The instants of a folder of fields, in order: files that end with the same number.
pub(crate) fn instants(folder: &Path) -> Vec<Instant> {
    let mut found: BTreeMap<String, Instant> = BTreeMap::new();
    let mut add = |begin: &str, end: &str, put: fn(&mut Instant, PathBuf)| {
        for path in files(folder, begin, end) {
            let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
            let number = &stem[begin.len().min(stem.len())..];
            if number.parse::<u64>().is_ok() {
                put(found.entry(number.to_owned()).or_default(), path);
            }
        }
    };
    add("fluid_", ".vtr", |instant, path| instant.fluid = Some(path));
    add("fluid_", ".pvtr", |instant, path| instant.fluid = Some(path));
    add("grains_", ".vtp", |instant, path| instant.grains = Some(path));
    add("bodies_", ".vtp", |instant, path| instant.bodies = Some(path));
    found.into_values().collect()
}

/// A field on the plane.
pub(crate) struct Field {
    /// Faces of the cells to the right and upwards, m.
    pub(crate) faces: [Vec<f64>; 2],
    /// Rows from below.
    pub(crate) values: Vec<Vec<f64>>,
    /// Is it mirrored about the axis, and with what sign?
    pub(crate) mirrored: bool,
    pub(crate) mirror_sign: f64,
}

impl Field {
    /// Value at a place, of the cell that it lies in.
    pub(crate) fn at(&self, (x, z): Point) -> f64 {
        let (x, sign) = if self.mirrored && x < 0.0 { (-x, self.mirror_sign) } else { (x, 1.0) };
        let cell = |faces: &[f64], x: f64| faces.partition_point(|face| *face <= x).checked_sub(1);
        match (cell(&self.faces[0], x), cell(&self.faces[1], z)) {
            (Some(i), Some(k)) => {
                sign * self.values.get(k).and_then(|row| row.get(i)).copied().unwrap_or(f64::NAN)
            }
            _ => f64::NAN,
        }
    }

    /// Values of the cells that reach into a view.
    fn within(&self, (low, high): View) -> Vec<f64> {
        let seen = |faces: &[f64], low: f64, high: f64| {
            let first = faces.partition_point(|face| *face <= low).saturating_sub(1);
            first..faces.partition_point(|face| *face < high).min(faces.len().saturating_sub(1))
        };
        let columns = seen(&self.faces[0], low.0, high.0);
        let rows = self.values.get(seen(&self.faces[1], low.1, high.1)).unwrap_or_default();
        rows.iter().flat_map(|row| row.get(columns.clone()).unwrap_or_default()).copied().collect()
    }
}

/// A grain or body on the plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Body {
    pub(crate) outline: Vec<Point>,
    pub(crate) speed: f64,
    /// Is it fixed, or moved by prescription?
    pub(crate) held: bool,
}

impl Body {
    /// Lower left and upper right corner around it.
    pub(super) fn extent(&self) -> View {
        self.outline.iter().fold(NOWHERE, |view, at| around(view, (*at, *at)))
    }
}

/// A place on the plane, m.
pub(crate) type Point = (f64, f64);

/// Lower left and upper right corner, m.
pub(crate) type View = (Point, Point);

pub(crate) const NOWHERE: View = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));

/// What shows two views.
pub(crate) fn around((low, high): View, (low2, high2): View) -> View {
    ((low.0.min(low2.0), low.1.min(low2.1)), (high.0.max(high2.0), high.1.max(high2.1)))
}

pub(crate) struct Frame {
    pub(crate) time: f64,
    pub(crate) view: View,
    pub(crate) field: Option<Field>,
    /// What the plane cuts, with its [`copies`].
    pub(crate) bodies: Vec<Body>,
    /// All grains of the file, wherever the plane lies, and the copies of those that it cuts.
    pub(crate) grains: Vec<Grain>,
    /// What is coloured.
    pub(crate) quantity: Quantity,
    /// Plane that cuts spheres; none for grains that all lie in it.
    pub(crate) cut: Option<Slice>,
}

/// A grain of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grain {
    pub(crate) at: [f64; 3],
    pub(crate) radius: f64,
    pub(crate) speed: f64,
    /// Is it fixed, or moved by prescription?
    pub(crate) held: bool,
    /// Is it one of the [`copies`]?
    pub(crate) copy: bool,
}

/// Where a plane shows a body that spans `from` to `to`: at its place, and as copies, mirrored about the axis
/// of symmetry and beyond each periodic side that it reaches over. Sign along the first axis and shift, its
/// own place first. Films, reports and the player draw what this names; there is no other rule.
fn copies(view: View, mirrored: bool, periodic: [bool; 2], (from, to): View) -> Vec<(f64, Point)> {
    let ((left, below), (right, above)) = view;
    let shifts = |on: bool, from: f64, to: f64, low: f64, high: f64| {
        let beyond = [(from < low).then_some(high - low), (to > high).then_some(low - high)];
        std::iter::once(0.0).chain(beyond.into_iter().flatten().filter(move |_| on))
    };
    let signs: &[f64] = if mirrored && from.0 + to.0 > 0.0 { &[1.0, -1.0] } else { &[1.0] };
    let mut found = Vec::new();
    for sign in signs {
        for x in shifts(periodic[0], from.0, to.0, left, right) {
            found.extend(shifts(periodic[1], from.1, to.1, below, above).map(|z| (*sign, (x, z))));
        }
    }
    found
}

/// Time and grains of a file of grains.
fn grains_of(path: &Path) -> Result<(f64, Vec<Grain>), String> {
    let place = |why: String| format!("{}: {why}", path.display());
    let bytes = std::fs::read(path).map_err(|error| place(format!("cannot read: {error}")))?;
    let file = Appended::parse(&bytes, "PolyData").map_err(place)?;
    let real = |name: &str| file.real(&file.find(name)?).map_err(place);
    let (position, radius, speed) = (real("position")?, real("radius")?, real("speed")?);
    let held = file.whole(&file.find("held").map_err(place)?).map_err(place)?;
    let places = position.as_chunks::<3>().0;
    if [places.len(), speed.len(), held.len()].iter().any(|length| *length != radius.len()) {
        return Err(place(format!("its arrays are not of {} grains each", radius.len())));
    }
    let grains = places.iter().zip(radius.iter().zip(&speed).zip(&held));
    let grain = |(at, ((radius, speed), held)): (&[f64; 3], ((&f64, &f64), &i64))| Grain {
        at: *at,
        radius: *radius,
        speed: *speed,
        held: *held != 0,
        copy: false,
    };
    Ok((file.time(), grains.map(grain).collect()))
}

impl Frame {
    /// Reads the files of an instant; `slice`: the plane at a time.
    pub(crate) fn read(
        instant: &Instant,
        slice: &dyn Fn(f64) -> Option<Slice>,
        quantity: Quantity,
        shape: Shape<'_>,
    ) -> Result<Self, String> {
        let (mut frame, fields) = Self::read_several(instant, slice, &[quantity], shape)?;
        frame.field = fields.into_iter().next().flatten();
        Ok(frame)
    }

    /// The same with several fields, none for the grains; the first quantity is that of the frame.
    pub(crate) fn read_several(
        instant: &Instant,
        slice: &dyn Fn(f64) -> Option<Slice>,
        quantities: &[Quantity],
        shape: Shape<'_>,
    ) -> Result<(Self, Vec<Option<Field>>), String> {
        let quantity = quantities.first().copied().unwrap_or(Quantity::GRAINS);
        let mut fields = Vec::new();
        let mut frame = Self {
            time: f64::NAN,
            view: NOWHERE,
            field: None,
            bodies: Vec::new(),
            grains: Vec::new(),
            quantity,
            cut: None,
        };
        if let Some(path) = &instant.fluid {
            let grid = vtk::read(path)?;
            frame.time = grid.time;
            frame.cut = slice(grid.time);
            let plane = plane_of(&grid, frame.cut).map_err(|why| format!("{}: {why}", path.display()))?;
            if grid.counts()[plane.axis] > 1 {
                frame.cut = Some(plane);
            }
            for quantity in quantities {
                fields.push(frame.take_field(&grid, plane, shape.mirrored, *quantity)?);
            }
        }
        match &instant.grains {
            Some(path) => frame.take_grains(path, slice, shape)?,
            None if instant.has_fluid() => frame.take_held(shape.grains),
            None => {}
        }
        if let Some(path) = &instant.bodies {
            frame.take_bodies(path)?;
        }
        let known = fields.iter().any(Option::is_some) || shape.ends.is_some();
        frame.repeat(shape.mirrored, frame.axes().map(|axis| known && shape.periodic[axis]));
        if frame.view.1.0 > frame.view.0.0 && frame.view.1.1 > frame.view.0.1 {
            return Ok((frame, fields));
        }
        Err(format!("{}: nothing to see: no grid, and no grain that the plane cuts", instant.name()))
    }

    /// What is coloured, as far as it is in view.
    pub(crate) fn values(&self) -> Vec<f64> {
        match &self.field {
            Some(field) if !self.quantity.is_of_grains() => field.within(self.view),
            _ => self.bodies.iter().filter(|body| !body.held).map(|body| body.speed).collect(),
        }
    }

    /// Axes of the picture: to the right and upwards.
    pub(crate) fn axes(&self) -> [usize; 2] {
        Slice::seen(self.cut.map_or(1, |slice| slice.axis))
    }

    /// Radius of the circle in which the plane cuts a sphere; none where it does not.
    fn seen(&self, at: [f64; 3], radius: f64) -> Option<f64> {
        let aside = self.cut.map_or(0.0, |slice| at[slice.axis] - slice.position);
        Some((radius * radius - aside * aside).max(0.0).sqrt()).filter(|seen| *seen > 0.0)
    }

    /// Adds a sphere with its speed, where the plane cuts it.
    pub(super) fn add_sphere(&mut self, at: [f64; 3], radius: f64, speed: f64, held: bool) {
        let Some(seen) = self.seen(at, radius) else { return };
        let [right, up] = self.axes();
        let corner = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
            (at[right] + seen * angle.cos(), at[up] + seen * angle.sin())
        };
        self.bodies.push(Body { outline: (0..CORNERS).map(corner).collect(), speed, held });
    }

    /// Adds the bodies of a fluid alone, which go as the scene says.
    fn take_held(&mut self, grains: &[bedload_scene::Grain]) {
        for grain in grains {
            let motion = motion_at(grain, self.time);
            let (at, speed) = (motion.position, motion.velocity.iter().map(|v| v * v).sum::<f64>().sqrt());
            self.grains.push(Grain { at, radius: grain.radius, speed, held: true, copy: false });
            let Some(outline) = grain.outline() else {
                self.add_sphere(at, grain.radius, speed, true);
                continue;
            };
            // A turn about y.
            let [w, _, y, _] = motion.orientation;
            let (cos, sin) = (1.0 - 2.0 * y * y, 2.0 * w * y);
            let place = |[x, z]: [f64; 2]| (at[0] + cos * x + sin * z, at[2] - sin * x + cos * z);
            let outline = outline.corners().into_iter().map(place).collect();
            self.bodies.push(Body { outline, speed, held: true });
        }
    }

    fn take_field(
        &mut self,
        grid: &Vtr,
        plane: Slice,
        mirrored: bool,
        quantity: Quantity,
    ) -> Result<Option<Field>, String> {
        let [right, up] = Slice::seen(plane.axis);
        let faces = [grid.faces[right].clone(), grid.faces[up].clone()];
        let (Some((left, end)), Some((bottom, top))) = (ends(&faces[0]), ends(&faces[1])) else {
            let flat = [right, up].into_iter().filter(|axis| ends(&grid.faces[*axis]).is_none());
            let flat: Vec<&str> = flat.map(|axis| AXES[axis]).collect();
            return Err(format!(
                "the grid has no extent along {}: choose another --slice",
                flat.join(" and ")
            ));
        };
        self.view = ((if mirrored { -end } else { left }, bottom), (end, top));
        let Some(array) = quantity.array else { return Ok(None) };
        let Some((components, values)) = grid.arrays.get(array) else {
            let names: Vec<&str> = grid.arrays.keys().map(String::as_str).collect();
            return Err(format!("the files hold no {array}, only {}", names.join(", ")));
        };
        let counts = grid.counts();
        let layer = grid.faces[plane.axis].partition_point(|face| *face <= plane.position);
        let layer = layer.saturating_sub(1).min(counts[plane.axis] - 1);
        let value = |i: usize, k: usize| {
            let mut at = [0; 3];
            (at[right], at[up], at[plane.axis]) = (i, k, layer);
            let cell = components * (at[0] + counts[0] * (at[1] + counts[1] * at[2]));
            match quantity.component {
                Some(component) => values[cell + component.min(components - 1)],
                None => values[cell..cell + components].iter().map(|v| v * v).sum::<f64>().sqrt(),
            }
        };
        let values = (0..counts[up]).map(|k| (0..counts[right]).map(|i| value(i, k)).collect()).collect();
        // What points outwards, or turns about y, changes its sign on the other side of the axis.
        let turns = matches!(quantity.name, "velocity-x" | "vorticity");
        Ok(Some(Field { faces, values, mirrored, mirror_sign: if turns { -1.0 } else { 1.0 } }))
    }

    fn take_grains(
        &mut self,
        path: &Path,
        slice: &dyn Fn(f64) -> Option<Slice>,
        shape: Shape<'_>,
    ) -> Result<(), String> {
        let (time, grains) = grains_of(path)?;
        // Without a fluid the picture shows the box, and the plane goes through its middle; where the box is
        // not known, all grains, and the middle of them.
        let alone = !self.view.0.0.is_finite();
        if alone {
            self.time = time;
            let of_grains = || {
                grains.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), grain| {
                    (low.min(grain.at[1]), high.max(grain.at[1]))
                })
            };
            let (low, high) = shape.ends.map_or_else(of_grains, |ends| ends[1]);
            let middle = (high > low).then_some(Slice { axis: 1, position: 0.5 * (low + high) });
            self.cut = slice(self.time).or(middle);
        }
        let [right, up] = self.axes();
        if let Some(ends) = shape.ends.filter(|_| alone) {
            let left = if shape.mirrored { -ends[right].1 } else { ends[right].0 };
            self.view = ((left, ends[up].0), (ends[right].1, ends[up].1));
        }
        for Grain { at, radius, speed, held, .. } in &grains {
            let known = self.bodies.len();
            self.add_sphere(*at, *radius, *speed, *held);
            if alone && shape.ends.is_none() && self.bodies.len() > known {
                let (x, z) = (at[right], at[up]);
                self.view = around(self.view, ((x - radius, z - radius), (x + radius, z + radius)));
            }
        }
        self.grains = grains;
        Ok(())
    }

    /// Adds the [`copies`] of all bodies, and of the grains that the plane cuts.
    fn repeat(&mut self, mirrored: bool, periodic: [bool; 2]) {
        let view = self.view;
        let copies = |extent: View| copies(view, mirrored, periodic, extent).into_iter().skip(1);
        let mut bodies = Vec::new();
        for body in &self.bodies {
            bodies.extend(copies(body.extent()).map(|(sign, shift)| {
                let outline = body.outline.iter().map(|at| (sign * at.0 + shift.0, at.1 + shift.1)).collect();
                Body { outline, ..*body }
            }));
        }
        let [right, up] = self.axes();
        let mut grains = Vec::new();
        for grain in &self.grains {
            let Some(seen) = self.seen(grain.at, grain.radius) else { continue };
            let (x, z) = (grain.at[right], grain.at[up]);
            grains.extend(copies(((x - seen, z - seen), (x + seen, z + seen))).map(|(sign, shift)| {
                let mut copy = Grain { copy: true, ..*grain };
                (copy.at[right], copy.at[up]) = (sign * x + shift.0, z + shift.1);
                copy
            }));
        }
        self.bodies.extend(bodies);
        self.grains.extend(grains);
    }

    /// Bodies that are not round, in place of the circles around them.
    fn take_bodies(&mut self, path: &Path) -> Result<(), String> {
        let place = |why: String| format!("{}: {why}", path.display());
        let bytes = std::fs::read(path).map_err(|error| place(format!("cannot read: {error}")))?;
        let file = Appended::parse(&bytes, "PolyData").map_err(place)?;
        let position = file.real(&file.find("position").map_err(place)?).map_err(place)?;
        let whole = |name: &str| file.whole(&file.find(name)?).map_err(place);
        let (ends, ids, held) = (whole("offsets")?, whole("id")?, whole("held")?);
        let points = position.as_chunks::<3>().0;
        let mut first = 0;
        for ((end, id), held) in ends.iter().zip(&ids).zip(&held) {
            let range = first..usize::try_from(*end).unwrap_or(0);
            first = range.end;
            let outline =
                points.get(range).ok_or_else(|| place("a polygon lies beyond its points".into()))?;
            let outline = outline.iter().map(|at| (at[0], at[2])).collect();
            if let Some(body) = usize::try_from(*id).ok().and_then(|id| self.bodies.get_mut(id)) {
                *body = Body { outline, speed: body.speed, held: *held != 0 };
            }
        }
        Ok(())
    }
}

/// Least and greatest face.
fn ends(faces: &[f64]) -> Option<(f64, f64)> {
    let (first, last) = (*faces.first()?, *faces.last()?);
    (last > first).then_some((first, last))
}

/// The plane asked for, or the middle of the grid along y.
fn plane_of(grid: &Vtr, slice: Option<Slice>) -> Result<Slice, String> {
    let Some(slice) = slice else {
        let (low, high) = ends(&grid.faces[1]).unwrap_or_default();
        return Ok(Slice { axis: 1, position: 0.5 * (low + high) });
    };
    let Some((low, high)) = ends(&grid.faces[slice.axis]) else {
        return Err(format!("the grid has no extent along {}: leave --slice out", AXES[slice.axis]));
    };
    if (low..=high).contains(&slice.position) {
        return Ok(slice);
    }
    let (axis, position) = (AXES[slice.axis], slice.position);
    Err(format!("--slice {axis}={position}: outside the box; allowed: {low} to {high}"))
}

#[cfg(test)]
mod tests {
    use bedload_output::vtk::{Array, points, rectilinear_part};
    use bedload_scene::Shape as Form;

    use super::*;

    #[test]
    fn fields_and_planes_are_read_or_refused() {
        assert_eq!(Quantity::parse("speed", Geometry::Plane).unwrap(), Quantity::SPEED);
        assert!(Quantity::parse("colour", Geometry::Space).unwrap_err().contains("vorticity-x"));
        for none in ["vorticity-x", "vorticity-z", "velocity-y"] {
            assert!(Quantity::parse(none, Geometry::Space).is_ok());
            for flat in [Geometry::Plane, Geometry::Axisymmetric] {
                assert!(Quantity::parse(none, flat).unwrap_err().contains("no such field"), "{none}");
            }
        }
        assert_eq!(Slice::parse("z = 0.25").unwrap(), Slice { axis: 2, position: 0.25 });
        for bad in ["w=1", "y", "y=", "y=nan", "0.5"] {
            assert!(Slice::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_plane_outside_the_box_is_refused() {
        let grid = Vtr { faces: [vec![0.0, 1.0], vec![0.0], vec![0.0, 2.0]], ..Vtr::default() };
        assert_eq!(plane_of(&grid, None).unwrap().axis, 1);
        let at = |axis, position| plane_of(&grid, Some(Slice { axis, position }));
        assert!(at(2, 1.5).is_ok());
        assert!(at(2, 2.5).unwrap_err().contains("outside"));
        assert!(at(1, 0.0).unwrap_err().contains("no extent"));
    }

    fn file(y: [f64; 3]) -> Vec<u8> {
        let data = [
            Array::scalar("radius", vec![1.0; 3]),
            Array::scalar("speed", vec![0.0, 2.0, 3.0]),
            Array::whole("held", vec![0, 0, 1]),
        ];
        points(0.5, vec![1.0, y[0], 2.0, 3.0, y[1], 4.0, 5.0, y[2], 6.0], &data)
    }

    fn read(name: &str, bytes: &[u8]) -> Result<Frame, String> {
        let path = std::env::temp_dir().join(format!("bedload-{}-{name}.vtp", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        let frame = Frame::read(&Instant::of_grains(&path), &|_| None, Quantity::GRAINS, Shape::UNKNOWN);
        std::fs::remove_file(&path).unwrap();
        frame
    }

    #[test]
    fn discs_are_whole_and_spheres_cut() {
        let plane = read("plane", &file([0.0; 3])).unwrap();
        assert_eq!((plane.time, plane.cut, plane.bodies.len()), (0.5, None, 3));
        assert_eq!((plane.bodies[1].outline[0], plane.bodies[1].speed), ((4.0, 4.0), 2.0));
        assert!(plane.bodies[2].held && !plane.bodies[1].held);
        let space = read("space", &file([-2.0, 2.0, 0.6])).unwrap();
        assert_eq!(space.cut, Some(Slice { axis: 1, position: 0.0 }));
        assert_eq!(space.bodies.len(), 1, "two do not reach the plane");
        assert!((space.bodies[0].outline[0].0 - 5.8).abs() < 1e-12);
    }

    #[test]
    fn copies_stand_beyond_periodic_sides_and_across_the_axis() {
        let view = ((0.0, 0.0), (4.0, 6.0));
        let of = |mirrored, periodic, extent| copies(view, mirrored, periodic, extent);
        let inside = ((1.0, 1.0), (2.0, 2.0));
        assert_eq!(of(false, [true; 2], inside), [(1.0, (0.0, 0.0))]);
        assert_eq!(of(true, [false; 2], inside), [(1.0, (0.0, 0.0)), (-1.0, (0.0, 0.0))]);
        assert_eq!(of(true, [false; 2], ((-1.0, 1.0), (1.0, 3.0))).len(), 1, "it stands on the axis");
        let corner = ((-0.5, 5.5), (0.5, 6.5));
        assert_eq!(of(false, [false; 2], corner).len(), 1);
        assert_eq!(of(false, [true, false], corner)[1..], [(1.0, (4.0, 0.0))]);
        assert_eq!(
            of(false, [true; 2], corner)[1..],
            [(1.0, (0.0, -6.0)), (1.0, (4.0, 0.0)), (1.0, (4.0, -6.0))]
        );
    }

    /// A disc that moves by prescription over a periodic side, and a square that turns: no file has them.
    #[test]
    fn bodies_of_a_fluid_alone_are_those_of_the_scene() {
        let faces = [vec![0.0, 2.0, 4.0], vec![0.0], vec![0.0, 6.0]];
        let data = [Array::real("velocity", 3, vec![1.0; 6])];
        let path = std::env::temp_dir().join(format!("bedload-{}-held.vtr", std::process::id()));
        std::fs::write(&path, rectilinear_part(2.0, &faces, 0, &data)).unwrap();
        let mut disc = bedload_scene::Grain::at([3.0, 0.0, 2.0], 0.5, 1.0);
        (disc.motion, disc.velocity) = (bedload_scene::Motion::Prescribed, [0.4, 0.0, 0.0].into());
        let mut square = bedload_scene::Grain::at([1.0, 0.0, 4.0], 0.5, 1.0);
        (square.shape, square.sides) = (Form::Rectangle, Some([0.8, 0.8]));
        (square.motion, square.spin) =
            (bedload_scene::Motion::Prescribed, [0.0, std::f64::consts::FRAC_PI_8, 0.0].into());
        let grains = [disc, square];
        let shape = Shape { periodic: [true, false, false], grains: &grains, ..Shape::UNKNOWN };
        let instant = Instant { fluid: Some(path.clone()), ..Instant::default() };
        let frame = Frame::read(&instant, &|_| None, Quantity::SPEED, shape).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!((frame.bodies.len(), frame.grains.len()), (3, 3), "two and a copy");
        assert!(frame.bodies.iter().all(|body| body.held));
        let [places, copy] = [&frame.bodies[0], &frame.bodies[2]].map(|body| body.outline[0].0);
        assert!((places - 4.3).abs() < 1e-12 && (copy - 0.3).abs() < 1e-12, "{places} {copy}");
        let left = frame.bodies[1].outline.iter().map(|at| at.0).fold(f64::INFINITY, f64::min);
        assert!((left - (1.0 - 0.4 * 2f64.sqrt())).abs() < 1e-12, "turned by 45°: {left}");
    }

    #[test]
    fn a_file_of_something_else_is_refused() {
        let other = points(0.0, vec![0.0; 3], &[Array::scalar("radius", vec![1.0])]);
        let whole = file([0.0; 3]);
        let refusal = |name, bytes: &[u8]| read(name, bytes).err().expect(name);
        assert!(refusal("other", &other).contains("speed"));
        assert!(refusal("abc", b"abc").contains("bedload"));
        assert!(refusal("torn", &whole[..whole.len() - 200]).contains("beyond the end"));
    }
}
