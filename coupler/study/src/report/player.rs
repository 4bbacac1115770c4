//! What the player of a page shows: grains and a plane of the flow over time, and columns of the series.
//!
//! The pictures of the plane are drawn here, as PNG in the colours of their scale; the grains go as numbers,
//! and the script of the page (`templates/player.js`) draws them, on the plane or in space.

use bedload_scene::Geometry;
use serde::Serialize;

use super::run_files::RunFiles;
use crate::page::{Value, context};
use crate::pictures::{
    Field, Frame, Grain, Instant, NOWHERE, Quantity, Raster, Scale, Shape, View, around, base64, stops,
};
use coupler::failure::Failure;
use coupler::number::rounded;

/// Instants at most, and bytes of their pictures and grains: the page stays below 20 MB.
const MOST_INSTANTS: usize = 600;
const MOST_BYTES: usize = 18 << 20;

/// Bytes of files that are read for it, and values that are kept meanwhile.
const MOST_READ: u64 = 4 << 30;
const MOST_VALUES: usize = 60_000_000;

/// Pixels of a picture along its longer side, at most.
const PIXELS: usize = 256;

/// What is shown of the fluid.
const QUANTITIES: [Quantity; 3] = [Quantity::SPEED, Quantity::VORTICITY, Quantity::PRESSURE];

/// Columns of the series, and points of each, at most.
const MOST_COLUMNS: usize = 24;
const MOST_POINTS: usize = 600;

/// Bytes of a grain: position and radius in steps of the scale, 16 bits each, colour, and whether it is held
/// (1) and a copy, for the plane alone (2).
const BYTES: usize = 10;

/// What `templates/player.js` draws.
#[derive(Serialize)]
struct Player {
    /// Of each instant, s.
    times: Vec<f64>,
    /// Corners of the plane, lower left and upper right, m.
    view: [f64; 4],
    /// Axes of the plane, to the right and upwards, and the one that it is normal to.
    axes: [usize; 3],
    /// Where the plane cuts that axis, m; none in two dimensions.
    cut: Option<f64>,
    /// Ends of the box along each axis, m.
    ends: [(f64, f64); 3],
    quantities: Vec<Pictures>,
    /// Of each instant the grains, [`BYTES`] each, as base64.
    grains: Vec<String>,
    /// Place of step 0 and size of a step along each axis, then those of the radius, m.
    steps: [(f64, f64); 4],
    /// Fastest free grain, m/s, and the colours.
    fastest: f64,
    colours: &'static [[u8; 3]; 9],
    /// Of each instant the outlines of bodies that are not round, m; empty without any.
    outlines: Vec<Vec<Vec<(f64, f64)>>>,
    series: Columns,
}

/// A quantity of the fluid on the plane.
#[derive(Serialize)]
struct Pictures {
    name: &'static str,
    unit: &'static str,
    low: f64,
    high: f64,
    colours: &'static [[u8; 3]; 9],
    /// PNG of each instant as base64.
    pictures: Vec<String>,
}

/// Columns of the series over time.
#[derive(Serialize)]
struct Columns {
    times: Vec<f64>,
    names: Vec<String>,
    values: Vec<Vec<f64>>,
}

/// What is read of the instants.
#[derive(Default)]
struct Read {
    frames: Vec<Frame>,
    /// Pixels of a picture to the right and upwards.
    size: [usize; 2],
    /// Of each instant, each quantity at the pixels, row by row from above; empty without a fluid.
    values: Vec<Vec<Vec<f32>>>,
}

impl Read {
    /// As many instants of a run as memory, time and the page allow. Where there is a fluid, those with it.
    fn of(run: &RunFiles, shape: Shape<'_>) -> Self {
        let with_fluid = run.instants.iter().any(Instant::has_fluid);
        let instants: Vec<&Instant> =
            run.instants.iter().filter(|instant| instant.has_fluid() == with_fluid).collect();
        let bytes: u64 = instants.iter().map(|instant| instant.bytes()).sum();
        let most = instants.len() as u64 * MOST_READ / bytes.max(1);
        let mut chosen = spread(instants.len(), MOST_INSTANTS.min(most as usize).max(2));
        let mut read = Self::default();
        while let Some(number) = chosen.pop() {
            let Ok((frame, fields)) = Frame::read_several(instants[number], &|_| None, &QUANTITIES, shape)
            else {
                continue;
            };
            let fields: Option<Vec<Field>> = fields.into_iter().collect();
            let fields = fields.unwrap_or_default();
            if let (true, Some(field)) = (read.frames.is_empty(), fields.first()) {
                read.size = size(field, frame.view);
                let fit = MOST_VALUES / (QUANTITIES.len() * read.size[0] * read.size[1]);
                let left = spread(chosen.len(), fit.max(2));
                chosen = left.into_iter().map(|k| chosen[k]).collect();
            }
            let sampled = fields.iter().map(|field| sample(field, frame.view, read.size));
            read.values.push(sampled.collect());
            read.frames.push(frame);
        }
        read.frames.reverse();
        read.values.reverse();
        read
    }
}

