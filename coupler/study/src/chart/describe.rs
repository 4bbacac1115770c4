//! Runs and results in words, the same on the terminal, in the figure and on the page.

use serde::Serialize;

use super::limit;
use super::reference::Compared;
use crate::section::{Finer, Reference, Section};
use crate::table::{Row, Table};
use crate::vary::Vary;
use coupler::number::{Short, number, percent};

/// Errors that users ask for.
const TOLERANCES: [f64; 3] = [0.05, 0.02, 0.01];

/// Names of the varied keys for people, in the order of the columns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Names {
    names: Vec<String>,
    /// Is it varied? What only single runs change is known by their labels.
    varied: Vec<bool>,
    /// Labels of the single runs: they are called by them.
    singles: Vec<String>,
}

impl Names {
    pub(super) fn new(chart: &Section, table: &Table) -> Self {
        let varied = |key: &String| chart.vary.iter().find(|vary| vary.header() == key);
        let name = |key: &String| varied(key).map_or(key.as_str(), Vary::title).to_owned();
        Self {
            names: table.keys.iter().map(name).collect(),
            varied: table.keys.iter().map(|key| varied(key).is_some()).collect(),
            singles: chart.runs.iter().map(|run| run.label.clone()).collect(),
        }
    }

    pub(super) fn all(&self) -> &[String] {
        &self.names
    }

    /// A key with a value: `D/Δx 8`; a word needs no key beside it.
    pub(super) fn value(&self, column: usize, value: &str) -> String {
        let name = &self.names[column];
        match value {
            "" => format!("{name} by default"),
            word if word.parse::<f64>().is_err() && word.starts_with(char::is_alphabetic) => {
                if ["true", "false"].contains(&word) { format!("{name} {word}") } else { word.to_owned() }
            }
            other => format!("{name} {}", short(other)),
        }
    }

    /// A run in a few words.
    pub(super) fn of(&self, row: &Row) -> String {
        if self.singles.contains(&row.label) {
            return row.label.clone();
        }
        self.some(row.values.iter().enumerate())
    }

    /// Those of these columns and values that distinguish runs.
    fn some<'a>(&self, values: impl Iterator<Item = (usize, &'a String)>) -> String {
        let parts = values.filter(|(column, value)| !value.is_empty() && self.varied[*column]);
        parts.map(|(column, value)| self.value(column, value)).collect::<Vec<_>>().join(", ")
    }

    /// A run, key by key.
    pub(super) fn lines(&self, row: &Row) -> Vec<String> {
        let single = self.singles.contains(&row.label).then(|| row.label.clone());
        let shown = |(name, value): (&String, &String)| {
            format!("{name} = {}", if value.is_empty() { "default".to_owned() } else { short(value) })
        };
        single.into_iter().chain(self.names.iter().zip(&row.values).map(shown)).collect()
    }
}

/// A value as typed, with three digits where it has more than anybody reads.
fn short(value: &str) -> String {
    const READ: usize = 8;
    match value.parse::<f64>() {
        Ok(number) if value.len() > READ => format!("{:.3}", Short(number)),
        _ => value.to_owned(),
    }
}

