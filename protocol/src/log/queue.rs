//! The bounded queue between a run and its recorder: one buffer fills while the other is written.
//!
//! Messages are encoded straight into the filling buffer, and the buffers change places, so nothing
//! is allocated once they have grown to what a flush period needs.

use super::topic::Topic;

/// Where one message ends in the buffer, and what it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) topic: Topic,
    pub(crate) sequence: u32,
    pub(crate) log_time: u64,
    pub(crate) publish_time: u64,
    end: usize,
}

/// Messages one after the other.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    pub(crate) bytes: Vec<u8>,
    frames: Vec<Frame>,
}

impl Batch {
    /// Ends the message whose bytes were just appended.
    pub(crate) fn close(&mut self, topic: Topic, sequence: u32, log_time: u64, publish_time: u64) {
        let end = self.bytes.len();
        self.frames.push(Frame { topic, sequence, log_time, publish_time, end });
    }

    /// Takes back bytes of a message that was not closed.
    pub(crate) fn undo(&mut self) {
        self.bytes.truncate(self.frames.last().map_or(0, |frame| frame.end));
    }

    /// Forgets all, keeping the room.
    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.frames.clear();
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (Frame, &[u8])> {
        let mut start = 0;
        self.frames.iter().map(move |frame| {
            let payload = &self.bytes[start..frame.end];
            start = frame.end;
            (*frame, payload)
        })
    }
}