/// Pixels of a field: square, at most one a cell along the longer side.
fn size(field: &Field, view: View) -> [usize; 2] {
    let extent = [view.1.0 - view.0.0, view.1.1 - view.0.1];
    let longer = usize::from(extent[1] > extent[0]);
    let sides = if longer == 0 && field.mirrored { 2 } else { 1 };
    let cells = (sides * field.faces[longer].len().saturating_sub(1)).clamp(1, PIXELS);
    [0, 1].map(|a| ((cells as f64 * extent[a] / extent[longer]).round() as usize).max(1))
}

/// Values at the pixels, row by row from above.
fn sample(field: &Field, (low, high): View, [width, height]: [usize; 2]) -> Vec<f32> {
    let step = ((high.0 - low.0) / width as f64, (high.1 - low.1) / height as f64);
    let at = |i: usize, k: usize| (low.0 + (i as f64 + 0.5) * step.0, high.1 - (k as f64 + 0.5) * step.1);
    (0..width * height).map(|p| field.at(at(p % width, p / width)) as f32).collect()
}

/// The film of a run: which part of the instants is shown, and a [`Player`] as JSON that may stand in a page;
/// none without two instants with anything to see.
pub(super) fn film(run: &RunFiles) -> Result<Option<Value>, Failure> {
    let shape = Shape::of(&run.summary, run.scene.as_ref());
    let read = Read::of(run, shape);
    let (Some(first), true) = (read.frames.first(), read.frames.len() > 1) else { return Ok(None) };
    let view = read.frames.iter().fold(NOWHERE, |view, frame| around(view, frame.view));
    let [right, up] = first.axes();
    let steps = steps(&read.frames);
    let free = read.frames.iter().flat_map(|frame| &frame.grains).filter(|grain| !grain.held);
    let fastest = free.map(|grain| grain.speed).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let round = run.scene.as_ref().is_none_or(|scene| scene.grains.iter().all(|g| g.outline().is_none()));
    let outlines = |frame: &Frame| {
        let digits = |at: &(f64, f64)| (rounded(at.0, 5), rounded(at.1, 5));
        frame.bodies.iter().map(|body| body.outline.iter().map(digits).collect()).collect()
    };
    let of_fluid = if read.size == [0; 2] { 0 } else { QUANTITIES.len() };
    let mut player = Player {
        times: read.frames.iter().map(|frame| frame.time).collect(),
        view: [view.0.0, view.0.1, view.1.0, view.1.1],
        axes: [right, up, 3 - right - up],
        cut: first.cut.map(|cut| cut.position).filter(|_| run.summary.size.geometry == Geometry::Space),
        ends: shape.ends.unwrap_or([(0.0, 0.0); 3]),
        quantities: (0..of_fluid).map(|q| pictures(&read, q)).collect::<Result<_, Failure>>()?,
        grains: read.frames.iter().map(|frame| base64(&bytes(&frame.grains, &steps, fastest))).collect(),
        steps,
        fastest,
        colours: stops(false),
        outlines: if round { Vec::new() } else { read.frames.iter().map(outlines).collect() },
        series: columns(run),
    };
    player.thin();
    let about = format!("{} of {} instants.", player.times.len(), run.instants.len());
    let json = serde_json::to_string(&player).map_err(|error| Failure::Run(error.to_string()))?;
    Ok(Some(context! { about, json => json.replace('<', "\\u003c") }))
}

