//! The contract from outside: the exchange over shared memory, and its log.

mod channel;
mod checkpoint;
mod log;
mod new_file;
