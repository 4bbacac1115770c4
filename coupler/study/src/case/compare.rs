//! A measured value against its reference.

use bedload_output::{MetricValue, Summary};

use super::formula;
use crate::make::Made;
use crate::runs::Outcome;
use crate::section::{Check, Expected, Rule, matches};
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

/// One check of one run.
#[derive(Clone, Debug)]
pub(super) struct Line<'a> {
    pub(super) check: &'a Check,
    pub(super) label: &'a str,
    pub(super) value: Option<f64>,
    pub(super) unit: String,
    pub(super) reference: Option<f64>,
    /// Relative; absolute where the reference is 0.
    pub(super) error: Option<f64>,
    pub(super) comparison: Comparison,
    /// What to know about the value, or why there is none.
    pub(super) note: Option<String>,
    /// Wall time of the run, s.
    pub(super) wall_s: Option<f64>,
}

/// Every check of every run that was made, in the order of the runs.
pub(super) fn lines<'a>(made: &Made<'a>) -> Vec<Line<'a>> {
    let mut rows = Vec::new();
    for (point, outcome) in made.runs() {
        let label = &point.label;
        for check in made.study.section.checks.iter().filter(|check| matches(&check.run, label)) {
            rows.push(match outcome {
                Outcome::Failed(why) => missing(check, label, why.clone()),
                Outcome::Done(summary) => line(check, label, summary),
            });
        }
    }
    rows
}

fn missing<'a>(check: &'a Check, label: &'a str, why: String) -> Line<'a> {
    // Even a value that is only reported must be there: its run is part of the case.
    let comparison = Comparison::NoValue;
    let (value, reference, error, wall_s) = (None, None, None, None);
    Line { check, label, value, unit: String::new(), reference, error, comparison, note: Some(why), wall_s }
}

fn line<'a>(check: &'a Check, label: &'a str, summary: &Summary) -> Line<'a> {
    let Some(metric) = summary.metrics.get(&check.metric) else {
        let there: Vec<&str> = summary.metrics.keys().map(String::as_str).collect();
        return missing(check, label, format!("the scene has no such metric; it has {}", there.join(", ")));
    };
    let (reference, fault) = match reference(check, summary) {
        Ok(reference) => (reference, None),
        Err(fault) => (None, Some(fault)),
    };
    let MetricValue { value, unit, note, .. } = metric.clone();
    let error = value.zip(reference).map(|(value, reference)| error(value, reference));
    let comparison = compare(check, value, error);
    let note = note.or(fault);
    Line { check, label, value, unit, reference, error, comparison, note, wall_s: Some(summary.cost.wall_s) }
}

fn reference(check: &Check, summary: &Summary) -> Result<Option<f64>, String> {
    match &check.reference {
        None => Ok(None),
        Some(Expected::Number(number)) => Ok(Some(*number)),
        Some(Expected::Formula(text)) => {
            let value = |name: &str| summary.metrics.get(name).and_then(|metric| metric.value);
            formula::evaluate(text, &value).map(Some)
        }
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
