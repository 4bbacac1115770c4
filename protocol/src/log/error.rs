//! What can be wrong with a log, on the way in and on the way out.

use std::fmt;
use std::sync::Arc;

use crate::message::PROTOCOL_VERSION;

/// The last step that was whole before an error, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct After(pub Option<u64>);

impl fmt::Display for After {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(step) => write!(f, "after step {step}"),
            None => f.write_str("before the first step"),
        }
    }
}

/// What is out of order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SequenceError {
    /// A window that does not follow.
    #[error("step gap: window {step} attempt {attempt} where window {expected} was expected")]
    Gap { step: u64, attempt: u64, expected: String },
    /// A window ended without a message.
    #[error("step gap: window {step} attempt {attempt} has no {what}")]
    Missing { step: u64, attempt: u64, what: &'static str },
    /// A message outside its window, or twice.
    #[error("{what} of window {step} attempt {attempt} {where_}")]
    Stray { what: &'static str, step: u64, attempt: u64, where_: String },
    /// Another number of grains.
    #[error("{what} of window {step} have {found} grains, the scene has {expected}")]
    Grains { what: &'static str, step: u64, found: usize, expected: usize },
    /// Time went backwards.
    #[error("window {step} begins at {time} s, before the window in front of it")]
    Time {
        step: u64,
        /// Its start, s, as text (so that the error can be compared).
        time: String,
    },
    /// An order that this protocol does not know.
    #[error("command of window {step}: {what}")]
    Order { step: u64, what: String },
    /// More windows than an MCAP sequence number can count.
    #[error("window {step} is beyond 4294967295, the last that a log can number")]
    TooMany { step: u64 },
}

/// Why a log could not be written or read. Cloneable, because a recorder's first error stays.
#[derive(Clone, Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum LogError {
    /// The operating system refused.
    #[error("{file}: cannot {action} the log: {source}")]
    File { file: String, action: &'static str, source: Arc<std::io::Error> },
    /// The file stops before its end mark: the recorder was killed, or the disk was full.
    #[error(
        "{file}: the log breaks off at byte {offset}, {after} (no end mark): {}",
        what_is_left(*offset)
    )]
    Truncated { file: String, offset: u64, after: After },
    /// Bytes differ from what was written.
    #[error(
        "{file}: the log is damaged in the record at byte {offset}, {after}: {what}{}; `bedload log \
         repair` keeps the rest",
        goes_on(*next)
    )]
    Damaged { file: String, offset: u64, after: After, what: String, next: Option<u64> },
    /// Not a Bedload log.
    #[error("{file}: not a Bedload log: {what}")]
    NotALog { file: String, what: String },
    /// Written with another layout of messages.
    #[error(
        "{file}: written by Bedload {version} with protocol {theirs_version}, layout {theirs:016x}; this \
         build speaks protocol {PROTOCOL_VERSION}, layout {ours:016x}: replay it with the version that wrote \
         it (`bedload log info` works with any)"
    )]
    Layout { file: String, version: String, theirs_version: u64, theirs: u64, ours: u64 },
    /// A step is missing, doubled or out of order, or a message has another number of grains.
    #[error("{file}: {source}{}", place(*offset))]
    Sequence { file: String, offset: Option<u64>, source: SequenceError },
    /// The disk does not keep up with the run.
    #[error(
        "{file}: the queue of the recorder is full at step {step} ({limit} bytes not yet written): the disk \
         is too slow; record to a faster one or run with --no-record"
    )]
    QueueFull { file: String, step: u64, limit: usize },
    /// The disk took longer than the deadline to finish.
    #[error(
        "{file}: the log was not finished within {seconds} s: the disk hangs; `bedload log repair` rewrites \
         what is there"
    )]
    Unfinished { file: String, seconds: f64 },
    /// A value cannot be put in a log.
    #[error("{file}: cannot record {what}")]
    Value { file: String, what: String },
}

fn place(offset: Option<u64>) -> String {
    offset.map_or_else(String::new, |byte| format!(" (record at byte {byte})"))
}

fn what_is_left(offset: u64) -> &'static str {
    match offset {
        0 => "nothing stands before, so that there is nothing to rewrite",
        _ => "what stands before is good; `bedload log repair` rewrites it",
    }
}

fn goes_on(next: Option<u64>) -> String {
    next.map_or_else(String::new, |byte| format!("; the log goes on at byte {byte}"))
}

impl LogError {
    /// The operating system's refusal to `action` the log `file`.
    pub(crate) fn io(file: &str, action: &'static str, source: std::io::Error) -> Self {
        Self::File { file: file.to_owned(), action, source: Arc::new(source) }
    }

    /// A failure of the MCAP writer, with the operating system's words where it has any.
    pub(crate) fn write(file: &str, error: mcap::McapError) -> Self {
        match error {
            mcap::McapError::Io(source) => Self::io(file, "write", source),
            other => Self::Value { file: file.to_owned(), what: other.to_string() },
        }
    }

    /// Whether the log merely breaks off: everything before is good.
    pub fn is_truncation(&self) -> bool {
        matches!(self, Self::Truncated { .. })
    }
}
