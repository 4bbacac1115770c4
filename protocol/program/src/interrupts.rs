//! Signals that end a run in order.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::failure::Failure;
use crate::orphan::PARENT_DIED;

/// Ctrl-C, SIGTERM and SIGHUP (a terminal that closes) as a count. The first ends the run in order, as the
/// death of the `bedload` that started this program does. A SIGHUP that is ignored from the start, as under
/// `nohup`, stays ignored.
#[derive(Clone, Debug)]
pub struct Interrupts(Arc<AtomicUsize>);

impl Interrupts {
    /// Listens from now on. Signal number `last` ends the process at once, with code 130.
    ///
    /// # Errors
    /// [`Failure::Run`] if a handler cannot be set.
    pub fn listen(last: usize) -> Result<Self, Failure> {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        let count = Arc::new(AtomicUsize::new(0));
        let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, PARENT_DIED.as_raw()])
            .and_then(|signals| {
                if !ignores_hangups() {
                    signals.add_signal(SIGHUP)?;
                }
                Ok(signals)
            })
            .map_err(|error| Failure::Run(format!("cannot handle signals: {error}")))?;
        let shared = count.clone();
        let listener = move || {
            for signal in signals.forever() {
                if signal == PARENT_DIED.as_raw() {
                    // A terminal sends its signal to the parent and to this process: one interrupt.
                    shared.fetch_max(1, Ordering::SeqCst);
                } else if shared.fetch_add(1, Ordering::SeqCst) + 1 >= last {
                    std::process::exit(130);
                }
            }
        };
        std::thread::Builder::new()
            .spawn(listener)
            .map_err(|error| Failure::Run(format!("cannot start a thread for signals: {error}")))?;
        Ok(Self(count))
    }

    /// Listens to nothing: for a run inside another program.
    pub fn never() -> Self {
        Self(Arc::default())
    }

    /// Signals so far.
    pub fn count(&self) -> usize {
        self.0.load(Ordering::SeqCst)
    }
}

/// Does this process ignore SIGHUP, as under `nohup`?
pub fn ignores_hangups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}
