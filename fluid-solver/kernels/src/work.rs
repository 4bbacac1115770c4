//! The clock of solver work: CPU time of the process, all threads together.

use rustix::time::{ClockId, clock_gettime};

/// A stretch of work that goes on.
#[derive(Clone, Copy, Debug)]
pub struct Work(f64);

impl Work {
    /// Starts the clock.
    pub fn begin() -> Self {
        Self(now())
    }

    /// CPU seconds since the start.
    pub fn seconds(self) -> f64 {
        now() - self.0
    }
}

fn now() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
