//! The recorder: copies a message at once, writes it later, in a thread that owns the file.
//!
//! It never slows a solver: a call encodes the message into a buffer and returns. What goes wrong
//! (the disk is full, does not keep up, a step is missing) becomes an error that stays: every later
//! call and [`Recorder::error`] return it, and what was written before remains a readable log.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::codec::{self, CodecError};
use super::error::{LogError, SequenceError};
use super::manifest::Manifest;
use super::queue::Batch;
use super::sequence::Sequence;
use super::sink::Sink;
use super::topic::Topic;
use super::viewer::Viewer;
use crate::message::{Command, Header, Kinematics, Loads, Status};
use crate::new_file::OwnFile;
use crate::participant::Role;

/// How a log is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecorderOptions {
    /// Bytes of messages after which a chunk is written, as the log begins; later more, so that the index
    /// stays small.
    pub chunk_bytes: usize,
    /// Time after which a chunk is written, however small, as the log begins: what a kill loses at most.
    pub flush_period: Duration,
    /// Room of the queue, bytes; 0: 64 MiB, or four windows where a window is larger than that.
    pub queue_bytes: usize,
    /// How long [`Recorder::finish`] waits for the disk.
    pub finish_deadline: Duration,
}

impl Default for RecorderOptions {
    fn default() -> Self {
        Self {
            chunk_bytes: 64 << 10,
            flush_period: Duration::from_millis(100),
            queue_bytes: 0,
            finish_deadline: Duration::from_secs(30),
        }
    }
}

/// Chunks of a log after which chunks and flush period double for the first time.
const CHUNKS: u64 = 4096;
/// Times that they double at most: chunks of 2 MiB, a flush after 3.2 s.
const DOUBLINGS: u32 = 5;

/// How large chunks are by now. The index that closes a log stays in memory until then, some 300 bytes for
/// each chunk. Chunks that grow with the log bound it: a kill loses 100 ms, or 1/2000 of the time recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pace {
    chunk_bytes: usize,
    flush_period: Duration,
    /// Chunks written, and number of them at which the next doubling comes.
    chunks: u64,
    next: u64,
}

impl Pace {
    fn new(options: RecorderOptions) -> Self {
        let RecorderOptions { chunk_bytes, flush_period, .. } = options;
        Self { chunk_bytes, flush_period, chunks: 0, next: CHUNKS }
    }

    /// One more chunk is written.
    fn count(&mut self) {
        self.chunks += 1;
        if self.chunks == self.next && self.next < CHUNKS * u64::from(DOUBLINGS + 1) {
            self.next += CHUNKS;
            self.chunk_bytes *= 2;
            self.flush_period *= 2;
        }
    }
}

/// What recording cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RecorderStatistics {
    /// Data messages taken.
    pub messages: u64,
    /// Bytes handed to the operating system.
    pub bytes: u64,
    /// Wall time inside `record_*` calls, s: what the caller paid.
    pub call_s: f64,
    /// Wall time of the recorder's thread at work, s (compressing and writing).
    pub write_s: f64,
}

/// What both threads see.
struct Shared {
    state: Mutex<State>,
    /// Wakes the writer: enough bytes, or closing.
    work: Condvar,
    done: Condvar,
    bytes: Arc<AtomicU64>,
}

struct State {
    filling: Batch,
    sequence: Sequence,
    error: Option<LogError>,
    closing: bool,
    done: bool,
    pace: Pace,
    statistics: RecorderStatistics,
}

