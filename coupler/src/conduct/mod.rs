//! A coupled run: the master of time.
//!
//! One window: order it, collect loads, kinematics and both reports, judge, record, observe, learn for
//! the next plan. Data go from solver to solver; what is read here is a second copy. With the iterated
//! scheme a window is ordered again, from its start, until the motion stays the same ([`crate::iterate`]).
//!
//! | file | what it holds |
//! |---|---|
//! | `conductor` | the state |
//! | `windows` | the loop: which window is ordered when, checkpoints, the stop |
//! | `collect`, `collected` | what the solvers send, put where it belongs |
//! | `verdict` | a window that is done: accepted, repeated, or the end of the run |
//! | `witness` | what a foreign DEM says, against what the coupler sees |
//! | `cause` | why a run ends early |
//! | `close` | costs, summary, children gone |

mod cause;
mod close;
mod collect;
mod collected;
mod conductor;
mod verdict;
mod windows;
mod witness;

pub(crate) use cause::{alive, explain};
pub(crate) use conductor::{Conductor, End};
