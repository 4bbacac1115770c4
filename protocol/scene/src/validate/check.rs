//! Checks of single numbers.

use crate::error::SceneError;
use crate::source::SceneSource;

pub(super) type Check = Result<(), SceneError>;

pub(super) fn positive(source: &SceneSource, key: &str, value: f64) -> Check {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(source.error(
        key,
        format!("is {value}; allowed: a finite number > 0"),
        "give a positive number in consistent units",
    ))
}

pub(super) fn not_negative(source: &SceneSource, key: &str, value: f64) -> Check {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(source.error(
        key,
        format!("is {value}; allowed: a finite number ≥ 0"),
        "give zero or a positive number",
    ))
}

pub(super) fn finite(source: &SceneSource, key: &str, values: &[f64]) -> Check {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => {
            Err(source.error(key, format!("holds {value}; allowed: finite numbers"), "give finite numbers"))
        }
    }
}
