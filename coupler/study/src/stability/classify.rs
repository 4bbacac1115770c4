//! Stable, oscillating or failed: classified from a signal of the run, sample by sample.
//!
//! An exchange of forces once per window fails by alternating from window to window, so the second
//! difference d_n = (s_n − 2 s_{n−1} + s_{n−2})/4 is looked at: it passes an alternation as it is
//! and a motion of period P windows with sin²(π/P), so that slower instabilities are seen too, while
//! of a smooth motion nearly nothing is left. Its envelope is the largest |d| in each of
//! `BLOCKS` blocks of the second half, and the growth rate the slope of the line of least squares
//! through the logarithms of these, per window.

use std::fmt;

use serde::Serialize;

/// Blocks of the envelope in the second half. Eight of them leave a line of least squares enough
/// points to tell growth from noise, and blocks long enough to hold a slow oscillation.
const BLOCKS: usize = 8;

/// Shortest record whose second half counts alone; of a shorter one, of a run that blew up, all is.
const HALVED: usize = 32;

/// The envelope must double within the second half before slow growth counts …
const GROWN: f64 = std::f64::consts::LN_2;
/// … and have become visible: a grain that crosses cells feels 1e-4 to 1e-3 of its velocity as noise.
const VISIBLE: f64 = 2e-3;

/// Growth by e⁴ = 55 within the second half along a straight line is an instability even before it is visible
/// …
const GROWN_FAR: f64 = 4.0;
/// … if the line explains this part of the scatter …
const STRAIGHT: f64 = 0.9;
/// … and the envelope stands well above rounding and the tolerance of solvers.
const ABOVE_ROUNDING: f64 = 1e-9;

/// Alternation above this part of the signal's scale is an oscillation: a per cent is more than any
/// smooth motion of the maps leaves (a start-up with a time constant of 5 windows leaves 1 % at once
/// and decays), and less than anybody wants in a velocity.
const OSCILLATION: f64 = 0.01;
/// It is decaying, and so no oscillation, if the envelope falls by e within the second half.
const DECAYED: f64 = -1.0;

/// The scale of the second half is at least this part of that of the whole signal: of a grain that
/// comes to rest, alternation of 1e-5 of its first velocity still counts.
const LEAST_SCALE: f64 = 1e-3;

/// Below this part of the scale there is nothing but rounding.
const ROUNDING: f64 = 1e-15;

/// Where a method stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// It does what it should.
    Stable,
    /// It alternates from window to window, without growing or decaying.
    Oscillating,
    /// The run ended early, left what is possible, or grows.
    Failed,
}

impl Class {
    /// All of them, from good to bad.
    pub const ALL: [Self; 3] = [Self::Stable, Self::Oscillating, Self::Failed];

    /// From its word in a table.
    pub fn parse(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.to_string() == word)
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stable => "stable",
            Self::Oscillating => "oscillating",
            Self::Failed => "failed",
        })
    }
}

/// A class and what it rests on.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The class.
    pub class: Class,
    /// Growth of the envelope, 1/window; NaN where the record is too short to know it.
    pub growth: f64,
    /// Why, where it is not stable.
    pub note: String,
}

/// Classifies a run by one sample per window. `scale`: size of the signal that counts as whole; by default
/// the largest smooth value of the second half.
///
/// ```
/// use study::stability::classify::{Class, classify};
/// let falls = |n: u32| 1.0 - (-f64::from(n) / 10.0).exp();
/// let smooth: Vec<f64> = (0..200).map(falls).collect();
/// assert_eq!(classify(&smooth, None).class, Class::Stable);
/// let swings: Vec<f64> = (0..200).map(|n| falls(n) + if n % 2 == 0 { 0.1 } else { -0.1 }).collect();
/// assert_eq!(classify(&swings, None).class, Class::Oscillating);
/// ```
pub fn classify(signal: &[f64], scale: Option<f64>) -> Finding {
    if let Some(at) = signal.iter().position(|value| !value.is_finite()) {
        return Finding {
            class: Class::Failed,
            growth: growth(signal),
            note: format!("not finite in window {at}"),
        };
    }
    let Some(envelope) = Envelope::of(signal, 3) else {
        return Finding { class: Class::Stable, growth: f64::NAN, note: "too short to classify".into() };
    };
    let part = envelope.last / scale.unwrap_or(envelope.scale);
    let total = envelope.growth * envelope.length;
    let seen = total >= GROWN && part >= VISIBLE;
    let straight = total >= GROWN_FAR && envelope.straight >= STRAIGHT && part >= ABOVE_ROUNDING;
    let growth = envelope.growth;
    if seen || straight {
        let note = format!("grows by {growth:.2e} per window; alternation {part:.1e} of the signal");
        return Finding { class: Class::Failed, growth, note };
    }
    if part >= OSCILLATION && total > DECAYED {
        let note = format!("alternation of {part:.1e} of the signal stays");
        return Finding { class: Class::Oscillating, growth, note };
    }
    Finding { class: Class::Stable, growth, note: String::new() }
}

