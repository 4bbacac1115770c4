//! `bedload film`: a plane of the flow and the grains in it, frame by frame, as PNG files and one animated
//! GIF, and an MP4 where ffmpeg is.
//!
//! Frames are drawn straight into numbered colours, so that no display, font or encoder of the system is
//! needed.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use bedload_output::{OutputFolder, Summary, atomic_write};
use bedload_scene::{CheckedScene, SceneSource};
use clap::Args;

use super::pictures::{
    self, COLOURS, Frame, HIGH, Instant, Quantity, Raster, Scale, Shape, Slice, Tone, instants,
};
use coupler::failure::Failure;
use coupler::number::{AXES, Short};

/// What `bedload film` was asked.
#[derive(Clone, Debug, Args)]
pub struct Film {
    /// Output folder of a run with fields (observe.fields_every)
    pub dir: PathBuf,
    /// What is coloured: speed, velocity-x, -y, -z, vorticity, vorticity-x, -z, pressure, solid, or
    /// grains (by their speed). By default speed, or grains in a run without fluid
    #[arg(long, value_name = "F")]
    pub field: Option<String>,
    /// Plane, such as y=0.5 (m); by default y in the middle of the box
    #[arg(long, value_name = "AXIS=POSITION")]
    pub slice: Option<String>,
    /// Width of a frame, pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 960,
          value_parser = clap::value_parser!(u16).range(160..=4096))]
    pub width: u16,
    /// Frames per second of the film
    #[arg(long, value_name = "N", default_value_t = 10,
          value_parser = clap::value_parser!(u16).range(1..=50))]
    pub rate: u16,
}

/// Margins above the picture, to its right and below its axis, pixels, and length of a tick.
const ABOVE: usize = HIGH + HIGH / 2 + 4;
const RIGHT: usize = 16;
const STRIP: usize = HIGH + 16;
const TICK: usize = 6;
/// Size of a frame in either direction, pixels.
const SIZES: std::ops::RangeInclusive<usize> = 64..=4096;
/// Neighbouring colours of the scale that are one in the film, and a number that stands for what the frame
/// before has: with both a film takes a third of the bytes.
const MERGED: u8 = 5;
const SAME: u8 = u8::MAX;

/// Draws the film; returns its paths.
///
/// # Errors
/// [`Failure::Input`] if the folder is no run, has no such files or field, or the plane misses the box;
/// [`Failure::Run`] if it cannot be written.
pub fn film(film: &Film) -> Result<Vec<PathBuf>, Failure> {
    let folder = OutputFolder::open(&film.dir)?;
    let summary = Summary::read(&folder.summary())?;
    let slice = film.slice.as_deref().map(Slice::parse).transpose().map_err(Failure::Input)?;
    let parse = |text| Quantity::parse(text, summary.size.geometry);
    let quantity = film.field.as_deref().map(parse).transpose().map_err(Failure::Input)?;
    let instants = instants(&folder.fields());
    if instants.is_empty() {
        return Err(Failure::Input(format!(
            "{} holds no fields: ask for them with [observe] fields_every, and run again",
            folder.root().display()
        )));
    }
    let scene = SceneSource::read(&folder.scene(), &[]).and_then(CheckedScene::new).ok();
    let shape = Shape::of(&summary, scene.as_ref());
    let has_fluid = instants.iter().any(Instant::has_fluid);
    if let Some(field) = film.field.as_ref().filter(|_| !has_fluid && quantity != Some(Quantity::GRAINS)) {
        return Err(Failure::Input(format!(
            "--field {field}: {} has no fields of a fluid, only grains: leave it out",
            folder.root().display()
        )));
    }
    let quantity = quantity.unwrap_or(if has_fluid { Quantity::SPEED } else { Quantity::GRAINS });
    let read = |instant: &Instant| Frame::read(instant, &|_| slice, quantity, shape).map_err(Failure::Input);
    let mut view = pictures::NOWHERE;
    let scale = Scale::of(instants.iter().map(|instant| {
        let frame = read(instant)?;
        view = pictures::around(view, frame.view);
        Ok::<_, Failure>(frame.values())
    }))?;
    // A GIF counts in hundredths of a second, and viewers slow down below two of them.
    let delay = (100 / film.rate).max(2);
    if u32::from(delay) * u32::from(film.rate) != 100 {
        protocol::say!(
            "bedload: a GIF shows a frame for whole hundredths of a second: {} frames/s",
            100 / delay
        );
    }
    super::folder::make(&folder.frames())?;
    folder.remove_frames()?;
    let path = folder.film();
    let mut gif: Option<gif::Encoder<Vec<u8>>> = None;
    let mut last: Vec<u8> = Vec::new();
    for (number, instant) in instants.iter().enumerate() {
        let frame = Frame { view, ..read(instant)? };
        let raster = draw(&frame, &scale, usize::from(film.width), shape.mirrored)?;
        atomic_write(&folder.frame(number), &raster.png().map_err(Failure::Run)?)?;
        let encoder = match &mut gif {
            Some(encoder) => encoder,
            None => gif.insert(begin(&raster).map_err(|error| cannot(&path, &error))?),
        };
        let mut picture = changed(&raster, &mut last);
        picture.delay = delay;
        picture.dispose = gif::DisposalMethod::Keep;
        encoder.write_frame(&picture).map_err(|error| cannot(&path, &error))?;
    }
    let Some(encoder) = gif else { return Err(Failure::Input("there is no frame".into())) };
    atomic_write(&path, &encoder.into_inner().map_err(|error| cannot(&path, &error))?)?;
    Ok([path].into_iter().chain(mp4(&folder, film.rate)).collect())
}

