//! The MCAP file being written: its channels, and a data message or a frame at a time.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, WriteOptions, Writer};

use super::error::LogError;
use super::manifest::{METADATA, Manifest, SCENE};
use super::schema;
use super::topic::{DATA_ENCODING, DATA_SCHEMA_ENCODING, Topic};

/// Level 1: logs are written while solvers run on the same cores.
const ZSTD_LEVEL: u32 = 1;

/// Options of every log: chunks of about `chunk_bytes`, or as long as whoever writes wants them, whole in
/// memory before they are written, so the file holds a whole number of chunks unless the write itself was
/// cut.
pub(crate) fn write_options(chunk_bytes: Option<u64>) -> WriteOptions {
    WriteOptions::new()
        .profile("bedload")
        .library(concat!("bedload ", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        .compression_level(ZSTD_LEVEL)
        // Compress in the calling thread: no pool of workers beside the solvers.
        .compression_threads(0)
        .chunk_size(chunk_bytes)
        .disable_seeking(true)
}

/// Counts what goes to the disk.
struct Counted<W> {
    inner: W,
    bytes: Arc<AtomicU64>,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(buffer)?;
        self.bytes.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// A log under way.
pub(crate) struct Sink<W: Write> {
    file: String,
    writer: Writer<NoSeek<BufWriter<Counted<W>>>>,
    /// Channel of each topic, by its place in [`Topic::ALL`].
    channels: [u16; Topic::ALL.len()],
    /// Bytes of messages since the last flush.
    open: usize,
    /// Time of the last message, ns.
    clock: u64,
}

impl<W: Write> Sink<W> {
    /// Writes the manifest, the scene and the channels, and flushes them.
    pub(crate) fn create(
        inner: W,
        file: &str,
        manifest: &Manifest,
        bytes: Arc<AtomicU64>,
    ) -> Result<Self, LogError> {
        let fail = |error| LogError::write(file, error);
        let out = NoSeek::new(BufWriter::new(Counted { inner, bytes }));
        let mut writer = write_options(None).create(out).map_err(fail)?;
        let metadata = Metadata { name: METADATA.to_owned(), metadata: manifest.to_metadata() };
        writer.write_metadata(&metadata).map_err(fail)?;
        writer.attach(&scene(manifest)).map_err(fail)?;
        let channels = add_channels(&mut writer, &metadata.metadata).map_err(fail)?;
        writer.flush().map_err(fail)?;
        Ok(Self { file: file.to_owned(), writer, channels, open: 0, clock: 0 })
    }

    /// Puts one message into the chunk under way.
    pub(crate) fn write(
        &mut self,
        topic: Topic,
        sequence: u32,
        log_time: u64,
        publish_time: u64,
        data: &[u8],
    ) -> Result<(), LogError> {
        let channel_id = self.channels[topic as usize];
        let header = MessageHeader { channel_id, sequence, log_time, publish_time };
        self.open += data.len();
        self.clock = log_time;
        self.writer.write_to_known_channel(&header, data).map_err(|error| LogError::write(&self.file, error))
    }

    /// Time of the last message, ns.
    pub(crate) fn clock(&self) -> u64 {
        self.clock
    }

    /// Bytes of the messages in the chunk under way.
    pub(crate) fn open(&self) -> usize {
        self.open
    }

    /// Ends the chunk under way and hands it to the operating system; false: there was none.
    pub(crate) fn flush(&mut self) -> Result<bool, LogError> {
        if std::mem::take(&mut self.open) == 0 {
            return Ok(false);
        }
        self.writer.flush().map_err(|error| LogError::write(&self.file, error))?;
        Ok(true)
    }

    /// Writes index and end mark.
    pub(crate) fn finish(mut self) -> Result<(), LogError> {
        let fail = |error| LogError::write(&self.file, error);
        self.writer.finish().map_err(fail)?;
        let mut out = self.writer.into_inner();
        out.flush().map_err(|error| LogError::io(&self.file, "finish", error))
    }
}

fn scene(manifest: &Manifest) -> Attachment<'_> {
    Attachment {
        log_time: 0,
        create_time: 0,
        name: SCENE.to_owned(),
        media_type: "application/toml".to_owned(),
        data: manifest.scene.as_bytes().into(),
    }
}

/// The channel of orders says the `facts` of the run once more, as channels have a checksum.
fn add_channels<W: Write + std::io::Seek>(
    writer: &mut Writer<W>,
    facts: &BTreeMap<String, String>,
) -> mcap::McapResult<[u16; Topic::ALL.len()]> {
    let mut channels = [0; Topic::ALL.len()];
    for topic in Topic::ALL {
        let layout = topic.layout();
        let (encoding, schema_encoding, schema) = match topic {
            Topic::Scene | Topic::Points => ("protobuf", "protobuf", schema::FOXGLOVE),
            Topic::Window | Topic::Grains => ("protobuf", "protobuf", schema::VIEWER),
            _ => (DATA_ENCODING, DATA_SCHEMA_ENCODING, layout.as_bytes()),
        };
        let schema = writer.add_schema(topic.schema_name(), schema_encoding, schema)?;
        let metadata = if topic == Topic::Command { facts } else { &BTreeMap::new() };
        channels[topic as usize] = writer.add_channel(schema, topic.name(), encoding, metadata)?;
    }
    Ok(channels)
}
