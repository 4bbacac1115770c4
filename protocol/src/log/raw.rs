//! A log as records: streams an MCAP file from its beginning to its end, from chunk to chunk past damage.
//!
//! No index is needed, so a file without its end reads just as well. Every chunk is held against
//! its checksum before any of its messages are given out.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::bytes::Bytes;
use super::error::{After, LogError};
use super::manifest::{METADATA, SCENE};
use super::topic::Topic;

/// Largest chunk that is unpacked, bytes: a chunk holds at least one message, and a message is
/// bounded by the codec; twice that leaves room for what shares its chunk.
const CHUNK_LIMIT: usize = 2 * super::codec::LIMIT;
/// Bytes of a chunk in front of what is compressed: type, length, two times, size, checksum, `zstd`, length.
const CHUNK_HEAD: usize = 1 + 8 + 16 + 8 + 4 + 8 + 8;
/// Bytes of the end of a file: the footer (type, length, two places, checksum) and the end mark.
const FILE_END: u64 = 1 + 8 + 20 + 8;

/// A channel as the file declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Number in the file.
    pub id: u16,
    /// Name.
    pub topic: String,
    /// How payloads are encoded.
    pub encoding: String,
    /// Further facts.
    pub metadata: BTreeMap<String, String>,
    /// Its schema, if it has one.
    pub schema: Option<Arc<Schema>>,
}

/// A schema as the file declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    /// Name.
    pub name: String,
    /// How it is written.
    pub encoding: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// A message with its payload undecoded.
#[derive(Clone, Debug)]
pub struct RawMessage {
    /// Its channel.
    pub channel: Arc<Channel>,
    /// Step number.
    pub sequence: u32,
    /// Simulated time, ns.
    pub log_time: u64,
    /// Wall time since the recorder's start, ns.
    pub publish_time: u64,
    /// Where its chunk begins in the file, bytes.
    pub offset: u64,
    /// Payload.
    pub data: Vec<u8>,
}

/// A record of interest.
#[derive(Clone, Debug)]
pub enum RawItem {
    /// Text by key, under a name.
    Metadata(String, BTreeMap<String, String>),
    /// A file inside the file: name, media type, bytes.
    Attachment(String, String, Vec<u8>),
    /// A message.
    Message(RawMessage),
}

/// What stands before the first message.
#[derive(Debug, Default)]
pub(crate) struct Preface {
    /// Of the run, by key.
    pub(crate) facts: Option<BTreeMap<String, String>>,
    /// The scene's text.
    pub(crate) scene: Option<Vec<u8>>,
    /// What an editor of logs may have added.
    pub(crate) others: Vec<RawItem>,
    /// What was damaged.
    pub(crate) errors: Vec<LogError>,
}

/// Sizes met so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Bytes of the file read.
    pub file: u64,
    /// Chunks.
    pub chunks: u64,
    /// Bytes in chunks as they stand in the file.
    pub packed: u64,
    /// Bytes in chunks unpacked.
    pub unpacked: u64,
}

/// A file, or bytes in memory.
trait Source: Read + Seek + Send {}

impl<T: Read + Seek + Send> Source for T {}

/// Streams a file. Behind damage it goes on with the next chunk; any other error ends it.
pub struct RawReader {
    source: Box<dyn Source>,
    name: String,
    /// Bytes of the file when it was opened.
    length: u64,
    reader: LinearReader,
    schemas: HashMap<u16, Arc<Schema>>,
    channels: HashMap<u16, Arc<Channel>>,
    ready: VecDeque<RawItem>,
    /// Error found behind the items in `ready`.
    failure: Option<LogError>,
    last_step: Option<u64>,
    sizes: Sizes,
    /// Where the record under way begins.
    begin: u64,
    /// Whether the file ends in an end mark.
    marked: bool,
    /// Behind the data.
    in_index: bool,
    done: bool,
}

