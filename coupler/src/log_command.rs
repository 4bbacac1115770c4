//! `bedload log info | cat | repair | thin`: reads a log without any solver.

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use bedload_output::{OutputError, OutputFolder};
use protocol::log::{self, Entry, LogError, LogReader, Manifest, Message, Repaired};
use protocol::message::{Command, Header, Order, State, Status};
use protocol::new_file::is_full;
use protocol::participant::Role;
use protocol::printable::printable;
use serde::Serialize;
use serde_json::json;

use crate::failure::Failure;

/// Why the command failed.
#[derive(Debug, thiserror::Error)]
pub enum LogCommandError {
    /// The log cannot be read or written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The terminal or pipe is gone.
    #[error("cannot print: {0}")]
    Print(#[from] std::io::Error),
    /// A value on the command line.
    #[error("{0}")]
    Usage(String),
    /// A run still writes the log that would be replaced.
    #[error("{} is in use by another process of Bedload: nothing was changed; wait until it ends, or name another \
             file for what is left: `bedload log repair LOG OUT`", .0.display())]
    InUse(PathBuf),
}

impl From<LogCommandError> for Failure {
    fn from(error: LogCommandError) -> Self {
        match &error {
            LogCommandError::Usage(_) => Self::Input(error.to_string()),
            LogCommandError::InUse(_) => Self::InUse(error.to_string()),
            LogCommandError::Log(LogError::File { source, .. }) if is_full(source) => {
                Self::Full(error.to_string())
            }
            LogCommandError::Log(
                LogError::File { .. } | LogError::NotALog { .. } | LogError::Layout { .. },
            ) => Self::Input(error.to_string()),
            // A reader that has seen enough is no fault.
            LogCommandError::Print(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {
                Self::Passed(0)
            }
            LogCommandError::Log(error) => error.clone().into(),
            LogCommandError::Print(source) if is_full(source) => Self::Full(error.to_string()),
            LogCommandError::Print(_) => Self::Run(error.to_string()),
        }
    }
}

/// What `log cat` prints.
#[derive(Clone, Debug, Default)]
pub struct CatOptions {
    /// Only this topic; its last part is enough (`loads`).
    pub topic: Option<String>,
    /// Only these steps.
    pub steps: Option<RangeInclusive<u64>>,
    /// JSON, one object per line.
    pub json: bool,
}

/// Reads `A..B` (both included), `A..`, `..B` or `A`.
pub fn parse_steps(text: &str) -> Result<RangeInclusive<u64>, LogCommandError> {
    let usage = || LogCommandError::Usage(format!("--step {text}: give A..B, A.., ..B or A"));
    let number = |word: &str, open: u64| match word {
        "" => Ok(open),
        word => word.parse().map_err(|_| usage()),
    };
    let (from, to) = match text.split_once("..") {
        Some((from, to)) => (number(from, 0)?, number(to, u64::MAX)?),
        None if text.is_empty() => return Err(usage()),
        None => (number(text, 0)?, number(text, 0)?),
    };
    if from > to {
        return Err(usage());
    }
    Ok(from..=to)
}

/// Counts of one reading.
#[derive(Default)]
struct Tally {
    topics: BTreeMap<String, (u64, u64)>,
    steps: Option<(u64, u64)>,
    repeats: u64,
    time: Option<(f64, f64)>,
    failed: Option<String>,
}

impl Tally {
    fn add(&mut self, entry: &Entry) {
        let topic = self.topics.entry(entry.channel.topic.clone()).or_default();
        topic.0 += 1;
        topic.1 += entry.size as u64;
        match &entry.message {
            Message::Command(command) => self.command(command),
            Message::Status(role, status) if status.state == State::Failed as u64 => {
                self.failed = Some(format!("{role} in step {}: {}", status.step, status.text()));
            }
            _ => {}
        }
    }

