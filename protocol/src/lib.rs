//! Bedload's ground floor: the scene, the messages, the channels, the participant loop, the log.
//!
//! Solvers know this crate and nothing of each other.

pub mod channel;
pub mod checkpoint;
pub mod facts;
pub mod log;
pub mod memory;
pub mod message;
pub mod participant;
#[cfg(feature = "scene")]
pub mod scene;
pub mod scheme;
pub mod serve;

/// `eprintln!` that does not panic where nobody reads any more: a process whose reader has died still
/// has to leave in order, with its own exit code.
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => {{
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("{}\n", format_args!($($text)*)));
    }};
}
