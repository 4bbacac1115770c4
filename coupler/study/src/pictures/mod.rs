//! Pictures of fields and grains on a plane of a run, to scale: for films, pages and figures.
//!
//! | file | what it holds |
//! |---|---|
//! | `frame` | the files of one instant: field and grains on the plane |
//! | `raster` | numbered colours, polygons, text, PNG: no display, font or encoder of the system is needed |

mod frame;
mod raster;

use std::path::PathBuf;

use crate::page::{context, render};
use coupler::failure::Failure;
use coupler::number::Short;

pub(crate) use frame::{Field, Frame, Grain, Instant, Point, Quantity, Shape, Slice, View, instants};
pub(crate) use frame::{NOWHERE, around};
pub(crate) use raster::{COLOURS, HIGH, Raster, Tone, stops};

/// Part of the values beyond which a colour scale does not reach: single cells beside a wall would leave the
/// rest dark.
const OUTLIERS: f64 = 0.002;

/// This part of the grains on each side may be left out of the view: single ones roll far away.
const STRAY: f64 = 0.005;

/// Width of pictures that stand together, in units of the SVG and in pixels; height of a line of text.
const WIDTH: f64 = 900.0;
const PIXELS: f64 = 1800.0;
const LINE: f64 = 24.0;

/// A picture has no more pixels than this, however tall it is.
const MOST_PIXELS: f64 = 4e6;

/// From which value to which the colours go: the same in every frame.
pub(crate) struct Scale {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Scale {
    /// Of frames, which may have to be read for it.
    pub(crate) fn of<E>(frames: impl Iterator<Item = Result<Vec<f64>, E>>) -> Result<Self, E> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for values in frames {
            if let Some((first, last)) = span(values?.into_iter(), OUTLIERS) {
                (low, high) = (low.min(first), high.max(last));
            }
        }
        Ok(match (low < 0.0 && high > 0.0, high > low) {
            // Zero lies in the middle, where it is white.
            (true, _) => Self { low: -high.max(-low), high: high.max(-low) },
            (false, true) => Self { low: low.min(0.0), high },
            (false, false) => Self { low: 0.0, high: if high > 0.0 { high } else { 1.0 } },
        })
    }

    pub(crate) fn is_signed(&self) -> bool {
        self.low < 0.0
    }

    /// Colour of a value, 0 to [`COLOURS`] − 1.
    pub(crate) fn tone(&self, value: f64) -> Tone {
        let part = (value - self.low) / (self.high - self.low);
        Tone::colour((part.clamp(0.0, 1.0) * f64::from(COLOURS - 1)).round() as u8)
    }
}

/// Least and largest of the finite values but for a part at both ends.
fn span(values: impl Iterator<Item = f64>, out: f64) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let out = (out * values.len() as f64) as usize;
    Some((*values.get(out)?, *values.get(values.len().checked_sub(out + 1)?)?))
}

/// Nearly all free grains of all frames, and two mean diameters around them.
pub(crate) fn view_of_grains(frames: &[Frame]) -> Option<View> {
    let mut view = NOWHERE;
    for frame in frames {
        let any_free = frame.bodies.iter().any(|body| !body.held);
        let extents = || frame.bodies.iter().filter(|body| !any_free || !body.held).map(|body| body.extent());
        let largest = extents().map(|(low, high)| high.0 - low.0).fold(0.0, f64::max);
        let middle = |along: fn(&Point) -> f64| {
            span(extents().map(|(low, high)| 0.5 * (along(&low) + along(&high))), STRAY)
        };
        if let Some((x, z)) = middle(|at| at.0).zip(middle(|at| at.1)) {
            let margin = 2.0 * largest;
            view = around(view, ((x.0 - margin, z.0 - margin), (x.1 + margin, z.1 + margin)));
        }
    }
    (view.1.0 > view.0.0).then_some(view)
}

/// Draws field and grains of a frame, `width` pixels wide.
pub(crate) fn draw(frame: &Frame, scale: &Scale, width: usize) -> Raster {
    let (low, high) = frame.view;
    let unit = width as f64 / (high.0 - low.0);
    let height = height(frame, width);
    let mut raster = Raster::new(width, height, scale.is_signed());
    let at = |i: usize, k: usize| (low.0 + (i as f64 + 0.5) / unit, high.1 - (k as f64 + 0.5) / unit);
    if let Some(field) = &frame.field {
        for k in 0..height {
            for i in 0..width {
                let value = field.at(at(i, k));
                raster.set(i, k, if value.is_finite() { scale.tone(value) } else { Tone::PAPER });
            }
        }
    }
    for body in &frame.bodies {
        let fill = match (frame.quantity.is_of_grains(), body.held) {
            (_, true) => Tone::HELD,
            (true, false) => scale.tone(body.speed),
            (false, false) => Tone::GRAIN,
        };
        let place = |(x, z): &Point| (unit * (x - low.0), unit * (high.1 - z));
        raster.polygon(&body.outline.iter().map(place).collect::<Vec<_>>(), fill);
    }
    raster
}

/// Height of a frame of this width, pixels.
pub(crate) fn height(frame: &Frame, width: usize) -> usize {
    let (low, high) = frame.view;
    (width as f64 * (high.1 - low.1) / (high.0 - low.0)).round().max(1.0) as usize
}

