//! Curves over time as figures of a page, each with its close-up.

use crate::page::{Figure, Key};
use crate::plot::{Axis, Look, Plot, Point, Series, colour};
use coupler::number::{Short, decade};

/// Points that a line keeps per chart: more than a screen has columns.
const MOST_POINTS: usize = 1600;

/// Width and height of a chart in its own units; text is 14 of them.
const SIZE: Point = (560.0, 370.0);

/// A logarithmic axis ends at this part of the largest value.
const DECADES: f64 = 1e-6;

#[derive(Clone, Default)]
pub(super) struct Chart {
    /// Caption, also read out in place of the picture.
    pub(super) caption: String,
    pub(super) x_label: String,
    pub(super) y_label: String,
    pub(super) lines: Vec<Series>,
    pub(super) log_y: bool,
    /// Close-up of this interval of x.
    pub(super) closeup: Option<Point>,
}

/// A line through the finite points of two columns.
pub(super) fn line(name: &str, number: usize, x: &[f64], y: &[f64]) -> Series {
    let points = x.iter().copied().zip(y.iter().copied());
    let points = points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let look = Look::Line { width: 1.6, dashed: false };
    Series { name: name.to_owned(), colour: colour(number), points, look }
}

impl Chart {
    /// Lines over linear axes with these labels, without a close-up.
    pub(super) fn new(caption: &str, [x_label, y_label]: [&str; 2], lines: Vec<Series>) -> Self {
        let [caption, x_label, y_label] = [caption, x_label, y_label].map(str::to_owned);
        Self { caption, x_label, y_label, lines, ..Self::default() }
    }

    /// The chart as a figure, and its close-up as another; none if there is no line to draw.
    pub(super) fn figures(&self) -> Vec<Figure> {
        let Some(body) = self.draw() else { return Vec::new() };
        let figure = Figure {
            view: format!("0 0 {} {}", SIZE.0, SIZE.1),
            label: self.caption.clone(),
            caption: self.caption.clone(),
            body,
            keys: self.keys(),
        };
        let closeup = self.closeup.and_then(|span| self.closeup(span));
        std::iter::once(figure).chain(closeup.iter().flat_map(Self::figures)).collect()
    }

    /// The part of the chart within `span`, if there is enough of it.
    fn closeup(&self, span: Point) -> Option<Self> {
        let mut lines = self.lines.clone();
        lines.iter_mut().for_each(|line| line.points.retain(|(x, _)| (span.0..=span.1).contains(x)));
        let caption = format!("{} around the first bounce", self.caption);
        let seen = lines.iter().any(|line| line.points.len() > 2);
        seen.then(|| Self { caption, lines, closeup: None, ..self.clone() })
    }

    /// Names of the lines beside their colours, if there are several.
    fn keys(&self) -> Vec<Key> {
        let drawn: Vec<&Series> = self.lines.iter().filter(|line| !line.points.is_empty()).collect();
        let key = |line: &&Series| Key { name: line.name.clone(), colour: line.colour };
        if drawn.len() < 2 { Vec::new() } else { drawn.iter().map(key).collect() }
    }

    /// What kuva draws, without its outer tag.
    fn draw(&self) -> Option<String> {
        let floor = if self.log_y { self.floor()? } else { f64::NEG_INFINITY };
        let mut series: Vec<Series> =
            self.lines.iter().filter(|line| !line.points.is_empty()).cloned().collect();
        series.iter_mut().for_each(|line| line.points = visible(&line.points, floor));
        if series.is_empty() {
            return None;
        }
        let format = match self.log_y {
            true => Some(decade as fn(f64) -> String),
            false => is_narrow(&series).then_some(fine as fn(f64) -> String),
        };
        let plot = Plot {
            size: SIZE,
            x: Axis { label: self.x_label.clone(), ..Axis::default() },
            y: Axis { label: self.y_label.clone(), log: self.log_y, format, ..Axis::default() },
            series,
            ticks: 6,
            ..Plot::default()
        };
        Some(plot.draw().inner().to_owned())
    }

