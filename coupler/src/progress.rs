//! How far the run is: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::bounds::Short;

const PLAIN_EVERY: Duration = Duration::from_secs(2);
/// Resolution of the bar.
const TICKS: f64 = 10_000.0;

/// Progress of a run.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    until: f64,
    begin: Instant,
    told: Instant,
}

impl Progress {
    /// Of a run to `until`.
    #[must_use]
    pub fn new(until: f64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar =
                ProgressBar::with_draw_target(Some(TICKS as u64), ProgressDrawTarget::stderr_with_hz(5));
            if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  {eta} left") {
                bar.set_style(style);
            }
            bar
        });
        let now = Instant::now();
        Self { bar, until, begin: now, told: now }
    }

    /// Window `step` has ended at `time`.
    pub fn tell(&mut self, step: u64, time: f64, substeps: u64) {
        if self.told.elapsed() < if self.bar.is_some() { PLAIN_EVERY / 10 } else { PLAIN_EVERY } {
            return;
        }
        self.told = Instant::now();
        let text =
            format!("t = {} of {} s, window {step}, {substeps} sub-steps", Short(time), Short(self.until));
        match &self.bar {
            Some(bar) => {
                bar.set_position((time / self.until * TICKS) as u64);
                bar.set_message(text);
            }
            None => protocol::say!("bedload: {text}, {:.0} s", self.begin.elapsed().as_secs_f64()),
        }
    }

    /// Leaves the terminal in order.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
