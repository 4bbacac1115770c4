//! `bedload film`: a plane of the flow and the grains in it, frame by frame, as PNG files and one animated
//! GIF.
//!
//! Frames are drawn straight into numbered colours (`raster`), so that no display, font or encoder of the
//! system is needed.
//!
//! | file | what it holds |
//! |---|---|
//! | `source` | the files of one instant: field and grains on the plane |
//! | `raster` | numbered colours, dots, polygons, text, PNG |

mod raster;
mod source;

use std::path::{Path, PathBuf};

use bedload_output::{OutputFolder, Summary, atomic_write};
use bedload_scene::{CheckedScene, Geometry, SceneSource};

use self::raster::{COLOURS, Raster, Tone};
use self::source::{Field, Instant, Quantity, Shape, Slice, instants};
use coupler::failure::Failure;
use coupler::number::Short;

/// What `bedload film` was asked.
#[derive(Clone, Debug)]
pub struct Film {
    /// Output folder of a run.
    pub dir: PathBuf,
    /// Field to colour; none: the speed of the fluid, or of the grains where no fluid took part.
    pub field: Option<String>,
    /// Plane, such as `y=0.5`; none: y in the middle of the box.
    pub slice: Option<String>,
    /// Width of a frame, pixels.
    pub width: u16,
    /// Frames per second of the film.
    pub rate: u16,
}

/// Height of the strip below the picture, pixels.
const STRIP: usize = 40;
/// Size of a frame in either direction, pixels.
const SIZES: std::ops::RangeInclusive<usize> = 64..=4096;
/// Part of the values beyond which a colour scale does not reach: single cells beside a wall would leave the
/// rest dark.
const OUTLIERS: f64 = 0.002;

/// Draws the film; returns its path.
///
/// # Errors
/// [`Failure::Input`] if the folder is no run, has no such files or field, or the plane misses the box;
/// [`Failure::Run`] if it cannot be written.
pub fn film(film: &Film) -> Result<PathBuf, Failure> {
    let folder = OutputFolder::open(&film.dir)?;
    let summary = Summary::read(&folder.summary())?;
    let slice = film.slice.as_deref().map(Slice::parse).transpose().map_err(Failure::Input)?;
    let quantity = film.field.as_deref().map(Quantity::parse).transpose().map_err(Failure::Input)?;
    let instants = instants(&folder.fields());
    if instants.is_empty() {
        return Err(Failure::Input(format!(
            "{} holds no fields: ask for them with [observe] fields_every, and run again",
            folder.root().display()
        )));
    }
    let shape =
        Shape { mirrored: summary.size.geometry == Geometry::Axisymmetric, periodic: periodic(&folder) };
    let quantity = quantity.unwrap_or(match instants.iter().any(Instant::has_fluid) {
        true => Quantity::SPEED,
        false => Quantity::GRAINS,
    });
    let read =
        |instant: &Instant| source::Frame::read(instant, slice, quantity, shape).map_err(Failure::Input);
    let scale = Scale::of(&instants, &read)?;
    let frames = folder.root().join("film");
    std::fs::create_dir_all(&frames).map_err(|error| cannot(&frames, &error))?;
    remove_old(&frames);
    let path = folder.root().join("film.gif");
    let mut gif: Option<gif::Encoder<Vec<u8>>> = None;
    let mut size = (0, 0);
    for (number, instant) in instants.iter().enumerate() {
        let frame = read(instant)?;
        let raster = draw(&frame, &scale, quantity, usize::from(film.width))?;
        let png = frames.join(format!("frame_{number:05}.png"));
        atomic_write(&png, &raster.png().map_err(Failure::Run)?)?;
        let encoder = match &mut gif {
            Some(encoder) => encoder,
            None => {
                size = (raster.width, raster.height);
                gif.insert(begin(&raster).map_err(|error| cannot(&path, &error))?)
            }
        };
        if size != (raster.width, raster.height) {
            return Err(Failure::Input(format!(
                "{}: its grid is another than that of the first frame",
                instant.name()
            )));
        }
        let mut picture =
            gif::Frame::from_indexed_pixels(raster.width as u16, raster.height as u16, raster.pixels, None);
        picture.delay = (100 / film.rate).max(2);
        picture.dispose = gif::DisposalMethod::Keep;
        encoder.write_frame(&picture).map_err(|error| cannot(&path, &error))?;
    }
    let Some(encoder) = gif else { return Err(Failure::Input("there is no frame".into())) };
    atomic_write(&path, &encoder.into_inner().map_err(|error| cannot(&path, &error))?)?;
    Ok(path)
}

/// Components along which the box is periodic; none where the scene of the run cannot be read here any more.
fn periodic(folder: &OutputFolder) -> [bool; 3] {
    let mut periodic = [false; 3];
    let scene = SceneSource::read(&folder.scene(), &[]).and_then(CheckedScene::new);
    if let Ok(CheckedScene { scene, .. }) = scene {
        for axis in (0..scene.domain.dimensions()).filter(|axis| scene.domain.is_periodic(*axis)) {
            periodic[scene.domain.geometry.component(axis)] = true;
        }
    }
    periodic
}

