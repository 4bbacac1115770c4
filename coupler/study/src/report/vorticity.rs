//! The panel of vorticity pictures around a grain, after Izard et al. (2014), figure 6.

use bedload_output::vtk::{self, Vtr};
use bedload_scene::Geometry;
use serde::Serialize;

use super::contour::{Field, Segment};
use super::run_files::{RunFiles, column};
use crate::page::{Figure, render};
use coupler::failure::Failure;
use coupler::number::number;

/// Pictures in a panel.
const MOST_PICTURES: usize = 24;

/// Contours: ten, evenly from −17.8 to 17.8 in √(g/D) (the increment 3.956 is printed there as 3.9).
const LEVELS: usize = 10;
const HIGHEST: f64 = 17.8;

/// A picture shows this far around the grain's centre, in D: sideways, down and up (the wake).
const REACH: [f64; 3] = [1.6, 1.0, 2.2];

/// Units of a picture per D.
const UNIT: f64 = 70.0;

/// One instant, everything in units of the grain's diameter.
struct Picture {
    time: f64,
    field: Field,
    /// Grains within sight: x, z and radius.
    grains: Vec<(f64, f64, f64)>,
    /// Lower left and upper right corner of the view.
    view: Corners,
    /// The same of the box.
    walls: Corners,
}

/// Lower left and upper right corner.
type Corners = [(f64, f64); 2];

/// The panel.
#[derive(Serialize)]
pub(super) struct Vorticity {
    pictures: Vec<Figure>,
    about: String,
    /// Files that could not be read, and why.
    faults: Vec<String>,
}

/// The panel, or nothing if the run left no fields or has no grain.
pub(super) fn panel(run: &RunFiles) -> Result<Option<Vorticity>, Failure> {
    let mut faults = Vec::new();
    let files = &run.fields;
    let step = files.len().div_ceil(MOST_PICTURES).max(1);
    let read = files.iter().step_by(step).filter_map(|path| match vtk::read(path) {
        Ok(vtr) => picture(run, &vtr),
        Err(error) => {
            faults.push(error);
            None
        }
    });
    let pictures: Vec<Picture> = read.collect();
    if pictures.is_empty() && faults.is_empty() {
        return Ok(None);
    }
    let unit = if run.scales.by_gravity { 1.0 / run.scales.time } else { 1.0 };
    let highest = highest_level(&pictures, run.scales.by_gravity.then_some(unit));
    let about = format!(
        "Vorticity about y: ten contours from −{level} to {level} {scaled}, red positive, blue negative{mirror}. {count} \
         of {total} field files.",
        level = number(highest / unit),
        scaled = if run.scales.by_gravity { "in √(g/D)" } else { "in 1/s" },
        mirror = if axisymmetric(run) { ", mirrored about the axis with its sign" } else { "" },
        count = pictures.len(),
        total = files.len(),
    );
    let pictures = pictures.iter().map(|picture| picture.draw(run, highest)).collect::<Result<_, _>>()?;
    Ok(Some(Vorticity { pictures, about, faults }))
}

fn axisymmetric(run: &RunFiles) -> bool {
    run.summary.size.geometry == Geometry::Axisymmetric
}

/// The highest level of Izard et al., 1/s; half the strongest vorticity where that would leave the pictures
/// empty, or where there is no gravity to scale with.
fn highest_level(pictures: &[Picture], unit: Option<f64>) -> f64 {
    let strongest = pictures.iter().map(Picture::strongest).fold(0.0, f64::max);
    let published = unit.map(|unit| HIGHEST * unit);
    published.filter(|highest| strongest > highest / (LEVELS as f64 - 1.0)).unwrap_or(0.5 * strongest)
}

fn picture(run: &RunFiles, vtr: &Vtr) -> Option<Picture> {
    let scene = run.scene.as_ref()?;
    let grain = run.grains().first().copied().unwrap_or(0);
    let radius = scene.grains.get(grain)?.radius;
    let length = 2.0 * radius;
    let at = position(run, grain, vtr.time)?;
    let slice = nearest(&vtr.centres(1), at[1]);
    let values = vtr.slice("vorticity", 1, slice)?;
    let mut field = Field { x: vtr.centres(0), z: vtr.centres(2), values };
    if axisymmetric(run) {
        field = mirrored(&field);
    }
    let edge = |axis: usize| Some((*vtr.faces[axis].first()?, *vtr.faces[axis].last()?));
    let ((mut left, right), (bottom, top)) = (edge(0)?, edge(2)?);
    if axisymmetric(run) {
        left = -right;
    }
    let corner = |x: f64, z: f64| (x / length, z / length);
    let [aside, down, up] = REACH.map(|reach| reach * length);
    let view = [corner(at[0] - aside, at[2] - down), corner(at[0] + aside, at[2] + up)];
    let walls = [corner(left, bottom), corner(right, top)];
    let mut grains = Vec::new();
    for other in run.grains() {
        let (Some(place), Some(data)) = (position(run, other, vtr.time), scene.grains.get(other)) else {
            continue;
        };
        // The plane of the picture cuts a sphere in a smaller circle.
        let cut = (data.radius.powi(2) - (place[1] - at[1]).powi(2)).max(0.0).sqrt();
        if cut > 0.0 {
            grains.push((place[0] / length, place[2] / length, cut / length));
        }
    }
    let field = cropped(&field, length, view);
    Some(Picture { time: vtr.time, field, grains, view, walls })
}