/// The frames as an MP4 by the ffmpeg on the `PATH`; none where there is none. One that fails is told: the
/// GIF is there.
fn mp4(folder: &OutputFolder, rate: u16) -> Option<PathBuf> {
    let path = folder.film_mp4();
    let _ = std::fs::remove_file(&path);
    // Sizes are even with H.264. From the folder of the frames, whose name may have a %.
    let output = Command::new("ffmpeg")
        .current_dir(folder.frames())
        .args(["-y", "-loglevel", "error", "-framerate", &rate.to_string(), "-i", "frame_%05d.png"])
        .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "../film.mp4"])
        .stdin(Stdio::null())
        .output();
    let why = match output {
        Ok(output) if output.status.success() => return Some(path),
        Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
        Err(error) if error.kind() == ErrorKind::NotFound => return None,
        Err(error) => error.to_string(),
    };
    protocol::say!("bedload: no film.mp4: ffmpeg: {why}");
    None
}

/// The shortest of 1, 2, 5, 10 … that is no shorter than `least`.
fn round_length(least: f64) -> f64 {
    let decade = 10_f64.powi(least.log10().floor() as i32);
    let lengths = [1.0, 2.0, 5.0].map(|times| times * decade);
    lengths.into_iter().find(|length| *length >= least * (1.0 - 1e-9)).unwrap_or(10.0 * decade)
}

/// Places of round numbers from `low` to `high`, at least `least` apart, and the numbers over `unit`.
fn ticks((low, high): (f64, f64), least: f64, unit: f64) -> Vec<(f64, String)> {
    let step = round_length(least / unit) * unit;
    let numbers = (low / step - 1e-6).ceil() as i64..=(high / step + 1e-6).floor() as i64;
    numbers.map(|k| (k as f64 * step, Short(k as f64 * step / unit).to_string())).collect()
}

/// The frame with what differs from the `last` one, which it then is.
fn changed(raster: &Raster, last: &mut Vec<u8>) -> gif::Frame<'static> {
    let merged = |tone: &u8| if *tone < COLOURS { tone - tone % MERGED + MERGED / 2 } else { *tone };
    let pixels: Vec<u8> = raster.pixels.iter().map(merged).collect();
    let old = last.iter().map(Some).chain(std::iter::repeat(None));
    let new = pixels.iter().zip(old).map(|(new, old)| if Some(new) == old { SAME } else { *new });
    let new: Vec<u8> = new.collect();
    *last = pixels;
    gif::Frame::from_indexed_pixels(raster.width as u16, raster.height as u16, new, Some(SAME))
}

fn begin(raster: &Raster) -> Result<gif::Encoder<Vec<u8>>, gif::EncodingError> {
    let (width, height) = (raster.width as u16, raster.height as u16);
    let mut encoder = gif::Encoder::new(Vec::new(), width, height, &raster.palette)?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    Ok(encoder)
}

fn cannot(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Run(format!("cannot write {}: {error}", path.display()))
}