impl Shared {
    /// A panic in one thread must not hide the log's state from the other.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Records a run. Callable from several threads; dropped without [`Recorder::finish`] it finishes
/// the file and forgets errors.
pub struct Recorder {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    file: String,
    options: RecorderOptions,
    room: usize,
    start: Instant,
}

impl Recorder {
    /// Creates the log file at `path` (an older one is replaced) and writes the manifest.
    ///
    /// # Errors
    /// [`LogError::File`] if the file cannot be created or written.
    pub fn create(path: &Path, manifest: &Manifest, options: RecorderOptions) -> Result<Self, LogError> {
        let name = path.display().to_string();
        // Under another name until its beginning is written: a process that is killed leaves no empty log. A
        // device keeps its name.
        let is_device = path.exists() && !path.is_file();
        let begun = if is_device { path.to_owned() } else { path.with_extension("begun") };
        let file = crate::new_file::new_file(&begun).map_err(|error| LogError::io(&name, "create", error))?;
        let recorder = Self::to_writer(OwnFile::new(file, 0), &name, manifest, options)?;
        if begun != path {
            std::fs::rename(&begun, path).map_err(|error| LogError::io(&name, "create", error))?;
        }
        Ok(recorder)
    }

    /// Records into any writer; `name` stands for the file in messages.
    ///
    /// # Errors
    /// [`LogError::File`] if the manifest cannot be written.
    pub fn to_writer<W: Write + Send + 'static>(
        inner: W,
        name: &str,
        manifest: &Manifest,
        options: RecorderOptions,
    ) -> Result<Self, LogError> {
        let viewer = Viewer::new(manifest);
        let bytes = Arc::new(AtomicU64::new(0));
        let sink = Sink::create(inner, name, manifest, bytes.clone())?;
        let shared = Arc::new(Shared {
            state: Mutex::new(State {
                filling: Batch::default(),
                sequence: Sequence::new(manifest),
                error: None,
                closing: false,
                done: false,
                pace: Pace::new(options),
                statistics: RecorderStatistics::default(),
            }),
            work: Condvar::new(),
            done: Condvar::new(),
            bytes,
        });
        let theirs = shared.clone();
        let start = Instant::now();
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || Thread { shared: theirs, viewer, start }.run(sink))
            .map_err(|error| LogError::io(name, "start a thread for", error))?;
        Ok(Self {
            shared,
            thread: Some(thread),
            file: name.to_owned(),
            room: room(options, manifest),
            options,
            start,
        })
    }

    /// Takes an order of the coupler.
    ///
    /// # Errors
    /// The first thing that went wrong, from then on; [`LogError::Sequence`] on a step gap.
    pub fn record_command(&self, command: &Command) -> Result<(), LogError> {
        let encode = |out: &mut Vec<u8>| codec::encode(command, out);
        self.take(Topic::Command, command.step, |s| s.command(command), encode)
    }

    /// Takes the loads of a window.
    ///
    /// # Errors
    /// As [`Recorder::record_command`].
    pub fn record_loads(&self, header: &Header, loads: &[Loads]) -> Result<(), LogError> {
        let check = |s: &mut Sequence| s.loads(header, loads.len());
        self.take(Topic::Loads, header.step, check, |out| codec::encode_slice(header, loads, out))
    }

    /// Takes the kinematics of a window.
    ///
    /// # Errors
    /// As [`Recorder::record_command`].
    pub fn record_kinematics(&self, header: &Header, kinematics: &[Kinematics]) -> Result<(), LogError> {
        let check = |s: &mut Sequence| s.kinematics(header, kinematics.len());
        self.take(Topic::Kinematics, header.step, check, |out| codec::encode_slice(header, kinematics, out))
    }

    /// Takes an answer of a solver.
    ///
    /// # Errors
    /// As [`Recorder::record_command`].
    pub fn record_status(&self, role: Role, status: &Status) -> Result<(), LogError> {
        let encode = |out: &mut Vec<u8>| codec::encode(&(role as u64, status), out);
        self.take(Topic::Status, status.step, |s| s.status(status), encode)
    }

    /// What went wrong, if anything did.
    pub fn error(&self) -> Option<LogError> {
        self.shared.lock().error.clone()
    }

    /// What recording has cost so far.
    pub fn statistics(&self) -> RecorderStatistics {
        let bytes = self.shared.bytes.load(Ordering::Relaxed);
        RecorderStatistics { bytes, ..self.shared.lock().statistics }
    }

    /// Writes what is queued, the index and the end mark.
    ///
    /// # Errors
    /// The first thing that went wrong in the whole recording, or [`LogError::Unfinished`] if the
    /// disk hangs.
    pub fn finish(mut self) -> Result<RecorderStatistics, LogError> {
        self.close()?;
        self.error().map_or_else(|| Ok(self.statistics()), Err)
    }

    fn close(&mut self) -> Result<(), LogError> {
        let Some(thread) = self.thread.take() else { return Ok(()) };
        let mut state = self.shared.lock();
        state.closing = true;
        self.shared.work.notify_one();
        let deadline = self.options.finish_deadline;
        let (state, waited) = self
            .shared
            .done
            .wait_timeout_while(state, deadline, |state| !state.done)
            .unwrap_or_else(PoisonError::into_inner);
        drop(state);
        if waited.timed_out() {
            // The thread sits in a write that does not return; it must not take the run with it.
            let seconds = deadline.as_secs_f64();
            return Err(LogError::Unfinished { file: self.file.clone(), seconds });
        }
        // `done` is set last, so this does not wait; a panic has become an error already.
        let _ = thread.join();
        Ok(())
    }

    /// Checks the order, encodes into the queue, wakes the writer when a chunk is full.
    fn take(
        &self,
        topic: Topic,
        step: u64,
        check: impl FnOnce(&mut Sequence) -> Result<(), SequenceError>,
        encode: impl FnOnce(&mut Vec<u8>) -> Result<(), CodecError>,
    ) -> Result<(), LogError> {
        let begin = Instant::now();
        let mut state = self.shared.lock();
        let state = &mut *state;
        if let Some(error) = &state.error {
            return Err(error.clone());
        }
        let before = state.filling.bytes.len();
        let taken = self.check_and_encode(state, step, check, encode);
        if let Err(error) = taken {
            state.filling.undo();
            state.error = Some(error.clone());
            return Err(error);
        }
        let now = begin.duration_since(self.start).as_nanos() as u64;
        // Checked by the sequence: a step that does not fit never gets here.
        let sequence = u32::try_from(step).unwrap_or(u32::MAX);
        state.filling.close(topic, sequence, state.sequence.clock(), now);
        let chunk = state.pace.chunk_bytes;
        if before < chunk && state.filling.bytes.len() >= chunk {
            self.shared.work.notify_one();
        }
        state.statistics.messages += 1;
        state.statistics.call_s += begin.elapsed().as_secs_f64();
        Ok(())
    }

    fn check_and_encode(
        &self,
        state: &mut State,
        step: u64,
        check: impl FnOnce(&mut Sequence) -> Result<(), SequenceError>,
        encode: impl FnOnce(&mut Vec<u8>) -> Result<(), CodecError>,
    ) -> Result<(), LogError> {
        let file = || self.file.clone();
        check(&mut state.sequence).map_err(|source| LogError::Sequence {
            file: file(),
            offset: None,
            source,
        })?;
        encode(&mut state.filling.bytes)
            .map_err(|error| LogError::Value { file: file(), what: error.to_string() })?;
        if state.filling.bytes.len() > self.room {
            return Err(LogError::QueueFull { file: file(), step, limit: self.room });
        }
        Ok(())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let _ = self.close();
    }
}