impl Player {
    /// Leaves out instants, evenly, until the rest fits into the page.
    fn thin(&mut self) {
        let pictures = self.quantities.iter().flat_map(|q| &q.pictures);
        let bytes: usize = pictures.chain(&self.grains).map(String::len).sum();
        let kept = spread(self.times.len(), (self.times.len() * MOST_BYTES / bytes.max(1)).max(2));
        if kept.len() < self.times.len() {
            self.times = kept.iter().map(|k| self.times[*k]).collect();
            let lists = self.quantities.iter_mut().map(|quantity| &mut quantity.pictures);
            for list in lists.chain([&mut self.grains]) {
                *list = kept.iter().map(|k| std::mem::take(&mut list[*k])).collect();
            }
            if !self.outlines.is_empty() {
                self.outlines = kept.iter().map(|k| std::mem::take(&mut self.outlines[*k])).collect();
            }
        }
    }
}

/// At most `most` numbers below `count`, evenly, always with the last: the final state.
pub(super) fn spread(count: usize, most: usize) -> Vec<usize> {
    let step = count.div_ceil(most).max(1);
    let mut chosen: Vec<usize> = (0..count).rev().step_by(step).collect();
    chosen.reverse();
    chosen
}

/// Place of step 0 and size of a step, for positions along each axis and for radii.
fn steps(frames: &[Frame]) -> [(f64, f64); 4] {
    let grains = || frames.iter().flat_map(|frame| &frame.grains);
    std::array::from_fn(|axis| {
        let value = |grain: &Grain| if axis < 3 { grain.at[axis] } else { grain.radius };
        let low = if axis < 3 { grains().map(value).fold(f64::INFINITY, f64::min) } else { 0.0 };
        let high = grains().map(value).fold(f64::NEG_INFINITY, f64::max);
        match (high > low, low.is_finite()) {
            (true, _) => (low, (high - low) / f64::from(u16::MAX)),
            (false, true) => (low, 1.0),
            (false, false) => (0.0, 1.0),
        }
    })
}

/// Grains as the script reads them.
fn bytes(grains: &[Grain], steps: &[(f64, f64); 4], fastest: f64) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(BYTES * grains.len());
    for grain in grains {
        let [x, y, z] = grain.at;
        for (value, (low, step)) in [x, y, z, grain.radius].into_iter().zip(steps) {
            bytes.extend((((value - low) / step).round() as u16).to_le_bytes());
        }
        let flags = u8::from(grain.held) + 2 * u8::from(grain.copy);
        bytes.extend([(255.0 * grain.speed / fastest).round() as u8, flags]);
    }
    bytes
}

/// Quantity number `q` on the plane at every instant.
fn pictures(read: &Read, q: usize) -> Result<Pictures, Failure> {
    let values = || read.values.iter().map(|values| &values[q]);
    let numbers = values().map(|values| Ok::<_, Failure>(values.iter().map(|v| f64::from(*v)).collect()));
    let scale = Scale::of(numbers)?;
    let png = |values: &Vec<f32>| {
        let mut raster = Raster::new(read.size[0], read.size[1], scale.is_signed());
        for (pixel, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            raster.set(pixel % read.size[0], pixel / read.size[0], scale.tone(f64::from(*value)));
        }
        raster.png().map(|bytes| base64(&bytes)).map_err(Failure::Run)
    };
    Ok(Pictures {
        name: QUANTITIES[q].label(),
        unit: QUANTITIES[q].unit(),
        low: scale.low,
        high: scale.high,
        colours: stops(scale.is_signed()),
        pictures: values().map(png).collect::<Result<_, Failure>>()?,
    })
}

/// Columns of the series that change.
fn columns(run: &RunFiles) -> Columns {
    let rows = spread(run.series.len(), MOST_POINTS);
    let pick = |column: &[f64]| rows.iter().map(|row| rounded(column[*row], 6)).collect::<Vec<f64>>();
    let mut columns = Columns { times: pick(run.series.time()), names: Vec::new(), values: Vec::new() };
    for name in run.series.names().iter().filter(|name| !["t", "dt"].contains(&name.as_str())) {
        let Some(column) = run.series.column(name) else { continue };
        let changes = column.windows(2).any(|pair| pair[0] != pair[1]);
        if changes && columns.names.len() < MOST_COLUMNS && column.iter().all(|value| value.is_finite()) {
            columns.names.push(name.clone());
            columns.values.push(pick(column));
        }
    }
    columns
}
