//! The cheapest setting of a chart that is exact enough.

/// Columns that refine: a run with more of it is finer.
const REFINE: [&str; 3] = ["resolution", "cells", "dem.steps_per_contact"];

/// A run of a chart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) label: String,
    /// CPU time, s.
    pub(super) cost: f64,
    /// Relative error.
    pub(super) error: f64,
    /// How fine it is.
    rung: f64,
    /// Values of what else was varied: runs that share them are one ladder.
    ladder: Vec<String>,
}

impl Row {
    /// The rows of a `chart.csv` that have an error and a cost, but for a run that is the reference itself: its
    /// error, 0, says nothing.
    pub(super) fn all(header: &[String], rows: &[Vec<String>]) -> Result<Vec<Self>, String> {
        let place = |name: &str| {
            header.iter().position(|column| column == name).ok_or_else(|| format!("has no column {name}"))
        };
        let (label, cost, error) = (place("label")?, place("cpu_s")?, place("error")?);
        let refining = header.iter().position(|column| REFINE.contains(&column.as_str()));
        let row = |cells: &Vec<String>| {
            let number = |place: usize| cells[place].parse::<f64>().ok().filter(|value| value.is_finite());
            // The varied keys stand before the costs.
            let others = (0..cost).filter(|column| Some(*column) != refining);
            Some(Self {
                label: cells[label].clone(),
                cost: number(cost)?,
                error: number(error).filter(|error| *error > 0.0)?,
                rung: refining.and_then(number).unwrap_or(0.0),
                ladder: others.map(|column| cells[column].clone()).collect(),
            })
        };
        Ok(rows.iter().filter_map(row).collect())
    }
}

/// The cheapest row whose error is at most `target`, and stays so in every finer run of its ladder: an error that is small
/// by chance does not count, nor does a row that no other one stands by. Else the least error of such a row.
pub(super) fn cheapest(rows: &[Row], target: f64) -> Result<&Row, f64> {
    let ladder = |row: &Row| rows.iter().filter(|other| other.ladder == row.ladder).collect::<Vec<_>>();
    let worst = |row: &Row| {
        let ladder = ladder(row);
        let finer = ladder.iter().filter(|other| other.rung >= row.rung);
        let worst = finer.map(|other| other.error).fold(row.error, f64::max);
        if ladder.len() > 1 { worst } else { f64::INFINITY }
    };
    let enough = rows.iter().filter(|row| worst(row) <= target);
    let best = || rows.iter().map(worst).fold(f64::INFINITY, f64::min);
    enough.min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or_else(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_that_is_exact_enough_on_its_whole_ladder_is_taken() {
        let line = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<_>>();
        let header = line("method,resolution,cpu_s,error,label");
        let rows = [
            "good,5,2.0,0.03,a",
            "good,8,4.0,0.01,b",
            "good,16,9.0,0.004,c",
            "lucky,5,1.0,0.2,d",
            "lucky,8,1.5,0.001,e",
            "lucky,16,3.0,0.3,f",
            "alone,8,0.5,0.001,h",
            "broken,8,1.0,,g",
            "good,32,20.0,0,the reference",
        ];
        let rows = Row::all(&header, &rows.map(line)).unwrap();
        assert_eq!(rows.len(), 7);
        assert_eq!(cheapest(&rows, 0.05).unwrap().label, "a");
        assert_eq!(cheapest(&rows, 0.02).unwrap().label, "b");
        assert_eq!(cheapest(&rows, 0.001), Err(0.004));
        assert!(Row::all(&line("x,error,label"), &[]).unwrap_err().contains("cpu_s"));
    }
}
