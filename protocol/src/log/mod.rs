//! The log of a run: an MCAP file with every message, enough by itself for a replay.
//!
//! Bytes, channels, times and how to read it from Python: `docs/exchange-log.md`. A run writes through a
//! [`Recorder`]; [`LogReader`] streams it back, [`replay`] drives a solver from it, [`repair`]
//! rewrites one that breaks off.

pub mod codec;

mod bytes;
mod difference;
mod error;
mod exchange;
mod manifest;
mod queue;
mod raw;
mod reader;
mod recorder;
mod repair;
mod replay;
mod schema;
mod sequence;
mod sink;
mod topic;
mod viewer;
mod windows;

pub use difference::{Difference, FieldDifference};
pub use error::{After, LogError, SequenceError};
pub use exchange::{LogExchange, Logged};
pub use manifest::Manifest;
pub use raw::{Channel, RawItem, RawMessage, RawReader, Schema, Sizes};
pub use reader::{Entry, LogReader, Message};
pub use recorder::{Recorder, RecorderOptions, RecorderStatistics};
pub use repair::{Repaired, flip_bit, repair};
pub use replay::{OnWindow, ReplayError, ReplayOptions, ReplayReport, StandIn, replay, replay_beside};
pub use sequence::{Sequence, nanoseconds};
pub use topic::{DATA_ENCODING, DATA_SCHEMA_ENCODING, Topic};
pub use viewer::{Decimation, FRAMES, MOST_PLOTTED, MOST_SPHERES, OPEN_RUN};
pub use windows::{LoggedWindow, Windows};
