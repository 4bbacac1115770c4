//! What a picture shows: a field and the grains on a plane at one instant, from the files of a run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bedload_output::Summary;
use bedload_output::vtk::{self, Appended, Vtr};
use bedload_scene::{CheckedScene, Geometry};

use crate::folder::files;

const AXES: [&str; 3] = ["x", "y", "z"];

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

    /// Of `--field`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|quantity| quantity.name == text).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|quantity| quantity.name).collect();
            format!("--field {text}: no such field; allowed: {}", names.join(", "))
        })
    }

    /// Are the grains coloured by their speed, and nothing else?
    pub(crate) fn is_of_grains(self) -> bool {
        self.array.is_none()
    }

    /// Unit of the values.
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

/// The box of the run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Does the picture show both sides of an axis?
    pub(crate) mirrored: bool,
    /// Components along which it is periodic.
    pub(crate) periodic: [bool; 3],
    /// Its ends along each component, m; none where the scene cannot be read.
    pub(crate) ends: Option<[(f64, f64); 3]>,
}

impl Shape {
    /// Of a run; without periodic sides where its scene cannot be read here any more.
    pub(crate) fn of(summary: &Summary, scene: Option<&CheckedScene>) -> Self {
        let mut shape = Self {
            mirrored: summary.size.geometry == Geometry::Axisymmetric,
            periodic: [false; 3],
            ends: scene.map(|_| [(0.0, 0.0); 3]),
        };
        let Some(CheckedScene { scene, .. }) = scene else { return shape };
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

/// A view of nothing.
pub(crate) const NOWHERE: View = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));

/// What shows two views.
pub(crate) fn around((low, high): View, (low2, high2): View) -> View {
    ((low.0.min(low2.0), low.1.min(low2.1)), (high.0.max(high2.0), high.1.max(high2.1)))
}

pub(crate) struct Frame {
    pub(crate) time: f64,
    pub(crate) view: View,
    pub(crate) field: Option<Field>,
    /// What the plane cuts, with images beyond periodic faces.
    pub(crate) bodies: Vec<Body>,
    /// All grains of the file, wherever the plane lies.
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
    };
    Ok((file.time(), grains.map(grain).collect()))
}

impl Frame {
    /// Reads the files of an instant; `slice`: the plane at a time.
    pub(crate) fn read(
        instant: &Instant,
        slice: &dyn Fn(f64) -> Option<Slice>,
        quantity: Quantity,
        shape: Shape,
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
        shape: Shape,
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
        if let Some(path) = &instant.grains {
            frame.take_grains(path, slice, shape)?;
        }
        if let Some(path) = &instant.bodies {
            frame.take_bodies(path)?;
        }
        if fields.iter().any(Option::is_some) || shape.ends.is_some() {
            frame.repeat(frame.axes().map(|axis| shape.periodic[axis]));
        }
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

    /// Adds a sphere with its speed, where the plane cuts it.
    pub(crate) fn add_sphere(&mut self, at: [f64; 3], radius: f64, speed: f64, held: bool, mirrored: bool) {
        let aside = self.cut.map_or(0.0, |slice| at[slice.axis] - slice.position);
        let seen = (radius * radius - aside * aside).max(0.0).sqrt();
        if seen == 0.0 {
            return;
        }
        let [right, up] = self.axes();
        let sides = if mirrored && at[right] > 0.0 { vec![1.0, -1.0] } else { vec![1.0] };
        for side in sides {
            let corner = |k: u32| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
                (side * at[right] + seen * angle.cos(), at[up] + seen * angle.sin())
            };
            self.bodies.push(Body { outline: (0..CORNERS).map(corner).collect(), speed, held });
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
            let (a, b) = (AXES[right], AXES[up]);
            return Err(format!("the grid has no extent along {a} and {b}: choose another --slice"));
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
        shape: Shape,
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
        for Grain { at, radius, speed, held } in &grains {
            let known = self.bodies.len();
            self.add_sphere(*at, *radius, *speed, *held, shape.mirrored);
            if alone && shape.ends.is_none() && self.bodies.len() > known {
                let (x, z) = (at[right], at[up]);
                self.view = around(self.view, ((x - radius, z - radius), (x + radius, z + radius)));
            }
        }
        self.grains = grains;
        Ok(())
    }

    /// Shows what reaches out of a periodic box on the other side, too.
    fn repeat(&mut self, periodic: [bool; 2]) {
        let (low, high) = self.view;
        let extent = (high.0 - low.0, high.1 - low.1);
        let shifts = |on: bool, length: f64| if on { vec![-length, 0.0, length] } else { vec![0.0] };
        let mut images = Vec::new();
        for (x, z) in shifts(periodic[0], extent.0)
            .into_iter()
            .flat_map(|x| shifts(periodic[1], extent.1).into_iter().map(move |z| (x, z)))
            .filter(|shift| *shift != (0.0, 0.0))
        {
            for body in &self.bodies {
                let outline: Vec<Point> = body.outline.iter().map(|at| (at.0 + x, at.1 + z)).collect();
                let seen = |at: &Point| at.0 > low.0 && at.0 < high.0 && at.1 > low.1 && at.1 < high.1;
                if outline.iter().any(seen) {
                    images.push(Body { outline, ..*body });
                }
            }
        }
        self.bodies.extend(images);
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
    use bedload_output::vtk::{Array, points};

    use super::*;

    #[test]
    fn fields_and_planes_are_read_or_refused() {
        assert_eq!(Quantity::parse("speed").unwrap(), Quantity::SPEED);
        assert!(Quantity::parse("colour").unwrap_err().contains("vorticity"));
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
        let shape = Shape { mirrored: false, periodic: [false; 3], ends: None };
        let frame = Frame::read(&Instant::of_grains(&path), &|_| None, Quantity::GRAINS, shape);
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
    fn a_file_of_something_else_is_refused() {
        let other = points(0.0, vec![0.0; 3], &[Array::scalar("radius", vec![1.0])]);
        let whole = file([0.0; 3]);
        let refusal = |name, bytes: &[u8]| read(name, bytes).err().expect(name);
        assert!(refusal("other", &other).contains("speed"));
        assert!(refusal("abc", b"abc").contains("bedload"));
        assert!(refusal("torn", &whole[..whole.len() - 200]).contains("beyond the end"));
    }
}
