//! Rewriting a log record by record: [`repair`] for one that is damaged, [`thin`] for viewers, [`flip_bit`]
//! for tests.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Writer};

use super::error::LogError;
use super::manifest::{METADATA, SCENE};
use super::raw::{Preface, RawItem, RawMessage, RawReader};
use super::reader::LogReader;
use super::sink::write_options;
use super::topic::Topic;

/// What a rewritten log holds and what it lost.
#[derive(Clone, Debug, Default)]
pub struct Repaired {
    /// Messages kept, by topic.
    pub kept: BTreeMap<String, u64>,
    /// Last step kept.
    pub last_step: Option<u64>,
    /// Bytes of the old file.
    pub bytes: u64,
    /// Bytes of it that could not be used: from each error to the next chunk, or to the end.
    pub bytes_lost: u64,
    /// Size of the new file, bytes.
    pub bytes_kept: u64,
    /// What was wrong, in order; nothing if the log was whole (it was rewritten all the same).
    pub errors: Vec<LogError>,
}

/// Reads `from` to its end, past what is damaged, and writes what was read to `to`, complete and indexed. A
/// scene that is lost is empty in it.
///
/// `to` appears only when it is whole and can be opened as a log.
///
/// # Errors
/// [`LogError`] if what is left of `from` is no log, or `to` cannot be written. Damage in `from` is otherwise
/// not an error here: it is reported in [`Repaired`].
pub fn repair(from: &Path, to: &Path) -> Result<Repaired, LogError> {
    rewrite(from, to, &mut |_| true)
}

/// Rewrites `from` to `to` with every `every`-th frame of the viewers' channels (0 counts as 1), and without
/// the messages of the solvers, which only a replay needs.
///
/// # Errors
/// As [`repair`].
pub fn thin(from: &Path, to: &Path, every: u64) -> Result<Repaired, LogError> {
    let (mut frames, mut last) = (0_u64, None);
    rewrite(from, to, &mut |message| {
        if Topic::from_name(&message.channel.topic).is_none_or(Topic::is_data) {
            return false;
        }
        // A frame is a message on each of these channels, with the same number.
        frames += u64::from(last.replace(message.sequence) != Some(message.sequence));
        (frames - 1).is_multiple_of(every.max(1))
    })
}

/// Rewrites `from` to `to` with one bit of the payload of `topic` in window `step` turned over, and
/// every checksum right: damage that only a replay can find. `attempt` counts the messages of that
/// topic and step; bit 0 is the lowest of the first byte.
///
/// # Errors
/// As [`repair`]; [`LogError::Value`] if there is no such message or bit.
pub fn flip_bit(
    from: &Path,
    to: &Path,
    topic: Topic,
    step: u32,
    attempt: usize,
    bit: usize,
) -> Result<(), LogError> {
    let (mut met, mut flipped) = (0, false);
    rewrite(from, to, &mut |message| {
        if message.channel.topic == topic.name() && message.sequence == step {
            if met == attempt && bit / 8 < message.data.len() {
                message.data[bit / 8] ^= 1 << (bit % 8);
                flipped = true;
            }
            met += 1;
        }
        true
    })?;
    if flipped {
        return Ok(());
    }
    let file = from.display().to_string();
    let name = topic.name();
    let what = format!("bit {bit} of {name} in window {step}, message {attempt}: there is none");
    Err(LogError::Value { file, what })
}

/// Changes a message, and says whether it is kept.
type Edit<'a> = &'a mut dyn FnMut(&mut RawMessage) -> bool;

