//! What the runs are compared with, and their errors.

use bedload_scene::Metric;

use super::limit::{self, Limit, Refinement};
use crate::section::{Finer, LimitOf, Reference, Section};
use crate::table::{Row, Table, error};
use crate::vary::text;

/// The reference of one metric.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Compared {
    pub(super) metric: String,
    pub(super) value: f64,
    /// How it was extrapolated, if it was: the limit, and from which refinement.
    pub(super) limit: Option<(Limit, Refinement)>,
    pub(super) source: Option<String>,
    /// Columns and values of the rows that it is for; none where it is for all.
    pub(super) rows: Vec<(usize, String)>,
}

impl Compared {
    fn is_for(&self, row: &Row) -> bool {
        self.rows.iter().all(|(column, value)| row.values[*column] == *value)
    }
}

/// The references of the charted metrics, in their order; none where a curve is charted.
pub(super) fn values(chart: &Section, metrics: &[Metric], table: &Table) -> Result<Vec<Compared>, String> {
    let of = |(place, name): (usize, &str)| {
        let own = metrics.iter().find(|metric| metric.name == name);
        let source = chart.source.clone();
        let known =
            |value, source| Compared { metric: name.to_owned(), value, source, ..Compared::default() };
        match &chart.reference {
            Some(Reference::Number(value)) => Ok(vec![known(*value, source)]),
            Some(Reference::Limit(of)) => {
                let limit = |rows: Vec<(usize, String)>| {
                    let (limit, refinement) = extrapolated(of, place, table, &rows)?;
                    let value = limit.value;
                    Ok(Compared { limit: Some((limit, refinement)), rows, ..known(value, source.clone()) })
                };
                // A case without a limit has rows without errors; where no case has one, none has.
                let (known, without): (Vec<_>, Vec<_>) =
                    cases(of, table)?.into_iter().map(limit).partition(Result::is_ok);
                match (known.is_empty(), without.into_iter().find_map(Result::err)) {
                    (true, Some(why)) => Err(why),
                    _ => known.into_iter().collect(),
                }
            }
            None => {
                let own = own.ok_or_else(|| format!("the scene has no metric {name}"))?;
                let value = own.reference.ok_or_else(|| format!("the metric {name} has no reference"))?;
                Ok(vec![known(value, source.or(own.source.clone()))])
            }
        }
    };
    let all: Result<Vec<Vec<Compared>>, String> = chart.metrics().into_iter().enumerate().map(of).collect();
    Ok(all?.concat())
}

fn column_of(table: &Table, key: &str) -> Result<usize, String> {
    table.keys.iter().position(|other| other == key).ok_or_else(|| format!("no key {key} is varied"))
}

/// The rows that share a limit: columns of `each` with their values.
fn cases(of: &LimitOf, table: &Table) -> Result<Vec<Vec<(usize, String)>>, String> {
    let columns: Result<Vec<usize>, String> = of.each.iter().map(|key| column_of(table, key)).collect();
    let columns = columns?;
    let mut cases: Vec<Vec<(usize, String)>> = Vec::new();
    for row in &table.rows {
        let case = columns.iter().map(|column| (*column, row.values[*column].clone())).collect();
        if !cases.contains(&case) {
            cases.push(case);
        }
    }
    Ok(cases)
}

/// The limit of metric `place` over the refinement that was asked for, among the rows of one case.
fn extrapolated(
    of: &LimitOf,
    place: usize,
    table: &Table,
    case: &[(usize, String)],
) -> Result<(Limit, Refinement), String> {
    let key = &of.richardson;
    let column = column_of(table, key)?;
    let finer = limit::refines(key).unwrap_or(Finer::Smaller);
    let wanted = |row: &Row| {
        case.iter().all(|(column, value)| row.values[*column] == *value)
            && of.with.iter().all(|(key, value)| {
                column_of(table, key).is_ok_and(|column| row.values[column] == text(value))
            })
    };
    let measured = |row: &Row| row.measured.get(place).copied().flatten();
    let mut refinements = limit::refinements(table, column, finer);
    for refinement in &mut refinements {
        refinement.rows.retain(|(_, row)| wanted(&table.rows[*row]) && measured(&table.rows[*row]).is_some());
    }
    let refinement = refinements.into_iter().find(|refinement| refinement.rows.len() >= 3);
    let refinement = refinement
        .ok_or_else(|| format!("no refinement of {key} has three runs with a value, so it has no limit"))?;
    let pair = |(h, row): &(f64, usize)| Some((*h, measured(&table.rows[*row])?));
    let pairs: Vec<(f64, f64)> = refinement.rows.iter().filter_map(pair).collect();
    let limit = limit::richardson(&pairs).ok_or("too few runs for a limit")?;
    Ok((limit, refinement))
}