fn begin(raster: &Raster) -> Result<gif::Encoder<Vec<u8>>, gif::EncodingError> {
    let (width, height) = (raster.width as u16, raster.height as u16);
    let mut encoder = gif::Encoder::new(Vec::new(), width, height, &raster.palette)?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    Ok(encoder)
}

/// Frames of an earlier film.
fn remove_old(frames: &Path) {
    for path in super::folder::files(frames, "frame_", ".png") {
        // One that stays is written over, or seen beside the new ones.
        let _ = std::fs::remove_file(path);
    }
}

fn cannot(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Run(format!("cannot write {}: {error}", path.display()))
}

/// From which value to which the colours go: the same in every frame.
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    fn of(
        instants: &[Instant],
        read: &impl Fn(&Instant) -> Result<source::Frame, Failure>,
    ) -> Result<Self, Failure> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for instant in instants {
            let mut values = read(instant)?.values();
            values.retain(|value| value.is_finite());
            values.sort_by(f64::total_cmp);
            let out = (OUTLIERS * values.len() as f64) as usize;
            if let (Some(first), Some(last)) = (values.get(out), values.iter().rev().nth(out)) {
                low = low.min(*first);
                high = high.max(*last);
            }
        }
        Ok(match (low < 0.0 && high > 0.0, high > low) {
            // Zero lies in the middle, where it is white.
            (true, _) => Self { low: -high.max(-low), high: high.max(-low) },
            (false, true) => Self { low: low.min(0.0), high },
            (false, false) => Self { low: 0.0, high: if high > 0.0 { high } else { 1.0 } },
        })
    }

    fn is_signed(&self) -> bool {
        self.low < 0.0
    }

    /// Colour of a value, 0 to [`COLOURS`] − 1.
    fn tone(&self, value: f64) -> Tone {
        let part = (value - self.low) / (self.high - self.low);
        Tone::colour((part.clamp(0.0, 1.0) * f64::from(COLOURS - 1)).round() as u8)
    }
}

/// Draws one frame: field, grains, time and the scale of the colours.
fn draw(frame: &source::Frame, scale: &Scale, quantity: Quantity, width: usize) -> Result<Raster, Failure> {
    let (low, high) = frame.view;
    let unit = width as f64 / (high.0 - low.0);
    let height = (unit * (high.1 - low.1)).round() as usize;
    if !SIZES.contains(&height) || !SIZES.contains(&width) {
        return Err(Failure::Input(format!(
            "a frame would be {width} × {height} pixels; allowed: {} to {} in either direction: choose another --width",
            SIZES.start(),
            SIZES.end()
        )));
    }
    let mut raster = Raster::new(width, height + STRIP, scale.is_signed());
    let at = |i: usize, k: usize| (low.0 + (i as f64 + 0.5) / unit, high.1 - (k as f64 + 0.5) / unit);
    if let Some(field) = &frame.field {
        for k in 0..height {
            for i in 0..width {
                let value = field.at(at(i, k));
                raster.set(i, k, if value.is_finite() { scale.tone(value) } else { Tone::PAPER });
            }
        }
    }
    let place = |(x, z): (f64, f64)| (unit * (x - low.0), unit * (high.1 - z));
    for body in &frame.bodies {
        let fill = match (quantity.is_of_grains(), body.held) {
            (_, true) => Tone::HELD,
            (true, false) => scale.tone(body.speed),
            (false, false) => Tone::GRAIN,
        };
        let outline: Vec<(f64, f64)> = body.outline.iter().map(|point| place(*point)).collect();
        raster.polygon(&outline, height, fill);
    }
    for k in height..height + 1 {
        (0..width).for_each(|i| raster.set(i, k, Tone::INK));
    }
    raster.text(8, height + 12, &format!("t = {} s", Short(frame.time)));
    let legend = format!("{} {} ", quantity.label(), Short(scale.low));
    let (bar, end) = (width / 6, format!(" {}", Short(scale.high)));
    let start = width.saturating_sub(8 + bar + Raster::wide(&legend) + Raster::wide(&end));
    raster.text(start, height + 12, &legend);
    let left = start + Raster::wide(&legend);
    for i in 0..bar {
        let value = scale.low + (scale.high - scale.low) * i as f64 / bar as f64;
        (height + 12..height + 28).for_each(|k| raster.set(left + i, k, scale.tone(value)));
    }
    raster.text(left + bar, height + 12, &end);
    Ok(raster)
}

impl Field {
    /// Value at a place, of the cell that it lies in.
    fn at(&self, (x, z): (f64, f64)) -> f64 {
        let (x, sign) = if self.mirrored && x < 0.0 { (-x, self.mirror_sign) } else { (x, 1.0) };
        let cell = |faces: &[f64], x: f64| faces.partition_point(|face| *face <= x).checked_sub(1);
        match (cell(&self.faces[0], x), cell(&self.faces[1], z)) {
            (Some(i), Some(k)) => {
                sign * self.values.get(k).and_then(|row| row.get(i)).copied().unwrap_or(f64::NAN)
            }
            _ => f64::NAN,
        }
    }
}