    fn command(&mut self, command: &Command) {
        let Ok(order @ (Order::Advance | Order::Repeat)) = Order::try_from(command.order) else {
            return;
        };
        self.repeats += u64::from(order == Order::Repeat);
        let first = self.steps.map_or(command.step, |steps| steps.0);
        self.steps = Some((first, command.step));
        let begin = self.time.map_or(command.time, |time| time.0);
        self.time = Some((begin, command.time + command.dt));
    }
}

/// `bedload log info LOG`: what is in it, and whether it is whole.
///
/// # Errors
/// [`LogCommandError`] if it is no log, if it breaks off or is damaged: then after all that can be read was
/// told.
pub fn info(path: &Path, out: &mut dyn Write) -> Result<(), LogCommandError> {
    let mut reader = LogReader::open_any(path)?;
    let mut tally = Tally::default();
    let mut errors = Vec::new();
    for entry in reader.by_ref() {
        match entry {
            Ok(entry) => tally.add(&entry),
            Err(error) => errors.push(error),
        }
    }
    writeln!(out, "{}", path.display())?;
    print_manifest(reader.manifest(), out)?;
    print_tally(&tally, out)?;
    let sizes = reader.sizes();
    let bytes = std::fs::metadata(path)?.len();
    let ratio = sizes.unpacked as f64 / sizes.packed.max(1) as f64;
    line(out, "size", &format!("{bytes} bytes, {} chunks, compressed {ratio:.1} : 1", sizes.chunks))?;
    print_errors("state", &errors, out)?;
    match errors.into_iter().next() {
        None if reader.is_complete() => line(out, "state", "complete"),
        None => line(out, "state", "complete file; the last window has not all its messages"),
        Some(first) => Err(first.into()),
    }
}

/// The first errors of a log, one a line.
fn print_errors(name: &str, errors: &[LogError], out: &mut dyn Write) -> Result<(), LogCommandError> {
    const MOST: usize = 8;
    for error in errors.iter().take(MOST) {
        let state = if error.is_truncation() { "truncated" } else { "damaged" };
        line(out, name, &format!("{state}: {error}"))?;
    }
    match errors.len().saturating_sub(MOST) {
        0 => Ok(()),
        more => line(out, name, &format!("and {more} more places")),
    }
}

fn line(out: &mut dyn Write, name: &str, value: &str) -> Result<(), LogCommandError> {
    Ok(writeln!(out, "  {name:<12} {}", printable(value))?)
}

fn print_manifest(manifest: &Manifest, out: &mut dyn Write) -> Result<(), LogCommandError> {
    let ours = Manifest::new("", "", Vec::new(), 0.0, 0.0);
    let same = (ours.layout, ours.protocol) == (manifest.layout, manifest.protocol);
    let note = if same { "as this build" } else { "NOT this build's: cannot be replayed by it" };
    let (version, protocol, layout) = (&manifest.version, manifest.protocol, manifest.layout);
    line(out, "title", &manifest.title)?;
    line(out, "written by", &format!("Bedload {version}"))?;
    line(out, "protocol", &format!("{protocol}, layout {layout:016x} ({note})"))?;
    for (name, command) in [("fluid", &manifest.fluid_command), ("dem", &manifest.dem_command)] {
        let words = if command.is_empty() { "none".to_owned() } else { command.join(" ") };
        line(out, name, &words)?;
    }
    line(out, "grains", &manifest.grains().to_string())?;
    line(out, "dt", &format!("{} s planned, until {} s", manifest.dt, manifest.until))?;
    if manifest.first_step > 0 {
        let (step, time) = (manifest.first_step, manifest.first_time);
        line(out, "resumed", &format!("from step {step}, {time} s"))?;
    }
    Ok(())
}

fn print_tally(tally: &Tally, out: &mut dyn Write) -> Result<(), LogCommandError> {
    if let (Some((first, last)), Some((begin, end))) = (tally.steps, tally.time) {
        line(out, "steps", &format!("{first} to {last}, {} repeated", tally.repeats))?;
        line(out, "time", &format!("{begin} to {end} s"))?;
    }
    for (topic, (count, bytes)) in &tally.topics {
        line(out, "messages", &format!("{count:>8} {bytes:>12} bytes  {topic}"))?;
    }
    match &tally.failed {
        Some(failed) => line(out, "failed", failed),
        None => Ok(()),
    }
}

/// `bedload log cat LOG`: one line per message, in order.
///
/// # Errors
/// [`LogCommandError`]: also if the log breaks off or is damaged, after everything else was printed.
pub fn cat(path: &Path, options: &CatOptions, out: &mut dyn Write) -> Result<(), LogCommandError> {
    let (mut failure, mut printed) = (None, 0_u64);
    for entry in LogReader::open_any(path)? {
        let entry = match entry {
            Ok(entry) => entry,
            Err(error) => {
                // The last of them is what the command ends with.
                if let Some(before) = failure.replace(error) {
                    protocol::say!("{before}");
                }
                continue;
            }
        };
        if !is_wanted(&entry, options) {
            continue;
        }
        printed += 1;
        match options.json {
            true => writeln!(out, "{}", as_json(&entry)?)?,
            false => writeln!(out, "{}", printable(&as_text(&entry)))?,
        }
    }
    match failure {
        Some(error) => Err(error.into()),
        None if printed == 0 && (options.topic.is_some() || options.steps.is_some()) => {
            let log = path.display();
            let what = format!("{log} has no such message: `bedload log info` lists topics and steps");
            Err(LogCommandError::Usage(what))
        }
        None => Ok(()),
    }
}

fn is_wanted(entry: &Entry, options: &CatOptions) -> bool {
    let topic = &entry.channel.topic;
    let named = options
        .topic
        .as_ref()
        .is_none_or(|name| topic == name || topic.rsplit('/').next().is_some_and(|last| last == name));
    named && options.steps.as_ref().is_none_or(|steps| steps.contains(&entry.step))
}

fn as_text(entry: &Entry) -> String {
    let (topic, step) = (&entry.channel.topic, entry.step);
    let what = match &entry.message {
        Message::Command(command) => command_text(command),
        Message::Loads(header, loads) => {
            let force = loads.iter().fold([0.0; 3], |sum, load| add(sum, load.force));
            format!("{}, {} grains, total force {force:?} N", slice_text(header), loads.len())
        }
        Message::Kinematics(header, grains) => format!(
            "{}, {} grains, {} sub-steps, smallest gap {} m, largest overlap {} m",
            slice_text(header),
            grains.len(),
            header.substeps,
            header.smallest_gap,
            header.largest_overlap
        ),
        Message::Status(role, status) => status_text(*role, status),
        Message::Opaque(bytes) => format!("{} bytes", bytes.len()),
    };
    format!("{step:>8}  {topic:<20} {what}")
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn slice_text(header: &Header) -> String {
    format!("attempt {}, t = {} s, dt = {} s", header.attempt, header.time, header.dt)
}

fn command_text(command: &Command) -> String {
    let Command { attempt, time, dt, substeps, .. } = command;
    match Order::try_from(command.order) {
        Ok(order @ (Order::Advance | Order::Repeat)) => {
            format!("{order:?}, attempt {attempt}, t = {time} s, dt = {dt} s, {substeps} sub-steps")
        }
        Ok(order) => format!("{order:?}"),
        Err(error) => error.to_string(),
    }
}

fn status_text(role: Role, status: &Status) -> String {
    let state =
        State::try_from(status.state).map_or_else(|error| error.to_string(), |state| format!("{state:?}"));
    let (limit, cpu, text) = (status.dt_limit, status.solver_s, status.text());
    let space = if text.is_empty() { "" } else { ": " };
    format!("{role} {state}, accepts dt <= {limit} s, {cpu} s of CPU{space}{text}")
}

/// One message as JSON. Numbers that JSON does not have (NaN, infinities) become `null`.
fn as_json(entry: &Entry) -> Result<String, LogCommandError> {
    #[derive(Serialize)]
    struct Line<'a> {
        step: u64,
        topic: &'a str,
        log_time: u64,
        publish_time: u64,
        message: serde_json::Value,
    }
    let message = match &entry.message {
        Message::Command(command) => json!(command),
        Message::Loads(header, loads) => json!({ "header": header, "records": loads }),
        Message::Kinematics(header, grains) => json!({ "header": header, "records": grains }),
        Message::Status(role, status) => {
            let mut value = json!(status);
            value["role"] = json!(role);
            value["text"] = json!(status.text());
            value
        }
        Message::Opaque(bytes) => json!({ "bytes": bytes.len() }),
    };
    let line = Line {
        step: entry.step,
        topic: &entry.channel.topic,
        log_time: entry.log_time,
        publish_time: entry.publish_time,
        message,
    };
    serde_json::to_string(&line).map_err(|error| LogCommandError::Print(error.into()))
}

/// `bedload log repair LOG [OUT]`: rewrites what can be read, complete and indexed; without `to`
/// the log itself is replaced.
///
/// # Errors
/// [`LogCommandError`] if `to` exists, nothing can be read or the new file cannot be written; without `to` if
/// a run writes in the folder of the log.
pub fn repair(from: &Path, to: Option<&Path>, out: &mut dyn Write) -> Result<(), LogCommandError> {
    let _claim = match to {
        Some(to) => is_new(to).map(|()| None),
        None => claimed(from),
    }?;
    let to = to.unwrap_or(from);
    let report = log::repair(from, to)?;
    print_kept(to, &report, out)?;
    let last = report.last_step.map_or("no step".to_owned(), |step| format!("step {step}"));
    line(out, "last", &last)?;
    // Windows that a chunk in the middle held are gone.
    let gaps: Vec<LogError> = LogReader::open_any(to)?.filter_map(Result::err).collect();
    let lost = match report.errors.is_empty() {
        true if gaps.is_empty() => "nothing: the log was whole".to_owned(),
        true => "nothing more".to_owned(),
        false => format!("{} of {} bytes", report.bytes_lost, report.bytes),
    };
    line(out, "lost", &lost)?;
    print_errors("because", &report.errors, out)?;
    print_errors("gap", &gaps, out)
}

/// `bedload log thin LOG OUT --every N`: a log for viewers, with every `every`-th frame and no messages.
///
/// # Errors
/// [`LogCommandError`] if `to` exists, the log has no frames or the new file cannot be written; of a log that
/// is cut or damaged the first fault, once what is left was thinned.
pub fn thin(from: &Path, to: &Path, every: u64, out: &mut dyn Write) -> Result<(), LogCommandError> {
    is_new(to)?;
    let report = log::thin(from, to, every)?;
    if report.kept.is_empty() {
        std::fs::remove_file(to)?;
        let from = from.display();
        return Err(LogCommandError::Usage(format!(
            "{from} holds no frame for viewers: nothing is left of it"
        )));
    }
    print_kept(to, &report, out)?;
    line(out, "size", &format!("{} bytes of {}", report.bytes_kept, report.bytes))?;
    print_errors("damage", &report.errors, out)?;
    // As `cat` ends: what was thinned is not all that was recorded.
    report.errors.into_iter().next().map_or(Ok(()), |error| Err(error.into()))
}

/// The folder of a run's log, claimed: a run would go on with a log that was replaced, and lose what it
/// writes. None where the log lies elsewhere.
fn claimed(log: &Path) -> Result<Option<OutputFolder>, LogCommandError> {
    let folder = log.parent().filter(|folder| !folder.as_os_str().is_empty());
    match OutputFolder::resume(folder.unwrap_or(Path::new("."))) {
        Ok(folder) => Ok(Some(folder)),
        Err(OutputError::InUse(folder)) => Err(LogCommandError::InUse(folder)),
        Err(_) => Ok(None),
    }
}

fn is_new(to: &Path) -> Result<(), LogCommandError> {
    if std::fs::symlink_metadata(to).is_err() {
        return Ok(());
    }
    let to = to.display();
    Err(LogCommandError::Usage(format!(
        "{to} exists and is not overwritten: name another file, or remove it"
    )))
}

fn print_kept(to: &Path, report: &Repaired, out: &mut dyn Write) -> Result<(), LogCommandError> {
    writeln!(out, "{}", to.display())?;
    for (topic, count) in &report.kept {
        line(out, "kept", &format!("{count:>8}  {topic}"))?;
    }
    Ok(())
}
