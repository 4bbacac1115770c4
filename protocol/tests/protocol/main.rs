//! The contract from outside: the exchange over shared memory, and its log.

mod channel;
mod log;
