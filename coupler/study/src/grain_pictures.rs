//! Pictures of the grains, to scale and coloured by speed, in one SVG.
//!
//! A grain is a dot: a line of no length with a round end, as wide as the grain. Dots of one colour
//! and width share a path, which keeps a picture of thousands of grains at some ten bytes each.

use std::collections::BTreeMap;

use serde::Serialize;

use super::page::render;
use super::snapshot::{Disc, Snapshot};
use coupler::failure::Failure;

/// Width of the picture; whole numbers place grains to a hundredth of a pixel on a usual screen.
const WIDTH: f64 = 9000.0;

/// Height of the text, and of the line it stands on; `templates/grains.svg` has these, too.
const TEXT: f64 = 150.0;
const LINE: f64 = 220.0;

/// From slow to fast: viridis (Smith & van der Walt 2015), readable without colour as well.
const COLOURS: [&str; 10] = [
    "#440154", "#482878", "#3E4989", "#31688E", "#26828E", "#1F9E89", "#35B779", "#6ECE58", "#B5DE2B",
    "#FDE725",
];

/// Colour of grains that are held.
const HELD: &str = "#999";

/// This part of the grains on each side may be left out of the view: single ones roll far away.
const STRAY: f64 = 0.005;

/// What all pictures show: lower left and upper right corner, m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct View {
    low: (f64, f64),
    high: (f64, f64),
}

impl View {
    /// Nearly all free grains at all times, and two mean diameters around them.
    fn of(snapshots: &[Snapshot]) -> Option<Self> {
        let mut view: Option<Self> = None;
        for snapshot in snapshots {
            let any_free = snapshot.discs.iter().any(|disc| !disc.held);
            let discs: Vec<&Disc> = snapshot.discs.iter().filter(|disc| !any_free || !disc.held).collect();
            let largest = discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
            let (Some(x), Some(z)) =
                (span(discs.iter().map(|disc| disc.centre.0)), span(discs.iter().map(|disc| disc.centre.1)))
            else {
                continue;
            };
            let margin = 4.0 * largest;
            let (low, high) = ((x.0 - margin, z.0 - margin), (x.1 + margin, z.1 + margin));
            let old = view.unwrap_or(Self { low, high });
            view = Some(Self {
                low: (low.0.min(old.low.0), low.1.min(old.low.1)),
                high: (high.0.max(old.high.0), high.1.max(old.high.1)),
            });
        }
        view
    }

    fn size(&self) -> (f64, f64) {
        (self.high.0 - self.low.0, self.high.1 - self.low.1)
    }

    fn shows(&self, disc: &Disc) -> bool {
        let ((x, z), r) = (disc.centre, disc.radius);
        x + r > self.low.0 && x - r < self.high.0 && z + r > self.low.1 && z - r < self.high.1
    }
}

/// Least and largest of the values but for the strays at both ends.
fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let strays = (STRAY * values.len() as f64) as usize;
    Some((*values.get(strays)?, *values.get(values.len().checked_sub(strays + 1)?)?))
}

