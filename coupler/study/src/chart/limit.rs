//! Orders and limits of a refinement: Richardson's extrapolation, with Roache's uncertainty.

use crate::section::Finer;
use crate::table::Table;
use crate::table::grouped;

/// Safety factor of a grid convergence index from three grids (Roache 1994).
const SAFE: f64 = 1.25;

/// The same from two grids, or where no order is seen.
const SAFE_WITHOUT_ORDER: f64 = 3.0;

/// A larger observed order is not trusted to extrapolate with: no part of the solvers has more.
const LARGEST_ORDER: f64 = 2.0;

/// Nor a smaller one.
const SMALLEST_ORDER: f64 = 0.5;

/// Where a refinement leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    /// Extrapolated value.
    pub(super) value: f64,
    /// Observed order p; none where the three finest values do not go one way, ever slower.
    pub(super) order: Option<f64>,
    /// Grid convergence index of the finest value, in the unit of the value.
    pub(super) uncertainty: f64,
}

impl Limit {
    /// Uncertainty over the value; itself where that is 0.
    pub(super) fn relative_uncertainty(&self) -> f64 {
        self.uncertainty / if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }
}

/// Runs that differ in one key alone.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Refinement {
    /// Values of the other keys.
    pub(super) with: Vec<String>,
    /// Step h (1/value where larger is finer) and row, finest first.
    pub(super) rows: Vec<(f64, usize)>,
}

/// The limit of the three finest of some pairs (h, value), each h once. With the ratios of h alike
/// it is f₁ + (f₁ − f₂)/(r^p − 1), p = ln((f₃ − f₂)/(f₂ − f₁))/ln r.
pub(super) fn richardson(points: &[(f64, f64)]) -> Option<Limit> {
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.dedup_by(|a, b| a.0 == b.0);
    let [(h1, f1), (h2, f2), (h3, f3)] = *points.get(..3)? else { return None };
    let order = order([h1, h2, h3], [f1, f2, f3]);
    let p = order.map_or(1.0, |p| p.clamp(SMALLEST_ORDER, LARGEST_ORDER));
    let step = (f1 - f2) / ((h2 / h1).powf(p) - 1.0);
    let trusted = order.is_some_and(|p| p >= SMALLEST_ORDER);
    Some(Limit {
        value: if order.is_some() { f1 + step } else { f1 },
        order,
        uncertainty: step.abs() * if trusted { SAFE } else { SAFE_WITHOUT_ORDER },
    })
}