/// Position of a grain at `time` from the series, between its rows; components that have no column
/// are those of the scene.
fn position(run: &RunFiles, grain: usize, time: f64) -> Option<[f64; 3]> {
    let mut at = run.scene.as_ref()?.grains.get(grain)?.position;
    for (axis, at) in at.iter_mut().enumerate() {
        if let Some(column) = run.series.column(&column("position", axis, grain)) {
            *at = between(run.series.time(), column, time, *at);
        }
    }
    Some(at)
}

/// Linear interpolation; before the first row from `initial` at t = 0, after the last row the last.
fn between(times: &[f64], values: &[f64], time: f64, initial: f64) -> f64 {
    let after = times.partition_point(|t| *t < time);
    let point = |row: usize| (times[row], values[row]);
    match (after, times.len()) {
        (_, 0) => initial,
        (after, rows) if after == rows => values[rows - 1],
        (after, _) => {
            let (t0, v0) = if after == 0 { (0.0, initial) } else { point(after - 1) };
            let (t1, v1) = point(after);
            if t1 > t0 { v0 + (v1 - v0) * (time - t0) / (t1 - t0) } else { v1 }
        }
    }
}

fn nearest(centres: &[f64], value: f64) -> usize {
    let distance = |index: &usize| (centres[*index] - value).abs();
    (0..centres.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

/// The field on both sides of the axis: the azimuthal direction turns round, so the component along
/// y changes its sign.
fn mirrored(field: &Field) -> Field {
    let x = field.x.iter().rev().map(|x| -x).chain(field.x.iter().copied()).collect();
    let row = |row: &Vec<f64>| row.iter().rev().map(|value| -value).chain(row.iter().copied()).collect();
    Field { x, z: field.z.clone(), values: field.values.iter().map(row).collect() }
}

/// The part of the field in view and one point around it, in units of `length`.
fn cropped(field: &Field, length: f64, view: Corners) -> Field {
    let range = |points: &[f64], from: f64, to: f64| {
        let first = points.partition_point(|point| point / length < from).saturating_sub(1);
        let last = (points.partition_point(|point| point / length <= to) + 1).min(points.len());
        first..last
    };
    let columns = range(&field.x, view[0].0, view[1].0);
    let rows = range(&field.z, view[0].1, view[1].1);
    Field {
        x: field.x[columns.clone()].iter().map(|x| x / length).collect(),
        z: field.z[rows.clone()].iter().map(|z| z / length).collect(),
        values: field.values[rows].iter().map(|row| row[columns.clone()].to_vec()).collect(),
    }
}

impl Picture {
    /// Largest magnitude of vorticity in view outside the grains, 1/s.
    fn strongest(&self) -> f64 {
        let mut strongest = 0.0f64;
        for (z, row) in self.field.z.iter().zip(&self.field.values) {
            for (x, value) in self.field.x.iter().zip(row) {
                let inside = self.grains.iter().any(|(gx, gz, r)| (x - gx).hypot(z - gz) < *r);
                if !inside && value.is_finite() {
                    strongest = strongest.max(value.abs());
                }
            }
        }
        strongest
    }

    fn draw(&self, run: &RunFiles, highest: f64) -> Result<Figure, Failure> {
        let [(left, bottom), (right, top)] = self.view;
        let place = |(x, z): (f64, f64)| (UNIT * (x - left), UNIT * (top - z));
        let time = number(self.time / run.scales.time);
        let caption =
            if run.scales.by_gravity { format!("t = {time} √(D/g)") } else { format!("t = {time} s") };
        // What lies outside the box stays grey.
        let (x, y) = place((self.walls[0].0.max(left), self.walls[1].1.min(top)));
        let (x2, y2) = place((self.walls[1].0.min(right), self.walls[0].1.max(bottom)));
        let contours = |sign: f64| {
            let level = |index: usize| sign * highest * (2 * index + 1) as f64 / (LEVELS - 1) as f64;
            (0..LEVELS / 2).map(|index| path(&self.field.contour(level(index)), &place)).collect()
        };
        let disc = |&(x, z, radius): &(f64, f64, f64)| {
            let (x, y) = place((x, z));
            (x, y, UNIT * radius)
        };
        let drawn = Drawn {
            walls: [x, y, x2 - x, y2 - y],
            positive: contours(1.0),
            negative: contours(-1.0),
            grains: self.grains.iter().map(disc).collect(),
        };
        let view = format!("0 0 {:.1} {:.1}", UNIT * (right - left), UNIT * (top - bottom));
        let label = format!("Vorticity at {caption}");
        Ok(Figure { view, label, caption, body: render("vorticity.svg", drawn)?, keys: Vec::new() })
    }
}

/// What `templates/vorticity.svg` shows, in the units of the picture.
#[derive(Serialize)]
struct Drawn {
    /// Left, top, width and height of the box.
    walls: [f64; 4],
    /// Paths of the contours.
    positive: String,
    negative: String,
    /// Centre and radius.
    grains: Vec<(f64, f64, f64)>,
}

fn path(segments: &[Segment], place: &impl Fn((f64, f64)) -> (f64, f64)) -> String {
    let piece = |[from, to]: &Segment| {
        let ((x1, y1), (x2, y2)) = (place(*from), place(*to));
        format!("M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}")
    };
    segments.iter().map(piece).collect()
}
