//! `chart.csv`: one row per run. All that a page needs stands in it and in the scene.

use serde::Serialize;

use crate::table::{self, Record, flag, number};
use coupler::number::rounded;

/// Columns behind those of the keys, `value` being one for each metric.
const COLUMNS: [&str; 13] = [
    "cpu_s",
    "wall_s",
    "error",
    "pareto",
    "label",
    "value",
    "cpu_s_min",
    "cpu_s_max",
    "wall_s_min",
    "wall_s_max",
    "repeats",
    "beside",
    "note",
];

/// Those before and behind the values.
const BEFORE: usize = 5;
const BEHIND: usize = 7;

/// Smaller errors are alike: they are drawn here, and none is on the front for being the smaller one.
pub(super) const FLOOR: f64 = 1e-6;

/// Least, median and largest of repeated timings, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Spread {
    pub(super) min: f64,
    pub(super) median: f64,
    pub(super) max: f64,
}

impl Spread {
    /// Of some timings; none of none.
    pub(super) fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let median = 0.5 * (values.get(count.checked_sub(1)? / 2)? + values.get(count / 2)?);
        Some(Self { min: values[0], median, max: values[count - 1] })
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Row {
    /// Its value of each varied key.
    pub(super) values: Vec<String>,
    pub(super) label: String,
    /// CPU time of fluid, DEM and coupler, s.
    pub(super) cpu: Option<Spread>,
    /// Wall time, s.
    pub(super) wall: Option<Spread>,
    /// Relative error; the largest of them where there are several metrics.
    pub(super) error: Option<f64>,
    /// Is no other run both as cheap and as exact?
    pub(super) pareto: bool,
    /// Value of each metric.
    pub(super) measured: Vec<Option<f64>>,
    /// Times it was made.
    pub(super) repeats: usize,
    /// Runs that shared the machine with it, at most.
    pub(super) beside: usize,
    /// Why there is no error, or what to know about it.
    pub(super) note: String,
}

/// All runs.
pub(super) type Table = table::Table<Row>;

/// Headers of the columns for these metrics; none of them where a curve is charted.
pub(super) fn columns(metrics: &[&str]) -> Vec<String> {
    let one = metrics.len() == 1;
    let named = |name: &&str| if one { "value".to_owned() } else { format!("value_{name}") };
    let fixed = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let values = metrics.iter().map(named).collect();
    [fixed(&COLUMNS[..BEFORE]), values, fixed(&COLUMNS[COLUMNS.len() - BEHIND..])].concat()
}

impl Table {
    /// Marks the rows that no other beats in both cost and error.
    pub(super) fn mark_front(&mut self) {
        let floored = |row: &Row| row.point().map(|(cost, error)| (cost, error.max(FLOOR)));
        let points: Vec<Option<(f64, f64)>> = self.rows.iter().map(floored).collect();
        for (row, point) in self.rows.iter_mut().zip(&points) {
            let beaten = |(cost, error): (f64, f64)| {
                let mut others = points.iter().flatten();
                others.any(|(c, e)| *c <= cost && *e <= error && (*c < cost || *e < error))
            };
            row.pareto = point.is_some_and(|point| !beaten(point));
        }
    }

    /// Rows of the front, cheapest first.
    pub(super) fn front(&self) -> Vec<usize> {
        let mut front: Vec<usize> = (0..self.rows.len()).filter(|row| self.rows[*row].pareto).collect();
        let cost = |row: &usize| self.rows[*row].cpu.map_or(f64::INFINITY, |cpu| cpu.median);
        front.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        front
    }

    /// The cheapest run whose error is at most `tolerance`.
    pub(super) fn cheapest(&self, tolerance: f64) -> Option<usize> {
        let within = |row: &usize| self.rows[*row].error.is_some_and(|error| error <= tolerance);
        self.front().into_iter().find(within)
    }

    /// A number in a row, if there is one.
    pub(super) fn number(&self, row: usize, column: usize) -> Option<f64> {
        self.rows[row].values[column].parse().ok().filter(|value: &f64| value.is_finite())
    }
}

impl Row {
    /// Cost and error, where both are known.
    pub(super) fn point(&self) -> Option<(f64, f64)> {
        Some((self.cpu?.median, self.error.filter(|error| error.is_finite())?))
    }

    /// Says one thing more, once.
    pub(super) fn add_note(&mut self, what: &str) {
        if !self.note.contains(what) {
            let joint = if self.note.is_empty() { "" } else { "; " };
            self.note += &format!("{joint}{what}");
        }
    }
}

impl Record for Row {
    fn values(&self) -> &[String] {
        &self.values
    }

    fn cells(&self) -> Vec<String> {
        let time = |spread: Option<Spread>, of: fn(&Spread) -> f64| short(spread.as_ref().map(of), 5);
        let (cpu, wall) = (self.cpu, self.wall);
        let mut cells = vec![
            time(cpu, |s| s.median),
            time(wall, |s| s.median),
            short(self.error, 6),
            u8::from(self.pareto).to_string(),
            self.label.clone(),
        ];
        cells.extend(self.measured.iter().map(|value| value.map_or_else(String::new, |v| v.to_string())));
        cells.extend([
            time(cpu, |s| s.min),
            time(cpu, |s| s.max),
            time(wall, |s| s.min),
            time(wall, |s| s.max),
        ]);
        cells.extend([self.repeats.to_string(), self.beside.to_string(), self.note.clone()]);
        cells
    }

