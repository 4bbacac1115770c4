//! `stability.csv`: one row per run, and what the rows say about the bound.

use std::path::Path;

use serde::{Serialize, Serializer};

use super::verdict::Verdict;
use crate::folder::{content, read};
use crate::table::{self, Record, flag, number};
use coupler::failure::Failure;
use coupler::number::Short;

const COLUMNS: [&str; 6] = ["verdict", "growth", "bound_margin", "label", "note", "refused"];

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its values, one per varied key, as they stand in the table.
    pub values: Vec<String>,
    /// What became of it.
    pub verdict: Verdict,
    /// Growth of the alternation, 1/window; NaN where it cannot be told.
    #[serde(serialize_with = "known")]
    pub growth: f64,
    /// Margin of the bound in its plan: below 1 it is broken; NaN where it does not apply.
    #[serde(serialize_with = "known")]
    pub margin: f64,
    /// Folder of the run.
    pub label: String,
    /// Why it is not stable.
    pub note: String,
    /// Does `bedload check` refuse it, by the bound of the map?
    pub refused: bool,
}

impl Row {
    /// Its values of all keys but those of the columns `x` and `y`: the panel of the map that it is in.
    pub(super) fn panel(&self, x: usize, y: usize) -> String {
        let others = self.values.iter().enumerate().filter(|(column, _)| *column != x && *column != y);
        let told = others.map(|(_, value)| value.as_str()).filter(|value| !value.is_empty());
        told.collect::<Vec<_>>().join(" · ")
    }
}

/// A number, or none in place of NaN.
fn known<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Some(*value).filter(|value| !value.is_nan()).serialize(serializer)
}

/// The whole table.
pub type Table = table::Table<Row>;

/// Headers of the columns behind those of the varied keys.
#[must_use]
pub fn columns() -> Vec<String> {
    COLUMNS.map(str::to_owned).into()
}

/// How verdicts and refusals go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Runs.
    pub runs: usize,
    /// Failed or oscillating, and refused.
    pub rightly_refused: usize,
    /// Stable, and accepted.
    pub rightly_accepted: usize,
    /// Failed, and accepted all the same: the bound is too weak.
    pub failed_accepted: usize,
    /// Oscillating, and accepted.
    pub oscillating_accepted: usize,
    /// Stable, and refused all the same.
    pub stable_refused: usize,
}

impl Counts {
    /// Of some rows.
    pub fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
        let mut counts = Self::default();
        for row in rows {
            counts.runs += 1;
            *match (row.verdict, row.refused) {
                (Verdict::Stable, false) => &mut counts.rightly_accepted,
                (Verdict::Stable, true) => &mut counts.stable_refused,
                (Verdict::Failed, false) => &mut counts.failed_accepted,
                (Verdict::Oscillating, false) => &mut counts.oscillating_accepted,
                (_, true) => &mut counts.rightly_refused,
            } += 1;
        }
        counts
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} runs: {} stable and accepted, {} failed or oscillating and refused; wrong: {} failed and accepted, \
             {} oscillating and accepted, {} stable and refused",
            self.runs,
            self.rightly_accepted,
            self.rightly_refused,
            self.failed_accepted,
            self.oscillating_accepted,
            self.stable_refused
        )
    }
}

/// The table of a file.
///
/// # Errors
/// [`Failure::Input`] with what does not fit.
pub fn read_table(path: &Path) -> Result<Table, Failure> {
    Table::parse(&read(path)?, &columns()).map_err(content(path))
}

impl Record for Row {
    fn values(&self) -> &[String] {
        &self.values
    }

    fn cells(&self) -> Vec<String> {
        let (growth, margin) = (digits(self.growth), digits(self.margin));
        let refused = u8::from(self.refused).to_string();
        vec![self.verdict.to_string(), growth, margin, self.label.clone(), self.note.clone(), refused]
    }

    fn parse(values: Vec<String>, cells: &[String]) -> Result<Self, String> {
        Ok(Self {
            values,
            verdict: Verdict::parse(&cells[0]).ok_or_else(|| format!("has no verdict {:?}", cells[0]))?,
            growth: number(&cells[1])?.unwrap_or(f64::NAN),
            margin: number(&cells[2])?.unwrap_or(f64::NAN),
            label: cells[3].clone(),
            note: cells[4].clone(),
            refused: flag(&cells[5])?,
        })
    }
}

/// Four digits; nothing where there is no number.
fn digits(value: f64) -> String {
    if value.is_nan() { String::new() } else { Short(value).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(verdict: Verdict, refused: bool) -> Row {
        Row {
            values: vec!["yu-shao-fixed-point".into(), "0.024".into()],
            verdict,
            growth: 0.125,
            margin: f64::NAN,
            label: "form-yu-shao-fixed-point_0.024".into(),
            note: "grows".into(),
            refused,
        }
    }

    #[test]
    fn a_table_comes_back_as_it_was_written() {
        let rows = vec![row(Verdict::Failed, true), row(Verdict::Stable, false)];
        let table = Table { keys: vec!["form".into(), "nu_dt".into()], columns: columns(), rows };
        let text = table.csv();
        assert!(text.starts_with("form,nu_dt,verdict,growth,bound_margin,label,note,refused\n"), "{text}");
        assert!(
            text.contains("yu-shao-fixed-point,0.024,failed,0.125,,form-yu-shao-fixed-point_0.024,grows,1\n"),
            "{text}"
        );
        let parse = |text: &str| Table::parse(text, &columns());
        let read = parse(&text).unwrap();
        assert_eq!((&read.keys, read.rows.len(), read.rows[1].verdict), (&table.keys, 2, Verdict::Stable));
        assert!(read.rows[0].margin.is_nan() && read.csv() == text);
        assert!(parse(&text.replace("failed", "broken")).unwrap_err().contains("row 1"));
        assert!(parse("a,b\n").unwrap_err().contains("verdict,growth"));
    }

    #[test]
    fn every_pair_of_verdict_and_refusal_is_counted_once() {
        let rows: Vec<Row> =
            Verdict::ALL.iter().flat_map(|verdict| [row(*verdict, false), row(*verdict, true)]).collect();
        let counts = Counts::of(&rows);
        assert_eq!((counts.runs, counts.rightly_refused, counts.rightly_accepted), (6, 2, 1));
        let wrong = (counts.failed_accepted, counts.oscillating_accepted, counts.stable_refused);
        assert_eq!(wrong, (1, 1, 1));
    }
}
