//! A figure of a case: measured points, published curves and points, as one SVG file.

use std::path::Path;

use bedload_output::points;
use kuva::plot::scatter::MarkerShape;
use kuva::plot::{LegendPosition, LinePlot, ScatterPlot};
use kuva::render::annotations::ReferenceLine;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render_to_svg;

use super::ValidateError;
use super::case::{Case, Figure, Points, Series, Table, matches};
use super::formula;
use super::runs::Outcome;
use crate::study::report::chart::{COLOURS, MARKERS};

/// Grey of what was not measured here.
const PUBLISHED: &str = "#444444";

/// Width and height.
const SIZE: (f64, f64) = (900.0, 440.0);

/// Width of the legend: kuva's own guess is too narrow for Greek letters.
const LEGEND: f64 = 250.0;

/// More published points than this are a line of small crosses.
const CROWD: usize = 60;

/// Points along a curve.
const STEPS: usize = 200;

/// A figure, or nothing if no run gave a point. `runs` is the folder of the runs' output folders.
pub(super) fn draw(
    case: &Case,
    figure: &Figure,
    outcomes: &[Outcome],
    runs: &Path,
) -> Result<Option<String>, ValidateError> {
    let tables = tables(case, figure, outcomes, runs)?;
    let measured: Vec<Vec<(f64, f64)>> =
        figure.series.iter().map(|series| measured(case, figure, series, outcomes)).collect();
    let abscissae = measured.iter().flatten().chain(tables.iter().flat_map(|(_, t)| t)).map(|(x, _)| *x);
    let marks = figure.marks.iter().map(|mark| mark.at);
    let (from, to) = abscissae
        .chain(marks)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), x| (x.min(from), x.max(to)));
    if measured.iter().all(Vec::is_empty) && tables.is_empty() {
        return Ok(None);
    }
    let mut plots = curves(figure, from, to);
    for (number, (table, points)) in tables.iter().enumerate() {
        let number = number + figure.series.len();
        let colour = COLOURS[number % COLOURS.len()];
        plots.push(if table.line {
            let line = LinePlot::new().with_data(points.clone()).with_color(colour).with_stroke_width(1.8);
            Plot::Line(line.with_legend(table.name.as_str()))
        } else {
            scatter(points, &table.name, colour, MARKERS[number % MARKERS.len()], 4.5)
        });
    }
    for (number, (series, points)) in figure.series.iter().zip(&measured).enumerate() {
        if !points.is_empty() {
            // Smaller and smaller, so that points of two series at one place both show.
            let size = 7.5 - 0.7 * number.min(5) as f64;
            let colour = COLOURS[number % COLOURS.len()];
            plots.push(scatter(points, &series.name, colour, MARKERS[number % MARKERS.len()], size));
        }
    }
    // Over the measured ones, which are larger.
    for from in &figure.points {
        let points = published(from, &case.folder)?;
        let size = if points.len() > CROWD { 2.0 } else { 5.0 };
        plots.push(scatter(&points, &from.name, PUBLISHED, MarkerShape::Cross, size));
    }
    let layout = layout(figure, &plots);
    Ok(Some(render_to_svg(plots, layout)))
}

fn layout(figure: &Figure, plots: &[Plot]) -> Layout {
    let mut layout = Layout::auto_from_plots(plots)
        .with_width(SIZE.0)
        .with_height(SIZE.1)
        .with_title(figure.title.as_str())
        .with_x_label(figure.x.label.as_str())
        .with_y_label(figure.y.label.as_str())
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_width(LEGEND)
        .with_font_family("system-ui, sans-serif")
        .with_title_size(16)
        .with_label_size(15)
        .with_tick_size(13)
        .with_body_size(13);
    if figure.log_x {
        layout = layout.with_log_x();
    }
    if figure.log_y {
        layout = layout.with_log_y();
    }
    if let Some([least, largest]) = figure.x.range {
        layout = layout.with_x_axis_min(least).with_x_axis_max(largest);
    }
    if let Some([least, largest]) = figure.y.range {
        layout = layout.with_y_axis_min(least).with_y_axis_max(largest);
    }
    for mark in &figure.marks {
        let line = ReferenceLine::vertical(mark.at).with_color(PUBLISHED).with_label(mark.name.as_str());
        layout = layout.with_reference_line(line);
    }
    layout
}

