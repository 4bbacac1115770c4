//! The exchange of a coupled run over shared memory (iceoryx2).
mod conductor;
mod folder;
mod observer;
mod outbox;
mod rendezvous;
mod solver;
mod topics;
mod wake;
mod watch;

pub use conductor::ConductorLink;
pub use folder::remove_stale_runs;
pub use observer::{Event, Lent};
pub use rendezvous::{CONNECT_VARIABLE, Rendezvous, Waiting};
pub use solver::SharedMemory;
pub use topics::{GRAINS_ATTRIBUTE, LAYOUT_ATTRIBUTE, PROTOCOL_ATTRIBUTE, Wire};
pub use watch::Member;
