//! A measured value against its reference.

use bedload_output::{MetricValue, Summary};

use super::case::{Check, Kind, Reference, matches};
use super::formula;
use super::runs::Made;
use crate::runs::Outcome;
use crate::table::error;

/// What a comparison says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Within the tolerance.
    Agrees,
    /// Outside.
    Differs,
    /// Outside by as much as is known.
    Misses,
    /// There should be a value to judge, and there is none.
    NoValue,
    /// Shown, not judged.
    Reported,
}

impl Verdict {
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
pub(super) struct Row<'a> {
    pub(super) check: &'a Check,
    pub(super) label: &'a str,
    pub(super) value: Option<f64>,
    pub(super) unit: String,
    pub(super) reference: Option<f64>,
    /// Relative; absolute where the reference is 0.
    pub(super) error: Option<f64>,
    pub(super) verdict: Verdict,
    /// What to know about the value, or why there is none.
    pub(super) note: Option<String>,
    /// Wall time of the run, s.
    pub(super) wall_s: Option<f64>,
}

/// Every check of every run that was made, in the order of the runs.
pub(super) fn rows<'a>(made: &Made<'a>) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    for (run, outcome) in made.runs() {
        for check in made.case.checks.iter().filter(|check| matches(&check.run, &run.label)) {
            match outcome {
                None => {}
                Some(Outcome::Failed(why)) => rows.push(missing(check, &run.label, why.clone())),
                Some(Outcome::Done(summary)) => rows.push(row(check, &run.label, summary)),
            }
        }
    }
    rows
}

fn missing<'a>(check: &'a Check, label: &'a str, why: String) -> Row<'a> {
    // Even a value that is only reported must be there: its run is part of the case.
    let verdict = Verdict::NoValue;
    let (value, reference, error, wall_s) = (None, None, None, None);
    Row { check, label, value, unit: String::new(), reference, error, verdict, note: Some(why), wall_s }
}

fn row<'a>(check: &'a Check, label: &'a str, summary: &Summary) -> Row<'a> {
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
    let verdict = judge(check, value, error);
    let note = note.or(fault);
    Row { check, label, value, unit, reference, error, verdict, note, wall_s: Some(summary.cost.wall_s) }
}

fn reference(check: &Check, summary: &Summary) -> Result<Option<f64>, String> {
    match &check.reference {
        None => Ok(None),
        Some(Reference::Number(number)) => Ok(Some(*number)),
        Some(Reference::Formula(text)) => {
            let value = |name: &str| summary.metrics.get(name).and_then(|metric| metric.value);
            formula::evaluate(text, &value).map(Some)
        }
    }
}

/// By how much a known miss may change, of itself.
const KNOWN: f64 = 0.25;

fn judge(check: &Check, value: Option<f64>, error: Option<f64>) -> Verdict {
    match (check.kind, value, error, check.tolerance) {
        (Kind::Reported, Some(_), ..) => Verdict::Reported,
        (Kind::Agrees, Some(_), Some(error), Some(tolerance)) if error.abs() <= tolerance => Verdict::Agrees,
        (Kind::Misses, Some(_), Some(error), Some(_)) => {
            // Whoever mends a miss, or makes it worse, says so in the case.
            let known = check.known_error.unwrap_or(f64::NAN);
            if (error - known).abs() <= KNOWN * known.abs() { Verdict::Misses } else { Verdict::Differs }
        }
        (Kind::Agrees, Some(_), Some(_), Some(_)) => Verdict::Differs,
        _ => Verdict::NoValue,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(kind: Kind, reference: Option<f64>, tolerance: f64) -> Check {
        Check {
            run: "a".into(),
            metric: "m".into(),
            reference: reference.map(Reference::Number),
            tolerance: Some(tolerance),
            source: None,
            kind,
            known_error: None,
        }
    }

    fn verdict(check: &Check, value: Option<f64>) -> Verdict {
        let reference = match check.reference {
            Some(Reference::Number(number)) => Some(number),
            _ => None,
        };
        judge(check, value, value.zip(reference).map(|(value, reference)| error(value, reference)))
    }

    #[test]
    fn only_values_within_their_tolerance_agree() {
        let judged = check(Kind::Agrees, Some(-20.0), 0.01);
        assert_eq!(verdict(&judged, Some(-20.19)), Verdict::Agrees);
        assert_eq!(verdict(&judged, Some(-19.79)), Verdict::Differs);
        assert_eq!(verdict(&judged, Some(20.0)), Verdict::Differs);
        assert_eq!(verdict(&judged, None), Verdict::NoValue);
        assert_eq!(verdict(&judged, Some(f64::NAN)), Verdict::Differs);
    }

    #[test]
    fn a_reference_of_zero_has_an_absolute_tolerance() {
        let none = check(Kind::Agrees, Some(0.0), 0.05);
        assert_eq!(verdict(&none, Some(0.04)), Verdict::Agrees);
        assert_eq!(verdict(&none, Some(0.06)), Verdict::Differs);
    }

    #[test]
    fn a_known_miss_must_stay_what_it_is() {
        let known = Check { known_error: Some(-0.04), ..check(Kind::Misses, Some(100.0), 0.03) };
        for (value, expected) in [
            (96.0, Verdict::Misses),
            (95.1, Verdict::Misses),
            (99.0, Verdict::Differs),
            (104.0, Verdict::Differs),
            (90.0, Verdict::Differs),
        ] {
            assert_eq!(verdict(&known, Some(value)), expected, "{value}");
        }
        assert!(verdict(&known, None).is_failure());
    }

    #[test]
    fn a_reported_value_cannot_fail_unless_it_is_missing() {
        assert_eq!(verdict(&check(Kind::Reported, Some(1.0), 0.01), Some(5.0)), Verdict::Reported);
        assert!(verdict(&check(Kind::Reported, None, 0.01), None).is_failure());
    }
}
