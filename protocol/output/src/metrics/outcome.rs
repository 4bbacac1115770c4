//! A value of a metric, perhaps with a remark, or why there is none.

/// What a metric comes to.
pub(super) type Outcome = Result<(f64, Option<&'static str>), String>;

/// A value without a remark.
pub(super) fn plain(value: f64) -> Outcome {
    Ok((value, None))
}

/// Why there is no value, unless a condition is met.
pub(super) fn require(met: bool, otherwise: &str) -> Result<(), String> {
    if met { Ok(()) } else { Err(otherwise.to_owned()) }
}
