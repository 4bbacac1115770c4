//! How far a run is: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

const PLAIN_EVERY: Duration = Duration::from_secs(2);
const BAR_EVERY: Duration = Duration::from_millis(200);
/// Resolution of the bar.
const TICKS: f64 = 10_000.0;

#[derive(Debug)]
pub(crate) struct Progress {
    program: &'static str,
    bar: Option<ProgressBar>,
    from: f64,
    until: f64,
    /// Before the time left.
    most: &'static str,
    begin: Instant,
    shown_at: Instant,
}

impl Progress {
    /// Of a run of `program` from time `from` to `until`, s. One that `may_end_sooner` is promised at
    /// most the time left.
    pub(crate) fn new(program: &'static str, from: f64, until: f64, may_end_sooner: bool) -> Self {
        let most = if may_end_sooner { "at most " } else { "" };
        let bar = (std::io::stderr().is_terminal() && !protocol::loudness::is_quiet()).then(|| {
            let bar =
                ProgressBar::with_draw_target(Some(TICKS as u64), ProgressDrawTarget::stderr_with_hz(5));
            let template = format!("{{bar:30}} {{percent:>3}} %  {{msg}}  {most}{{eta}} left");
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style);
            }
            bar
        });
        let now = Instant::now();
        Self { program, bar, from, until, most, begin: now, shown_at: now }
    }

    /// The run is at `time`, s; `text` says more, and is asked for only where it is shown.
    pub(crate) fn print(&mut self, time: f64, text: impl FnOnce() -> String) {
        if self.shown_at.elapsed() < if self.bar.is_some() { BAR_EVERY } else { PLAIN_EVERY } {
            return;
        }
        self.shown_at = Instant::now();
        match &self.bar {
            Some(bar) => {
                bar.set_position((time / self.until * TICKS) as u64);
                bar.set_message(text());
            }
            None => {
                let begin = self.begin.elapsed().as_secs_f64();
                let left = begin * (self.until - time) / (time - self.from);
                protocol::tell!("{}: {}, {}{left:.0} s to go", self.program, text(), self.most);
            }
        }
    }

    /// Leaves the terminal in order.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
