//! How long the windows of a solver alone are.

use protocol::participant::Window;

/// Sub-steps in a window of a DEM alone: short enough to observe, long enough to cost nothing.
const SUBSTEPS_ALONE: f64 = 100.0;

/// Steps of a solver alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Length of a window, s; of the first alone where the solver's own limit decides the others.
    pub window: f64,
    /// DEM sub-step, s (infinite for a fluid).
    pub substep: f64,
    /// Does the solver's own limit, once it is known, decide the length?
    pub adaptive: bool,
}

impl Clock {
    /// Of a DEM alone, that observes every `observed` seconds, or where that is 0 nothing within `until`.
    pub fn of_dem(substep: f64, observed: f64, until: f64) -> Self {
        let longest = if observed > 0.0 { observed } else { until };
        Self { window: (SUBSTEPS_ALONE * substep).min(longest), substep, adaptive: false }
    }

    /// The next window from `time`, ending at `until` at the latest; the last two share what is left, so that
    /// none is a sliver, over which the mean of a force means nothing.
    pub fn next(&self, step: u64, time: f64, until: f64, limit: f64, output: bool) -> Window {
        let wished = if self.adaptive && limit.is_finite() { limit } else { self.window };
        // A remainder of a few parts in 1e9 is rounding, not a window.
        let dt = match until - time {
            left if left <= wished * (1.0 + 1e-9) => left,
            left if left < wished * (2.0 - 1e-9) => 0.5 * left,
            _ => wished,
        };
        let substeps =
            if self.substep.is_finite() { (dt / self.substep * (1.0 - 1e-12)).ceil().max(1.0) } else { 1.0 };
        Window { step, attempt: 0, time, dt, substeps: substeps as u64, output }
    }
}
