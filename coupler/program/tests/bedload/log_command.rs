//! `bedload log` on small logs.

use std::io::Write;
use std::path::{Path, PathBuf};

use bedload_output::{Claim, OutputError};
use coupler::failure::Failure;
use coupler::log_command::{CatOptions, LogCommandError, cat, info, parse_steps, repair, thin};
use protocol::log::{LogError, Manifest, Recorder};
use protocol::message::{Command, Header, Kinematics, Loads, Order, State, Status};
use protocol::participant::{Role, SolverError};
use serde_json::json;

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

/// A run would go on with a log that no name leads to.
#[test]
fn a_log_that_a_run_writes_is_not_replaced() {
    let folder = std::env::temp_dir().join(format!("bedload-{}-written", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("exchange.mcap");
    std::fs::rename(log("written.mcap"), &path).unwrap();
    std::fs::write(folder.join("scene.toml"), "# Bedload output: a scene\n").unwrap();
    let (before, claim) = (std::fs::read(&path).unwrap(), Claim::of(&folder).unwrap());
    let failure = Failure::from(repair(&path, None, &mut Vec::new()).expect_err("it is in use"));
    assert_eq!(failure.exit_code(), 7);
    assert!(failure.to_string().contains("in use") && failure.to_string().contains("LOG OUT"), "{failure}");
    assert_eq!(std::fs::read(&path).unwrap(), before);
    printed(|out| repair(&path, Some(&folder.join("left.mcap")), out));
    drop(claim);
    printed(|out| repair(&path, None, out));
    std::fs::remove_dir_all(folder).unwrap();
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
    // A list or table that a solver writes.
    let error = OutputError::file("write", Path::new("grains.pvd"))(std::io::ErrorKind::StorageFull.into());
    assert_eq!(Failure::from(SolverError::from(error)).exit_code(), 5);
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
