//! A measured value against its reference.

use bedload_output::{MetricValue, Summary};

use super::formula;
use crate::make::Made;
use crate::runs::Outcome;
use crate::section::{Check, Expected, Rule, matches};
use crate::sweep::Point;
use crate::table::error;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comparison {
    Agrees,
    Differs,
    /// Outside by as much as is known.
    Misses,
    /// There should be a value to compare, and there is none.
    NoValue,
    Reported,
}

impl Comparison {
    pub(super) fn is_failure(self) -> bool {
        matches!(self, Self::Differs | Self::NoValue)
    }

    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Differs => "**DIFFERS**",
            Self::Misses => "misses, as known",
            Self::NoValue => "**NO VALUE**",
            Self::Reported => "reported",
        }
    }
}

/// One check of one run, or of the mean over several.
#[derive(Clone, Debug)]
pub(super) struct Line<'a> {
    pub(super) check: &'a Check,
    pub(super) label: &'a str,
    pub(super) value: Option<f64>,
    /// Of the mean over a run, or over runs.
    pub(super) standard_error: Option<f64>,
    pub(super) unit: String,
    pub(super) reference: Option<f64>,
    /// Relative; absolute where the reference is 0.
    pub(super) error: Option<f64>,
    pub(super) comparison: Comparison,
    /// What to know about the value, or why there is none.
    pub(super) note: Option<String>,
    /// Wall time of the run, or of all, s.
    pub(super) wall_s: Option<f64>,
}

/// Every check of every run that was made, in the order of the runs; a mean stands with its first run.
pub(super) fn lines<'a>(made: &Made<'a>) -> Vec<Line<'a>> {
    let mut rows = Vec::new();
    for (point, outcome) in made.runs() {
        let label = &point.label;
        for check in made.study.section.checks.iter().filter(|check| matches(&check.run, label)) {
            let all = || made.runs().filter(|(other, _)| matches(&check.run, &other.label));
            if check.mean && all().next().is_some_and(|(first, _)| first.label != *label) {
                continue;
            }
            let failed = |(run, outcome): (&Point, &Outcome)| match outcome {
                Outcome::Failed(why) => Some(format!("{}: {why}", run.label)),
                Outcome::Done(_) => None,
            };
            rows.push(match outcome {
                _ if check.mean => match all().find_map(failed) {
                    Some(why) => missing(check, &check.run, why),
                    None => {
                        line(check, &check.run, &all().filter_map(|(_, o)| o.summary()).collect::<Vec<_>>())
                    }
                },
                Outcome::Failed(why) => missing(check, label, why.clone()),
                Outcome::Done(summary) => line(check, label, &[summary]),
            });
        }
    }
    rows
}

/// Mean, and its standard error by the scatter: none of a single value.
pub(super) fn mean(values: &[f64]) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, (n > 1.0).then(|| (square / (n * (n - 1.0))).sqrt()))
}

fn missing<'a>(check: &'a Check, label: &'a str, why: String) -> Line<'a> {
    // Even a value that is only reported must be there: its run is part of the case.
    let comparison = Comparison::NoValue;
    let (value, standard_error, reference, error, wall_s) = (None, None, None, None, None);
    let (unit, note) = (String::new(), Some(why));
    Line { check, label, value, standard_error, unit, reference, error, comparison, note, wall_s }
}

/// The mean of a metric over runs, if all have it.
fn over(runs: &[&Summary], name: &str) -> Option<f64> {
    let value = |run: &&Summary| run.metrics.get(name).and_then(|metric| metric.value);
    Some(mean(&runs.iter().map(value).collect::<Option<Vec<_>>>()?).0)
}

/// The comparison of the mean over `runs`, or of a single one.
fn line<'a>(check: &'a Check, label: &'a str, runs: &[&Summary]) -> Line<'a> {
    let all: Vec<&MetricValue> = runs.iter().filter_map(|run| run.metrics.get(&check.metric)).collect();
    let (Some(first), true) = (all.first(), all.len() == runs.len()) else {
        let there = runs.iter().flat_map(|run| run.metrics.keys().map(String::as_str));
        let there: Vec<&str> = there.take(runs[0].metrics.len()).collect();
        return missing(check, label, format!("the scene has no such metric; it has {}", there.join(", ")));
    };
    let (reference, fault) = match reference(check, &|name| over(runs, name)) {
        Ok(reference) => (reference, None),
        Err(fault) => (None, Some(fault)),
    };
    let value = over(runs, &check.metric);
    let values: Vec<f64> = all.iter().filter_map(|metric| metric.value).collect();
    let standard_error = if runs.len() > 1 { mean(&values).1 } else { first.standard_error };
    let error = value.zip(reference).map(|(value, reference)| error(value, reference));
    let comparison = compare(check, value, error);
    let note = all.iter().find_map(|metric| metric.note.clone()).or(fault);
    let wall_s = Some(runs.iter().map(|run| run.cost.wall_s).sum());
    let unit = first.unit.clone();
    Line { check, label, value, standard_error, unit, reference, error, comparison, note, wall_s }
}

