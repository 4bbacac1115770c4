//! The tables of a report: plan, bounds, metrics, cost.

use bedload_output::{MetricValue, Summary};
use serde_json::Value;

use super::page::{escape, integer, number};

/// A table with a header row; cells are HTML already.
pub(crate) fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let row = |tag: &str, cells: &mut dyn Iterator<Item = String>| {
        // Long cells may break their lines; short ones stay whole and the table scrolls.
        let wide = |cell: &str| if cell.chars().count() > 24 { " class=\"text\"" } else { "" };
        let cells: String = cells.map(|cell| format!("<{tag}{}>{cell}</{tag}>", wide(&cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let mut html = String::from("<div class=\"wide\"><table>\n");
    if !head.is_empty() {
        html += &format!("<thead>{}</thead>\n", row("th", &mut head.iter().map(|name| escape(name))));
    }
    html += "<tbody>\n";
    for cells in rows {
        html += &row("td", &mut cells.iter().cloned());
    }
    html + "</tbody></table></div>\n"
}

fn seconds(value: Option<f64>) -> String {
    value.map_or("–".into(), |value| format!("{} s", number(value)))
}

fn ratio(over: Option<f64>, under: Option<f64>) -> String {
    over.zip(under)
        .filter(|(_, under)| *under > 0.0)
        .map_or("–".into(), |(over, under)| number(over / under))
}

/// Time steps, their ratios, sub-steps: as planned and as done.
pub(super) fn steps(summary: &Summary, plan: Option<&Value>) -> String {
    let planned = |key: &str| plan.and_then(|plan| plan.get(key)).and_then(Value::as_f64);
    let time = &summary.time;
    let line = |name: &str, planned: String, done: String| vec![escape(name), planned, done];
    let (t_c, dt_f, dt_dem) = (planned("contact_time"), planned("dt_fluid"), planned("dt_dem"));
    let substeps = &time.substeps_per_window;
    let done = format!("{} / {} / {}", substeps.min, number(substeps.mean), substeps.max);
    let count = |value: Option<f64>| value.map_or("–".into(), |value| integer(value as u64));
    let rows = [
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
    table(&["", "planned", "done"], &rows)
}

/// The bounds that the plan was checked against; nothing without a plan.
pub(super) fn bounds(plan: Option<&Value>) -> Option<String> {
    let bounds = plan?.get("bounds")?.as_array()?;
    let text =
        |bound: &Value, key: &str| bound.get(key).and_then(Value::as_str).map(escape).unwrap_or_default();
    let value = |bound: &Value, key: &str| bound.get(key).and_then(Value::as_f64).map_or("∞".into(), number);
    let rows: Vec<Vec<String>> = bounds
        .iter()
        .map(|bound| {
            let holds = bound.get("holds").and_then(Value::as_bool).unwrap_or(false);
            let sign = if text(bound, "side") == "at-least" { "≥" } else { "≤" };
            let state =
                if holds { "<span class=\"good\">kept</span>" } else { "<span class=\"bad\">broken</span>" };
            let source = text(bound, "source");
            vec![
                text(bound, "name"),
                text(bound, "quantity"),
                value(bound, "value"),
                format!("{sign} {}", value(bound, "limit")),
                value(bound, "margin"),
                state.to_owned(),
                source,
            ]
        })
        .collect();
    let head = ["bound", "quantity", "value", "limit", "margin", "", "source"];
    (!rows.is_empty()).then(|| table(&head, &rows))
}

/// The metrics with their references.
pub(super) fn metrics(summary: &Summary) -> Option<String> {
    let row = |(name, metric): (&String, &MetricValue)| {
        let percent = |error: f64| format!("{} %", number(100.0 * error));
        vec![
            format!("<code>{}</code>", escape(name)),
            metric.value.map_or("–".into(), number),
            escape(&metric.unit),
            metric.reference.map_or("–".into(), number),
            metric.relative_error.map_or("–".into(), percent),
            escape(metric.source.as_deref().unwrap_or("")),
            escape(metric.note.as_deref().unwrap_or("")),
        ]
    };
    let rows: Vec<Vec<String>> = summary.metrics.iter().map(row).collect();
    let head = ["metric", "value", "unit", "reference", "error", "source of the reference", "remark"];
    (!rows.is_empty()).then(|| table(&head, &rows))
}

/// Size and cost.
pub(super) fn cost(summary: &Summary) -> String {
    let (cost, size) = (&summary.cost, &summary.size);
    let line = |name: &str, value: String| vec![escape(name), value];
    let memory =
        |bytes: Option<u64>| bytes.map_or("–".into(), |bytes| format!("{} MiB", integer(bytes >> 20)));
    let nanoseconds =
        |value: Option<f64>| value.map_or("–".into(), |value| format!("{} ns", number(value)));
    let rss = &cost.peak_rss_bytes;
    let peak = format!("{} / {} / {}", memory(rss.fluid), memory(rss.dem), memory(rss.coupler));
    let rows = [
        line("cells", integer(size.cells)),
        line("grains", integer(size.grains)),
        line("wall time", seconds(Some(cost.wall_s))),
        line("fluid, per cell and step", nanoseconds(cost.ns_per_cell_step)),
        line("DEM, per free grain and sub-step", nanoseconds(cost.ns_per_grain_substep)),
        line("peak memory (fluid / DEM / coupler)", peak),
    ];
    table(&[], &rows)
}

/// The split of the cost: one bar per part, drawn as SVG.
pub(super) fn cost_split(summary: &Summary) -> String {
    let cost = &summary.cost;
    let parts = [
        ("fluid", cost.fluid_cpu_s, "#0072B2"),
        ("DEM", cost.dem_cpu_s, "#D55E00"),
        ("coupler", cost.coupler_cpu_s, "#009E73"),
        ("exchange", cost.exchange_s, "#CC79A7"),
        ("record", cost.record_s, "#E69F00"),
    ];
    let total: f64 = parts.iter().map(|(_, seconds, _)| seconds).sum();
    let most = parts.iter().map(|(_, seconds, _)| *seconds).fold(0.0, f64::max);
    let (height, room) = (30 * parts.len() + 6, 300.0);
    let mut svg = format!(
        "<figure><svg viewBox=\"0 0 560 {height}\" role=\"img\" aria-label=\"Cost split\" \
         font-family=\"system-ui, sans-serif\" font-size=\"15\">\n"
    );
    for (row, (name, seconds, colour)) in parts.iter().enumerate() {
        let (top, middle) = (30 * row + 4, 30 * row + 20);
        let width = if most > 0.0 { room * seconds / most } else { 0.0 };
        let share = if total > 0.0 { 100.0 * seconds / total } else { 0.0 };
        let end = 96.0 + width;
        svg += &format!(
            "<text x=\"84\" y=\"{middle}\" text-anchor=\"end\">{name}</text>\
             <rect x=\"90\" y=\"{top}\" width=\"{width:.1}\" height=\"22\" fill=\"{colour}\"/>\
             <text x=\"{end:.1}\" y=\"{middle}\">{} s ({share:.1} %)</text>\n",
            number(*seconds)
        );
    }
    svg + "</svg><figcaption>Cost split: CPU time of the solvers and the coupler; wall time of exchange and \
           record</figcaption></figure>\n"
}