/// Fills in the errors of the rows by their values; where there is no reference, says so in each.
pub(super) fn compare(table: &mut Table, known: &Result<Vec<Compared>, String>) {
    for row in &mut table.rows {
        match known {
            Err(why) => row.add_note(why),
            Ok(known) => {
                let known: Vec<&Compared> = known.iter().filter(|known| known.is_for(row)).collect();
                let off =
                    |(value, known): (&Option<f64>, &&Compared)| Some(error((*value)?, known.value).abs());
                if known.len() < row.measured.len() {
                    row.add_note(
                        "its case has no three runs of the refinement with a value, so it has no limit",
                    );
                    continue;
                }
                let errors: Option<Vec<f64>> = row.measured.iter().zip(&known).map(off).collect();
                row.error = errors.and_then(|errors| errors.into_iter().reduce(f64::max));
                // Where no order is seen the finest run is the limit, and cannot be compared with itself.
                let finest =
                    |known: &&Compared| known.limit.as_ref().is_some_and(|(limit, _)| limit.order.is_none());
                if row.error == Some(0.0) && known.iter().all(finest) {
                    row.error = None;
                    row.add_note("is itself the reference");
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::chart as table;

    #[test]
    fn several_metrics_give_their_largest_error() {
        let mut table = table(&[(8.0, "a", 1.0, 0.0), (16.0, "a", 2.0, 0.0)]);
        table.rows[0].measured = vec![Some(1.1), Some(-0.02)];
        table.rows[1].measured = vec![Some(1.1), None];
        let known = |metric: &str, value| Compared { metric: metric.into(), value, ..Compared::default() };
        compare(&mut table, &Ok(vec![known("m", 1.0), known("n", 0.0)]));
        assert!((table.rows[0].error.unwrap() - 0.1).abs() < 1e-12);
        assert_eq!(table.rows[1].error, None, "a value is missing");
        compare(&mut table, &Err("no limit".to_owned()));
        assert_eq!(table.rows[0].note, "no limit");
    }

    #[test]
    fn a_limit_is_taken_of_the_runs_asked_for() {
        let value = |n: f64, c: f64| c + 1.0 / (n * n);
        let points = [("a", 8.0), ("b", 8.0), ("a", 16.0), ("b", 16.0), ("a", 32.0), ("b", 32.0)];
        let points =
            points.map(|(family, n)| (n, family, 1.0, value(n, if family == "a" { 0.0 } else { 1.0 })));
        let table = table(&points); // values are 1 + these
        let text = "metric = \"m\"\nreference = { richardson = \"resolution\", with = { method = \"b\" } }\n";
        let mut chart: Section = toml::from_str(text).unwrap();
        let of = |chart: &Section| values(chart, &[], &table).map(|known| known[0].clone());
        let second = of(&chart).unwrap();
        assert!((second.value - 2.0).abs() < 1e-9, "{second:?}");
        assert_eq!(second.limit.unwrap().1.with, ["b"]);
        let read = |text: &str| toml::from_str::<Section>(text).unwrap().reference;
        chart.reference = read("reference = { richardson = \"resolution\" }");
        assert!((of(&chart).unwrap().value - 1.0).abs() < 1e-9, "the first refinement");
        chart.reference = read("reference = { richardson = \"method\" }");
        assert!(of(&chart).unwrap_err().contains("three runs"));
        chart.reference = read("reference = { richardson = \"resolution\", each = [\"method\"] }");
        let each = values(&chart, &[], &table).unwrap();
        let limits: Vec<f64> = each.iter().map(|known| known.value).collect();
        assert!((limits[0] - 1.0).abs() < 1e-9 && (limits[1] - 2.0).abs() < 1e-9, "{limits:?}");
        let mut table = table;
        compare(&mut table, &Ok(each));
        assert!(table.rows.iter().all(|row| row.error.unwrap() < 0.02), "each against its own limit");
    }
}