/// Room of the queue: a window must fit several times.
fn room(options: RecorderOptions, manifest: &Manifest) -> usize {
    let window = manifest.grains() * (size_of::<Loads>() + size_of::<Kinematics>());
    match options.queue_bytes {
        0 => (64 << 20).max(4 * window),
        bytes => bytes,
    }
}

/// The thread that owns the file.
struct Thread {
    shared: Arc<Shared>,
    viewer: Viewer,
    start: Instant,
}

impl Thread {
    fn run<W: Write>(mut self, sink: Sink<W>) {
        // Only a defect of this crate could panic here; the run must hear of it all the same.
        let work = std::panic::AssertUnwindSafe(|| self.record(sink));
        let result = std::panic::catch_unwind(work).unwrap_or_else(|_| {
            let what = "anything more: its thread panicked".to_owned();
            Err(LogError::Value { file: "recorder".to_owned(), what })
        });
        let mut state = self.shared.lock();
        if let Err(error) = result {
            state.error.get_or_insert(error);
        }
        // Nothing more will be written: let the buffer go.
        state.filling = Batch::default();
        state.done = true;
        drop(state);
        self.shared.done.notify_all();
    }

    /// Writes batches until the recorder closes or the disk refuses.
    fn record<W: Write>(&mut self, mut sink: Sink<W>) -> Result<(), LogError> {
        let mut batch = Batch::default();
        loop {
            let (closing, chunk_bytes) = self.next(&mut batch);
            let begin = Instant::now();
            for (frame, payload) in batch.iter() {
                self.write(&mut sink, frame, payload)?;
                if sink.open() >= chunk_bytes {
                    self.end_chunk(&mut sink)?;
                }
            }
            batch.clear();
            if closing {
                self.emit(&mut sink, u64::MAX)?;
                sink.finish()?;
                self.count(begin);
                return Ok(());
            }
            self.end_chunk(&mut sink)?;
            self.count(begin);
        }
    }

