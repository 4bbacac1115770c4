//! What the frames show: a field and the grains on a plane, from the files of a run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bedload_output::vtk::{self, Appended, Vtr};

use crate::folder::files;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Corners of the outline of a round grain.
const CORNERS: u32 = 48;

/// What is coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Quantity {
    name: &'static str,
    /// Array of the field files; none: the grains themselves.
    array: Option<&'static str>,
    /// Component, none: the length of the vector.
    component: Option<usize>,
}

impl Quantity {
    pub(super) const SPEED: Self = Self { name: "speed", array: Some("velocity"), component: None };
    pub(super) const GRAINS: Self = Self { name: "grains", array: None, component: None };
    const ALL: [Self; 10] = [
        Self::SPEED,
        Self { name: "velocity-x", array: Some("velocity"), component: Some(0) },
        Self { name: "velocity-y", array: Some("velocity"), component: Some(1) },
        Self { name: "velocity-z", array: Some("velocity"), component: Some(2) },
        Self { name: "vorticity-x", array: Some("vorticity"), component: Some(0) },
        Self { name: "vorticity", array: Some("vorticity"), component: Some(1) },
        Self { name: "vorticity-z", array: Some("vorticity"), component: Some(2) },
        Self { name: "pressure", array: Some("pressure"), component: Some(0) },
        Self { name: "solid", array: Some("solid"), component: Some(0) },
        Self::GRAINS,
    ];

    /// Of `--field`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|quantity| quantity.name == text).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|quantity| quantity.name).collect();
            format!("--field {text}: no such field; allowed: {}", names.join(", "))
        })
    }

    /// Are the grains coloured by their speed, and nothing else?
    pub(super) fn is_of_grains(self) -> bool {
        self.array.is_none()
    }

    pub(super) fn label(self) -> &'static str {
        if self.is_of_grains() { "speed" } else { self.name }
    }
}

/// A plane normal to an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slice {
    axis: usize,
    position: f64,
}

impl Slice {
    /// Of `--slice`, such as `y=0.5`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
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
pub(super) struct Shape {
    /// Does the picture show both sides of an axis?
    pub(super) mirrored: bool,
    /// Components along which it is periodic.
    pub(super) periodic: [bool; 3],
}

/// Files of one instant.
#[derive(Clone, Debug, Default)]
pub(super) struct Instant {
    fluid: Option<PathBuf>,
    grains: Option<PathBuf>,
    bodies: Option<PathBuf>,
}

impl Instant {
    pub(super) fn has_fluid(&self) -> bool {
        self.fluid.is_some()
    }

    pub(super) fn name(&self) -> String {
        let path = self.fluid.as_ref().or(self.grains.as_ref());
        path.map_or_else(String::new, |path| path.display().to_string())
    }
}

/// The instants of a folder of fields, in order: files that end with the same number.
pub(super) fn instants(folder: &Path) -> Vec<Instant> {
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
pub(super) struct Field {
    /// Faces of the cells to the right and upwards, m.
    pub(super) faces: [Vec<f64>; 2],
    /// Rows from below.
    pub(super) values: Vec<Vec<f64>>,
    /// Is it mirrored about the axis, and with what sign?
    pub(super) mirrored: bool,
    pub(super) mirror_sign: f64,
}

/// A grain or body on the plane.
pub(super) struct Body {
    pub(super) outline: Vec<(f64, f64)>,
    pub(super) speed: f64,
    pub(super) held: bool,
}

/// One frame.
pub(super) struct Frame {
    pub(super) time: f64,
    /// Lower left and upper right corner, m.
    pub(super) view: ((f64, f64), (f64, f64)),
    pub(super) field: Option<Field>,
    pub(super) bodies: Vec<Body>,
    of_grains: bool,
}

impl Frame {
    /// Reads the files of an instant.
    pub(super) fn read(
        instant: &Instant,
        slice: Option<Slice>,
        quantity: Quantity,
        shape: Shape,
    ) -> Result<Self, String> {
        let mut frame = Self {
            time: f64::NAN,
            view: ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY)),
            field: None,
            bodies: Vec::new(),
            of_grains: quantity.is_of_grains(),
        };
        let mut slice = slice;
        if let Some(path) = &instant.fluid {
            let grid = vtk::read(path)?;
            frame.time = grid.time;
            let plane = plane_of(&grid, slice).map_err(|why| format!("{}: {why}", path.display()))?;
            if grid.counts()[plane.axis] > 1 || slice.is_some() {
                slice = Some(plane);
            }
            frame.take_field(&grid, plane, quantity, shape.mirrored)?;
        }
        if let Some(path) = &instant.grains {
            frame.take_grains(path, slice, shape.mirrored)?;
        }
        if let Some(path) = &instant.bodies {
            frame.take_bodies(path)?;
        }
        let axes = Slice::seen(slice.map_or(1, |slice| slice.axis));
        if frame.field.is_some() {
            frame.repeat(axes.map(|axis| shape.periodic[axis]));
        }
        if frame.view.1.0 > frame.view.0.0 && frame.view.1.1 > frame.view.0.1 {
            return Ok(frame);
        }
        Err(format!("{}: nothing to see: no grid, and no grain that the plane cuts", instant.name()))
    }

