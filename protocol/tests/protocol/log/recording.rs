//! Recorders that are killed, starved or hung.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command as Process, Stdio};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use protocol::log::{LogError, LogReader, Recorder, RecorderOptions, SequenceError, repair};
use protocol::message::{Kinematics, Loads, Order};

use crate::log::support::{DT, GRAINS, manifest, path, window};

/// Records one window of still grains.
fn still_window(recorder: &Recorder, step: u64) -> Result<(), LogError> {
    let now = window(step, 0);
    recorder.record_command(&now.command(Order::Advance))?;
    recorder.record_loads(&now.header(), &[Loads::default(); GRAINS])?;
    recorder.record_kinematics(&now.header(), &[Kinematics::default(); GRAINS])
}

const CHILD: &str = "BEDLOAD_TEST_LOG";

/// Not a test by itself: the process that the next test kills.
#[test]
#[ignore = "run by a_killed_recorder_leaves_a_readable_log"]
fn child_records_until_killed() {
    let Some(file) = std::env::var_os(CHILD) else { return };
    let recorder = Recorder::create(file.as_ref(), &manifest(), RecorderOptions::default()).unwrap();
    let begin = Instant::now();
    for step in 0.. {
        still_window(&recorder, step).unwrap();
        println!("recorded {step} {}", begin.elapsed().as_millis());
        std::thread::sleep(Duration::from_millis(1));
        // If the parent is gone, nobody kills us.
        assert!(begin.elapsed() < Duration::from_secs(60));
    }
}

#[test]
fn a_killed_recorder_leaves_a_readable_log() {
    let file = path("killed.mcap");
    let mut child = Process::new(std::env::current_exe().unwrap())
        .args(["--exact", "log::recording::child_records_until_killed", "--ignored", "--nocapture"])
        .env(CHILD, &file)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    // (step, ms) as the child saw them; the pipe outlives it.
    let mut seen: Vec<(u64, u64)> = Vec::new();
    for line in lines {
        let line = line.unwrap();
        let Some((_, rest)) = line.split_once("recorded ") else { continue };
        let mut words = rest.split(' ').map(|word| word.parse().unwrap());
        seen.push((words.next().unwrap(), words.next().unwrap()));
        if seen.len() > 10 && seen.last().unwrap().1 > 1500 {
            child.kill().unwrap();
            break;
        }
    }
    child.wait().unwrap();
    let killed_at = seen.last().unwrap().1;
    // Flushed every 100 ms; a busy machine gets ten times that.
    let due = seen.iter().filter(|(_, ms)| ms + 1000 < killed_at).map(|(step, _)| *step).max();

    let mut last = None;
    let mut error = None;
    for entry in LogReader::open(&file).unwrap() {
        match entry {
            Ok(entry) => last = Some(entry.step),
            Err(end) => error = Some(end),
        }
    }
    assert!(error.is_some_and(|error| error.is_truncation()));
    assert!(due.is_some() && last >= due, "log ends at {last:?}, {due:?} was due");
    let mut windows = LogReader::open(&file).unwrap().windows();
    let whole = windows.by_ref().filter(Result::is_ok).count() as u64;
    assert!(whole == last.unwrap() + 1 || windows.unfinished().is_some());

    let mended = path("killed-repaired.mcap");
    let report = repair(&file, &mended).unwrap();
    assert_eq!(report.last_step, last);
    assert!(LogReader::open(&mended).unwrap().all(|entry| entry.is_ok()));
}

#[test]
fn a_log_that_somebody_cuts_short_is_an_error_and_not_a_hole() {
    let file = path("cut-meanwhile.mcap");
    let recorder = Recorder::create(&file, &manifest(), RecorderOptions::default()).unwrap();
    std::fs::File::options().write(true).open(&file).unwrap().set_len(0).unwrap();
    let _ = recorder.record_command(&window(0, 0).command(Order::Advance));
    let error = recorder.finish().unwrap_err().to_string();
    assert!(error.contains("0 bytes, where") && error.contains("leave its files alone"), "{error}");
    assert_eq!(std::fs::metadata(&file).unwrap().len(), 0);
}

