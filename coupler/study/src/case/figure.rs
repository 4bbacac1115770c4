//! A figure of a case: measured points, published curves and points, as one SVG file.

use bedload_output::Summary;

use super::compare::mean;
use super::formula;
use super::profile::{Profile, profile};
use crate::folder::columns;
use crate::make::Made;
use crate::plot::{self, Axis, Bars, GREY, Look, Plot, Point, Rule, Shape, colour, shape};
use crate::section::{Figure, FigureAxis, FormulaCurve, Mark, RunTable, Series, matches};
use crate::sweep::Point as Run;
use coupler::failure::Failure;

/// Width and height.
const SIZE: (f64, f64) = (900.0, 440.0);

/// Width of the legend.
const LEGEND: f64 = 250.0;

/// More published points than this are a line of small crosses.
const CROWD: usize = 60;

/// Marker of a set of published points.
fn cross(number: usize) -> Shape {
    [Shape::Cross, Shape::Plus, Shape::TriangleDown, Shape::Diamond][number % 4]
}

/// Points along a curve.
const STEPS: usize = 200;

/// A figure, or nothing if no run gave a point.
pub(super) fn draw(made: &Made<'_>, figure: &Figure) -> Result<Option<String>, Failure> {
    let tables = tables(made, figure)?;
    known(made, figure)?;
    let published = figure.points.iter().map(|from| {
        let points = columns(&made.study.folder().join(&from.file), &from.x, &from.y)?;
        Ok((from, points))
    });
    let published = published.collect::<Result<Vec<_>, Failure>>()?;
    let measured: Vec<Profile> = figure.series.iter().map(|series| measured(made, figure, series)).collect();
    let abscissae = measured
        .iter()
        .flat_map(|(points, _)| points)
        .chain(tables.iter().flat_map(|(_, (points, _))| points))
        .map(|(x, _)| *x);
    let marks = figure.marks.iter().map(|mark| mark.at);
    let (from, to) = abscissae
        .chain(marks)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), x| (x.min(from), x.max(to)));
    if measured.iter().all(|(points, _)| points.is_empty()) && tables.is_empty() {
        return Ok(None);
    }
    let mut drawn = curves(figure, from, to);
    for (number, (table, (points, bars))) in tables.into_iter().enumerate() {
        let number = number + figure.series.len();
        if !table.line {
            drawn.push(scatter(points, &table.name, colour(number), (shape(number), 4.5), bars));
            continue;
        }
        if bars != Bars::None {
            drawn.push(scatter(points.clone(), "", colour(number), (Shape::Circle, 1.5), bars));
        }
        let look = Look::Line { width: 1.8, dashed: false };
        drawn.push(plot::Series { name: table.name.clone(), colour: colour(number), points, look });
    }
    for (number, (series, (points, bars))) in figure.series.iter().zip(measured).enumerate() {
        if !points.is_empty() {
            // Smaller and smaller, so that points of two series at one place both show.
            let size = 7.5 - 0.7 * number.min(5) as f64;
            drawn.push(scatter(points, &series.name, colour(number), (shape(number), size), bars));
        }
    }
    // Over the measured ones, which are larger.
    for (number, (from, points)) in published.into_iter().enumerate() {
        let size = if points.len() > CROWD { 2.0 } else { 5.0 };
        drawn.push(scatter(points, &from.name, GREY, (cross(number), size), Bars::None));
    }
    Ok(Some(plot_of(figure, drawn).draw().svg))
}

/// Refuses a series none of whose runs has what it draws.
fn known(made: &Made<'_>, figure: &Figure) -> Result<(), Failure> {
    for series in &figure.series {
        let runs = || made.results().filter(|(run, _)| matches(&series.run, &run.label));
        let lacks = |metric: &String| runs().all(|(_, summary)| !summary.metrics.contains_key(metric));
        let y = series.metric.as_ref().or(figure.y.metric.as_ref());
        let what = match (&figure.x.metric, y) {
            _ if runs().next().is_none() => continue,
            (Some(metric), _) | (_, Some(metric)) if lacks(metric) => format!("has the metric {metric:?}"),
            (None, _) if runs().all(|(run, _)| run.at.is_none()) => "has `at`, and x no metric".to_owned(),
            (_, None) => "is given: y has no metric".to_owned(),
            _ => continue,
        };
        let (case, title, name) = (made.study.name(), &figure.title, &series.name);
        let what = format!("case.figures: {case}: {title:?}: {name:?}: none of its runs {what}");
        return Err(Failure::Input(what));
    }
    Ok(())
}

