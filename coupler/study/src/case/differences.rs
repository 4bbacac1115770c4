//! How far apart two runs of a case are, or means over runs: two columns of a table that they left.

use super::profile::profile;
use crate::make::Made;
use crate::section::Difference;
use crate::table::interpolated;
use coupler::failure::Failure;

/// A difference that could be measured.
pub(super) struct Measured<'a> {
    pub(super) wanted: &'a Difference,
    /// Largest difference over the largest value.
    pub(super) value: f64,
}

/// Every difference of which runs of both sides were made.
pub(super) fn measured<'a>(made: &Made<'a>) -> Result<Vec<Measured<'a>>, Failure> {
    let measure = |wanted| measure(made, wanted).transpose();
    made.study.section.differences.iter().filter_map(measure).collect()
}

fn measure<'a>(made: &Made<'_>, wanted: &'a Difference) -> Result<Option<Measured<'a>>, Failure> {
    let known = |runs: &str| profile(made, runs, &wanted.file, &wanted.x, &wanted.y);
    let [Some((a, _)), Some((b, _))] = [known(&wanted.runs[0])?, known(&wanted.runs[1])?] else {
        return Ok(None);
    };
    let within = wanted.within.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let what = |what: &str| {
        let (name, file, x) = (&wanted.name, wanted.file.display(), &wanted.x);
        Failure::Input(format!("case.differences: {name:?}: {file}: {x} {what}"))
    };
    if [&a, &b].iter().any(|points| points.windows(2).any(|pair| pair[0].0 > pair[1].0)) {
        return Err(what("does not ascend, so that there is no value between two rows"));
    }
    let value = largest(&a, &b, within);
    if value.is_nan() {
        Err(what("has no place that both sides share, or nothing there"))
    } else {
        Ok(Some(Measured { wanted, value }))
    }
}

/// Largest |a − b| at the places of `a` within a range, b interpolated, over the largest |b| there; NaN where
/// they share no place.
fn largest(a: &[(f64, f64)], b: &[(f64, f64)], [from, to]: [f64; 2]) -> f64 {
    let known = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
    };
    let (a, b) = (known(a), known(b));
    let inside = |x: &f64| (from..=to).contains(x);
    let pairs = a.iter().filter(|(x, _)| inside(x)).filter_map(|(x, y)| Some((y, interpolated(&b, *x)?)));
    let worst = pairs.map(|(y, other)| (y - other).abs()).reduce(f64::max);
    let scale = b.iter().filter(|(x, _)| inside(x)).map(|(_, y)| y.abs()).fold(0.0, f64::max);
    worst.map_or(f64::NAN, |worst| worst / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_is_taken_where_both_are_known() {
        let a: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i) + 0.5, f64::from(i) + 0.5)).collect();
        let mut b: Vec<(f64, f64)> = (0..7).map(|i| (f64::from(i), 1.1 * f64::from(i))).collect();
        b[6].1 = f64::NAN;
        // 0.1 × 4.5 over 1.1 × 5
        assert!((largest(&a, &b, [0.0, 9.0]) - 0.45 / 5.5).abs() < 1e-12);
        // 0.1 × 1.5 over 1.1 × 2
        assert!((largest(&a, &b, [0.0, 2.0]) - 0.15 / 2.2).abs() < 1e-12);
        assert!(largest(&a, &b, [20.0, 30.0]).is_nan());
    }
}
