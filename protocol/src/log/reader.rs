//! A log as typed messages, in order, each step accounted for.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

use super::codec::{self, CodecError};
use super::error::LogError;
use super::manifest::Manifest;
use super::raw::{Channel, Preface, RawItem, RawMessage, RawReader, Sizes};
use super::sequence::Sequence;
use super::topic::Topic;
use crate::message::{Command, Header, Kinematics, Loads, Status};
use crate::participant::Role;

/// A decoded payload.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// An order.
    Command(Command),
    /// Fluid → DEM.
    Loads(Header, Vec<Loads>),
    /// DEM → fluid.
    Kinematics(Header, Vec<Kinematics>),
    /// An answer.
    Status(Role, Box<Status>),
    /// A viewer's message, an unknown channel, or any message of another layout: bytes.
    Opaque(Vec<u8>),
}

/// A message and where it stands.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its channel, as the file declares it.
    pub channel: Arc<Channel>,
    /// Step number.
    pub step: u64,
    /// Simulated time, ns: the start of the window (viewer channels: its end).
    pub log_time: u64,
    /// Wall time since the recorder's start, ns.
    pub publish_time: u64,
    /// Where its chunk begins in the file, bytes.
    pub offset: u64,
    /// Bytes of the payload.
    pub size: usize,
    /// What it says.
    pub message: Message,
}

/// Streams a log. The first error ends it, unless it was opened with [`LogReader::open_any`].
///
/// ```no_run
/// use protocol::log::{LogReader, Message};
///
/// for entry in LogReader::open("out/exchange.mcap".as_ref())? {
///     let entry = entry?;
///     if let Message::Loads(header, loads) = entry.message {
///         println!("window {}: force on grain 0: {:?} N", header.step, loads[0].force);
///     }
/// }
/// # Ok::<(), protocol::log::LogError>(())
/// ```
pub struct LogReader {
    raw: RawReader,
    manifest: Manifest,
    /// None: another layout, payloads stay bytes.
    sequence: Option<Sequence>,
    log_time: u64,
    /// Whether it reads on behind damage.
    reads_on: bool,
    /// What was met already, and is given out next.
    ready: VecDeque<Result<Entry, LogError>>,
    ended: bool,
}