fn reference(check: &Check, value: &dyn Fn(&str) -> Option<f64>) -> Result<Option<f64>, String> {
    match &check.reference {
        None => Ok(None),
        Some(Expected::Number(number)) => Ok(Some(*number)),
        Some(Expected::Formula(text)) => formula::evaluate(text, value).map(Some),
    }
}

/// By how much a known miss may change, of itself.
const KNOWN: f64 = 0.25;

fn compare(check: &Check, value: Option<f64>, error: Option<f64>) -> Comparison {
    match (check.kind, value, error, check.tolerance) {
        (Rule::Reported, Some(_), ..) => Comparison::Reported,
        (Rule::Agrees, Some(_), Some(error), Some(tolerance)) if error.abs() <= tolerance => {
            Comparison::Agrees
        }
        (Rule::Misses, Some(_), Some(error), Some(_)) => {
            // Whoever mends a miss, or makes it worse, says so in the case.
            let known = check.known_error.unwrap_or(f64::NAN);
            if (error - known).abs() <= KNOWN * known.abs() {
                Comparison::Misses
            } else {
                Comparison::Differs
            }
        }
        (Rule::Agrees, Some(_), Some(_), Some(_)) => Comparison::Differs,
        _ => Comparison::NoValue,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(kind: Rule, reference: Option<f64>, tolerance: f64) -> Check {
        Check {
            run: "a".into(),
            metric: "m".into(),
            reference: reference.map(Expected::Number),
            tolerance: Some(tolerance),
            source: None,
            kind,
            known_error: None,
            mean: false,
        }
    }

    fn comparison(check: &Check, value: Option<f64>) -> Comparison {
        let reference = match check.reference {
            Some(Expected::Number(number)) => Some(number),
            _ => None,
        };
        compare(check, value, value.zip(reference).map(|(value, reference)| error(value, reference)))
    }

    #[test]
    fn only_values_within_their_tolerance_agree() {
        let compared = check(Rule::Agrees, Some(-20.0), 0.01);
        assert_eq!(comparison(&compared, Some(-20.19)), Comparison::Agrees);
        assert_eq!(comparison(&compared, Some(-19.79)), Comparison::Differs);
        assert_eq!(comparison(&compared, Some(20.0)), Comparison::Differs);
        assert_eq!(comparison(&compared, None), Comparison::NoValue);
        assert_eq!(comparison(&compared, Some(f64::NAN)), Comparison::Differs);
    }

    #[test]
    fn a_reference_of_zero_has_an_absolute_tolerance() {
        let none = check(Rule::Agrees, Some(0.0), 0.05);
        assert_eq!(comparison(&none, Some(0.04)), Comparison::Agrees);
        assert_eq!(comparison(&none, Some(0.06)), Comparison::Differs);
    }

    #[test]
    fn a_known_miss_must_stay_what_it_is() {
        let known = Check { known_error: Some(-0.04), ..check(Rule::Misses, Some(100.0), 0.03) };
        for (value, expected) in [
            (96.0, Comparison::Misses),
            (95.1, Comparison::Misses),
            (99.0, Comparison::Differs),
            (104.0, Comparison::Differs),
            (90.0, Comparison::Differs),
        ] {
            assert_eq!(comparison(&known, Some(value)), expected, "{value}");
        }
        assert!(comparison(&known, None).is_failure());
    }

    #[test]
    fn a_reported_value_cannot_fail_unless_it_is_missing() {
        assert_eq!(comparison(&check(Rule::Reported, Some(1.0), 0.01), Some(5.0)), Comparison::Reported);
        assert!(comparison(&check(Rule::Reported, None, 0.01), None).is_failure());
    }
}
