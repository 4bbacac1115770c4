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

use super::pictures::{self, COLOURS, Frame, Instant, Quantity, Raster, Scale, Shape, Slice, Tone, instants};
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
    let quantity = film.field.as_deref().map(Quantity::parse).transpose().map_err(Failure::Input)?;
    let instants = instants(&folder.fields());
    if instants.is_empty() {
        return Err(Failure::Input(format!(
            "{} holds no fields: ask for them with [observe] fields_every, and run again",
            folder.root().display()
        )));
    }
    let scene = SceneSource::read(&folder.scene(), &[]).and_then(CheckedScene::new).ok();
    let shape = Shape::of(&summary, scene.as_ref());
    let quantity = quantity.unwrap_or(match instants.iter().any(Instant::has_fluid) {
        true => Quantity::SPEED,
        false => Quantity::GRAINS,
    });
    let read = |instant: &Instant| Frame::read(instant, &|_| slice, quantity, shape).map_err(Failure::Input);
    let mut view = pictures::NOWHERE;
    let scale = Scale::of(instants.iter().map(|instant| {
        let frame = read(instant)?;
        view = pictures::around(view, frame.view);
        Ok::<_, Failure>(frame.values())
    }))?;
    super::folder::make(&folder.frames())?;
    folder.remove_frames()?;
    let path = folder.film();
    let mut gif: Option<gif::Encoder<Vec<u8>>> = None;
    let mut last: Vec<u8> = Vec::new();
    for (number, instant) in instants.iter().enumerate() {
        let frame = Frame { view, ..read(instant)? };
        let raster = draw(&frame, &scale, usize::from(film.width))?;
        atomic_write(&folder.frame(number), &raster.png().map_err(Failure::Run)?)?;
        let encoder = match &mut gif {
            Some(encoder) => encoder,
            None => gif.insert(begin(&raster).map_err(|error| cannot(&path, &error))?),
        };
        let mut picture = changed(&raster, &mut last);
        picture.delay = (100 / film.rate).max(2);
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

/// The longest of 1, 2, 5, 10 … that is no longer than `most`.
fn round_length(most: f64) -> f64 {
    let decade = 10_f64.powi(most.log10().floor() as i32);
    [5.0, 2.0].map(|times| times * decade).into_iter().find(|length| *length <= most).unwrap_or(decade)
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

/// Draws one frame: field, grains, time, a length to scale and the scale of the colours.
fn draw(frame: &Frame, scale: &Scale, width: usize) -> Result<Raster, Failure> {
    let height = pictures::height(frame, width);
    if !SIZES.contains(&height) || !SIZES.contains(&width) {
        return Err(Failure::Input(format!(
            "a frame would be {width} × {height} pixels; allowed: {} to {} in either direction: choose another --width",
            SIZES.start(),
            SIZES.end()
        )));
    }
    let mut raster = pictures::draw(frame, scale, width, STRIP);
    (0..width).for_each(|i| raster.set(i, height, Tone::INK));
    let time = format!("t = {} s", Short(frame.time));
    raster.text(8, height + 12, &time);
    let (bar, end) = (width / 6, format!(" {}", Short(scale.high)));
    let begin = |legend: &str| width.saturating_sub(8 + bar + Raster::wide(legend) + Raster::wide(&end));
    let mut legend = format!("{} {} ", frame.quantity.label(), Short(scale.low));
    // A narrow frame has no room for the name beside the time.
    if begin(&legend) < 24 + Raster::wide(&time) {
        legend = format!("{} ", Short(scale.low));
    }
    let start = begin(&legend);
    raster.text(start, height + 12, &legend);
    let left = start + Raster::wide(&legend);
    for i in 0..bar {
        let value = scale.low + (scale.high - scale.low) * i as f64 / bar as f64;
        (height + 12..height + 28).for_each(|k| raster.set(left + i, k, scale.tone(value)));
    }
    raster.text(left + bar, height + 12, &end);
    let unit = width as f64 / (frame.view.1.0 - frame.view.0.0);
    let length = round_length(bar as f64 / unit);
    let (begin, long) = (32 + Raster::wide(&time), (length * unit).round() as usize);
    let name = format!(" {} m", Short(length));
    // A narrow frame has no room for it.
    if begin + long + Raster::wide(&name) + 24 < start {
        (0..=long).for_each(|i| raster.set(begin + i, height + 20, Tone::INK));
        for k in height + 14..height + 27 {
            raster.set(begin, k, Tone::INK);
            raster.set(begin + long, k, Tone::INK);
        }
        raster.text(begin + long, height + 12, &name);
    }
    Ok(raster)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_to_scale_is_round() {
        let found = [0.0199, 0.02, 0.7, 1.0, 99.0].map(round_length);
        let wanted = [0.01, 0.02, 0.5, 1.0, 50.0];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{found:?}");
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