impl RawReader {
    /// Opens the file at `path`.
    ///
    /// # Errors
    /// [`LogError::File`].
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let name = path.display().to_string();
        let fail = |error| LogError::io(&name, "open", error);
        let mut file = crate::input_file::open(path).map_err(fail)?;
        let length = file.metadata().map_err(fail)?.len();
        let marked = ends_in_mark(&mut file, length).map_err(fail)?;
        let source = std::io::BufReader::with_capacity(1 << 18, file);
        Ok(Self::new(Box::new(source), length, marked, &name))
    }

    /// Reads a file in memory; `name` stands for it in messages.
    pub fn from_bytes(bytes: Vec<u8>, name: &str) -> Self {
        let marked = bytes.len() > 2 * mcap::MAGIC.len() && bytes.ends_with(mcap::MAGIC);
        let length = bytes.len() as u64;
        Self::new(Box::new(std::io::Cursor::new(bytes)), length, marked, name)
    }

    fn new(source: Box<dyn Source>, length: u64, marked: bool, name: &str) -> Self {
        let options = of_file(length).with_validate_data_section_crc(true);
        Self {
            source,
            name: name.to_owned(),
            length,
            reader: LinearReader::new_with_options(options),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            ready: VecDeque::new(),
            failure: None,
            last_step: None,
            sizes: Sizes::default(),
            begin: 0,
            marked,
            in_index: false,
            done: false,
        }
    }

    /// Name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Sizes met so far.
    pub fn sizes(&self) -> Sizes {
        self.sizes
    }

    pub(crate) fn damaged(&self, offset: u64, what: String) -> LogError {
        let after = After(self.last_step);
        LogError::Damaged { file: self.name.clone(), offset, after, what, next: None }
    }

    /// What stands before the first message, which comes next. The channel of orders says the facts of the
    /// run once more, within a checksum: what differs from it is damage.
    pub(crate) fn preface(&mut self) -> Preface {
        let mut preface = Preface::default();
        loop {
            match self.next() {
                Some(Ok(RawItem::Metadata(name, map))) if name == METADATA => preface.facts = Some(map),
                Some(Ok(RawItem::Attachment(name, _, bytes))) if name == SCENE => preface.scene = Some(bytes),
                Some(Ok(message @ RawItem::Message(_))) => {
                    self.ready.push_front(message);
                    break;
                }
                Some(Ok(item)) => preface.others.push(item),
                Some(Err(error)) => preface.errors.push(error),
                None => break,
            }
        }
        let orders = self.channels.values().find(|channel| channel.topic == Topic::Command.name());
        let again = orders.map(|channel| &channel.metadata).filter(|again| !again.is_empty());
        if let Some(again) = again.filter(|again| preface.facts.as_ref() != Some(again)) {
            if preface.facts.is_some() {
                let what = "its manifest is not the one that its channels have".to_owned();
                preface.errors.insert(0, self.damaged(0, what));
            }
            preface.facts = Some(again.clone());
        }
        preface
    }

    /// Goes on with the first chunk behind the record in which `error` was met, if it is damage and there is
    /// such a chunk; the error then says where.
    fn go_on(&mut self, error: LogError) -> LogError {
        let (offset, what) = match &error {
            LogError::Damaged { offset, what, .. } => (*offset, what.clone()),
            LogError::Truncated { offset, .. } => (*offset, "it leads beyond the end".to_owned()),
            LogError::NotALog { what, .. } => (0, what.clone()),
            _ => return error,
        };
        let Ok(Some(found)) = self.next_chunk(offset + 1) else { return error };
        if self.channels.is_empty() {
            // Their chunk is the damaged one; the end of the file says them once more.
            let _ = self.channels_at_end();
        }
        if self.source.seek(SeekFrom::Start(found)).is_err() {
            return error;
        }
        // The checksum over all data can no longer be right; that of each chunk still is.
        let options = of_file(self.length).with_skip_start_magic(true);
        self.reader = LinearReader::new_with_options(options);
        (self.begin, self.sizes.file) = (found, found);
        (self.in_index, self.done) = (false, false);
        let (file, after) = (self.name.clone(), After(self.last_step));
        LogError::Damaged { file, offset, after, what, next: Some(found) }
    }

    /// Where the first record at or behind byte `from` stands that looks like a chunk of a recorder.
    fn next_chunk(&mut self, mut from: u64) -> std::io::Result<Option<u64>> {
        let mut block = Vec::new();
        loop {
            self.source.seek(SeekFrom::Start(from))?;
            block.clear();
            (&mut self.source).take(1 << 20).read_to_end(&mut block)?;
            let mut places = (from..).zip(block.windows(CHUNK_HEAD));
            let found =
                places.find(|(place, head)| is_chunk(head, self.length.saturating_sub(*place)) == Some(true));
            if found.is_some() || block.len() < CHUNK_HEAD {
                return Ok(found.map(|(place, _)| place));
            }
            from += (block.len() - CHUNK_HEAD + 1) as u64;
        }
    }

    /// Schemas and channels as the end of a complete file says them again, if its checksum is right.
    fn channels_at_end(&mut self) -> std::io::Result<()> {
        let Some(footer) = self.length.checked_sub(FILE_END).filter(|_| self.marked) else { return Ok(()) };
        self.source.seek(SeekFrom::Start(footer + 9))?;
        let mut start = [0; 8];
        self.source.read_exact(&mut start)?;
        self.source.seek(SeekFrom::Start(u64::from_le_bytes(start)))?;
        let mut end = Vec::new();
        self.source.read_to_end(&mut end)?;
        let Some((summed, sum)) = end.split_last_chunk::<12>() else { return Ok(()) };
        if !sum.starts_with(&crc32(summed).to_le_bytes()) {
            return Ok(());
        }
        let mut rest = Bytes(summed);
        while let Some((opcode, body)) = rest.take(1).map(|opcode| opcode[0]).zip(rest.long()) {
            if matches!(opcode, op::SCHEMA | op::CHANNEL) && self.declare(opcode, body, footer).is_none() {
                break;
            }
        }
        Ok(())
    }

    /// Reads one record of the file; `None` at its proper end.
    fn advance(&mut self) -> Option<Result<(), LogError>> {
        loop {
            match self.reader.next_event()? {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    if let Err(error) = self.feed(need) {
                        return Some(Err(error));
                    }
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    // The framing reader asks for no byte beyond its record.
                    let offset = std::mem::replace(&mut self.begin, self.sizes.file);
                    let body = data.to_vec();
                    return Some(self.record(opcode, &body, offset));
                }
                Err(error) => return Some(Err(self.failed(&error))),
            }
        }
    }

    /// Gives the framing reader the bytes it asks for.
    fn feed(&mut self, need: usize) -> Result<(), LogError> {
        // In slices: a record that claims more than is left must not reserve its claim.
        let buffer = self.reader.insert(need.min(1 << 20));
        let read = loop {
            match self.source.read(buffer) {
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                other => break other,
            }
        };
        let read = read.map_err(|error| LogError::io(&self.name, "read", error))?;
        self.reader.notify_read(read);
        self.sizes.file += read as u64;
        Ok(())
    }

    /// The framing reader's error, as ours.
    fn failed(&self, error: &McapError) -> LogError {
        use McapError::{BadMagic, ChunkTooLarge, RecordTooLarge, UnexpectedEof};
        let (file, offset, after) = (self.name.clone(), self.begin, After(self.last_step));
        match error {
            // A record that leads beyond the end: either the end is missing, or its length is bad.
            UnexpectedEof | RecordTooLarge { .. } | ChunkTooLarge(_) if !self.marked => {
                LogError::Truncated { file, offset, after }
            }
            BadMagic if offset == 0 => {
                LogError::NotALog { file, what: "it does not begin like an MCAP file".to_owned() }
            }
            other => self.damaged(offset, other.to_string()),
        }
    }

    /// A record outside chunks. A recorder writes few kinds there, and no other is passed over:
    /// a chunk whose type was damaged would go missing unnoticed.
    fn record(&mut self, opcode: u8, body: &[u8], offset: u64) -> Result<(), LogError> {
        let known = match (opcode, self.in_index) {
            (op::CHUNK, false) => return self.chunk(body, offset),
            (op::METADATA, false) => metadata(body).map(|item| self.ready.push_back(item)),
            (op::ATTACHMENT, false) => attachment(body).map(|item| self.ready.push_back(item)),
            (op::MESSAGE_INDEX, false) => message_index(body),
            // The first record begins with the file's mark.
            (op::HEADER, false) if offset == 0 => Some(()),
            (op::DATA_END, false) => {
                self.in_index = true;
                Some(())
            }
            // Behind the data everything is said once more, for readers that jump.
            (op::CHUNK | op::MESSAGE | op::DATA_END, true) | (_, false) => None,
            (_, true) => Some(()),
        };
        known.ok_or_else(|| self.damaged(offset, format!("record of type {opcode} is malformed")))
    }

    /// Unpacks a chunk whole, against its checksum, and reads its records.
    fn chunk(&mut self, body: &[u8], offset: u64) -> Result<(), LogError> {
        let (packed, unpacked) = chunk_sizes(body)
            .ok_or_else(|| self.damaged(offset, "its chunk header is malformed".to_owned()))?;
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(CHUNK_LIMIT);
        let mut inner = LinearReader::new_with_options(options);
        let mut rest = Bytes(body);
        let mut head = vec![op::CHUNK];
        head.extend_from_slice(&(body.len() as u64).to_le_bytes());
        inner.insert(head.len()).copy_from_slice(&head);
        inner.notify_read(head.len());
        loop {
            match inner.next_event() {
                None => break,
                Some(Ok(LinearReadEvent::ReadRequest(need))) => {
                    let piece = rest.take(need.min(rest.0.len())).unwrap_or_default();
                    inner.insert(piece.len()).copy_from_slice(piece);
                    inner.notify_read(piece.len());
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    if self.declare(opcode, data, offset).is_none() {
                        let what = format!("record of type {opcode} in its chunk is malformed");
                        return Err(self.damaged(offset, what));
                    }
                }
                Some(Err(error)) => return Err(self.damaged(offset, error.to_string())),
            }
        }
        self.sizes.chunks += 1;
        self.sizes.packed += packed;
        self.sizes.unpacked += unpacked;
        Ok(())
    }

    /// A schema, a channel or a message.
    fn declare(&mut self, opcode: u8, body: &[u8], offset: u64) -> Option<()> {
        let mut body = Bytes(body);
        match opcode {
            op::SCHEMA => {
                let id = body.u16()?;
                let (name, encoding) = (body.text()?.to_owned(), body.text()?.to_owned());
                let data = body.short()?.to_vec();
                self.schemas.insert(id, Arc::new(Schema { name, encoding, data }));
            }
            op::CHANNEL => {
                let id = body.u16()?;
                let schema = match body.u16()? {
                    0 => None,
                    schema => Some(self.schemas.get(&schema)?.clone()),
                };
                let (topic, encoding) = (body.text()?.to_owned(), body.text()?.to_owned());
                let metadata = body.map()?;
                let channel = Channel { id, topic, encoding, metadata, schema };
                self.channels.insert(id, Arc::new(channel));
            }
            op::MESSAGE => {
                let channel = self.channels.get(&body.u16()?)?.clone();
                let sequence = body.u32()?;
                let (log_time, publish_time) = (body.u64()?, body.u64()?);
                let data = body.0.to_vec();
                self.ready.push_back(RawItem::Message(RawMessage {
                    channel,
                    sequence,
                    log_time,
                    publish_time,
                    offset,
                    data,
                }));
            }
            _ => {}
        }
        Some(())
    }
}

