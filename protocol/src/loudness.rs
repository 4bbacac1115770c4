//! How much a program says on stderr: warnings and errors always ([`say!`](crate::say)), news unless it is
//! quiet ([`tell!`](crate::tell)), details where it is verbose ([`detail!`](crate::detail)).

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

static QUIET: AtomicBool = AtomicBool::new(false);
static VERBOSE: AtomicBool = AtomicBool::new(false);

/// As `--quiet` and `--verbose` ask, from here on.
pub fn set(quiet: bool, verbose: bool) {
    QUIET.store(quiet, Relaxed);
    VERBOSE.store(verbose, Relaxed);
}

/// Are only warnings and errors wanted?
pub fn is_quiet() -> bool {
    QUIET.load(Relaxed)
}

/// Are details wanted?
pub fn is_verbose() -> bool {
    VERBOSE.load(Relaxed)
}