    fn end_chunk<W: Write>(&self, sink: &mut Sink<W>) -> Result<(), LogError> {
        if sink.flush()? {
            self.shared.lock().pace.count();
        }
        Ok(())
    }

    fn count(&self, begin: Instant) {
        self.shared.lock().statistics.write_s += begin.elapsed().as_secs_f64();
    }

    /// Waits for a chunk's worth, the flush period or the end, and takes what is there. Is it the end, and
    /// how long is a chunk?
    fn next(&self, batch: &mut Batch) -> (bool, usize) {
        let state = self.shared.lock();
        let Pace { chunk_bytes, flush_period, .. } = state.pace;
        let wait = |state: &mut State| !state.closing && state.filling.bytes.len() < chunk_bytes;
        let (mut state, _) = self
            .shared
            .work
            .wait_timeout_while(state, flush_period, wait)
            .unwrap_or_else(PoisonError::into_inner);
        std::mem::swap(&mut state.filling, batch);
        (state.closing, chunk_bytes)
    }

    fn write<W: Write>(
        &mut self,
        sink: &mut Sink<W>,
        frame: super::queue::Frame,
        payload: &[u8],
    ) -> Result<(), LogError> {
        if frame.topic == Topic::Command && codec::begins_window(payload) {
            self.emit(sink, frame.log_time)?;
        }
        self.viewer
            .watch(frame.topic, payload)
            .map_err(|error| LogError::Value { file: "viewer".to_owned(), what: error.to_string() })?;
        sink.write(frame.topic, frame.sequence, frame.log_time, frame.publish_time, payload)
    }

    /// Writes the frame of the window that has just ended, not later than `latest`.
    fn emit<W: Write>(&mut self, sink: &mut Sink<W>, latest: u64) -> Result<(), LogError> {
        let now = self.start.elapsed().as_nanos() as u64;
        self.viewer.emit(|topic, step, time, bytes| {
            let sequence = u32::try_from(step).unwrap_or(u32::MAX);
            // A solver may say any time in its header; the file's clock must not fall.
            let time = time.min(latest).max(sink.clock());
            sink.write(topic, sequence, time, now, bytes)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A day of flushes and ten million windows of 1.7 kB stay below 50,000 entries of the index, 15 MB.
    #[test]
    fn the_index_of_a_long_log_is_bounded() {
        let mut pace = Pace::new(RecorderOptions::default());
        let mut bytes = 0;
        while bytes < 17_000_000_000_usize {
            bytes += pace.chunk_bytes;
            pace.count();
        }
        assert!(pace.chunks < 50_000, "{pace:?}");
        let mut pace = Pace::new(RecorderOptions::default());
        let mut time = Duration::ZERO;
        while time < Duration::from_secs(86_400) {
            assert!(pace.flush_period <= Duration::from_millis(100).max(time / 2047));
            time += pace.flush_period;
            pace.count();
        }
        assert!(pace.chunks < 50_000, "{pace:?}");
    }
}