impl Iterator for RawReader {
    type Item = Result<RawItem, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(item) = self.ready.pop_front() {
                if let RawItem::Message(message) = &item {
                    self.last_step = Some(u64::from(message.sequence));
                }
                return Some(Ok(item));
            }
            if let Some(error) = self.failure.take() {
                return Some(Err(error));
            }
            if self.done {
                return None;
            }
            match self.advance() {
                Some(Ok(())) => {}
                Some(Err(error)) => {
                    // Messages of a chunk whose sum failed are not to be given out.
                    self.ready.clear();
                    self.done = true;
                    self.failure = Some(self.go_on(error));
                }
                None => self.done = true,
            }
        }
    }
}

/// How a file of `length` bytes is framed. No record is longer: a hostile length asks for no memory.
fn of_file(length: u64) -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_validate_summary_section_crc(true)
        .with_check_finishes_after_end_magic(true)
        .with_record_length_limit(usize::try_from(length).unwrap_or(usize::MAX))
}

/// Whether the file ends as a complete one does; leaves it at its beginning.
fn ends_in_mark(file: &mut std::fs::File, length: u64) -> std::io::Result<bool> {
    let mut mark = [0; 8];
    if length <= 2 * mark.len() as u64 {
        return Ok(false);
    }
    file.seek(SeekFrom::End(-(mark.len() as i64)))?;
    file.read_exact(&mut mark)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(mark == mcap::MAGIC)
}