/// Points of a series: one per run that has both values.
fn measured(case: &Case, figure: &Figure, series: &Series, outcomes: &[Outcome]) -> Vec<(f64, f64)> {
    let of = |number: usize, outcome: &Outcome| {
        let Outcome::Done(summary) = outcome else { return None };
        let run = &case.runs[number];
        let value = |name: &String| summary.metrics.get(name).and_then(|metric| metric.value);
        let x = figure.x.metric.as_ref().map_or(run.at, value)?;
        let y = value(series.metric.as_ref().or(figure.y.metric.as_ref())?)? / series.over;
        let shown = |value: f64, log: bool| value.is_finite() && (value > 0.0 || !log);
        let drawn = shown(x, figure.log_x) && shown(y, figure.log_y);
        (matches(&series.run, &run.label) && drawn).then_some((x, y))
    };
    outcomes.iter().enumerate().filter_map(|(number, outcome)| of(number, outcome)).collect()
}

/// A table and its points.
type Drawn<'a> = (&'a Table, Vec<(f64, f64)>);

/// Tables of the runs that were made, with their points.
fn tables<'a>(
    case: &Case,
    figure: &'a Figure,
    outcomes: &[Outcome],
    runs: &Path,
) -> Result<Vec<Drawn<'a>>, ValidateError> {
    let mut found = Vec::new();
    for table in &figure.tables {
        let made = |(run, outcome): (&super::case::Run, &Outcome)| {
            run.label == table.run && matches!(outcome, Outcome::Done(_))
        };
        if !case.runs.iter().zip(outcomes).any(made) {
            continue;
        }
        let path = runs.join(&table.run).join(&table.file);
        let text = std::fs::read_to_string(&path).map_err(ValidateError::file("read", &path))?;
        let mut points =
            points(&text, &table.x, &table.y).map_err(|what| ValidateError::Case { path, what })?;
        let shown = |value: f64, log: bool| value.is_finite() && (value > 0.0 || !log);
        points.retain(|(x, y)| shown(*x, figure.log_x) && shown(*y, figure.log_y));
        found.push((table, points));
    }
    Ok(found)
}

/// Curves by formula, evenly spaced along the axis as it is drawn.
fn curves(figure: &Figure, from: f64, to: f64) -> Vec<Plot> {
    let place = |step: usize| {
        let part = step as f64 / STEPS as f64;
        if figure.log_x { from * (to / from).powf(part) } else { from + (to - from) * part }
    };
    let curve = |(number, curve): (usize, &super::case::Curve)| {
        let value = |x: f64| formula::evaluate(&curve.formula, &|name| (name == "x").then_some(x));
        let points =
            (0..=STEPS).map(place).filter_map(|x| Some((x, value(x).ok().filter(|y| y.is_finite())?)));
        let line = LinePlot::new()
            .with_data(points.collect::<Vec<_>>())
            .with_color(PUBLISHED)
            .with_stroke_width(1.6)
            .with_legend(curve.name.as_str());
        Plot::Line(if number == 0 { line } else { line.with_dashed() })
    };
    figure.curves.iter().enumerate().map(curve).collect()
}

fn scatter(points: &[(f64, f64)], name: &str, colour: &str, marker: MarkerShape, size: f64) -> Plot {
    let plot = ScatterPlot::new().with_data(points.iter().copied()).with_color(colour);
    Plot::Scatter(plot.with_size(size).with_marker(marker).with_legend(name))
}

/// Two columns of a CSV file.
fn published(from: &Points, folder: &Path) -> Result<Vec<(f64, f64)>, ValidateError> {
    let path = folder.join(&from.file);
    let text = std::fs::read_to_string(&path).map_err(ValidateError::file("read", &path))?;
    points(&text, &from.x, &from.y).map_err(|what| ValidateError::Case { path, what })
}
