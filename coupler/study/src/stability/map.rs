//! The map: one panel for each combination of what varies besides the two axes. A marker is a run; grey is
//! what `bedload check` refuses, up to where the margin of the bound crosses 1 between two sampled values.

use super::classify::Class;
use crate::plot::{Axis, Bars, Look, Plot, Point, Series, Shape, panels};
use crate::section::ANY;
use crate::table::{Row, Table, grouped};
use coupler::number::{Short, decade};

/// Width of a panel at least and of all of a row, and height.
const LEAST_WIDTH: f64 = 290.0;
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 320.0;

/// Panels beside each other, at most.
const ACROSS: usize = 4;

/// Part of the axis that is left free at each end.
const MARGIN: f64 = 0.07;

/// From this ratio of largest to least on, an axis is logarithmic.
const DECADE: f64 = 9.0;

/// Colour and marker of each class: they stay apart for colour-blind eyes (Okabe & Ito 2008) and in black and
/// white.
const LOOKS: [(Class, &str, Shape, f64); 3] = [
    (Class::Stable, "#0072B2", Shape::Circle, 3.6),
    (Class::Oscillating, "#E69F00", Shape::Diamond, 4.6),
    (Class::Failed, "#C03A00", Shape::Cross, 3.8),
];

/// Names of the axes, and what stands over the map.
#[derive(Clone, Debug)]
pub(super) struct Frame<'a> {
    pub(super) title: &'a str,
    /// Numbers of the columns along x and y, and their names.
    pub(super) x: (usize, &'a str),
    pub(super) y: (usize, &'a str),
    pub(super) bound: &'a str,
}

/// The map of a table, as SVG.
pub(super) fn draw(table: &Table, frame: &Frame<'_>) -> String {
    let along = |column: usize| Samples::new(table.rows.iter().map(move |row| row.values[column].as_str()));
    let (x, y) = (along(frame.x.0), along(frame.y.0));
    let groups = grouped(&table.rows, |row| row.panel(frame.x.0, frame.y.0));
    let across = groups.len().clamp(1, ACROSS);
    let size = ((WIDTH / across as f64).max(LEAST_WIDTH), HEIGHT);
    let panel = |(name, rows): (String, Vec<&Row>)| Plot { size, ..panel(name, &rows, frame, (&x, &y)) };
    panels(frame.title, &groups.into_iter().map(panel).collect::<Vec<_>>(), across)
}

fn panel(title: String, rows: &[&Row], frame: &Frame<'_>, (x, y): (&Samples, &Samples)) -> Plot {
    let place = |row: &Row| Some((x.find(&row.values[frame.x.0])?, y.find(&row.values[frame.y.0])?));
    let mut cells = vec![vec![None; y.texts.len()]; x.texts.len()];
    for row in rows {
        if let Some((i, j)) = place(row) {
            cells[i][j] = Some((row.refused, row.margin.unwrap_or(f64::NAN)));
        }
    }
    let region = Region { x, y, cells };
    let bound = if frame.bound == ANY { String::new() } else { format!(": {}", frame.bound) };
    let refused = Series {
        name: format!("refused by check{bound}"),
        colour: "#E2E2E2",
        points: region.rectangles().into_iter().flatten().collect(),
        look: Look::Rectangles,
    };
    let of_class = |(class, colour, shape, size): (Class, &'static str, Shape, f64)| {
        let runs = || rows.iter().filter(|row| row.class == Some(class));
        let point = |row: &&Row| place(row).map(|(i, j)| (x.value(x.heights[i]), y.value(y.heights[j])));
        let words = runs().map(|row| words(row, &title, frame)).collect();
        let points = runs().filter_map(point).collect();
        Series {
            name: class.to_string(),
            colour,
            points,
            look: Look::Points { shape, size, words, bars: Bars::None },
        }
    };
    let series = std::iter::once(refused).chain(LOOKS.map(of_class)).collect();
    let (x, y) = (x.axis(frame.x.1), y.axis(frame.y.1));
    Plot { title, x, y, series, ticks: 5, ..Plot::default() }
}

/// What a marker says when the mouse rests on it.
fn words(row: &Row, panel: &str, frame: &Frame<'_>) -> String {
    let value = |(column, name): (usize, &str)| format!("{name} = {}", row.values[column]);
    let number = |name: &str, value: Option<f64>| {
        let known = value.filter(|value| value.is_finite());
        known.map_or_else(String::new, |value| format!(", {name} {}", Short(value)))
    };
    format!(
        "{panel}: {}, {}: {}{}{}, {}",
        value(frame.x),
        value(frame.y),
        row.class.map_or_else(String::new, |class| class.to_string()),
        number("growth per window", row.growth),
        number("margin", row.margin),
        if row.refused { "refused" } else { "accepted" }
    )
}

/// What distances along an axis mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Spacing {
    /// Nothing: names.
    Names,
    Linear,
    Logarithmic,
}

