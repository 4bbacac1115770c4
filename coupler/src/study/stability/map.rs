//! The map: one panel for each combination of what varies besides the two axes.
//!
//! Drawn by hand, not with kuva: the ticks are the sampled values, refused cells are filled behind the
//! markers, and panels share their axes.

use std::fmt::Write as _;

use super::axis::Axis;
use super::region::{Cell, Region};
use super::table::{Row, Table};
use super::verdict::Verdict;
use crate::number::Short;
use crate::study::page::escape;

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

/// What `check` refuses.
const REFUSED: &str = "#e9e9e9";

/// The bound.
const BOUND: &str = "#222";

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

/// The map of a table.
pub(super) fn draw(table: &Table, frame: &Frame<'_>) -> String {
    let along = |column: usize| Axis::new(table.rows.iter().map(move |row| row.values[column].as_str()));
    let (x, y) = (along(frame.x.0), along(frame.y.0));
    let panels = panels(table, frame);
    let across = panels.len().clamp(1, ACROSS);
    let left = ROOM.0.max(32.0 + longest(&y));
    let size = (left + AREA.0 + ROOM.2, ROOM.1 + AREA.1 + ROOM.3);
    let width = (across as f64 * size.0).max(LEAST_WIDTH);
    let height = HEAD + panels.len().div_ceil(across) as f64 * size.1;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"system-ui, sans-serif\" font-size=\"12\" role=\"img\" aria-label=\"{title}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{edge}\" y=\"24\" font-size=\"16\" font-weight=\"600\">{title}</text>\n",
        title = escape(frame.title),
        edge = 14,
    );
    svg += &legend(frame.bound);
    for (number, (name, rows)) in panels.iter().enumerate() {
        let (column, line) = ((number % across) as f64, (number / across) as f64);
        let corner = (column * size.0 + left, HEAD + line * size.1 + ROOM.1);
        let _ = writeln!(svg, "<g transform=\"translate({},{})\">", corner.0, corner.1);
        svg += &Panel { frame, x: &x, y: &y, left, name, rows }.draw();
        svg += "</g>\n";
    }
    svg + "</svg>\n"
}

/// Rows of each panel with its name, in order of appearance.
fn panels<'a>(table: &'a Table, frame: &Frame<'_>) -> Vec<(String, Vec<&'a Row>)> {
    let others: Vec<usize> =
        (0..table.keys.len()).filter(|column| *column != frame.x.0 && *column != frame.y.0).collect();
    let mut panels: Vec<(String, Vec<&Row>)> = Vec::new();
    for row in &table.rows {
        let values = others.iter().map(|column| row.values[*column].as_str());
        let name = values.filter(|value| !value.is_empty()).collect::<Vec<_>>().join(" · ");
        match panels.iter_mut().find(|(known, _)| *known == name) {
            Some((_, rows)) => rows.push(row),
            None => panels.push((name, vec![row])),
        }
    }
    panels
}

struct Panel<'a> {
    frame: &'a Frame<'a>,
    x: &'a Axis,
    y: &'a Axis,
    /// Room for the labels along y.
    left: f64,
    name: &'a str,
    rows: &'a [&'a Row],
}

impl Panel<'_> {
    fn draw(&self) -> String {
        let region = self.region();
        let mut svg = String::new();
        for strip in region.strips() {
            let (left, right) = (across(strip.x.0), across(strip.x.1));
            let (top, bottom) = (up(strip.y.1), up(strip.y.0));
            let _ = writeln!(
                svg,
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{REFUSED}\" shape-rendering=\"crispEdges\"/>",
                right - left,
                bottom - top
            );
        }
        svg += &self.ticks();
        let pieces: String = region
            .pieces()
            .iter()
            .map(|(from, to)| {
                format!("M{:.1} {:.1}L{:.1} {:.1}", across(from.0), up(from.1), across(to.0), up(to.1))
            })
            .collect();
        if !pieces.is_empty() {
            let _ = writeln!(
                svg,
                "<path d=\"{pieces}\" fill=\"none\" stroke=\"{BOUND}\" stroke-width=\"2\" stroke-linecap=\"square\"/>"
            );
        }
        for row in self.rows {
            svg += &self.mark(row);
        }
        svg
    }

    fn place(&self, row: &Row) -> Option<(usize, usize)> {
        Some((self.x.find(&row.values[self.frame.x.0])?, self.y.find(&row.values[self.frame.y.0])?))
    }

    fn region(&self) -> Region<'_> {
        let mut cells = vec![vec![None; self.y.len()]; self.x.len()];
        for row in self.rows {
            if let Some((i, j)) = self.place(row) {
                cells[i][j] = Some(Cell { refused: row.refused, margin: row.margin });
            }
        }
        Region { x: self.x, y: self.y, cells }
    }

    /// Frame, ticks at sampled values, names.
    fn ticks(&self) -> String {
        let (width, height) = AREA;
        let mut svg = format!(
            "<rect width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#777\"/>\n\
             <text x=\"{middle}\" y=\"-9\" text-anchor=\"middle\" font-weight=\"600\">{name}</text>\n\
             <text x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">{x}</text>\n\
             <text transform=\"translate({beside},{half}) rotate(-90)\" text-anchor=\"middle\">{y}</text>\n",
            middle = width / 2.0,
            name = escape(self.name),
            below = height + 34.0,
            beside = 16.0 - self.left,
            half = height / 2.0,
            x = escape(self.frame.x.1),
            y = escape(self.frame.y.1),
        );
        for at in self.x.labelled((longest(self.x) + GAP) / width) {
            let x = across(self.x.place(at));
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {height}v4\" stroke=\"#777\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" \
                 font-size=\"11\">{}</text>",
                height + 16.0,
                escape(&label(self.x.text(at)))
            );
        }
        for at in self.y.labelled(LINE / height) {
            let y = up(self.y.place(at));
            let _ = writeln!(
                svg,
                "<path d=\"M0 {y:.1}h-4\" stroke=\"#777\"/><text x=\"-7\" y=\"{:.1}\" text-anchor=\"end\" \
                 font-size=\"11\">{}</text>",
                y + 4.0,
                escape(&label(self.y.text(at)))
            );
        }
        svg
    }

    /// The marker of a run; what it stands for appears under the pointer.
    fn mark(&self, row: &Row) -> String {
        let Some((i, j)) = self.place(row) else { return String::new() };
        let mut words = format!(
            "{}: {} = {}, {} = {}: {}",
            self.name,
            self.frame.x.1,
            self.x.text(i),
            self.frame.y.1,
            self.y.text(j),
            row.verdict
        );
        if row.growth.is_finite() {
            words += &format!(", growth {} per window", Short(row.growth));
        }
        if row.margin.is_finite() {
            words += &format!(", margin {}", Short(row.margin));
        }
        words += if row.refused { ", refused" } else { ", accepted" };
        let (x, y) = (across(self.x.place(i)), up(self.y.place(j)));
        format!("<g><title>{}</title>{}</g>\n", escape(&words), symbol(row.verdict, x, y))
    }
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