/// The reference of each metric, in words.
pub(super) fn references(
    chart: &Section,
    names: &Names,
    known: &Result<Vec<Compared>, String>,
) -> Vec<String> {
    let known = match known {
        Ok(known) => known,
        Err(why) => return vec![format!("There are no errors: {why}.")],
    };
    let line = |known: &Compared| {
        let source = known.source.as_ref().map_or(String::new(), |source| format!(" ({source})"));
        let Some((limit, refinement)) = &known.limit else {
            return format!("Reference of {}: {}{source}.", known.metric, number(known.value));
        };
        let order = limit.order.map_or_else(
            || "no order seen, so it is the finest value itself".to_owned(),
            |order| format!("observed order {}", number(rounded(order))),
        );
        format!(
            "Reference of {}: {}, Richardson's limit of {} runs{}; {order}. Uncertainty of the finest run {} (grid \
             convergence index, Roache 1994): errors below say little{source}.",
            known.metric,
            number(known.value),
            refinement.rows.len().min(3),
            with(names, &refinement.with, column_of(chart, names)),
            percent(limit.relative_uncertainty()),
        )
    };
    let mut lines: Vec<String> = known.iter().map(line).collect();
    // Of cases with a limit each, the one that is known the least tells of all.
    if known.len() > 2 * chart.metrics().len() {
        let uncertainty =
            |known: &Compared| known.limit.as_ref().map_or(0.0, |(l, _)| l.relative_uncertainty());
        let worst =
            (0..known.len()).max_by(|a, b| uncertainty(&known[*a]).total_cmp(&uncertainty(&known[*b])));
        lines = worst.map(|worst| lines.swap_remove(worst)).into_iter().collect();
        let count = known.len() / chart.metrics().len();
        lines.insert(0, format!("Each of {count} cases has its own reference; the least certain of them:"));
    }
    lines
}

fn column_of(chart: &Section, names: &Names) -> Option<usize> {
    let Some(Reference::Limit(of)) = &chart.reference else { return None };
    let vary = chart.vary.iter().find(|vary| vary.header() == of.richardson)?;
    names.all().iter().position(|name| name == vary.title())
}

/// ` with wf 0.5, dt 0.01`: the other keys of a refinement along `column`.
fn with(names: &Names, values: &[String], column: Option<usize>) -> String {
    let Some(column) = column else { return String::new() };
    let place = |number: usize| if number < column { number } else { number + 1 };
    let parts = names.some(values.iter().enumerate().map(|(number, value)| (place(number), value)));
    if parts.is_empty() { parts } else { format!(" with {parts}") }
}

/// What one refinement shows of its order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Order {
    pub(super) key: String,
    /// The others.
    pub(super) with: String,
    pub(super) runs: usize,
    /// Slope of the errors, all runs; orders are rounded to hundredths.
    pub(super) of_errors: Option<f64>,
    /// Richardson's order of the three finest values, for one metric.
    pub(super) of_values: Option<f64>,
    /// Their limit, and its uncertainty over its value.
    limit: Option<f64>,
    uncertainty: Option<f64>,
}

/// The observed order along every key that refines, for each refinement of three runs and more.
pub(super) fn orders(chart: &Section, table: &Table, names: &Names) -> Vec<Order> {
    let mut orders = Vec::new();
    let asked = match &chart.reference {
        Some(Reference::Limit(of)) => Some(of.richardson.as_str()),
        _ => None,
    };
    for (column, key) in table.keys.iter().enumerate() {
        let own = (asked == Some(key)).then_some(Finer::Smaller);
        let Some(finer) = limit::refines(key).or(own) else { continue };
        for refinement in limit::refinements(table, column, finer) {
            if refinement.rows.len() < 3 {
                continue;
            }
            let errors: Vec<(f64, f64)> =
                refinement.rows.iter().filter_map(|(h, row)| Some((*h, table.rows[*row].error?))).collect();
            let value = |row: &Row| if let [value] = row.measured.as_slice() { *value } else { None };
            let values: Vec<(f64, f64)> =
                refinement.rows.iter().filter_map(|(h, row)| Some((*h, value(&table.rows[*row])?))).collect();
            let limit = limit::richardson(&values);
            orders.push(Order {
                key: names.all()[column].clone(),
                with: with(names, &refinement.with, Some(column)).trim_start_matches(" with ").to_owned(),
                runs: errors.len(),
                of_errors: limit::slope(&errors).map(rounded),
                of_values: limit.and_then(|limit| limit.order).map(rounded),
                limit: limit.map(|limit| limit.value),
                uncertainty: limit.map(|limit| limit.relative_uncertainty()),
            });
        }
    }
    orders
}

