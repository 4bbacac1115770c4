//! The processes that share one fluid: who there is, and what they tell each other.
//!
//! A [`Ranks`] is one of them, with a [`Link`] to the others: none ([`Ranks::alone`]), threads of this
//! process ([`threads`]) or what a program brings, as `bedload-fluid` brings MPI. All that is sent goes
//! through [`Ranks::exchange`], and what is combined is combined in the order of the ranks, so that no result
//! depends on their number.
//!
//! An exchange that fails does not interrupt a sweep: the failure is kept, everything after it is left
//! out, and [`Ranks::check`] tells it at the end of the window.

mod rank;
pub mod threads;

pub use rank::{Link, Ranks, Traffic, launched};
