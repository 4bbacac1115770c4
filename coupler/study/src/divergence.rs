//! The figure of a replay beside its log: relative difference of each quantity against time.

use super::plot::{Axis, Look, Plot, Point, Series, colour};
use coupler::number::number;

/// Width and height.
const SIZE: (f64, f64) = (900.0, 440.0);

/// Width of the legend.
const LEGEND: f64 = 170.0;

/// Decimal logarithm at which a difference of 0 is drawn: the lower edge, the rounding of a number.
const FLOOR: f64 = -16.0;

/// That of what is no number, or where nothing was logged so far but 0.
const CEILING: f64 = 1.0;

/// Points of a curve, at most: of more windows each is the largest of several.
const POINTS: usize = 1000;

/// The figure as SVG; each curve has a name and points of time (s) and relative difference.
pub fn figure(title: &str, curves: Vec<(String, Vec<Point>)>) -> String {
    let series: Vec<Series> = curves
        .into_iter()
        .enumerate()
        .map(|(number, (name, points))| Series {
            name,
            colour: colour(number),
            points: thinned(&points),
            look: Look::Line { width: 1.8, dashed: false },
        })
        .collect();
    let top = series.iter().flat_map(|series| &series.points).fold(-10.0_f64, |top, (_, y)| top.max(*y));
    let plot = Plot {
        size: SIZE,
        title: title.to_owned(),
        x: Axis { label: "t / s".into(), ..Axis::default() },
        // The logarithm itself is drawn: kuva's logarithmic axis ends at 1e-10.
        y: Axis {
            label: "largest difference / largest logged so far".into(),
            log: false,
            range: Some([FLOOR, 2.0 * (0.5 * top).ceil()]),
            format: Some(tick),
            names: Vec::new(),
        },
        series,
        legend: Some(LEGEND),
        ..Plot::default()
    };
    plot.draw().svg
}

/// A whole power of ten; nothing between.
fn tick(power: f64) -> String {
    let whole = (power - power.round()).abs() < 1e-6;
    if whole {
        number(10.0_f64.powf(power.round())).trim_start_matches("1·").to_owned()
    } else {
        String::new()
    }
}

/// Logarithm of the largest of as many neighbours as it takes, none below the floor or beyond the ceiling.
fn thinned(points: &[Point]) -> Vec<Point> {
    let largest = |some: &[Point]| {
        let drawn = |y: f64| y.log10().clamp(FLOOR, CEILING);
        some.iter().map(|(x, y)| (*x, drawn(*y))).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    points.chunks(points.len().div_ceil(POINTS).max(1)).filter_map(largest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_windows_keep_their_largest_difference_and_zero_is_drawn() {
        let points: Vec<Point> =
            (0..5000).map(|k| (f64::from(k), if k == 2718 { 0.5 } else { 0.0 })).collect();
        let thin = thinned(&points);
        assert!(thin.len() <= POINTS && thin.contains(&(2718.0, 0.5_f64.log10())));
        assert_eq!([-10.0, -2.5, 0.0].map(tick), ["10⁻¹⁰", "", "1"]);
        let svg = figure("Replay \u{1}", vec![("velocity\u{1b}".into(), points)]);
        assert!(svg.starts_with("<svg") && svg.contains("velocity\\u{1b}"), "{svg}");
        assert!(svg.chars().all(|c| matches!(c, '\n' | '\t') || !c.is_control()), "{svg}");
    }
}
