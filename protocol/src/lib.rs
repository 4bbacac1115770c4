//! Bedload's ground floor: the scene, the messages, the channels, the participant loop, the log.
//!
//! Solvers know this crate and nothing of each other.

pub mod alone;
pub mod channel;
pub mod checkpoint;
pub mod facts;
pub mod log;
pub mod message;
pub mod output;
pub mod participant;
pub mod program;
pub mod scene;
pub mod serve;
