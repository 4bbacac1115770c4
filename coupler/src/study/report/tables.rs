//! The tables of a report: plan, bounds, metrics, cost.

use bedload_output::{MetricValue, Summary};
use serde::Serialize;
use serde_json::Value;

use crate::study::numbers::{integer, number};
use crate::study::page::{Cell, Listing, or_dash};
use crate::study::plot::colour;

fn seconds(value: Option<f64>) -> String {
    or_dash(value, |value| format!("{} s", number(value)))
}

fn ratio(over: Option<f64>, under: Option<f64>) -> String {
    or_dash(over.zip(under).filter(|(_, under)| *under > 0.0), |(over, under)| number(over / under))
}

/// Time steps, their ratios, sub-steps: as planned and as done.
pub(super) fn steps(summary: &Summary, plan: Option<&Value>) -> Listing {
    let planned = |key: &str| plan.and_then(|plan| plan.get(key)).and_then(Value::as_f64);
    let time = &summary.time;
    let line = |name: &str, planned: String, done: String| vec![name.into(), planned.into(), done.into()];
    let (t_c, dt_f, dt_dem) = (planned("contact_time"), planned("dt_fluid"), planned("dt_dem"));
    let substeps = &time.substeps_per_window;
    let done = format!("{} / {} / {}", substeps.min, number(substeps.mean), substeps.max);
    let count = |value: Option<f64>| or_dash(value, |value| integer(value as u64));
    let rows = vec![
        line("dt of the fluid", seconds(dt_f), seconds(time.dt_fluid)),
        line("dt of the DEM (done: smallest)", seconds(dt_dem), seconds(time.dt_dem)),
        line("contact time t_c", seconds(t_c), seconds(time.contact_time)),
        line("t_c / dt of the DEM", ratio(t_c, dt_dem), ratio(time.contact_time, time.dt_dem)),
        line("dt of the fluid / t_c", ratio(dt_f, t_c), ratio(time.dt_fluid, time.contact_time)),
        line("sub-steps per window (least / mean / most)", count(planned("substeps")), done),
        line("windows", count(planned("windows")), integer(time.fluid_steps)),
        line("sub-steps in all", "–".into(), integer(time.dem_substeps)),
        line("simulated time", seconds(planned("until")), seconds(Some(time.simulated))),
    ];
    Listing::new(&["", "planned", "done"], rows)
}

/// The bounds that the plan was checked against; nothing without a plan.
pub(super) fn bounds(plan: Option<&Value>) -> Option<Listing> {
    let bounds = plan?.get("bounds")?.as_array()?;
    let text =
        |bound: &Value, key: &str| bound.get(key).and_then(Value::as_str).unwrap_or_default().to_owned();
    let value = |bound: &Value, key: &str| bound.get(key).and_then(Value::as_f64).map_or("∞".into(), number);
    let row = |bound: &Value| {
        let holds = bound.get("holds").and_then(Value::as_bool).unwrap_or(false);
        let sign = if text(bound, "side") == "at-least" { "≥" } else { "≤" };
        vec![
            text(bound, "name").into(),
            text(bound, "quantity").into(),
            value(bound, "value").into(),
            format!("{sign} {}", value(bound, "limit")).into(),
            value(bound, "margin").into(),
            if holds { Cell::classed("kept", "good") } else { Cell::classed("broken", "bad") },
            text(bound, "source").into(),
        ]
    };
    let head = ["bound", "quantity", "value", "limit", "margin", "", "source"];
    Listing::new(&head, bounds.iter().map(row).collect()).any()
}

/// The metrics with their references.
pub(super) fn metrics(summary: &Summary) -> Option<Listing> {
    let row = |(name, metric): (&String, &MetricValue)| {
        vec![
            Cell::classed(name, "code"),
            or_dash(metric.value, number).into(),
            metric.unit.as_str().into(),
            or_dash(metric.reference, number).into(),
            or_dash(metric.relative_error, |error| format!("{} %", number(100.0 * error))).into(),
            metric.source.as_deref().unwrap_or("").into(),
            metric.note.as_deref().unwrap_or("").into(),
        ]
    };
    let head = ["metric", "value", "unit", "reference", "error", "source of the reference", "remark"];
    Listing::new(&head, summary.metrics.iter().map(row).collect()).any()
}

/// Size and cost.
pub(super) fn cost(summary: &Summary) -> Listing {
    let (cost, size) = (&summary.cost, &summary.size);
    let line = |name: &str, value: String| vec![name.into(), value.into()];
    let memory = |bytes| or_dash(bytes, |bytes: u64| format!("{} MiB", integer(bytes >> 20)));
    let nanoseconds = |value| or_dash(value, |value| format!("{} ns", number(value)));
    let rss = &cost.peak_rss_bytes;
    let peak = format!("{} / {} / {}", memory(rss.fluid), memory(rss.dem), memory(rss.coupler));
    let rows = vec![
        line("cells", integer(size.cells)),
        line("grains", integer(size.grains)),
        line("wall time", seconds(Some(cost.wall_s))),
        line("fluid, per cell and step", nanoseconds(cost.ns_per_cell_step)),
        line("DEM, per free grain and sub-step", nanoseconds(cost.ns_per_grain_substep)),
        line("peak memory (fluid / DEM / coupler)", peak),
    ];
    Listing::new::<&str>(&[], rows)
}

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
    /// Width of the longest bar.
    const ROOM: f64 = 300.0;
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
