//! `stability.csv`: one row per run, and what the rows say about the bound.

use std::path::Path;

use super::StabilityError;
use super::verdict::Verdict;
use crate::bounds::Short;
use crate::study::{SweepError, cell, parse_csv};

/// Columns behind those of the varied keys.
const FIXED: [&str; 6] = ["verdict", "growth", "bound_margin", "label", "note", "refused"];

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its values, one per varied key, as they stand in the table.
    pub values: Vec<String>,
    /// What became of it.
    pub verdict: Verdict,
    /// Growth of the alternation, 1/window; NaN where it cannot be told.
    pub growth: f64,
    /// Margin of the bound in its plan: below 1 it is broken; NaN where it does not apply.
    pub margin: f64,
    /// Folder of the run.
    pub label: String,
    /// Why it is not stable.
    pub note: String,
    /// Does `bedload check` refuse it, by the bound of the map?
    pub refused: bool,
}

/// The whole table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Headers of the varied keys.
    pub keys: Vec<String>,
    /// The runs.
    pub rows: Vec<Row>,
}

/// How verdicts and refusals go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

impl Table {
    /// The text of the file.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let keys = self.keys.iter().map(|key| cell(key));
        let mut text = keys.chain(FIXED.map(str::to_owned)).collect::<Vec<_>>().join(",") + "\n";
        for row in &self.rows {
            let mut cells: Vec<String> = row.values.iter().map(|value| cell(value)).collect();
            cells.extend([row.verdict.to_string(), digits(row.growth), digits(row.margin)]);
            cells.extend([cell(&row.label), cell(&row.note), u8::from(row.refused).to_string()]);
            text += &(cells.join(",") + "\n");
        }
        text
    }

    /// Reads a file of it.
    ///
    /// # Errors
    /// [`StabilityError`] with what does not fit.
    pub fn read(path: &Path) -> Result<Self, StabilityError> {
        let text = std::fs::read_to_string(path).map_err(SweepError::file("read", path))?;
        Self::parse(&text).map_err(|what| StabilityError::Content { path: path.to_owned(), what })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// Row and cell that do not fit.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (header, rows) = parse_csv(text)?;
        let keys = header.strip_suffix(FIXED.map(str::to_owned).as_slice());
        let keys = keys.ok_or_else(|| format!("does not end in the columns {}", FIXED.join(",")))?;
        let rows = rows.iter().enumerate().map(|(number, cells)| {
            row(cells, keys.len()).ok_or_else(|| format!("row {} is no run: {}", number + 1, cells.join(",")))
        });
        Ok(Self { keys: keys.to_vec(), rows: rows.collect::<Result<_, _>>()? })
    }
}

fn row(cells: &[String], keys: usize) -> Option<Row> {
    let (values, fixed) = cells.split_at_checked(keys)?;
    let [verdict, growth, margin, label, note, refused] = fixed else { return None };
    let number = |text: &String| if text.is_empty() { Some(f64::NAN) } else { text.parse().ok() };
    Some(Row {
        values: values.to_vec(),
        verdict: Verdict::parse(verdict)?,
        growth: number(growth)?,
        margin: number(margin)?,
        label: label.clone(),
        note: note.clone(),
        refused: match refused.as_str() {
            "0" => false,
            "1" => true,
            _ => return None,
        },
    })
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
        let table = Table { keys: vec!["form".into(), "nu_dt".into()], rows };
        let text = table.to_csv();
        assert!(text.starts_with("form,nu_dt,verdict,growth,bound_margin,label,note,refused\n"), "{text}");
        assert!(
            text.contains("yu-shao-fixed-point,0.024,failed,0.125,,form-yu-shao-fixed-point_0.024,grows,1\n"),
            "{text}"
        );
        let read = Table::parse(&text).unwrap();
        assert_eq!((&read.keys, read.rows.len(), read.rows[1].verdict), (&table.keys, 2, Verdict::Stable));
        assert!(read.rows[0].margin.is_nan() && read.to_csv() == text);
        assert!(Table::parse(&text.replace("failed", "broken")).unwrap_err().contains("row 1"));
        assert!(Table::parse("a,b\n").unwrap_err().contains("verdict,growth"));
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