/// What `templates/grains.svg` shows.
#[derive(Serialize)]
struct Sheet {
    height: f64,
    /// Of one picture.
    size: (f64, f64),
    pictures: Vec<Picture>,
    colours: [&'static str; 10],
    /// Top of the colours below the pictures.
    middle: f64,
    fastest: f64,
    /// A round length, m, and how long it is here.
    length: f64,
    bar: f64,
}

/// One instant.
#[derive(Serialize)]
struct Picture {
    /// Left and top.
    corner: (f64, f64),
    time: f64,
    dots: Vec<Dots>,
}

/// Dots of one colour and width, as a path.
#[derive(Serialize)]
struct Dots {
    colour: &'static str,
    wide: u64,
    way: String,
}

/// The pictures, or nothing if there is no grain to draw.
///
/// # Errors
/// [`Failure::Run`] if the template fails: a fault of this program.
pub(super) fn draw(snapshots: &[Snapshot]) -> Result<Option<String>, Failure> {
    let Some(view) = View::of(snapshots) else { return Ok(None) };
    let fastest = fastest(snapshots);
    let columns = columns(snapshots.len(), view.size().1 / view.size().0);
    let width = (WIDTH - (columns as f64 - 1.0) * TEXT) / columns as f64;
    let scale = width / view.size().0;
    let step = (width + TEXT, scale * view.size().1 + LINE);
    let top = snapshots.len().div_ceil(columns) as f64 * step.1;
    let picture = |(place, snapshot): (usize, &Snapshot)| Picture {
        corner: ((place % columns) as f64 * step.0, (place / columns) as f64 * step.1),
        time: (1e4 * snapshot.time).round() / 1e4,
        dots: dots(snapshot, &view, scale, fastest),
    };
    let length = round_length(0.2 * view.size().0);
    let sheet = Sheet {
        height: top + 1.5 * LINE,
        size: (scale * view.size().0, scale * view.size().1),
        pictures: snapshots.iter().enumerate().map(picture).collect(),
        colours: COLOURS,
        middle: top + 0.5 * LINE,
        fastest,
        length,
        bar: scale * length,
    };
    render("grains.svg", sheet).map(Some)
}

/// Speed of the fastest colour: all but the strays are slower.
fn fastest(snapshots: &[Snapshot]) -> f64 {
    let of = |snapshot: &Snapshot| {
        let free = snapshot.discs.iter().filter(|disc| !disc.held);
        span(free.map(|disc| disc.speed)).map_or(0.0, |(_, high)| high)
    };
    snapshots.iter().map(of).fold(0.0, f64::max)
}

/// As few columns as keep the picture from being taller than wide.
fn columns(pictures: usize, aspect: f64) -> usize {
    let height = |columns: &usize| pictures.div_ceil(*columns) as f64 * aspect / *columns as f64;
    (1..=pictures).find(|columns| height(columns) <= 1.0).unwrap_or(pictures.max(1))
}

/// The grains of one instant.
fn dots(snapshot: &Snapshot, view: &View, scale: f64, fastest: f64) -> Vec<Dots> {
    let mut dots: BTreeMap<(&'static str, u64), Vec<(i64, i64)>> = BTreeMap::new();
    for disc in snapshot.discs.iter().filter(|disc| view.shows(disc)) {
        let place = (scale * (disc.centre.0 - view.low.0), scale * (view.high.1 - disc.centre.1));
        let place = (place.0.round() as i64, place.1.round() as i64);
        let wide = (2.0 * scale * disc.radius).round().max(1.0) as u64;
        dots.entry((colour(disc, fastest), wide)).or_default().push(place);
    }
    let way = |places: &[(i64, i64)]| {
        let mut last = (0, 0);
        let step = |place: &(i64, i64)| {
            let from = std::mem::replace(&mut last, *place);
            format!("m{} {}h0", place.0 - from.0, place.1 - from.1)
        };
        places.iter().map(step).collect()
    };
    dots.into_iter().map(|((colour, wide), places)| Dots { colour, wide, way: way(&places) }).collect()
}

fn colour(disc: &Disc, fastest: f64) -> &'static str {
    if disc.held {
        return HELD;
    }
    let part = if fastest > 0.0 { disc.speed / fastest } else { 0.0 };
    COLOURS[((part * COLOURS.len() as f64) as usize).min(COLOURS.len() - 1)]
}

/// 1, 2 or 5 times a power of ten, at most `length`.
fn round_length(length: f64) -> f64 {
    let power = 10.0_f64.powi(length.log10().floor() as i32);
    [5.0, 2.0, 1.0].iter().map(|step| step * power).find(|round| *round <= length).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heap(time: f64, speed: f64) -> Snapshot {
        let disc =
            |i: u32| Disc { centre: (f64::from(i % 50), f64::from(i / 50)), radius: 0.5, speed, held: false };
        let mut discs: Vec<Disc> = (0..500).map(disc).collect();
        discs.push(Disc { centre: (1e4, 0.0), ..discs[0] });
        Snapshot { time, count: discs.len(), cut: None, discs }
    }

    #[test]
    fn a_grain_far_away_does_not_shrink_the_picture() {
        let snapshots = [heap(0.0, 0.0), heap(1.0, 2.0)];
        let view = View::of(&snapshots).unwrap();
        assert_eq!((view.low, view.high), ((-2.0, -2.0), (51.0, 11.0)));
        let svg = draw(&snapshots).unwrap().unwrap();
        assert_eq!(svg.matches("h0").count(), 1000, "the far one is left out of both");
        assert!(svg.contains("t = 1 s") && svg.contains("2 m/s and more"));
        assert!(svg.len() < 20 * 1000, "{}", svg.len());
        // slow ones in the first colour, fast ones in the last; the legend has each once
        assert_eq!((svg.matches(COLOURS[0]).count(), svg.matches(COLOURS[9]).count()), (2, 2));
    }

    #[test]
    fn nothing_is_drawn_of_nothing() {
        assert!(draw(&[]).unwrap().is_none());
        assert!(draw(&[Snapshot::default()]).unwrap().is_none());
    }

    #[test]
    fn wide_pictures_stand_below_and_tall_ones_beside_each_other() {
        assert_eq!((columns(4, 0.2), columns(4, 1.0), columns(4, 7.0), columns(1, 3.0)), (1, 2, 4, 1));
        assert_eq!([0.3, 0.2, 0.019].map(round_length), [0.2, 0.2, 0.01]);
    }
}