/// Frames of one size beside and below each other as SVG, each below its caption, with the scale of their
/// colours in `unit`, a size with its name. None: there is no frame.
pub(crate) fn sheet(
    frames: &[Frame],
    captions: &[String],
    unit: (f64, &str),
) -> Result<Option<String>, Failure> {
    let Some(first) = frames.first() else { return Ok(None) };
    let scale = Scale::of(frames.iter().map(|frame| Ok::<_, Failure>(frame.values())))?;
    let ((left, bottom), (right, top)) = first.view;
    let aspect = (top - bottom) / (right - left);
    let columns = columns(frames.len(), aspect);
    let width = (WIDTH - (columns as f64 - 1.0) * LINE) / columns as f64;
    let size = (width, width * aspect);
    let pixels = (PIXELS * width / WIDTH).min((MOST_PIXELS / aspect).sqrt()).max(1.0) as usize;
    let picture = |(number, (frame, caption)): (usize, (&Frame, &String))| {
        let (column, row) = ((number % columns) as f64, (number / columns) as f64);
        let raster = draw(frame, &scale, pixels);
        // Left and top.
        let corner = (column * (width + LINE), row * (size.1 + LINE) + LINE);
        Ok(context! { corner, caption, png => base64(&raster.png().map_err(Failure::Run)?) })
    };
    let number = |value: f64| Short(value / unit.0).to_string();
    let sheet = context! {
        size,
        height => frames.len().div_ceil(columns) as f64 * (size.1 + LINE) + 1.5 * LINE,
        pictures =>
            frames.iter().zip(captions).enumerate().map(picture).collect::<Result<Vec<_>, Failure>>()?,
        // Colours of the scale, and what they mean.
        stops => raster::stops(scale.is_signed()),
        label => first.quantity.label(),
        low => number(scale.low),
        high => number(scale.high),
        unit => unit.1,
        // Of one picture, m.
        width => Short(right - left).to_string(),
    };
    render("frames.svg", sheet).map(Some)
}

/// Pictures of grains coloured by speed.
pub(crate) struct GrainSheet {
    /// SVG; none if there is no grain to draw.
    pub(crate) pictures: Option<String>,
    /// Plane that cuts spheres; none for grains that all lie in one.
    pub(crate) cut: Option<Slice>,
    /// Files that could not be read, and why.
    pub(crate) faults: Vec<String>,
}

/// The grains of these files coloured by speed, as [`sheet`] has them.
pub(crate) fn sheet_of_grains(files: &[PathBuf]) -> Result<GrainSheet, Failure> {
    let read =
        |path: &PathBuf| Frame::read(&Instant::of_grains(path), &|_| None, Quantity::GRAINS, Shape::UNKNOWN);
    let (frames, faults): (Vec<_>, Vec<_>) = files.iter().map(read).partition(Result::is_ok);
    let mut frames: Vec<Frame> = frames.into_iter().filter_map(Result::ok).collect();
    let faults = faults.into_iter().filter_map(Result::err).collect();
    match view_of_grains(&frames) {
        Some(view) => frames.iter_mut().for_each(|frame| frame.view = view),
        None => frames.clear(),
    }
    let captions: Vec<String> = frames.iter().map(|frame| format!("t = {} s", Short(frame.time))).collect();
    let cut = frames.iter().find_map(|frame| frame.cut);
    Ok(GrainSheet { pictures: sheet(&frames, &captions, (1.0, "m/s"))?, cut, faults })
}

/// As few columns as keep the whole from being taller than wide.
fn columns(pictures: usize, aspect: f64) -> usize {
    let height = |columns: &usize| pictures.div_ceil(*columns) as f64 * aspect / *columns as f64;
    (1..=pictures).find(|columns| height(columns) <= 1.0).unwrap_or(pictures.max(1))
}

/// Bytes as a data URL has them (RFC 4648).
pub(crate) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0, |word, k| word << 8 | u32::from(chunk.get(k).copied().unwrap_or(0)));
        for k in 0..4 {
            let digit = char::from(DIGITS[(word >> (18 - 6 * k)) as usize & 63]);
            text.push(if k > chunk.len() { '=' } else { digit });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heap(time: f64, speed: f64) -> Frame {
        let (quantity, cut) = (Quantity::GRAINS, None);
        let (bodies, grains) = (Vec::new(), Vec::new());
        let mut frame = Frame { time, view: NOWHERE, field: None, bodies, grains, quantity, cut };
        for i in 0..500_u32 {
            frame.add_sphere([f64::from(i % 50), 0.0, f64::from(i / 50)], 0.5, speed, false);
        }
        frame.add_sphere([1e4, 0.0, 0.0], 0.5, speed, false);
        frame
    }

    #[test]
    fn a_grain_far_away_does_not_shrink_the_picture() {
        let mut frames = [heap(0.0, 0.0), heap(1.0, 2.0)];
        let view = view_of_grains(&frames).unwrap();
        assert!((view.0.0 + 2.0).abs() < 1e-9 && (view.1.1 - 11.0).abs() < 1e-9, "{view:?}");
        frames.iter_mut().for_each(|frame| frame.view = view);
        let svg = sheet(&frames, &["t = 0 s".into(), "t = 1 s".into()], (1.0, "m/s")).unwrap().unwrap();
        assert_eq!(svg.matches("<image").count(), 2);
        assert!(svg.contains("t = 1 s") && svg.contains("speed 0<") && svg.contains(">2 m/s<"), "{svg}");
    }

    #[test]
    fn nothing_is_drawn_of_nothing() {
        assert!(sheet(&[], &[], (1.0, "m/s")).unwrap().is_none());
        assert!(view_of_grains(&[]).is_none());
    }

    #[test]
    fn wide_pictures_stand_below_and_tall_ones_beside_each_other() {
        assert_eq!((columns(4, 0.2), columns(4, 1.0), columns(4, 7.0), columns(1, 3.0)), (1, 2, 4, 1));
    }

    #[test]
    fn bytes_are_written_as_the_standard_has_them() {
        let texts = ["", "f", "fo", "foo", "foobar"].map(|text| base64(text.as_bytes()));
        assert_eq!(texts, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYmFy"]);
    }
}
