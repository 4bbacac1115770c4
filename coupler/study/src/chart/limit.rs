//! Refinements of a table: how a key refines, and the slope of errors.

pub(super) use coupler::limit::{Limit, richardson};

use crate::section::Finer;
use crate::table::Table;
use crate::table::grouped;

/// Runs that differ in one key alone.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Refinement {
    /// Values of the other keys.
    pub(super) with: Vec<String>,
    /// Step h (1/value where larger is finer) and row, finest first.
    pub(super) rows: Vec<(f64, usize)>,
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
    fn the_slope_of_errors_is_their_order() {
        for p in [1.0, 1.5, 2.0] {
            let errors = [5.0, 8.0, 16.0].map(|n: f64| (1.0 / n, 0.7 * n.powf(-p)));
            assert!((slope(&errors).unwrap() - p).abs() < 1e-9);
        }
        assert_eq!(slope(&[(0.1, 1.0)]), None);
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
