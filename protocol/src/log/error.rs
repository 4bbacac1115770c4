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
pub enum SequenceError {
    /// A window that does not follow.
    #[error("step gap: window {step} attempt {attempt} where window {expected} was expected")]
    Gap {
        /// Window that came.
        step: u64,
        /// Attempt that came.
        attempt: u64,
        /// What should have come, in words.
        expected: String,
    },
    /// A window ended without a message.
    #[error("step gap: window {step} attempt {attempt} has no {what}")]
    Missing {
        /// Window.
        step: u64,
        /// Attempt.
        attempt: u64,
        /// `loads` or `kinematics`.
        what: &'static str,
    },
    /// A message outside its window, or twice.
    #[error("{what} of window {step} attempt {attempt} {where_}")]
    Stray {
        /// Kind of message.
        what: &'static str,
        /// Its window.
        step: u64,
        /// Its attempt.
        attempt: u64,
        /// Where it was found.
        where_: String,
    },
    /// Another number of grains.
    #[error("{what} of window {step} have {found} grains, the scene has {expected}")]
    Grains {
        /// Kind of message.
        what: &'static str,
        /// Its window.
        step: u64,
        /// Number in the message.
        found: usize,
        /// Number in the manifest.
        expected: usize,
    },
    /// Time went backwards.
    #[error("window {step} begins at {time} s, before the window in front of it")]
    Time {
        /// Window.
        step: u64,
        /// Its start, s, as text (so that the error can be compared).
        time: String,
    },
    /// An order that this protocol does not know.
    #[error("command of window {step}: {what}")]
    Order {
        /// Window.
        step: u64,
        /// What is wrong.
        what: String,
    },
    /// More windows than an MCAP sequence number can count.
    #[error("window {step} is beyond 4294967295, the last that a log can number")]
    TooMany {
        /// Window.
        step: u64,
    },
}

/// Why a log could not be written or read. Cloneable, because a recorder's first error stays.
#[derive(Clone, Debug, thiserror::Error)]
pub enum LogError {
    /// The operating system refused.
    #[error("{file}: cannot {action} the log: {source}")]
    File {
        /// Name of the file.
        file: String,
        /// What was tried.
        action: &'static str,
        /// Cause.
        source: Arc<std::io::Error>,
    },
    /// The file stops before its end mark: the recorder was killed, or the disk was full.
    #[error(
        "{file}: the log breaks off at byte {offset}, {after} (no end mark): what stands before is good; \
         `bedload log repair` rewrites it"
    )]
    Truncated {
        /// Name of the file.
        file: String,
        /// Where the last whole record ends, bytes.
        offset: u64,
        /// Last step read.
        after: After,
    },
    /// Bytes differ from what was written.
    #[error(
        "{file}: the log is damaged in the record at byte {offset}, {after}: {what}{}; `bedload log \
         repair` keeps the rest",
        goes_on(*next)
    )]
    Damaged {
        /// Name of the file.
        file: String,
        /// Where the bad record begins, bytes.
        offset: u64,
        /// Last step read.
        after: After,
        /// What is wrong.
        what: String,
        /// Where the next chunk behind it begins, bytes; none if no chunk follows or none was looked for.
        next: Option<u64>,
    },
    /// Not a Bedload log.
    #[error("{file}: not a Bedload log: {what}")]
    NotALog {
        /// Name of the file.
        file: String,
        /// What is missing.
        what: String,
    },
    /// Written with another layout of messages.
    #[error(
        "{file}: written by Bedload {version} with protocol {theirs_version}, layout {theirs:016x}; this \
         build speaks protocol {PROTOCOL_VERSION}, layout {ours:016x}: replay it with the version that wrote \
         it (`bedload log info` works with any)"
    )]
    Layout {
        /// Name of the file.
        file: String,
        /// Version of Bedload that wrote it.
        version: String,
        /// Its protocol version.
        theirs_version: u64,
        /// Its layout hash.
        theirs: u64,
        /// Ours.
        ours: u64,
    },
    /// A step is missing, doubled or out of order, or a message has another number of grains.
    #[error("{file}: {source}{}", place(*offset))]
    Sequence {
        /// Name of the file.
        file: String,
        /// Where the message stands when read, bytes; none while recording.
        offset: Option<u64>,
        /// What is out of order.
        source: SequenceError,
    },
    /// The disk does not keep up with the run.
    #[error(
        "{file}: the queue of the recorder is full at step {step} ({limit} bytes not yet written): the disk \
         is too slow; record to a faster one or run with --no-record"
    )]
    QueueFull {
        /// Name of the file.
        file: String,
        /// First step that was not recorded.
        step: u64,
        /// Room of the queue, bytes.
        limit: usize,
    },
    /// The disk took longer than the deadline to finish.
    #[error(
        "{file}: the log was not finished within {seconds} s: the disk hangs; `bedload log repair` rewrites \
         what is there"
    )]
    Unfinished {
        /// Name of the file.
        file: String,
        /// Deadline, s.
        seconds: f64,
    },
    /// A value cannot be put in a log.
    #[error("{file}: cannot record {what}")]
    Value {
        /// Name of the file.
        file: String,
        /// What, and what is allowed.
        what: String,
    },
}

fn place(offset: Option<u64>) -> String {
    offset.map_or_else(String::new, |byte| format!(" (record at byte {byte})"))
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
    #[must_use]
    pub fn is_truncation(&self) -> bool {
        matches!(self, Self::Truncated { .. })
    }
}
