//! Bedload's contract: what a solver and the coupler say to each other, and how.
//!
//! Solvers know this crate and nothing of each other. Where to start:
//!
//! | to | see |
//! |---|---|
//! | write a solver | [`participant::Participant`], one window at a time |
//! | let it take part in a coupled run | [`serve::Invitation`] |
//! | know what crosses | [`message::Loads`], [`message::Kinematics`] |
//! | stop and go on | [`checkpoint::write()`], [`checkpoint::read()`] |
//! | read a recorded run | [`log::LogReader`] |
//! | tell the coupler about a solver before a run | [`facts::FluidFacts`], [`facts::DemFacts`] |
//!
//! The scene with all its checks is in the package `bedload-scene`; a solver of its own may read the few keys
//! that it needs instead, as `examples/minimal_dem.rs` does. Output folder, series, metrics and VTK files are
//! in the package `bedload-output`, the command line of a solver in `bedload-program`.

pub mod channel;
pub mod checkpoint;
pub mod checkpoints;
pub mod facts;
pub mod input_file;
pub mod log;
pub mod loudness;
pub mod memory;
pub mod message;
pub mod new_file;
pub mod participant;
pub mod printable;
pub mod scheme;
pub mod serve;

/// `eprintln!` that does not panic where nobody reads any more: a process whose reader has died still
/// has to leave in order, with its own exit code. What others say in it is made [`printable::printable`].
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => {{
        let text = format!("{}\n", format_args!($($text)*));
        let _ = std::io::Write::write_all(
            &mut std::io::stderr(),
            $crate::printable::printable(&text).as_bytes(),
        );
    }};
}

/// [`say!`] of news: not where the program is quiet.
#[macro_export]
macro_rules! tell {
    ($($text:tt)*) => {
        if !$crate::loudness::is_quiet() {
            $crate::say!($($text)*);
        }
    };
}

/// [`say!`] of details: only where the program is verbose.
#[macro_export]
macro_rules! detail {
    ($($text:tt)*) => {
        if $crate::loudness::is_verbose() {
            $crate::say!($($text)*);
        }
    };
}

/// `println!` of text that others may have written: made [`printable::printable`].
#[macro_export]
macro_rules! show {
    ($($text:tt)*) => {
        println!("{}", $crate::printable::printable(&format!($($text)*)))
    };
}
