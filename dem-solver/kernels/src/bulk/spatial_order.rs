//! The order of the engine: grains that are near one another follow one another.
//!
//! Cells of about a diameter; pencils of some ten by ten cells along the longest axis, one after the
//! other; in a pencil layer by layer. A block of five hundred grains is then about as long as wide, and
//! in a column of ten diameters it reads only the blocks before and behind it.

use crate::motion::Vec3;
use crate::search::cells::{by_length, extent};

/// Cells across a pencil.
const PENCIL: f64 = 10.0;

/// Numbers of the grains in the order of the engine, by cells of `width`. A function of the positions alone.
pub(super) fn order(position: &[Vec3], width: f64) -> Vec<u32> {
    let (low, high) = extent(position.iter().map(|x| (*x).into()));
    // 2¹⁴ per axis: finer cells than that order nothing, and the key stays in 64 bits
    let count: [f64; 3] =
        std::array::from_fn(|axis| ((high[axis] - low[axis]) / width).floor().clamp(0.0, 16383.0) + 1.0);
    let [across, along, longest] = by_length(count);
    let pencils = |axis: usize| (count[axis] / PENCIL).round().max(1.0);
    let shares = [pencils(across) / count[across], pencils(along) / count[along]];
    let mut keyed: Vec<(u64, u32)> = (0u32..)
        .zip(position)
        .map(|(i, x)| {
            let cell = |axis: usize| ((x[axis] - low[axis]) / width).floor().clamp(0.0, count[axis] - 1.0);
            let (a, b, c) = (cell(across), cell(along), cell(longest));
            // five fields of 14 bits at most would be 70: a pencil's number needs no more than 11
            let pencil = ((b * shares[1]) as u64) << 11 | (a * shares[0]) as u64;
            (pencil << 42 | (c as u64) << 28 | (b as u64) << 14 | a as u64, i)
        })
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}
