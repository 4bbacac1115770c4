//! Where the time goes.

use std::time::{Duration, Instant};

/// A part of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Convection, explicit viscosity, pressure gradient, forces.
    Momentum,
    /// Implicit viscosity: one direct solve per component.
    Viscous,
    /// The projection as a whole.
    Projection,
    /// The direct solve of the pressure within it.
    Pressure,
}

/// Time spent in each part, summed over steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timings {
    spent: [Duration; 4],
}

impl Timings {
    /// Adds the time since `begin` to `part`.
    pub fn add(&mut self, part: Part, begin: Instant) {
        self.spent[part as usize] += begin.elapsed();
    }

    /// Seconds spent in `part` so far.
    pub fn seconds(&self, part: Part) -> f64 {
        self.spent[part as usize].as_secs_f64()
    }
}