/// p in f = f₀ + c h^p: the root of (f₃ − f₂)/(f₂ − f₁) = (h₃^p − h₂^p)/(h₂^p − h₁^p), whose right
/// side grows with p.
fn order(h: [f64; 3], f: [f64; 3]) -> Option<f64> {
    let asked = (f[2] - f[1]) / (f[1] - f[0]);
    let ratio = |p: f64| (h[2].powf(p) - h[1].powf(p)) / (h[1].powf(p) - h[0].powf(p));
    let (mut low, mut high) = (0.05, 12.0);
    if !asked.is_finite() || asked < ratio(low) || asked > ratio(high) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < asked { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

/// Slope of ln(error) over ln(h), least squares; none without two errors.
pub(super) fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> =
        points.iter().filter(|(h, e)| *h > 0.0 && *e > 0.0).map(|(h, e)| (h.ln(), e.ln())).collect();
    let count = logs.len() as f64;
    let (x, y) = logs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let (xx, xy) =
        logs.iter().fold((0.0, 0.0), |(xx, xy), p| (xx + (p.0 - x).powi(2), xy + (p.0 - x) * (p.1 - y)));
    (logs.len() > 1 && xx > 0.0).then(|| xy / xx)
}

/// The way a key refines, if it is known to.
pub(super) fn refines(key: &str) -> Option<Finer> {
    match key.rsplit('.').next().unwrap_or(key) {
        "resolution" | "cells" | "D/dx" | "D/Δx" | "steps_per_contact" => Some(Finer::Larger),
        "dt" | "cfl" | "spacing" => Some(Finer::Smaller),
        _ => None,
    }
}

/// The refinements along a column: rows with the same values of all other keys, by their step.
pub(super) fn refinements(table: &Table, column: usize, finer: Finer) -> Vec<Refinement> {
    let step = |row: usize| {
        let value = table.number(row, column).filter(|value| *value > 0.0)?;
        Some((if finer == Finer::Larger { 1.0 / value } else { value }, row))
    };
    let steps: Vec<(f64, usize)> = (0..table.rows.len()).filter_map(step).collect();
    let others = |step: &(f64, usize)| {
        let mut with = table.rows[step.1].values.clone();
        with.remove(column);
        with
    };
    let refinement = |(with, rows): (Vec<String>, Vec<&(f64, usize)>)| {
        let mut rows: Vec<(f64, usize)> = rows.into_iter().copied().collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A single run may repeat a combination.
        rows.dedup_by(|a, b| a.0 == b.0);
        Refinement { with, rows }
    };
    grouped(&steps, others).into_iter().map(refinement).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::chart as table;

    #[test]
    fn the_order_and_limit_of_a_known_series_are_found() {
        for (p, c) in [(1.0, 0.3), (1.5, -2.0), (2.0, 0.7)] {
            let points = [5.0, 8.0, 10.0, 16.0].map(|n: f64| (1.0 / n, 19.6 + c * n.powf(-p)));
            let limit = richardson(&points).unwrap();
            assert!((limit.order.unwrap() - p).abs() < 1e-6, "{limit:?} for order {p}");
            assert!((limit.value - 19.6).abs() < 1e-9, "{limit:?}");
            // Roache: 1.25 times the difference between the finest value and the limit.
            let off = (c * 16.0_f64.powf(-p)).abs();
            assert!((limit.uncertainty - 1.25 * off).abs() < 1e-6, "{limit:?}");
            let errors = points.map(|(h, f)| (h, (f - 19.6).abs()));
            assert!((slope(&errors).unwrap() - p).abs() < 1e-9);
        }
    }

    #[test]
    fn a_series_without_an_order_gives_its_finest_value_and_a_wide_margin() {
        let swinging = [(0.1, 1.0), (0.2, 1.1), (0.4, 0.9)];
        let limit = richardson(&swinging).unwrap();
        assert_eq!((limit.value, limit.order), (1.0, None));
        assert!((limit.uncertainty - 0.3).abs() < 1e-12);
        let still = richardson(&[(0.1, 1.0), (0.2, 1.0), (0.4, 1.0)]).unwrap();
        assert_eq!((still.value, still.order, still.uncertainty), (1.0, None, 0.0));
        assert!(richardson(&swinging[..2]).is_none());
        assert!(richardson(&[(0.1, 1.0), (0.1, 1.0), (0.4, 1.0)]).is_none(), "each h once");
        assert_eq!(slope(&[(0.1, 1.0)]), None);
    }

    #[test]
    fn an_order_above_two_is_shown_but_not_used() {
        let points = [8.0, 16.0, 32.0].map(|n: f64| (1.0 / n, 1.0 + n.powi(-4)));
        let limit = richardson(&points).unwrap();
        assert!((limit.order.unwrap() - 4.0).abs() < 1e-6);
        let second = points[2].1 + (points[2].1 - points[1].1) / 3.0;
        assert!((limit.value - second).abs() < 1e-15);
    }

    #[test]
    fn refinements_are_told_apart_by_the_other_keys() {
        let table = table(&[
            (8.0, "a", 1.0, 0.04),
            (8.0, "b", 1.0, 0.05),
            (16.0, "a", 4.0, 0.01),
            (12.0, "a", 2.0, 0.02),
            (16.0, "b", 4.0, 0.02),
        ]);
        let found = refinements(&table, 0, Finer::Larger);
        assert_eq!(found.len(), 2);
        assert_eq!(
            (found[0].with.as_slice(), &found[0].rows),
            (&["a".to_owned()][..], &vec![(0.0625, 2), (1.0 / 12.0, 3), (0.125, 0)])
        );
        assert!(refinements(&table, 1, Finer::Larger).is_empty(), "names are no numbers");
    }
}
