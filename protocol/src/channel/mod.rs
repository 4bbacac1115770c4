//! The exchange of a coupled run over shared memory (iceoryx2 0.10).
//!
//! The coupler makes a [`Rendezvous`], founds the run with a [`CouplerLink`] and starts the
//! solvers; each joins with [`Wire::join`] and obeys in [`crate::serve::serve`]. Loads and
//! kinematics go from solver to solver; the coupler listens to the same topics.
//!
//! How a solver in another language joins (token, lock, node, services, ports, waiting) is told in
//! `docs/coupling.md`.
//!
//! # What a window costs
//!
//! `cargo run --release -p bedload-protocol --example exchange_cost` measures it. A receiver yields its core
//! for [`Rendezvous::spin_us`] before it sleeps, and drains events only just before sleeping, so that
//! notifying a process that is awake costs no system call. Where windows are long and even it naps by
//! its own timer until shortly before the message is due, so that it is awake then; the coupler, with
//! windows in hand, looks once a window instead of being woken. With [`Rendezvous::ahead`] > 1 the coupler
//! orders further windows while the solvers work, and no window waits for it.

mod coupler_link;
mod folder;
mod names;
mod observer;
mod outbox;
mod rendezvous;
mod solver;
mod space;
mod topics;
mod wake;
mod watch;

pub use coupler_link::CouplerLink;
pub use folder::remove_stale_runs;
pub use observer::{Event, Lent};
pub use rendezvous::{CONNECT_VARIABLE, Rendezvous, Waiting};
pub use solver::{Connection, Joined, Wire};
pub use topics::{GRAINS_ATTRIBUTE, LAYOUT_ATTRIBUTE, PROTOCOL_ATTRIBUTE};
pub use watch::Member;