/// Two digits behind the point.
fn rounded(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}

/// The cheapest run within a tolerance.
#[derive(Serialize)]
pub(super) struct Cheapest {
    tolerance: f64,
    /// None: no run is exact enough.
    name: Option<String>,
    cost: Option<f64>,
    error: Option<f64>,
    /// Its cost over that of the paper's own setting, where that was run.
    over_baseline: Option<f64>,
}

/// For each of the tolerances.
pub(super) fn cheapest(chart: &Section, table: &Table, names: &Names) -> Vec<Cheapest> {
    let named = |label: &String| table.rows.iter().find(|row| row.label == *label);
    let baseline = chart.baseline.as_ref().and_then(named).and_then(|row| row.cpu).map(|cpu| cpu.median);
    let of = |tolerance: f64| {
        let found = table.cheapest(tolerance).map(|row| &table.rows[row]);
        let (cost, error) = found.and_then(Row::point).unzip();
        let both = cost.zip(baseline).filter(|(_, baseline)| *baseline > 0.0);
        let over_baseline = both.map(|(cost, baseline)| cost / baseline);
        Cheapest { tolerance, name: found.map(|row| names.of(row)), cost, error, over_baseline }
    };
    TOLERANCES.map(of).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::chart as table;

    const METHODS: &str = "[[vary]]\nname = \"method\"\nvalues = []\n";

    #[test]
    fn the_cheapest_is_told_over_the_papers_own_cost() {
        let table = table(&[(8.0, "a", 1.0, 0.04), (16.0, "a", 4.0, 0.015), (8.0, "paper", 8.0, 0.06)]);
        let chart = Section { baseline: Some("paper-8".to_owned()), ..Section::default() };
        let found = cheapest(&chart, &table, &Names::new(&chart, &table));
        let found: Vec<_> = found.iter().map(|c| (c.error, c.over_baseline)).collect();
        assert_eq!(found, [(Some(0.04), Some(0.125)), (Some(0.015), Some(0.5)), (None, None)]);
    }

    #[test]
    fn runs_are_named_by_their_keys() {
        let table = table(&[(8.0, "carried", 1.0, 0.04)]);
        let chart: Section = toml::from_str(&format!(
            "[[vary]]\nkey = \"resolution\"\nname = \"D/Δx\"\nvalues = [8]\n{METHODS}"
        ))
        .unwrap();
        let names = Names::new(&chart, &table);
        assert_eq!(names.of(&table.rows[0]), "D/Δx 8, carried");
        let single: Section = toml::from_str("[[vary]]\nkey = \"resolution\"\nvalues = [8]\n").unwrap();
        assert_eq!(Names::new(&single, &table).of(&table.rows[0]), "resolution 8");
        assert_eq!(names.lines(&table.rows[0]), ["D/Δx = 8", "method = carried"]);
        assert_eq!(names.value(0, ""), "D/Δx by default");
        assert_eq!(
            ["0.00043402777777777775", "0.0625", "carried"].map(short),
            ["4.34e-4", "0.0625", "carried"]
        );
    }

    #[test]
    fn orders_are_those_of_each_refinement() {
        let family = |name, p: f64| [8.0, 16.0, 32.0].map(|n: f64| (n, name, 1.0, n.powf(-p)));
        let points: Vec<_> = family("a", 1.0).into_iter().chain(family("b", 2.0)).collect();
        let table = table(&points);
        let chart: Section = toml::from_str(METHODS).unwrap();
        let orders = orders(&chart, &table, &Names::new(&chart, &table));
        assert_eq!(orders.len(), 2);
        for (order, (with, p)) in orders.iter().zip([("a", 1.0), ("b", 2.0)]) {
            assert_eq!((order.with.as_str(), order.runs), (with, 3));
            assert!((order.of_errors.unwrap() - p).abs() < 1e-9);
            assert!((order.of_values.unwrap() - p).abs() < 1e-6);
        }
    }
}