/// A disk with so many bytes left.
struct Disk {
    left: usize,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let fits = bytes.len().min(self.left);
        self.left -= fits;
        match fits {
            0 if !bytes.is_empty() => Err(std::io::ErrorKind::StorageFull.into()),
            _ => Ok(fits),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_disk_that_fills_at_any_byte_is_an_error_and_no_hang() {
    let options = RecorderOptions {
        chunk_bytes: 1000,
        flush_period: Duration::from_millis(1),
        ..RecorderOptions::default()
    };
    let mut failed_later = 0;
    for left in (0..20_000).step_by(701) {
        let recorder = match Recorder::to_writer(Disk { left }, "disk", &manifest(), options) {
            Err(error) => {
                assert!(matches!(error, LogError::File { .. }), "{error}");
                continue;
            }
            Ok(recorder) => recorder,
        };
        let begin = Instant::now();
        let stopped = (0..).find_map(|step| still_window(&recorder, step).err());
        assert!(begin.elapsed() < Duration::from_secs(20));
        let stopped = stopped.unwrap();
        let full = matches!(&stopped, LogError::File { source, .. }
            if source.kind() == std::io::ErrorKind::StorageFull);
        assert!(full, "{stopped}");
        // It stays, it can be polled, and finishing says it again.
        assert_eq!(recorder.error().unwrap().to_string(), stopped.to_string());
        assert_eq!(still_window(&recorder, 0).unwrap_err().to_string(), stopped.to_string());
        assert_eq!(recorder.finish().unwrap_err().to_string(), stopped.to_string());
        failed_later += 1;
    }
    assert!(failed_later > 5);
}

#[cfg(target_os = "linux")]
#[test]
fn the_full_device_is_an_error() {
    let full = std::path::Path::new("/dev/full");
    let error = Recorder::create(full, &manifest(), RecorderOptions::default()).err();
    assert!(error.is_some_and(|error| error.to_string().contains("/dev/full")));
}

/// A disk that hangs until it is let go.
#[derive(Clone)]
struct Hung(Arc<(Mutex<bool>, Condvar)>);

impl Write for Hung {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let held = self.0.0.lock().unwrap();
        drop(self.0.1.wait_while(held, |held| *held).unwrap());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_disk_that_hangs_fills_the_queue_and_holds_nobody() {
    let gate = Hung(Arc::new((Mutex::new(false), Condvar::new())));
    let options = RecorderOptions {
        queue_bytes: 100_000,
        finish_deadline: Duration::from_millis(200),
        ..RecorderOptions::default()
    };
    let recorder = Recorder::to_writer(gate.clone(), "hung", &manifest(), options).unwrap();
    *gate.0.0.lock().unwrap() = true;
    let begin = Instant::now();
    let stopped = (0..10_000).find_map(|step| still_window(&recorder, step).err());
    let limit = matches!(stopped, Some(LogError::QueueFull { limit: 100_000, .. }));
    assert!(limit, "{stopped:?}");
    assert!(begin.elapsed() < Duration::from_secs(5));
    let begin = Instant::now();
    assert!(matches!(recorder.finish(), Err(LogError::Unfinished { .. })));
    assert!(begin.elapsed() < Duration::from_secs(5));
    *gate.0.0.lock().unwrap() = false;
    gate.0.1.notify_all();
}

#[test]
fn a_gap_is_refused_and_the_log_before_it_stays() {
    let file = path("gap.mcap");
    let recorder = Recorder::create(&file, &manifest(), RecorderOptions::default()).unwrap();
    still_window(&recorder, 0).unwrap();
    still_window(&recorder, 1).unwrap();
    let error = still_window(&recorder, 3).unwrap_err();
    let gap = |error: &LogError| {
        matches!(error, LogError::Sequence { source: SequenceError::Gap { step: 3, .. }, .. })
    };
    assert!(gap(&error), "{error}");
    // Even the right window no longer helps: the error stays.
    assert!(gap(&still_window(&recorder, 2).unwrap_err()));
    assert!(gap(&recorder.finish().unwrap_err()));
    let windows: Vec<_> = LogReader::open(&file).unwrap().windows().collect();
    assert_eq!(windows.len(), 2);
    assert!(windows.iter().all(Result::is_ok));
}

#[test]
fn a_window_without_its_messages_is_refused() {
    let file = path("missing.mcap");
    let recorder = Recorder::create(&file, &manifest(), RecorderOptions::default()).unwrap();
    recorder.record_command(&window(0, 0).command(Order::Advance)).unwrap();
    recorder.record_loads(&window(0, 0).header(), &[Loads::default(); GRAINS]).unwrap();
    let error = still_window(&recorder, 1).unwrap_err().to_string();
    assert!(error.contains("window 0") && error.contains("no kinematics"), "{error}");
    drop(recorder);
    let mut windows = LogReader::open(&file).unwrap().windows();
    assert!(windows.next().is_none());
    assert_eq!(windows.unfinished(), Some((0, 0)));
}

#[test]
fn other_counts_and_times_are_refused() {
    let new =
        || Recorder::to_writer(std::io::sink(), "none", &manifest(), RecorderOptions::default()).unwrap();
    let recorder = new();
    recorder.record_command(&window(0, 0).command(Order::Advance)).unwrap();
    let error = recorder.record_loads(&window(0, 0).header(), &[Loads::default()]).unwrap_err();
    assert!(error.to_string().contains("have 1 grains, the scene has 3"), "{error}");
    let recorder = new();
    still_window(&recorder, 0).unwrap();
    let mut back = window(1, 0);
    back.time = -DT;
    still_window(&recorder, 1).unwrap();
    back.step = 2;
    let error = recorder.record_command(&back.command(Order::Advance)).unwrap_err();
    assert!(error.to_string().contains("before the window in front"), "{error}");
}
