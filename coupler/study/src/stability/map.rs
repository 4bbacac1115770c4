//! The map: one panel for each combination of what varies besides the two axes.
//!
//! A template of its own, not kuva: the ticks are the sampled values, refused cells are filled behind the
//! markers, and panels share their axes.

use serde::Serialize;

use super::axis::Axis;
use super::classify::Class;
use super::region::{Cell, Piece, Region, Strip};
use crate::page::render;
use crate::section::ANY;
use crate::table::grouped;
use crate::table::{Row, Table};
use coupler::failure::Failure;
use coupler::number::Short;

/// Width and height of the drawing area of a panel.
const AREA: (f64, f64) = (200.0, 250.0);

/// Left, top, right, bottom of it: room for labels and the panel's name. Left is more where the labels
/// along y are names.
const ROOM: (f64, f64, f64, f64) = (62.0, 30.0, 12.0, 44.0);

/// Width of a letter of a label.
const LETTER: f64 = 6.2;

/// Above all panels: title and legend.
const HEAD: f64 = 58.0;

/// Panels beside each other, at most.
const ACROSS: usize = 4;

/// Narrowest picture: the legend needs it.
const LEAST_WIDTH: f64 = 720.0;

/// Between labels beside each other, and from one line of them to the next.
const GAP: f64 = 6.0;
const LINE: f64 = 12.5;

/// Digits of a label; longer numbers get a power of ten.
const DIGITS: usize = 6;

/// Names of the axes, and what stands over the map.
#[derive(Clone, Debug)]
pub(super) struct Frame<'a> {
    pub(super) title: &'a str,
    /// Numbers of the columns along x and y, and their names.
    pub(super) x: (usize, &'a str),
    pub(super) y: (usize, &'a str),
    /// Name of the bound.
    pub(super) bound: &'a str,
}

/// What `templates/map.svg` shows.
#[derive(Serialize)]
struct Map<'a> {
    title: &'a str,
    size: (f64, f64),
    area: (f64, f64),
    /// Room for the labels along y.
    left: f64,
    legend: Vec<Tick>,
    bound: Tick,
    x: Ticks<'a>,
    y: Ticks<'a>,
    panels: Vec<Panel>,
}

/// An axis with its labelled values.
#[derive(Serialize)]
struct Ticks<'a> {
    name: &'a str,
    ticks: Vec<Tick>,
}

/// A word and its place along a line.
#[derive(Serialize)]
struct Tick {
    at: f64,
    name: String,
}

#[derive(Serialize)]
struct Panel {
    corner: (f64, f64),
    name: String,
    /// Left, top, width and height of what `check` refuses.
    refused: Vec<[f64; 4]>,
    /// Path of the line around it.
    bound: String,
    runs: Vec<Mark>,
}

/// The marker of a run; its words appear under the pointer.
#[derive(Serialize)]
struct Mark {
    at: (f64, f64),
    class: String,
    words: String,
}

/// The map of a table.
pub(super) fn draw(table: &Table, frame: &Frame<'_>) -> Result<String, Failure> {
    let along = |column: usize| Axis::new(table.rows.iter().map(move |row| row.values[column].as_str()));
    let (x, y) = (along(frame.x.0), along(frame.y.0));
    let groups = grouped(&table.rows, |row| row.panel(frame.x.0, frame.y.0));
    let across = groups.len().clamp(1, ACROSS);
    let left = ROOM.0.max(32.0 + longest(&y));
    let size = (left + AREA.0 + ROOM.2, ROOM.1 + AREA.1 + ROOM.3);
    let corner = |number: usize| {
        let (column, line) = ((number % across) as f64, (number / across) as f64);
        (column * size.0 + left, HEAD + line * size.1 + ROOM.1)
    };
    let panel = |(number, (name, rows)): (usize, &(String, Vec<&Row>))| {
        let region = region(&x, &y, rows, frame);
        let runs = rows.iter().filter_map(|row| mark(row, name, frame, &x, &y)).collect();
        let (refused, bound) = (refused(&region), line(&region));
        Panel { corner: corner(number), name: name.clone(), refused, bound, runs }
    };
    let (legend, bound) = legend(frame.bound);
    let ticks = |axis: &Axis, name, room: f64, place: fn(f64) -> f64| {
        let tick = |at| Tick { at: tenth(place(axis.place(at))), name: label(axis.text(at)) };
        Ticks { name, ticks: axis.labelled(room).into_iter().map(tick).collect() }
    };
    let whole = (across as f64 * size.0, HEAD + groups.len().div_ceil(across) as f64 * size.1);
    let map = Map {
        title: frame.title,
        size: (whole.0.max(LEAST_WIDTH), whole.1),
        area: AREA,
        left,
        legend,
        bound,
        x: ticks(&x, frame.x.1, (longest(&x) + GAP) / AREA.0, rightwards),
        y: ticks(&y, frame.y.1, LINE / AREA.1, upwards),
        panels: groups.iter().enumerate().map(panel).collect(),
    };
    render("map.svg", map)
}

fn region<'a>(x: &'a Axis, y: &'a Axis, rows: &[&Row], frame: &Frame<'_>) -> Region<'a> {
    let mut cells = vec![vec![None; y.len()]; x.len()];
    for row in rows {
        if let Some((i, j)) = place(row, frame, x, y) {
            cells[i][j] = Some(Cell { refused: row.refused, margin: row.margin.unwrap_or(f64::NAN) });
        }
    }
    Region { x, y, cells }
}

/// Numbers of a row's values along both axes.
fn place(row: &Row, frame: &Frame<'_>, x: &Axis, y: &Axis) -> Option<(usize, usize)> {
    Some((x.find(&row.values[frame.x.0])?, y.find(&row.values[frame.y.0])?))
}