fn plot_of(figure: &Figure, series: Vec<plot::Series>) -> Plot {
    let axis = |axis: &FigureAxis, log| Axis {
        label: axis.label.clone(),
        log,
        range: axis.range,
        ..Axis::default()
    };
    let rule = |mark: &Mark| Rule::Upright { at: mark.at, name: mark.name.clone() };
    Plot {
        size: SIZE,
        title: figure.title.clone(),
        x: axis(&figure.x, figure.log_x),
        y: axis(&figure.y, figure.log_y),
        series,
        rules: figure.marks.iter().map(rule).collect(),
        legend: Some(LEGEND),
        ticks: 0,
    }
}

/// Can a value be drawn along this axis?
fn drawable(value: f64, log: bool) -> bool {
    value.is_finite() && (value > 0.0 || !log)
}

/// Points of a series, one per run that has both values or one per x, and their standard errors: zero where
/// there is none.
fn measured(made: &Made<'_>, figure: &Figure, series: &Series) -> Profile {
    let of = |(run, summary): (&Run, &Summary)| {
        let value = |name: &String| summary.metrics.get(name).and_then(|metric| metric.value);
        let x = figure.x.metric.as_ref().map_or(run.at, value)?;
        let metric = summary.metrics.get(series.metric.as_ref().or(figure.y.metric.as_ref())?)?;
        let (y, bar) = (metric.value? / series.over, metric.standard_error.map(|e| e / series.over.abs()));
        let drawn = drawable(x, figure.log_x) && drawable(y, figure.log_y);
        (matches(&series.run, &run.label) && drawn).then_some((x, y, bar))
    };
    let mut points: Vec<_> = made.results().filter_map(of).collect();
    if series.mean {
        let single = std::mem::take(&mut points);
        for (x, ..) in &single {
            let here: Vec<_> = single.iter().filter(|(other, ..)| other == x).collect();
            let (y, scatter) = mean(&here.iter().map(|(_, y, _)| *y).collect::<Vec<_>>());
            if points.iter().all(|(other, ..)| other != x) {
                points.push((*x, y, scatter.or(here[0].2)));
            }
        }
    }
    let bars = match points.iter().any(|(.., bar)| bar.is_some()) {
        true => Bars::Upright(points.iter().map(|(.., bar)| bar.unwrap_or(0.0)).collect()),
        false => Bars::None,
    };
    (points.into_iter().map(|(x, y, _)| (x, y)).collect(), bars)
}

type Drawn<'a> = (&'a RunTable, Profile);

/// Tables of the runs that were made, with their points.
fn tables<'a>(made: &Made<'_>, figure: &'a Figure) -> Result<Vec<Drawn<'a>>, Failure> {
    let read = |table: &'a RunTable| -> Result<Option<Drawn<'a>>, Failure> {
        let drawable = |(x, y): Point| drawable(x, figure.log_x) && drawable(y, figure.log_y);
        let of = profile(made, &table.run, &table.file, &table.x, &table.y)?;
        Ok(of.map(|(points, bars)| {
            let bars = bars.of(|number| drawable(points[number]));
            (table, (points.into_iter().filter(|point| drawable(*point)).collect(), bars))
        }))
    };
    figure.tables.iter().filter_map(|table| read(table).transpose()).collect()
}

/// Curves by formula, evenly spaced along the axis as it is drawn.
fn curves(figure: &Figure, from: f64, to: f64) -> Vec<plot::Series> {
    let place = |step: usize| {
        let part = step as f64 / STEPS as f64;
        if figure.log_x { from * (to / from).powf(part) } else { from + (to - from) * part }
    };
    let curve = |(number, curve): (usize, &FormulaCurve)| {
        let value = |x: f64| formula::evaluate(&curve.formula, &|name| (name == "x").then_some(x));
        let points =
            (0..=STEPS).map(place).filter_map(|x| Some((x, value(x).ok().filter(|y| y.is_finite())?)));
        plot::Series {
            name: curve.name.clone(),
            colour: GREY,
            points: points.collect(),
            look: Look::Line { width: 1.6, dashed: number > 0 },
        }
    };
    figure.curves.iter().enumerate().map(curve).collect()
}

fn scatter(
    points: Vec<Point>,
    name: &str,
    colour: &'static str,
    (shape, size): (Shape, f64),
    bars: Bars,
) -> plot::Series {
    plot::Series {
        name: name.to_owned(),
        colour,
        points,
        look: Look::Points { shape, size, words: Vec::new(), bars },
    }
}
