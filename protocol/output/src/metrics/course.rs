//! How far a column of `series.csv` is from a published course.

use serde::{Deserialize, Serialize};

use super::line::interpolate;
use crate::points::published_points;

/// The largest difference so far between a column and a published table, at the table's times.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Course {
    /// Time, s, and published value, in the order of time.
    table: Vec<(f64, f64)>,
    passed: usize,
    /// Time and value of the window before.
    before: Option<(f64, f64)>,
    largest: Option<f64>,
}

impl Course {
    /// A table with the columns `t` and `value`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let mut table = published_points(text, "t", "value")?;
        table.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self { table, passed: 0, before: None, largest: None })
    }

    /// Adds a window; rows between its ends are compared with the straight line through them. What the column
    /// was before the first window is not known.
    pub(super) fn add(&mut self, time: f64, value: f64) {
        while let Some((t, published)) = self.table.get(self.passed).filter(|(t, _)| *t <= time) {
            self.passed += 1;
            if let Some((earlier, then)) = self.before {
                let difference = (interpolate(*t, (earlier, then), (time, value)) - published).abs();
                // A NaN stays.
                let largest = self.largest.unwrap_or(0.0);
                self.largest = Some(if difference <= largest { largest } else { difference });
            }
        }
        self.before = Some((time, value));
    }

    /// The difference, if the run reached a row of the table.
    pub(super) fn value(&self) -> Result<f64, String> {
        self.largest.ok_or_else(|| {
            let first = self.table.first().map_or(0.0, |row| row.0);
            format!("the run saw no time of the table, which begins at t = {first} s")
        })
    }

    /// Whether the run reached the last row.
    pub(super) fn is_whole(&self) -> bool {
        self.passed == self.table.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_course_differs_from_its_table_by_what_was_added() {
        let table = vec![(0.0, 5.0), (1.05, 2.1 + 0.25), (2.0, 4.0 - 0.5), (9.0, 0.0)];
        let mut course = Course { table, passed: 0, before: None, largest: None };
        assert!(course.value().is_err());
        for k in 1..=30 {
            let t = 0.1 * f64::from(k);
            course.add(t, 2.0 * t);
        }
        assert!((course.value().expect("two rows passed") - 0.5).abs() < 1e-12);
        assert!(!course.is_whole());
    }
}