fn refused(region: &Region<'_>) -> Vec<[f64; 4]> {
    let strips = region.strips();
    let rectangle = |strip: &Strip| {
        let (left, right) = (rightwards(strip.x.0), rightwards(strip.x.1));
        let (top, bottom) = (upwards(strip.y.1), upwards(strip.y.0));
        [left, top, right - left, bottom - top].map(tenth)
    };
    strips.iter().map(rectangle).collect()
}

fn line(region: &Region<'_>) -> String {
    let piece = |(from, to): &Piece| {
        let (x, y) = ([from.0, to.0].map(rightwards), [from.1, to.1].map(upwards));
        format!("M{:.1} {:.1}L{:.1} {:.1}", x[0], y[0], x[1], y[1])
    };
    region.pieces().iter().map(piece).collect()
}

fn mark(row: &Row, panel: &str, frame: &Frame<'_>, x: &Axis, y: &Axis) -> Option<Mark> {
    let (i, j) = place(row, frame, x, y)?;
    let (x_name, y_name, class) = (frame.x.1, frame.y.1, row.class?);
    let mut words = format!("{panel}: {x_name} = {}, {y_name} = {}: {class}", x.text(i), y.text(j));
    if let Some(growth) = row.growth.filter(|growth| growth.is_finite()) {
        words += &format!(", growth {} per window", Short(growth));
    }
    if let Some(margin) = row.margin.filter(|margin| margin.is_finite()) {
        words += &format!(", margin {}", Short(margin));
    }
    words += if row.refused { ", refused" } else { ", accepted" };
    let at = (tenth(rightwards(x.place(i))), tenth(upwards(y.place(j))));
    Some(Mark { at, class: class.to_string(), words })
}

/// A sampled value as it stands at an axis.
fn label(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(value) if text.len() > DIGITS && value.is_finite() => format!("{value:e}"),
        _ => text.to_owned(),
    }
}

/// Width of the longest label of an axis.
fn longest(axis: &Axis) -> f64 {
    let letters = (0..axis.len()).map(|at| label(axis.text(at)).chars().count()).max();
    LETTER * letters.unwrap_or(0) as f64
}

fn rightwards(place: f64) -> f64 {
    place * AREA.0
}

fn upwards(place: f64) -> f64 {
    (1.0 - place) * AREA.1
}

/// As fine as a picture needs it.
fn tenth(place: f64) -> f64 {
    (10.0 * place).round() / 10.0
}

/// The classes, and what is refused by the bound.
fn legend(bound: &str) -> (Vec<Tick>, Tick) {
    let mut at = 20.0;
    let tick = |class: Class| {
        let tick = Tick { at, name: class.to_string() };
        at += 30.0 + 7.5 * tick.name.len() as f64;
        tick
    };
    let classes = Class::ALL.map(tick).into();
    let line = if bound == ANY { String::new() } else { format!("; line: {bound}") };
    (classes, Tick { at, name: format!("refused by check{line}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(form: &str, x: &str, y: &str, class: Class, margin: f64) -> Row {
        Row {
            values: [form, x, y].map(str::to_owned).to_vec(),
            class: Some(class),
            growth: Some(0.1),
            margin: Some(margin),
            label: format!("{form}-{x}-{y}"),
            refused: margin < 1.0,
            ..Row::default()
        }
    }

    fn table(keys: &[&str], rows: Vec<Row>) -> Table {
        let keys = keys.iter().map(|key| (*key).to_owned()).collect();
        Table { kind: crate::kind::Kind::Stability, keys, metrics: Vec::new(), rows }
    }

    #[test]
    fn labels_are_short_and_names_have_room() {
        assert_eq!(
            ["0.000001", "0.0024", "yu-shao-fixed-point C_v=0.5"].map(label),
            ["1e-6", "0.0024", "yu-shao-fixed-point C_v=0.5"]
        );
        let names = Axis::new(["a rather long name", "b"].into_iter());
        assert!(longest(&names) > 100.0);
    }

    #[test]
    fn every_run_has_its_marker_and_every_combination_its_panel() {
        let rows = vec![
            row("izard-2014", "0.1", "1", Class::Failed, 0.25),
            row("izard-2014", "0.1", "16", Class::Stable, 4.0),
            row("izard-2014", "1", "1", Class::Oscillating, 0.25),
            row("izard-2014", "1", "16", Class::Stable, 4.0),
            row("yu-shao-fixed-point <½>", "0.1", "1", Class::Stable, 3.0),
        ];
        let table = table(&["form", "nu", "rho"], rows);
        let frame = Frame { title: "a & b", x: (1, "ν dt/D²"), y: (2, "ρ_r"), bound: "density-ratio" };
        let svg = draw(&table, &frame).unwrap();
        assert_eq!(svg.matches("<title>").count(), 5);
        assert_eq!(svg.matches("<g transform").count(), 2);
        assert!(
            svg.contains("a &amp; b")
                && svg.contains("yu-shao-fixed-point &lt;½&gt;")
                && svg.contains("density-ratio")
        );
        // The limit 4 lies half-way between 1 and 16, all along the first panel.
        assert_eq!(svg.matches(&format!(" {:.1}L", AREA.1 / 2.0)).count(), 2, "{svg}");
        assert_eq!(svg.matches("<circle").count(), 3 + 1, "three stable runs and the legend");
        let alone = Table { rows: table.rows[4..].to_vec(), ..table.clone() };
        assert!(
            !draw(&alone, &frame).unwrap().contains("fill=\"none\" stroke=\"#222\""),
            "nothing is refused: no line"
        );
    }
}