    /// Lower end of a logarithmic axis, which has whole decades: that below the least positive value, which
    /// counts as no less than [`DECADES`] of the largest. Zero and less are drawn there, so that a short
    /// contact shows as a peak.
    fn floor(&self) -> Option<f64> {
        let values = || self.lines.iter().flat_map(|line| &line.points).map(|(_, y)| *y).filter(|y| *y > 0.0);
        let most = values().fold(0.0, f64::max);
        let least = || values().fold(f64::INFINITY, f64::min).max(most * DECADES);
        (most > 0.0).then(|| 10_f64.powi(least().log10().floor() as i32))
    }
}

/// Do the lines keep so near a value that ticks of four digits would be alike?
fn is_narrow(lines: &[Series]) -> bool {
    let values = || lines.iter().flat_map(|line| &line.points).map(|(_, y)| *y);
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
    high > low && high - low < 5e-3 * high.abs().max(low.abs())
}

/// A tick of eight digits.
fn fine(value: f64) -> String {
    format!("{:.8}", Short(value))
}

/// What is drawn of a line: nothing below `floor`, and not more points than can be seen.
fn visible(points: &[Point], floor: f64) -> Vec<Point> {
    let points: Vec<Point> = points.iter().map(|(x, y)| (*x, y.max(floor))).collect();
    thin(&points)
}

/// Keeps the first, least, largest and last point of each of equally many runs of points, so that
/// no peak is lost.
fn thin(points: &[Point]) -> Vec<Point> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let run = points.len().div_ceil(MOST_POINTS / 4);
    let mut kept = Vec::with_capacity(MOST_POINTS + 4);
    for chunk in points.chunks(run) {
        let order = |a: &usize, b: &usize| chunk[*a].1.total_cmp(&chunk[*b].1);
        let least = (0..chunk.len()).min_by(order).unwrap_or(0);
        let most = (0..chunk.len()).max_by(order).unwrap_or(0);
        let mut places = [0, least, most, chunk.len() - 1];
        places.sort_unstable();
        let mut last = None;
        for place in places {
            if last != Some(place) {
                kept.push(chunk[place]);
            }
            last = Some(place);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_peaks_ends_and_order() {
        let mut points: Vec<Point> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 7.0;
        points[12_345].1 = -3.0;
        let kept = thin(&points);
        assert!(kept.len() <= MOST_POINTS + 8);
        assert!(kept.contains(&(54_321.0, 7.0)) && kept.contains(&(12_345.0, -3.0)));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[99_999]));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn ticks_of_a_narrow_range_differ() {
        let lines = |y: [f64; 2]| [line("a", 0, &[0.0, 1.0], &y)];
        assert!(is_narrow(&lines([6.0131, 6.0134])) && !is_narrow(&lines([6.0, 7.0])));
        assert!(!is_narrow(&lines([6.0, 6.0])) && !is_narrow(&lines([0.0, 0.0])));
        assert_eq!([6.01315, 6.0132].map(fine), ["6.01315", "6.0132"]);
    }

    #[test]
    fn zero_lies_on_the_lower_edge() {
        let lines = vec![line("a", 0, &[0.0, 1.0], &[6.4, 7.0]), line("b", 1, &[0.0, 1.0], &[0.0, 0.0])];
        let chart = Chart { lines, log_y: true, ..Chart::default() };
        assert_eq!(chart.floor(), Some(1.0));
        let y = |line: &Series| visible(&line.points, 1.0).iter().map(|(_, y)| *y).collect::<Vec<_>>();
        assert_eq!((y(&chart.lines[0]), y(&chart.lines[1])), (vec![6.4, 7.0], vec![1.0, 1.0]));
    }

    #[test]
    fn an_empty_chart_is_left_out() {
        let lines = vec![line("a", 0, &[0.0, 1.0], &[f64::NAN, 0.0])];
        let chart = Chart { lines, log_y: true, ..Chart::default() };
        assert!(chart.figures().is_empty());
    }
}