/// Draws one frame: field, grains, axes and legend; `mirrored`: the first axis is a radius.
fn draw(frame: &Frame, scale: &Scale, width: usize, mirrored: bool) -> Result<Raster, Failure> {
    let ((west, south), (east, north)) = frame.view;
    let largest = [west, south, east, north].map(f64::abs).into_iter().fold(0.0, f64::max);
    let (unit, symbol) = if largest < 0.1 { (1e-3, "mm") } else { (1.0, "m") };
    let [x, z] = frame.axes().map(|axis| format!("{}, {symbol}", AXES[axis]));
    let x = if mirrored { x.replace('x', "r") } else { x };
    // Of a first guess of the size of a pixel: the margin hangs on the numbers, and they on it.
    let levels = |pixel: f64| ticks((south, north), 4.0 * HIGH as f64 * pixel, unit);
    let wide = |levels: &[(f64, String)]| levels.iter().map(|(_, number)| Raster::wide(number)).max();
    let left =
        wide(&levels((east - west) / width as f64)).max(Some(Raster::wide(&x))).unwrap_or(0) + 3 * TICK;
    let across = width.saturating_sub(left + RIGHT).max(1);
    let height = pictures::height(frame, across);
    let bottom = ABOVE + height;
    let whole = bottom + 2 * TICK + HIGH + STRIP;
    if !SIZES.contains(&whole) || !SIZES.contains(&width) {
        return Err(Failure::Input(format!(
            "a frame would be {width} × {whole} pixels; allowed: {} to {} in either direction: choose another --width",
            SIZES.start(),
            SIZES.end()
        )));
    }
    let picture = pictures::draw(frame, scale, across);
    let mut raster = picture.within([left, ABOVE, RIGHT, whole - bottom]);
    let pixel = (east - west) / across as f64;
    raster.text(TICK, 2, &z);
    for (at, number) in levels(pixel) {
        let row = ABOVE + (((north - at) / pixel) as usize).min(height);
        (left - TICK..left).for_each(|i| raster.set(i, row, Tone::INK));
        raster.text(
            left.saturating_sub(2 * TICK + Raster::wide(&number)) + TICK / 2,
            row - HIGH / 2,
            &number,
        );
    }
    (ABOVE..=bottom).for_each(|k| raster.set(left - 1, k, Tone::INK));
    let under = bottom + TICK + TICK / 2;
    raster.text(TICK, under, &x);
    let widest = [west, east].map(|at| Raster::wide(&Short(at / unit).to_string()));
    for (at, number) in ticks((west, east), (4 * RIGHT + widest[0].max(widest[1])) as f64 * pixel, unit) {
        let (column, half) = (left + ((at - west) / pixel) as usize, Raster::wide(&number) / 2);
        (bottom..bottom + TICK).for_each(|k| raster.set(column, k, Tone::INK));
        let start = column.saturating_sub(half).max(2 * TICK + Raster::wide(&x));
        raster.text(start.min(width.saturating_sub(2 * half)), under, &number);
    }
    (left - 1..left + across).for_each(|i| raster.set(i, bottom, Tone::INK));
    legend(&mut raster, frame, scale, whole - STRIP + 8);
    Ok(raster)
}

/// Writes the time and the scale of the colours below row `row`.
fn legend(raster: &mut Raster, frame: &Frame, scale: &Scale, row: usize) {
    let width = raster.width;
    let time = format!("t = {} s", Short(frame.time));
    raster.text(TICK, row, &time);
    let (bar, end) = (width / 6, format!(" {}", Short(scale.high)));
    let begin = |legend: &str| width.saturating_sub(8 + bar + Raster::wide(legend) + Raster::wide(&end));
    let low = format!("{} ", Short(scale.low));
    let named = format!("{}, {} {low}", frame.quantity.label(), frame.quantity.unit());
    // A narrow frame has no room for the name, a very narrow one for the number beside the time.
    let fits = |legend: &&String| begin(legend) >= 24 + Raster::wide(&time);
    let legend = [&named, &low].into_iter().find(fits).cloned().unwrap_or_default();
    let start = begin(&legend);
    raster.text(start, row, &legend);
    let from = start + Raster::wide(&legend);
    for i in 0..bar {
        let value = scale.low + (scale.high - scale.low) * i as f64 / bar as f64;
        (row..row + HIGH).for_each(|k| raster.set(from + i, k, scale.tone(value)));
    }
    raster.text(from + bar, row, &end);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_at_round_numbers_up_to_both_ends() {
        let numbers = |ends, least, unit| -> Vec<String> {
            ticks(ends, least, unit).into_iter().map(|(_, number)| number).collect()
        };
        assert_eq!(numbers((-0.3, 0.3), 0.1, 1.0), ["-0.3", "-0.2", "-0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(numbers((0.0, 0.011), 0.0021, 1e-3), ["0", "5", "10"]);
        assert_eq!(numbers((0.9, 99.0), 60.0, 1.0), Vec::<String>::new());
    }

    #[test]
    fn frames_add_up_to_what_was_drawn() {
        let mut raster = Raster::new(8, 2, false);
        let (mut last, mut screen) = (Vec::new(), vec![SAME; 16]);
        for column in 0..3 {
            raster.set(column, 1, Tone::colour(7 + 100 * column as u8));
            raster.set(column, 0, Tone::INK);
            let frame = changed(&raster, &mut last);
            assert_eq!(
                frame.buffer.iter().filter(|pixel| **pixel != SAME).count(),
                if column == 0 { 16 } else { 2 }
            );
            let new = screen.iter_mut().zip(frame.buffer.iter());
            new.filter(|(_, pixel)| **pixel != SAME).for_each(|(shown, pixel)| *shown = *pixel);
            let far = screen.iter().zip(&raster.pixels).map(|(shown, drawn)| shown.abs_diff(*drawn)).max();
            assert!(far <= Some(MERGED / 2), "{far:?}");
        }
    }
}
