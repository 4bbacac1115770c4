//! The log of a run: an MCAP file with every message, enough by itself for a replay.
//!
//! Bytes, channels, times and how to read it from Python: `docs/exchange-log.md`. A run writes through a
//! [`Recorder`]; [`LogReader`] streams it back, [`Comparison`] holds against it what a solver
//! sends in a replay (package `bedload-run`), [`repair`] rewrites one that is damaged.

pub mod codec;

mod bytes;
mod difference;
mod error;
mod manifest;
mod queue;
mod raw;
mod reader;
mod recorder;
mod records;
mod repair;
mod schema;
mod sequence;
mod sink;
mod topic;
mod viewer;
mod windows;

pub use difference::{Comparison, Difference, FieldDifference};
pub use error::{After, LogError, SequenceError};
pub use manifest::Manifest;
pub use raw::{Channel, RawItem, RawMessage, RawReader, Schema, Sizes};
pub use reader::{Entry, LogReader, Message};
pub use recorder::{Recorder, RecorderOptions, RecorderStatistics};
pub use records::{Logged, Records};
pub use repair::{Repaired, flip_bit, repair, thin};
pub use sequence::{Sequence, nanoseconds};
pub use topic::{DATA_ENCODING, DATA_SCHEMA_ENCODING, Topic};
pub use viewer::{FRAMES, MOST_PLOTTED, MOST_SPHERES, OPEN_RUN};
pub use windows::{LoggedWindow, Windows};