/// Whether `head` begins a chunk of a recorder that fits into `room`, the bytes of the file from there on.
fn is_chunk(head: &[u8], room: u64) -> Option<bool> {
    let mut rest = Bytes(head);
    if rest.take(1)? != [op::CHUNK] {
        return None;
    }
    let length = rest.u64()?;
    let _times_sizes_sum = rest.take(16 + 8 + 4)?;
    let zstd = rest.text()? == "zstd";
    let whole = rest.u64()?.checked_add(CHUNK_HEAD as u64)?;
    Some(zstd && whole <= room && length.checked_add(9) == Some(whole))
}

fn metadata(body: &[u8]) -> Option<RawItem> {
    let mut body = Bytes(body);
    let item = RawItem::Metadata(body.text()?.to_owned(), body.map()?);
    body.0.is_empty().then_some(item)
}

fn attachment(body: &[u8]) -> Option<RawItem> {
    let mut rest = Bytes(body);
    let _times = rest.take(16)?;
    let (name, media) = (rest.text()?.to_owned(), rest.text()?.to_owned());
    let data = rest.long()?.to_vec();
    let summed = body.len() - rest.0.len();
    let sum = rest.u32()?;
    // 0 stands for "no sum" (specification).
    (rest.0.is_empty() && (sum == 0 || sum == crc32(&body[..summed])))
        .then_some(RawItem::Attachment(name, media, data))
}

/// Nothing in it is needed; only that it is one.
fn message_index(body: &[u8]) -> Option<()> {
    let mut body = Bytes(body);
    body.u16()?;
    let entries = body.short()?.len();
    (entries % 16 == 0 && body.0.is_empty()).then_some(())
}

/// Bytes packed and unpacked, of a chunk compressed with zstd.
fn chunk_sizes(body: &[u8]) -> Option<(u64, u64)> {
    let mut body = Bytes(body);
    let _times = body.take(16)?;
    let unpacked = body.u64()?;
    let _sum = body.u32()?;
    // The framing reader trusts lengths inside a chunk that is not compressed; a recorder
    // compresses always.
    let zstd = body.text()? == "zstd";
    let packed = body.long()?.len() as u64;
    // What is left was another record's: the length of this one is wrong.
    (body.0.is_empty() && zstd && usize::try_from(unpacked).is_ok_and(|size| size <= CHUNK_LIMIT))
        .then_some((packed, unpacked))
}

/// CRC-32 (ISO-HDLC), for attachments only: a scene is a few kilobytes.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg()))
    })
}