/// The sampled values along an axis: numbers by size, names in order of appearance.
#[derive(Clone, Debug, PartialEq)]
struct Samples {
    /// As they stand in the table.
    texts: Vec<String>,
    /// Numbers, their logarithms, or the places of names from 0; ascending.
    heights: Vec<f64>,
    spacing: Spacing,
}

impl Samples {
    fn new<'a>(values: impl Iterator<Item = &'a str>) -> Self {
        let mut texts: Vec<String> = Vec::new();
        for text in values {
            if !texts.iter().any(|known| known == text) {
                texts.push(text.to_owned());
            }
        }
        let number = |text: &String| text.parse().ok().filter(|value: &f64| value.is_finite());
        let Some(mut heights) = texts.iter().map(number).collect::<Option<Vec<f64>>>() else {
            let heights = (0..texts.len()).map(|at| at as f64).collect();
            return Self { texts, heights, spacing: Spacing::Names };
        };
        heights.sort_by(f64::total_cmp);
        let value = |text: &String| number(text).unwrap_or(f64::NAN);
        texts.sort_by(|a, b| value(a).total_cmp(&value(b)));
        let ends = heights.first().zip(heights.last());
        let decades = ends.is_some_and(|(least, most)| *least > 0.0 && most / least >= DECADE);
        if decades {
            heights.iter_mut().for_each(|height| *height = height.ln());
        }
        let spacing = if decades { Spacing::Logarithmic } else { Spacing::Linear };
        Self { texts, heights, spacing }
    }

    /// Number of a value.
    fn find(&self, text: &str) -> Option<usize> {
        self.texts.iter().position(|known| known == text)
    }

    /// The value that is drawn at a height.
    fn value(&self, height: f64) -> f64 {
        if self.spacing == Spacing::Logarithmic { height.exp() } else { height }
    }

    /// Where the cell of value `at` begins, half-way from the value before; the first and the last reach to
    /// the ends of the axis.
    fn edge(&self, at: usize) -> f64 {
        let (Some(first), Some(last)) = (self.heights.first(), self.heights.last()) else { return 0.0 };
        let free = match (self.spacing, last > first) {
            (Spacing::Names, _) | (_, false) => 0.5,
            _ => MARGIN * (last - first),
        };
        match at {
            0 => first - free,
            at if at == self.heights.len() => last + free,
            at => 0.5 * (self.heights[at - 1] + self.heights[at]),
        }
    }

    /// Between values `at − 1` and `at`: where a margin that is `before` at the one and `after` at the
    /// other is 1, on the axis as it is drawn; half-way where that is not known.
    fn crossing(&self, at: usize, before: f64, after: f64) -> f64 {
        // A margin is value/limit or limit/value: the first is linear in the value and grows, of the
        // other its inverse; the logarithm of both is linear in that of the value.
        let height = |margin: f64| match self.spacing {
            Spacing::Logarithmic => margin.ln(),
            _ if before < after => margin,
            _ => 1.0 / margin,
        };
        let part = (height(1.0) - height(before)) / (height(after) - height(before));
        if self.spacing != Spacing::Names && (0.0..=1.0).contains(&part) {
            self.heights[at - 1] + part * (self.heights[at] - self.heights[at - 1])
        } else {
            self.edge(at)
        }
    }

    fn axis(&self, label: &str) -> Axis {
        let named = self.spacing == Spacing::Names;
        Axis {
            label: label.to_owned(),
            log: self.spacing == Spacing::Logarithmic,
            format: (self.spacing == Spacing::Logarithmic).then_some(decade as fn(f64) -> String),
            range: Some([self.value(self.edge(0)), self.value(self.edge(self.heights.len()))]),
            names: if named { self.texts.clone() } else { Vec::new() },
        }
    }
}

/// What the bound says at the sampled points: whether it refuses, and its margin; by number of x, then of y.
struct Region<'a> {
    x: &'a Samples,
    y: &'a Samples,
    cells: Vec<Vec<Option<(bool, f64)>>>,
}

