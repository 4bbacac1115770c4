//! Checks of single numbers.

pub(super) use crate::error::Check;
use crate::source::SceneSource;

pub(super) fn positive(source: &SceneSource, key: &str, value: f64) -> Check {
    source.refuse_if(
        !(value.is_finite() && value > 0.0),
        key,
        format_args!("is {value}; allowed: a finite number > 0"),
        "give a positive number in consistent units",
    )
}

pub(super) fn not_negative(source: &SceneSource, key: &str, value: f64) -> Check {
    source.refuse_if(
        !(value.is_finite() && value >= 0.0),
        key,
        format_args!("is {value}; allowed: a finite number ≥ 0"),
        "give zero or a positive number",
    )
}

pub(super) fn finite(source: &SceneSource, key: &str, values: &[f64]) -> Check {
    let Some(value) = values.iter().find(|value| !value.is_finite()) else { return Ok(()) };
    Err(source.error(key, format!("holds {value}; allowed: finite numbers"), "give finite numbers"))
}
