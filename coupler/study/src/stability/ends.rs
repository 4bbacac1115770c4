//! Where a method ends: along y, for each panel and x.

use serde::Serialize;

use super::classify::Class;
use crate::table::grouped;
use crate::table::{Row, Table};

/// The end of a method at one x.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct End {
    /// Values of what varies besides the axes.
    pub(super) panel: String,
    pub(super) x: String,
    /// Largest y that is not stable.
    pub(super) last_bad: Option<f64>,
    /// Least y from which on all are stable.
    pub(super) first_good: Option<f64>,
}

/// Every panel and x whose y are numbers, in order of appearance.
pub(super) fn of(table: &Table, x: usize, y: usize) -> Vec<End> {
    let at = |row: &Row| (row.panel(x, y), row.values[x].clone());
    let ends = grouped(&table.rows, at).into_iter().filter_map(|((panel, x), rows)| {
        let heights: Option<Vec<(f64, bool)>> = rows
            .iter()
            .map(|row| Some((row.values[y].parse().ok()?, row.class == Some(Class::Stable))))
            .collect();
        let heights = heights?;
        let last_bad = heights.iter().filter(|(_, good)| !good).map(|(height, _)| *height).reduce(f64::max);
        let above = |height: &f64| last_bad.is_none_or(|bad| *height > bad);
        let first_good = heights.iter().map(|(height, _)| *height).filter(above).reduce(f64::min);
        Some(End { panel, x, last_bad, first_good })
    });
    ends.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stability_begins_above_the_last_that_fails() {
        let row = |y: &str, class| Row {
            values: ["kempe-froehlich-2012", "0.1", y].map(str::to_owned).to_vec(),
            class: Some(class),
            ..Row::default()
        };
        let rows = vec![
            row("4", Class::Stable),
            row("1", Class::Stable),
            row("2", Class::Oscillating),
            row("0.5", Class::Failed),
        ];
        let keys = ["form", "x", "y"].map(str::to_owned).to_vec();
        let table = Table { kind: crate::kind::Kind::Stability, keys, metrics: Vec::new(), rows };
        let end = of(&table, 1, 2);
        assert_eq!(end.len(), 1);
        assert_eq!((end[0].last_bad, end[0].first_good), (Some(2.0), Some(4.0)));
        assert_eq!((end[0].panel.as_str(), end[0].x.as_str()), ("kempe-froehlich-2012", "0.1"));
    }
}
