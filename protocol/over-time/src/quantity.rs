//! What may change over time: numbers and vectors.

use std::fmt::Debug;

use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A number, or a vector of a fixed number of them.
pub trait Quantity: Copy + PartialEq + Debug + Serialize + DeserializeOwned + JsonSchema + 'static {
    /// Nothing.
    const ZERO: Self;
    /// What a user writes for it.
    const NAME: &'static str;
    /// Columns of a file besides that of the time.
    const COLUMNS: &'static [&'static str];

    /// Its numbers.
    fn numbers(&self) -> &[f64];

    /// The same, to be changed.
    fn numbers_mut(&mut self) -> &mut [f64];

    /// Itself and `factor` times `other`.
    #[must_use]
    fn plus(&self, factor: f64, other: &Self) -> Self {
        let mut sum = *self;
        for (sum, other) in sum.numbers_mut().iter_mut().zip(other.numbers()) {
            *sum += factor * other;
        }
        sum
    }
}

impl Quantity for f64 {
    const ZERO: Self = 0.0;
    const NAME: &'static str = "a number";
    const COLUMNS: &'static [&'static str] = &["value"];

    fn numbers(&self) -> &[f64] {
        std::slice::from_ref(self)
    }

    fn numbers_mut(&mut self) -> &mut [f64] {
        std::slice::from_mut(self)
    }
}

macro_rules! vectors {
    ($($n:literal $columns:expr),*) => {$(
        impl Quantity for [f64; $n] {
            const ZERO: Self = [0.0; $n];
            const NAME: &'static str = concat!($n, " numbers");
            const COLUMNS: &'static [&'static str] = &$columns;

            fn numbers(&self) -> &[f64] {
                self
            }

            fn numbers_mut(&mut self) -> &mut [f64] {
                self
            }
        }
    )*};
}
vectors!(2 ["x", "z"], 3 ["x", "y", "z"]);

/// Length of a vector, size of a number.
pub fn length<T: Quantity>(value: &T) -> f64 {
    value.numbers().iter().map(|x| x * x).sum::<f64>().sqrt()
}
