//! What can be wrong with an input, and how it is said.

use thiserror::Error;

/// A [`crate::DemSpec`] that cannot be run.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SpecError {
    /// A value of one grain is out of range.
    #[error("grain {grain}: {quantity} is {value}; it must be {allowed}")]
    Grain { grain: usize, quantity: &'static str, value: f64, allowed: &'static str },
    /// A value of one wall is out of range.
    #[error("wall {wall}: {quantity} is {value}; it must be {allowed}")]
    Wall { wall: usize, quantity: &'static str, value: f64, allowed: &'static str },
    /// A parameter of a model is out of range.
    #[error("{model}: {quantity} is {value}; it must be {allowed}")]
    Model { model: &'static str, quantity: &'static str, value: f64, allowed: &'static str },
    /// Two images of one pair would be in reach at once, or a grain's own image.
    #[error(
        "the period along {axis} is {length} m; allowed: {least} m and more, twice the reach of a pair (the two \
         largest radii, and how far forces act beyond them) and once that of a grain to its own image; lengthen \
         the period"
    )]
    Period { axis: &'static str, length: f64, least: f64 },
    /// Two choices that exclude each other.
    #[error("{0}")]
    Combination(&'static str),
    /// A parameter without which a model cannot be.
    #[error("{model}: {quantity} is missing; give it, or {instead}")]
    Missing { model: &'static str, quantity: &'static str, instead: &'static str },
    /// A choice, by the key of the scene, that bodies that are not round do not allow.
    #[error("{why}")]
    Body { key: &'static str, why: &'static str, remedy: &'static str },
    /// The bulk engine was asked for where it cannot do the work.
    #[error("the bulk engine cannot run this: {0}; choose Engine::Auto or Engine::General")]
    Engine(String),
}

impl SpecError {
    /// Refuses the first parameter of `model` that is not positive and finite.
    pub(crate) fn unless_positive(model: &'static str, values: &[(&'static str, f64)]) -> Result<(), Self> {
        let bad = values.iter().find(|(_, value)| !(*value > 0.0 && value.is_finite()));
        let allowed = "positive and finite";
        bad.map_or(Ok(()), |&(quantity, value)| Err(Self::Model { model, quantity, value, allowed }))
    }

    /// Refuses the first parameter of `model` that is negative or not finite.
    pub(crate) fn if_negative(model: &'static str, values: &[(&'static str, f64)]) -> Result<(), Self> {
        let bad = values.iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite()));
        let allowed = "zero or positive, and finite";
        bad.map_or(Ok(()), |&(quantity, value)| Err(Self::Model { model, quantity, value, allowed }))
    }
}

/// A window that cannot be advanced; the state is untouched.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum AdvanceError {
    /// One load per grain, or none at all.
    #[error("{given} loads for {grains} grains; give one per grain, or none in a dry run")]
    LoadCount { given: usize, grains: usize },
    /// Window or number of sub-steps is not positive.
    #[error("window of {dt} s in {n_sub} sub-steps; both must be positive and finite")]
    Window { dt: f64, n_sub: u32 },
    /// A load is not a number, or an added mass is negative.
    #[error(
        "load on grain {grain}: {quantity} is {value}; loads must be finite, added mass and inertia not negative"
    )]
    Load { grain: usize, quantity: &'static str, value: f64 },
}

/// A [`crate::State`] that does not belong to this solver; the solver is untouched.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum RestoreError {
    /// An array has the wrong length.
    #[error(
        "the state holds {found} values of {quantity}, this scene needs {needed}; restore it with the scene \
         that wrote it"
    )]
    Length { quantity: &'static str, found: usize, needed: usize },
    /// A contact names a grain or wall that does not exist, or is out of order.
    #[error(
        "contact {index} of the state joins {first} and {second}, which this scene does not have in this \
         order; restore it with the scene that wrote it"
    )]
    Contact { index: usize, first: u32, second: u32 },
    /// The order of the grains is none.
    #[error("the order in the state does not hold each of {grains} grains once; take an earlier checkpoint")]
    Order { grains: usize },
    /// A value is not a number.
    #[error("the state holds a {quantity} of grain {grain} that is not finite; take an earlier checkpoint")]
    NotFinite { quantity: &'static str, grain: usize },
}