/// Growth per window up to the largest value of a signal: of a run that ended early or left what is
/// possible, after which (flung out of the box, say) the signal means nothing. NaN where it took fewer
/// than four windows.
pub fn growth(signal: &[f64]) -> f64 {
    let end = signal.iter().position(|value| !value.is_finite()).unwrap_or(signal.len());
    // Reversed, for the last of equals is found: the first is wanted.
    let largest = signal[..end].iter().enumerate().rev().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let upto = largest.map_or(0, |(at, _)| (at + 1).max(4).min(end));
    Envelope::of(&signal[..upto], 2).map_or(f64::NAN, |envelope| envelope.growth)
}

/// Size of the alternation over the second half.
struct Envelope {
    /// Slope of its logarithm, 1/window.
    growth: f64,
    /// Part of the scatter that the slope explains.
    straight: f64,
    /// Windows that the slope spans.
    length: f64,
    /// Largest alternation in the last quarter of the blocks.
    last: f64,
    /// Scale of the smooth signal.
    scale: f64,
}

impl Envelope {
    /// Of a signal that is long enough for an envelope of `least` points.
    fn of(signal: &[f64], least: usize) -> Option<Self> {
        let alternation: Vec<f64> =
            signal.windows(3).map(|s| ((s[2] - 2.0 * s[1] + s[0]) / 4.0).abs()).collect();
        let smooth: Vec<f64> = signal.windows(3).map(|s| ((s[2] + 2.0 * s[1] + s[0]) / 4.0).abs()).collect();
        let half = if alternation.len() >= HALVED { alternation.len() / 2 } else { 0 };
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let scale = most(&smooth[half..]).max(LEAST_SCALE * most(&smooth));
        let counted = &alternation[half..];
        let block = (counted.len() / BLOCKS).max(1);
        // From the end, so that the last windows always count. Below rounding there is nothing to see.
        let floors = smooth[half..].rchunks_exact(block).map(|part| ROUNDING * most(part));
        let mut peaks: Vec<f64> = counted.rchunks_exact(block).map(most).collect();
        let mut heights: Vec<f64> = peaks
            .iter()
            .zip(floors)
            .map(|(peak, floor)| peak.max(floor).max(f64::MIN_POSITIVE).ln())
            .collect();
        peaks.reverse();
        heights.reverse();
        if peaks.len() < least {
            return None;
        }
        let (slope, straight) = line(&heights);
        let last = most(&peaks[peaks.len() - peaks.len().div_ceil(4)..]);
        // An alternation about zero has no smooth part: it is its own scale.
        let scale = [scale, last, 1.0].into_iter().find(|size| *size > 0.0).unwrap_or(1.0);
        let length = (block * peaks.len()) as f64;
        Some(Self { growth: slope / block as f64, straight, length, last, scale })
    }
}

/// Slope of the line of least squares through values one apart, and the part of the scatter it explains.
fn line(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let middle = (count - 1.0) / 2.0;
    let mean = values.iter().sum::<f64>() / count;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (place, value) in values.iter().enumerate() {
        let (x, y) = (place as f64 - middle, value - mean);
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    (xy / xx, if yy > 0.0 { xy * xy / (xx * yy) } else { 0.0 })
}