    /// What is coloured.
    pub(super) fn values(&self) -> Vec<f64> {
        match &self.field {
            Some(field) if !self.of_grains => field.values.iter().flatten().copied().collect(),
            _ => self.bodies.iter().filter(|body| !body.held).map(|body| body.speed).collect(),
        }
    }

    fn take_field(
        &mut self,
        grid: &Vtr,
        plane: Slice,
        quantity: Quantity,
        mirrored: bool,
    ) -> Result<(), String> {
        let [right, up] = Slice::seen(plane.axis);
        let faces = [grid.faces[right].clone(), grid.faces[up].clone()];
        let (Some((left, end)), Some((bottom, top))) = (ends(&faces[0]), ends(&faces[1])) else {
            let (a, b) = (AXES[right], AXES[up]);
            return Err(format!("the grid has no extent along {a} and {b}: choose another --slice"));
        };
        self.view = ((if mirrored { -end } else { left }, bottom), (end, top));
        let Some(array) = quantity.array else { return Ok(()) };
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
        self.field = Some(Field { faces, values, mirrored, mirror_sign: if turns { -1.0 } else { 1.0 } });
        Ok(())
    }

    fn take_grains(&mut self, path: &Path, slice: Option<Slice>, mirrored: bool) -> Result<(), String> {
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
        if self.time.is_nan() {
            self.time = file.time();
        }
        // Without a fluid the plane goes through the middle of the grains, and all of them are in view.
        let middle = |axis: usize| {
            let (low, high) = places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at[axis]), high.max(at[axis]))
            });
            (high > low).then_some(Slice { axis, position: 0.5 * (low + high) })
        };
        let in_grid = self.field.is_some() || self.view.0.0.is_finite();
        let slice = slice.or_else(|| if in_grid { None } else { middle(1) });
        let [right, up] = Slice::seen(slice.map_or(1, |slice| slice.axis));
        for (at, ((radius, speed), held)) in places.iter().zip(radius.iter().zip(&speed).zip(&held)) {
            let aside = slice.map_or(0.0, |slice| at[slice.axis] - slice.position);
            let seen = (radius * radius - aside * aside).max(0.0).sqrt();
            if seen == 0.0 {
                continue;
            }
            let centre = (at[right], at[up]);
            if !in_grid {
                let (low, high) = &mut self.view;
                *low = (low.0.min(centre.0 - radius), low.1.min(centre.1 - radius));
                *high = (high.0.max(centre.0 + radius), high.1.max(centre.1 + radius));
            }
            let outline = |centre: (f64, f64)| {
                let corner = |k: u32| {
                    let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
                    (centre.0 + seen * angle.cos(), centre.1 + seen * angle.sin())
                };
                Body { outline: (0..CORNERS).map(corner).collect(), speed: *speed, held: *held != 0 }
            };
            self.bodies.push(outline(centre));
            if mirrored && centre.0 > 0.0 {
                self.bodies.push(outline((-centre.0, centre.1)));
            }
        }
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
                let outline: Vec<(f64, f64)> = body.outline.iter().map(|at| (at.0 + x, at.1 + z)).collect();
                let seen = |at: &(f64, f64)| at.0 > low.0 && at.0 < high.0 && at.1 > low.1 && at.1 < high.1;
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
}