impl Region<'_> {
    /// Lower left and upper right corner of each refused part of a column, neighbours joined.
    fn rectangles(&self) -> Vec<[Point; 2]> {
        let mut all: Vec<[Point; 2]> = Vec::new();
        for (i, column) in self.cells.iter().enumerate() {
            let sides = [i, i + 1].map(|i| self.x.value(self.side(i)));
            for j in (0..column.len()).filter(|j| column[*j].is_some_and(|(refused, _)| refused)) {
                let [low, high] = [j, j + 1].map(|j| self.y.value(self.level(i, j)));
                match all.last_mut().filter(|[from, to]| from.0 == sides[0] && to.1 == low) {
                    Some(last) => last[1].1 = high,
                    None => all.push([(sides[0], low), (sides[1], high)]),
                }
            }
        }
        all
    }

    /// Between rows `j − 1` and `j` of column `i`.
    fn level(&self, i: usize, j: usize) -> f64 {
        let column = &self.cells[i];
        match (j.checked_sub(1).and_then(|below| column[below]), column.get(j).copied().flatten()) {
            (Some(below), Some(above)) if below.0 != above.0 => self.y.crossing(j, below.1, above.1),
            _ => self.y.edge(j),
        }
    }

    /// Between columns `i − 1` and `i`: where the bound is one on x alone, where it crosses.
    fn side(&self, i: usize) -> f64 {
        if i == 0 || i == self.cells.len() {
            return self.x.edge(i);
        }
        let pairs = || self.cells[i - 1].iter().zip(&self.cells[i]).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
        let all_cross = pairs().all(|(left, right)| left.0 != right.0);
        match pairs().next() {
            Some((left, right)) if all_cross => self.x.crossing(i, left.1, right.1),
            _ => self.x.edge(i),
        }
    }
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

    #[test]
    fn every_run_has_its_marker_and_every_combination_its_panel() {
        let rows = vec![
            row("izard-2014", "0.1", "1", Class::Failed, 0.25),
            row("izard-2014", "0.1", "16", Class::Stable, 4.0),
            row("izard-2014", "1", "1", Class::Oscillating, 0.25),
            row("izard-2014", "1", "16", Class::Stable, 4.0),
            row("yu-shao-fixed-point <½>", "0.1", "1", Class::Stable, 3.0),
        ];
        let keys = ["form", "nu", "rho"].map(str::to_owned).to_vec();
        let table = Table { kind: crate::kind::Kind::Stability, keys, metrics: Vec::new(), rows };
        let frame = Frame { title: "a & b", x: (1, "ν dt/D²"), y: (2, "ρ_r"), bound: "density-ratio" };
        let svg = draw(&table, &frame);
        assert_eq!(svg.matches("<title>").count(), 5);
        for text in ["a &amp; b", "yu-shao-fixed-point &lt;½&gt;", "density-ratio", "izard-2014"] {
            assert!(svg.contains(text), "{text} is not in {svg}");
        }
    }

    #[test]
    fn samples_are_sorted_and_cells_end_half_way() {
        let samples = Samples::new(["1.0", "0.01", "0.1", "0.1"].into_iter());
        assert_eq!((samples.texts[0].as_str(), samples.find("1.0")), ("0.01", Some(2)));
        assert!((samples.value(samples.edge(1)) - 0.1_f64.sqrt() * 0.1).abs() < 1e-12, "by ratio");
        let names = Samples::new(["rk3", "ab2"].into_iter());
        assert_eq!(
            (names.texts[0].as_str(), names.edge(0), names.edge(1), names.edge(2)),
            ("rk3", -0.5, 0.5, 1.5)
        );
    }

    #[test]
    fn a_bound_crosses_where_its_margin_is_one() {
        let samples = Samples::new(["1", "100"].into_iter());
        // margin = value/10: at 1 it is 0.1, at 100 it is 10.
        assert!((samples.value(samples.crossing(1, 0.1, 10.0)) - 10.0).abs() < 1e-9);
        assert_eq!(samples.crossing(1, f64::NAN, 10.0), samples.edge(1));
        assert_eq!(samples.crossing(1, 2.0, 10.0), samples.edge(1), "it does not cross");
        // The limit 2 on a linear axis from 1 to 5, from below and from above.
        let samples = Samples::new(["1", "5"].into_iter());
        for (before, after) in [(0.5, 2.5), (2.0, 0.4)] {
            assert!((samples.crossing(1, before, after) - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_refused_ends_at_the_limit() {
        let (x, y) =
            (Samples::new(["0.1", "1", "10"].into_iter()), Samples::new(["0.1", "1", "10"].into_iter()));
        let limit = [0.5, 0.5, 5.0];
        let cell = |i: usize, value: f64| Some((value < limit[i], value / limit[i]));
        let cells = (0..3).map(|i| [0.1, 1.0, 10.0].map(|value| cell(i, value)).to_vec()).collect();
        let rectangles = Region { x: &x, y: &y, cells }.rectangles();
        assert_eq!(rectangles.len(), 3);
        for ([low, high], limit) in rectangles.iter().zip(limit) {
            assert!((high.1 / limit - 1.0).abs() < 1e-12 && low.1 == y.value(y.edge(0)), "{low:?} {high:?}");
        }
        // A bound on x alone is an upright line where it crosses.
        let (x, y) = (Samples::new(["1", "2", "4"].into_iter()), Samples::new(["ab2", "rk3"].into_iter()));
        let cells = [1.0, 2.0, 4.0].map(|value: f64| vec![Some((value > 2.5, 2.5 / value)); 2]).to_vec();
        let rectangles = Region { x: &x, y: &y, cells }.rectangles();
        assert_eq!(rectangles.len(), 1);
        assert!((rectangles[0][0].0 - 2.5).abs() < 1e-12 && rectangles[0][1].1 == 1.5, "{rectangles:?}");
        assert!(Region { x: &x, y: &y, cells: vec![vec![None; 2]; 3] }.rectangles().is_empty());
    }
}
