//! `bedload log info | cat | repair | thin`: reads a log without any solver.

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::RangeInclusive;
use std::path::Path;

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
}

impl From<LogCommandError> for Failure {
    fn from(error: LogCommandError) -> Self {
        match &error {
            LogCommandError::Usage(_) => Self::Input(error.to_string()),
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
            LogCommandError::Log(
                LogError::Truncated { .. } | LogError::Damaged { .. } | LogError::Sequence { .. },
            ) => Self::BreaksOff(error.to_string()),
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
///
/// # Errors
/// [`LogCommandError::Usage`].
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
    let mut failure = None;
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
        match options.json {
            true => writeln!(out, "{}", as_json(&entry)?)?,
            false => writeln!(out, "{}", printable(&as_text(&entry)))?,
        }
    }
    failure.map_or(Ok(()), |error| Err(error.into()))
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
/// [`LogCommandError`] if `to` exists, nothing can be read or the new file cannot be written.
pub fn repair(from: &Path, to: Option<&Path>, out: &mut dyn Write) -> Result<(), LogCommandError> {
    to.map_or(Ok(()), is_new)?;
    let to = to.unwrap_or(from);
    let report = log::repair(from, to)?;
    print_kept(to, &report, out)?;
    let last = report.last_step.map_or("no step".to_owned(), |step| format!("step {step}"));
    line(out, "last", &last)?;
    if report.errors.is_empty() {
        return line(out, "lost", "nothing: the log was whole");
    }
    line(out, "lost", &format!("{} of {} bytes", report.bytes_lost, report.bytes))?;
    print_errors("because", &report.errors, out)
}

/// `bedload log thin LOG OUT --every N`: a log for viewers, with every `every`-th frame and no messages.
///
/// # Errors
/// [`LogCommandError`] if `to` exists, the log has no frames or the new file cannot be written.
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
    print_errors("damage", &report.errors, out)
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

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use protocol::log::Recorder;
    use protocol::message::{Kinematics, Loads};

    use super::*;

    fn log(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("bedload-{}-{name}", std::process::id()));
        let manifest = Manifest::new("two grains", "", vec![1.0; 2], 0.5, 2.0);
        let recorder = Recorder::create(&path, &manifest, Default::default()).unwrap();
        for step in 0..4 {
            let (time, dt) = (0.5 * step as f64, 0.5);
            let order = Order::Advance as u64;
            let command = Command { order, step, time, dt, substeps: 7, ..Command::default() };
            let header = Header { step, time, dt, ..Header::default() };
            recorder.record_command(&command).unwrap();
            let loads = Loads { force: [0.0, 0.0, f64::INFINITY], ..Loads::default() };
            recorder.record_loads(&header, &[loads; 2]).unwrap();
            recorder.record_kinematics(&header, &[Kinematics::default(); 2]).unwrap();
        }
        let mut status = Status { state: State::Failed as u64, step: 3, ..Status::default() };
        status.set_text("diverged");
        recorder.record_status(Role::Dem, &status).unwrap();
        recorder.finish().unwrap();
        path
    }

    fn printed(run: impl FnOnce(&mut Vec<u8>) -> Result<(), LogCommandError>) -> String {
        let mut out = Vec::new();
        run(&mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn steps_are_read_in_every_form() {
        assert_eq!(parse_steps("3..7").unwrap(), 3..=7);
        assert_eq!(parse_steps("3..").unwrap(), 3..=u64::MAX);
        assert_eq!(parse_steps("..7").unwrap(), 0..=7);
        assert_eq!(parse_steps("4").unwrap(), 4..=4);
        for bad in ["", "a", "7..3", "1..b", "-1"] {
            assert!(parse_steps(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn info_tells_what_is_there_and_whether_it_is_whole() {
        let path = log("info.mcap");
        let text = printed(|out| info(&path, out));
        for part in [
            "two grains",
            "steps        0 to 3, 0 repeated",
            "time         0 to 2 s",
            "bedload/kinematics",
            "dem in step 3: diverged",
            "state        complete",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
        let mut text = Vec::new();
        let error = info(&path, &mut text).expect_err("it breaks off");
        assert_eq!(Failure::from(error).exit_code(), 6);
        assert!(String::from_utf8(text).unwrap().contains("state        truncated: "));
        let text = printed(|out| repair(&path, None, out));
        assert!(text.contains("lost") && text.contains("4  bedload/loads"), "{text}");
        assert!(printed(|out| info(&path, out)).contains("state        complete"));
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_full_disk_is_no_room() {
        let path = log("full.mcap");
        let failure = Failure::from(repair(&path, None, &mut NoRoom).expect_err("it takes nothing"));
        assert_eq!(failure.exit_code(), 5);
        assert!(!failure.to_string().contains("--resume"), "{failure}");
        let source = std::sync::Arc::new(std::io::Error::from(std::io::ErrorKind::StorageFull));
        let error = LogError::File { file: String::new(), action: "write", source };
        assert_eq!(Failure::from(LogCommandError::from(error)).exit_code(), 5);
        std::fs::remove_file(path).unwrap();
    }

    /// A terminal or pipe whose other end is a full disk.
    struct NoRoom;

    impl Write for NoRoom {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_file_that_exists_is_not_overwritten() {
        let (path, to) = (log("source.mcap"), log("precious.mcap"));
        std::fs::write(&to, "precious").unwrap();
        for run in [repair(&path, Some(&to), &mut Vec::new()), thin(&path, &to, 1, &mut Vec::new())] {
            let failure = Failure::from(run.expect_err("it exists"));
            assert!(failure.to_string().contains("name another file"), "{failure}");
            assert_eq!(failure.exit_code(), 2);
        }
        assert_eq!(std::fs::read(&to).unwrap(), b"precious");
        std::fs::remove_file(&to).unwrap();
        let text = printed(|out| thin(&path, &to, 2, out));
        assert!(text.contains("2  viewer/points") && !text.contains("bedload/loads"), "{text}");
        [path, to].iter().for_each(|path| std::fs::remove_file(path).unwrap());
    }

    #[test]
    fn cat_filters_and_prints_json_lines() {
        let path = log("cat.mcap");
        let options = CatOptions { topic: Some("loads".to_owned()), steps: Some(1..=2), json: true };
        let text = printed(|out| cat(&path, &options, out));
        let lines: Vec<serde_json::Value> =
            text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[1]["step"], 2);
        assert_eq!(lines[1]["message"]["header"]["time"], 1.0);
        assert_eq!(lines[1]["message"]["records"][1]["force"], json!([0.0, 0.0, null]));
        let all = printed(|out| cat(&path, &CatOptions::default(), out));
        assert!(all.lines().count() >= 13);
        assert!(all.lines().next().unwrap().contains("Advance, attempt 0, t = 0 s, dt = 0.5 s"));
        std::fs::remove_file(path).unwrap();
    }
}