    fn parse(values: Vec<String>, cells: &[String]) -> Result<Self, String> {
        let (first, rest) = cells.split_at(BEFORE);
        let (measured, last) = rest.split_at(rest.len() - BEHIND);
        let count = |text: &String| text.parse().map_err(|_| format!("has {text:?} where a count belongs"));
        let spread = |median: &str, min: &str, max: &str| -> Result<Option<Spread>, String> {
            let (median, min, max) = (number(median)?, number(min)?, number(max)?);
            Ok(median.zip(min.zip(max)).map(|(median, (min, max))| Spread { min, median, max }))
        };
        Ok(Self {
            values,
            cpu: spread(&first[0], &last[0], &last[1])?,
            wall: spread(&first[1], &last[2], &last[3])?,
            error: number(&first[2])?,
            pareto: flag(&first[3])?,
            label: first[4].clone(),
            measured: measured.iter().map(|text| number(text)).collect::<Result<_, _>>()?,
            repeats: count(&last[4])?,
            beside: count(&last[5])?,
            note: last[6].clone(),
        })
    }
}

/// A number of so many digits, or nothing.
fn short(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(String::new, |value| rounded(value, digits).to_string())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A table of one numeric key and a family, from cost and error (and value) of each run.
    pub(in crate::chart) fn table(points: &[(f64, &str, f64, f64)]) -> Table {
        let row = |(key, family, cost, error): &(f64, &str, f64, f64)| Row {
            values: vec![key.to_string(), (*family).to_owned()],
            label: format!("{family}-{key}"),
            cpu: Spread::of(vec![*cost]),
            wall: Spread::of(vec![*cost]),
            error: Some(*error),
            pareto: false,
            measured: vec![Some(1.0 + error)],
            repeats: 1,
            beside: 0,
            note: String::new(),
        };
        let mut table = Table {
            keys: vec!["resolution".to_owned(), "method".to_owned()],
            columns: columns(&["m"]),
            rows: points.iter().map(row).collect(),
        };
        table.mark_front();
        table
    }

    #[test]
    fn the_front_is_what_nothing_beats_in_both() {
        let mut table = table(&[
            (8.0, "a", 1.0, 0.04),
            (16.0, "a", 4.0, 0.01),
            (8.0, "b", 0.5, 0.04),  // beats the first
            (16.0, "b", 8.0, 0.01), // beaten by the second
            (32.0, "b", 9.0, 0.001),
        ]);
        assert_eq!(table.front(), [2, 1, 4]);
        assert_eq!([0.05, 0.02, 0.01, 1e-4].map(|t| table.cheapest(t)), [Some(2), Some(1), Some(1), None]);
        table.rows[4].error = Some(1e-9);
        table.rows[3].error = Some(1e-8);
        table.mark_front();
        assert_eq!(table.front(), [2, 1, 3], "neither has an error to speak of, and it is cheaper");
        table.rows[3].error = Some(0.01);
        table.rows[4].error = None;
        table.rows[1].error = Some(f64::NAN);
        table.mark_front();
        assert_eq!(table.front(), [2, 3], "a run without an error is on no front");
    }

    #[test]
    fn the_table_comes_back_from_its_file() {
        let mut before = table(&[(8.0, "a", 1.25, 0.0400001), (16.0, "b", 4.0, 0.01)]);
        before.rows[1].error = None;
        before.rows[1].cpu = None;
        before.rows[1].wall = None;
        before.rows[1].measured = vec![None];
        before.rows[1].note = "it broke; at once".to_owned();
        before.rows[0].error = Some(0.04);
        before.mark_front();
        let text = before.csv();
        assert!(
            text.starts_with("resolution,method,cpu_s,wall_s,error,pareto,label,value,cpu_s_min,"),
            "{text}"
        );
        assert!(text.contains("\n8,a,1.25,1.25,0.04,1,a-8,1.0400001,1.25,"), "{text}");
        let parse = |text: &str| Table::parse(text, &columns(&["m"]));
        assert_eq!(parse(&text), Ok(before));
        assert!(parse(&text.replace("wall_s,", "wall,")).is_err());
        assert!(parse(&text.replace("1.25,1.25", "x,1.25")).is_err());
    }

    #[test]
    fn a_spread_has_a_median() {
        let spread = Spread::of(vec![3.0, 1.0, 2.0]).unwrap();
        assert_eq!((spread.min, spread.median, spread.max), (1.0, 2.0, 3.0));
        assert_eq!(Spread::of(vec![1.0, 2.0]).map(|spread| spread.median), Some(1.5));
        assert_eq!(Spread::of(Vec::new()), None);
    }
}