impl LogReader {
    /// Opens a log written with the layout of this build.
    ///
    /// # Errors
    /// [`LogError::File`], [`LogError::NotALog`], [`LogError::Layout`], or what is wrong with the
    /// beginning of the file.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        Self::strict(RawReader::open(path)?)
    }

    /// Opens a log to look at it. Written with another layout, payloads stay bytes and their order is not
    /// checked. An error is given out where it stands and the log goes on behind it: damage with the next
    /// chunk, a missing window with the next one. A scene that is damaged is empty.
    ///
    /// # Errors
    /// As [`LogReader::open`], without [`LogError::Layout`].
    pub fn open_any(path: &Path) -> Result<Self, LogError> {
        Self::new(RawReader::open(path)?, true)
    }

    /// Reads a log in memory; `name` stands for the file in messages.
    ///
    /// # Errors
    /// As [`LogReader::open`].
    pub fn from_bytes(bytes: Vec<u8>, name: &str) -> Result<Self, LogError> {
        Self::strict(RawReader::from_bytes(bytes, name))
    }

    fn strict(raw: RawReader) -> Result<Self, LogError> {
        let reader = Self::new(raw, false)?;
        reader.manifest.check_layout(reader.raw.name())?;
        Ok(reader)
    }

    fn new(mut raw: RawReader, reads_on: bool) -> Result<Self, LogError> {
        let Preface { facts, scene, errors, .. } = raw.preface();
        // Where damage may be met, a scene that is lost is empty.
        let Some((facts, scene)) = facts.zip(scene.or(reads_on.then(Vec::new))) else {
            let what = "it does not begin with a manifest".to_owned();
            let not_a_log = || LogError::NotALog { file: raw.name().to_owned(), what };
            return Err(errors.into_iter().next().unwrap_or_else(not_a_log));
        };
        let manifest = String::from_utf8(scene)
            .map_err(|error| format!("its scene is not text: {error}"))
            .and_then(|scene| Manifest::from_metadata(&facts, &scene))
            .map_err(|what| LogError::NotALog { file: raw.name().to_owned(), what })?;
        let ready = errors.into_iter().map(Err).collect();
        let ours = manifest.check_layout(raw.name()).is_ok();
        let sequence = ours.then(|| Sequence::new(&manifest));
        Ok(Self { raw, manifest, sequence, log_time: 0, reads_on, ready, ended: false })
    }

    /// What stands at the beginning of the log.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Name of the file.
    pub fn name(&self) -> &str {
        self.raw.name()
    }

    /// Sizes met so far.
    pub fn sizes(&self) -> Sizes {
        self.raw.sizes()
    }

    /// Whether the last window read has all its messages.
    pub fn is_complete(&self) -> bool {
        self.sequence.as_ref().is_none_or(Sequence::is_complete)
    }

    /// What a message says; beside it what is wrong with its order.
    fn entry(&mut self, raw: RawMessage) -> Result<(Entry, Option<LogError>), LogError> {
        if raw.log_time < self.log_time {
            let (now, before) = (raw.log_time, self.log_time);
            let what = format!("its time {now} ns is before the message in front of it, {before} ns");
            return Err(self.raw.damaged(raw.offset, what));
        }
        self.log_time = raw.log_time;
        let (size, step) = (raw.data.len(), u64::from(raw.sequence));
        let mut wrong = None;
        let message = match (&mut self.sequence, Topic::from_name(&raw.channel.topic)) {
            (Some(sequence), Some(topic)) if topic.is_data() => {
                let message = decode(topic, &raw.data)
                    .map_err(|error| self.raw.damaged(raw.offset, error.to_string()))?;
                wrong = check(sequence, &message, step).err().map(|fault| match fault {
                    Fault::Order(source) => {
                        let file = self.raw.name().to_owned();
                        LogError::Sequence { file, offset: Some(raw.offset), source }
                    }
                    Fault::Label(what) => self.raw.damaged(raw.offset, what),
                });
                if wrong.is_some() && self.reads_on {
                    sequence.lose();
                    let _ = check(sequence, &message, step);
                }
                message
            }
            _ => Message::Opaque(raw.data),
        };
        let (channel, log_time, publish_time) = (raw.channel, raw.log_time, raw.publish_time);
        Ok((Entry { channel, step, log_time, publish_time, offset: raw.offset, size, message }, wrong))
    }

    /// The next message, or the next error.
    fn fetch(&mut self) -> Option<Result<Entry, LogError>> {
        loop {
            if let Some(ready) = self.ready.pop_front() {
                return Some(ready);
            }
            match self.raw.next()?.and_then(|item| match item {
                RawItem::Message(raw) => self.entry(raw).map(Some),
                // A repaired or edited log may carry more; none of it is a message.
                _ => Ok(None),
            }) {
                Ok(None) => {}
                Ok(Some((entry, wrong))) => {
                    self.ready.extend(wrong.map(Err));
                    self.ready.push_back(Ok(entry));
                }
                Err(error) => {
                    // Else the window under way stays open: it is not complete.
                    if let Some(sequence) = self.sequence.as_mut().filter(|_| self.reads_on) {
                        sequence.lose();
                    }
                    return Some(Err(error));
                }
            }
        }
    }
}

impl Iterator for LogReader {
    type Item = Result<Entry, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = if self.ended { None } else { self.fetch() };
        self.ended = matches!(next, Some(Err(_)) if !self.reads_on) || next.is_none();
        next
    }
}

fn decode(topic: Topic, bytes: &[u8]) -> Result<Message, CodecError> {
    Ok(match topic {
        Topic::Command => Message::Command(codec::decode(bytes)?),
        Topic::Loads => {
            let (header, records) = codec::decode_slice(bytes)?;
            Message::Loads(header, records)
        }
        Topic::Kinematics => {
            let (header, records) = codec::decode_slice(bytes)?;
            Message::Kinematics(header, records)
        }
        Topic::Status => {
            let (role, status): (u64, Status) = codec::decode(bytes)?;
            Message::Status(role_of(role, bytes.len())?, Box::new(status))
        }
        _ => Message::Opaque(bytes.to_vec()),
    })
}

fn role_of(code: u64, bytes: usize) -> Result<Role, CodecError> {
    [Role::Fluid, Role::Dem].into_iter().find(|role| *role as u64 == code).ok_or_else(|| {
        let what = format!("role {code} is neither 0 (fluid) nor 1 (DEM)");
        CodecError::Decode { bytes, wanted: "a status", what }
    })
}

enum Fault {
    Order(super::error::SequenceError),
    Label(String),
}

/// The order of messages, and that the label in the file is the step in the payload.
fn check(sequence: &mut Sequence, message: &Message, label: u64) -> Result<(), Fault> {
    let (step, result) = match message {
        Message::Command(command) => (command.step, sequence.command(command)),
        Message::Loads(header, loads) => (header.step, sequence.loads(header, loads.len())),
        Message::Kinematics(header, grains) => (header.step, sequence.kinematics(header, grains.len())),
        Message::Status(_, status) => (status.step, sequence.status(status)),
        Message::Opaque(_) => (label, Ok(())),
    };
    result.map_err(Fault::Order)?;
    if step == label {
        return Ok(());
    }
    Err(Fault::Label(format!("its label says step {label}, its payload step {step}")))
}
