//! A file that grows beyond a limit is an error like a full disk, not the end of the process.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// From here on a write beyond the limit of a file's size (`ulimit -f`) fails, where the system would end the
/// process with SIGXFSZ.
pub fn fail_at_file_limit() {
    // Where the handler cannot be set, the system's way stays.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
}