fn rewrite(from: &Path, to: &Path, edit: Edit) -> Result<Repaired, LogError> {
    let mut reader = RawReader::open(from)?;
    let bytes = std::fs::metadata(from).map_err(|error| LogError::io(reader.name(), "open", error))?.len();
    // Written beside its place and moved there whole: `to` may even be `from`.
    let draft = to.with_added_extension("part");
    let report = copy(&mut reader, &draft, edit).and_then(|mut report| {
        // What no command could open is not put in place: the log's own first error says why.
        let left = LogReader::open_any(&draft).map(|_| ());
        left.map_err(|error| match (report.errors.first(), error) {
            (Some(first), _) => first.clone(),
            (_, LogError::NotALog { what, .. }) => LogError::NotALog { file: reader.name().to_owned(), what },
            (_, error) => error,
        })?;
        let fail = |error| LogError::io(reader.name(), "measure", error);
        report.bytes_kept = std::fs::metadata(&draft).map_err(fail)?.len();
        let name = to.display().to_string();
        std::fs::rename(&draft, to).map_err(|error| LogError::io(&name, "put in place", error))?;
        Ok(report)
    });
    if report.is_err() {
        let _ = std::fs::remove_file(&draft);
    }
    let mut report = report?;
    report.bytes = bytes;
    let lost = |error: &LogError| match error {
        LogError::Damaged { offset, next, .. } => next.unwrap_or(bytes).saturating_sub(*offset),
        LogError::Truncated { offset, .. } => bytes.saturating_sub(*offset),
        _ => 0,
    };
    report.bytes_lost = report.errors.iter().map(lost).sum();
    Ok(report)
}

type Output = Writer<NoSeek<BufWriter<File>>>;

fn copy(reader: &mut RawReader, to: &Path, edit: Edit) -> Result<Repaired, LogError> {
    let name = to.display().to_string();
    let file = File::create(to).map_err(|error| LogError::io(&name, "create", error))?;
    let fail = |error| LogError::write(&name, error);
    let mut writer = write_options(Some(64 << 10)).create(NoSeek::new(BufWriter::new(file))).map_err(fail)?;
    let Preface { facts, scene, others, errors } = reader.preface();
    let mut report = Repaired { errors, ..Repaired::default() };
    let facts = facts.map(|facts| RawItem::Metadata(METADATA.to_owned(), facts));
    let scene = scene.unwrap_or_default();
    let scene = RawItem::Attachment(SCENE.to_owned(), "application/toml".to_owned(), scene);
    let preface = facts.into_iter().chain([scene]).chain(others);
    for item in preface.map(Ok).chain(reader) {
        match item {
            Ok(item) => put(&mut writer, item, edit, &mut report).map_err(fail)?,
            Err(error) => report.errors.push(error),
        }
    }
    writer.finish().map_err(fail)?;
    let mut out = writer.into_inner();
    out.flush().map_err(|error| LogError::io(&name, "finish", error))?;
    Ok(report)
}

fn put(writer: &mut Output, item: RawItem, edit: Edit, report: &mut Repaired) -> mcap::McapResult<()> {
    match item {
        RawItem::Metadata(name, metadata) => writer.write_metadata(&Metadata { name, metadata }),
        RawItem::Attachment(name, media_type, data) => {
            writer.attach(&Attachment { log_time: 0, create_time: 0, name, media_type, data: data.into() })
        }
        RawItem::Message(mut message) => {
            if !edit(&mut message) {
                return Ok(());
            }
            report.last_step = Some(u64::from(message.sequence));
            *report.kept.entry(message.channel.topic.clone()).or_default() += 1;
            put_message(writer, &message)
        }
    }
}

fn put_message(writer: &mut Output, message: &RawMessage) -> mcap::McapResult<()> {
    let channel = &message.channel;
    let schema = match &channel.schema {
        Some(schema) => writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
        None => 0,
    };
    // The writer knows both again by their content.
    let (topic, encoding) = (&channel.topic, &channel.encoding);
    let channel_id = writer.add_channel(schema, topic, encoding, &channel.metadata)?;
    let header = MessageHeader {
        channel_id,
        sequence: message.sequence,
        log_time: message.log_time,
        publish_time: message.publish_time,
    };
    writer.write_to_known_channel(&header, &message.data)
}