fn across(place: f64) -> f64 {
    place * AREA.0
}

fn up(place: f64) -> f64 {
    (1.0 - place) * AREA.1
}

/// Marker and colour of a verdict: they stay apart for colour-blind eyes (Okabe & Ito 2008) and in
/// black and white.
fn symbol(verdict: Verdict, x: f64, y: f64) -> String {
    match verdict {
        Verdict::Stable => {
            format!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\" fill=\"#0072B2\" stroke=\"#fff\" stroke-width=\".7\"/>"
            )
        }
        Verdict::Oscillating => format!(
            "<path d=\"M{x:.1} {:.1}l4.6 4.6l-4.6 4.6l-4.6 -4.6z\" fill=\"#E69F00\" stroke=\"#222\" stroke-width=\".7\"/>",
            y - 4.6
        ),
        Verdict::Failed => format!(
            "<path d=\"M{:.1} {:.1}l7.2 7.2m0 -7.2l-7.2 7.2\" stroke=\"#C03A00\" stroke-width=\"2.1\" fill=\"none\"/>",
            x - 3.6,
            y - 3.6
        ),
    }
}

fn legend(bound: &str) -> String {
    let mut svg = String::new();
    let mut x = 20.0;
    for verdict in Verdict::ALL {
        let _ =
            writeln!(svg, "{}<text x=\"{}\" y=\"46\">{verdict}</text>", symbol(verdict, x, 42.0), x + 9.0);
        x += 30.0 + 7.5 * verdict.to_string().len() as f64;
    }
    let name = if bound == super::section::ANY {
        "refused by check".to_owned()
    } else {
        format!("refused by check; line: {bound}")
    };
    let _ = writeln!(
        svg,
        "<rect x=\"{x}\" y=\"35\" width=\"18\" height=\"13\" fill=\"{REFUSED}\"/><path d=\"M{x} 35h18\" stroke=\"{BOUND}\" \
         stroke-width=\"2\"/><text x=\"{}\" y=\"46\">{}</text>",
        x + 24.0,
        escape(&name)
    );
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(form: &str, x: &str, y: &str, verdict: Verdict, margin: f64) -> Row {
        Row {
            values: [form, x, y].map(str::to_owned).to_vec(),
            verdict,
            growth: 0.1,
            margin,
            label: format!("{form}-{x}-{y}"),
            note: String::new(),
            refused: margin < 1.0,
        }
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
            row("izard-2014", "0.1", "1", Verdict::Failed, 0.25),
            row("izard-2014", "0.1", "16", Verdict::Stable, 4.0),
            row("izard-2014", "1", "1", Verdict::Oscillating, 0.25),
            row("izard-2014", "1", "16", Verdict::Stable, 4.0),
            row("yu-shao-fixed-point <½>", "0.1", "1", Verdict::Stable, 3.0),
        ];
        let table =
            Table { keys: ["form", "nu", "rho"].map(str::to_owned).to_vec(), columns: Vec::new(), rows };
        let frame = Frame { title: "a & b", x: (1, "ν dt/D²"), y: (2, "ρ_r"), bound: "density-ratio" };
        let svg = draw(&table, &frame);
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
        let alone = Table { keys: table.keys.clone(), columns: Vec::new(), rows: table.rows[4..].to_vec() };
        assert!(
            !draw(&alone, &frame).contains("fill=\"none\" stroke=\"#222\""),
            "nothing is refused: no line"
        );
    }
}
