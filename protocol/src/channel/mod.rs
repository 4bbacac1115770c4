//! The exchange of a coupled run over shared memory (iceoryx2 0.10).
//!
//! The coupler makes a [`Rendezvous`], founds the run with a [`CouplerLink`] and starts the
//! solvers; each joins with [`Wire::join`] and obeys in [`crate::serve::serve`]. Loads and
//! kinematics go from solver to solver; the coupler listens to the same topics.
//!
//! # How a solver in another language joins
//!
//! 1. **Token.** One line of JSON in the argument `--connect TOKEN` or in the environment variable
//!    `BEDLOAD_CONNECT`; its keys are the fields of [`Rendezvous`]. Refuse another `protocol` or
//!    `layout` than you were written for.
//! 2. **Lock.** Open `run.lock` in the folder `root` and hold it with `flock(LOCK_SH)` while you
//!    live. Whoever can take it exclusively is the last one and removes `/dev/shm/<prefix>*` and
//!    `root`; a process with a living node but without the lock is respected too.
//! 3. **Node.** iceoryx2 settings `global.root-path` = `root`, `global.prefix` = `prefix`, no
//!    clean-up of dead nodes (`global.node.cleanup-dead-nodes-on-creation`, `…-on-destruction`,
//!    `global.service.cleanup-dead-nodes-on-open` = false), signals not handled by iceoryx2; node
//!    name `fluid` or `dem`.
//! 4. **Services.** All exist already; open them, do not create. `ipc` variant, payload and user
//!    header as in `docs/coupling.md` (8-byte words, no padding). Type names are
//!    `protocol::message::` followed by the record's name.
//!
//!    | service | pattern | payload | user header | from → to |
//!    |---|---|---|---|---|
//!    | `bedload/command` | publish-subscribe | `Command` | none | coupler → solvers |
//!    | `bedload/loads` | publish-subscribe | `[Loads]`, one per grain | `Header` | fluid → DEM, coupler |
//!    | `bedload/kinematics` | publish-subscribe | `[Kinematics]`, one per grain | `Header` | DEM → fluid, coupler |
//!    | `bedload/status/fluid`, `bedload/status/dem` | publish-subscribe | `Status` | none | solver → coupler |
//!    | `bedload/wake/coupler`, `…/fluid`, `…/dem` | event, id 0 | | | whoever sent something → its owner |
//!
//!    Every publish-subscribe service carries the attributes `bedload.protocol` (decimal),
//!    `bedload.layout` (16 hexadecimal digits, [`crate::message::layout_hash`]) and
//!    `bedload.grains` (decimal): compare them before opening. There is one publisher per service,
//!    nothing overflows, nothing is kept for late comers.
//! 5. **Ports.** Create your publishers (`initial_max_slice_len` = `grains`), subscribers, your
//!    listener, and a notifier for each other process. Then wait until the topic you receive has a
//!    publisher and the topic you send has two subscribers, call `update_connections` on every
//!    port, and only then publish a `Status` with state `Ready`, `grains`, and the text
//!    `bedload <protocol> <layout>` ([`Rendezvous::greeting`]).
//! 6. **Loop.** Take commands in order and answer as [`crate::serve`] lists. In each window send
//!    your slice once and receive the other once; put step, attempt, time and dt of the command
//!    into the header, a DEM also its sub-steps. Check step, attempt and length of what you
//!    receive. After each message notify the wake-up service of its receiver (data: the other
//!    solver; status: the coupler).
//! 7. **Waiting.** Never wait without a limit and without looking, every 10 ms or so, whether the
//!    nodes `coupler` and your peer's are alive: nobody else tells you.
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
