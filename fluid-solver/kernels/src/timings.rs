//! Where the time goes, by the CPU clock: other programs on the machine do not count.

use crate::work::Work;

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

/// CPU time spent in each part, over all threads, summed over steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    spent: [f64; 4],
}

impl Timings {
    /// Adds the time since `begin` to `part`.
    pub fn add(&mut self, part: Part, begin: Work) {
        self.spent[part as usize] += begin.seconds();
    }

    /// Adds the time since `begin` to the solve of the pressure, which is part of the projection.
    pub fn add_pressure(&mut self, begin: Work) {
        let seconds = begin.seconds();
        self.spent[Part::Pressure as usize] += seconds;
        self.spent[Part::Projection as usize] += seconds;
    }

    /// CPU seconds spent in `part` so far.
    pub fn seconds(&self, part: Part) -> f64 {
        self.spent[part as usize]
    }
}
