//! The split of a run's cost, as bars.

use bedload_output::Summary;
use serde::Serialize;

use crate::plot::colour;
use coupler::number::number;

/// Width of the longest bar.
const ROOM: f64 = 300.0;

/// A part of the cost as a bar.
#[derive(Serialize)]
pub(super) struct Part {
    name: &'static str,
    colour: &'static str,
    /// Width of the bar, and where the words behind it begin.
    width: String,
    end: String,
    words: String,
}

/// The split of the cost.
pub(super) fn parts(summary: &Summary) -> Vec<Part> {
    let cost = &summary.cost;
    let parts = [
        ("fluid", cost.fluid_cpu_s),
        ("DEM", cost.dem_cpu_s),
        ("coupler", cost.coupler_cpu_s),
        ("exchange", cost.exchange_s),
        ("record", cost.record_s),
    ];
    let total: f64 = parts.iter().map(|(_, seconds)| seconds).sum();
    let most = parts.iter().map(|(_, seconds)| *seconds).fold(0.0, f64::max);
    let part = |(row, (name, seconds)): (usize, &(&'static str, f64))| {
        let width = if most > 0.0 { ROOM * seconds / most } else { 0.0 };
        let percent = if total > 0.0 { 100.0 * seconds / total } else { 0.0 };
        let words = format!("{} s ({percent:.1} %)", number(*seconds));
        let (width, end) = (format!("{width:.1}"), format!("{:.1}", 96.0 + width));
        Part { name, colour: colour(row), width, end, words }
    };
    parts.iter().enumerate().map(part).collect()
}
