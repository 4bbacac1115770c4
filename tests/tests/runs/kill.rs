//! Kill -9 of each of the three processes at ten instants: the others end within a second with exit
//! code 3 and the name of the solver that failed, nothing is left in shared memory, the log is readable.

use std::path::Path;

use protocol::log::LogReader;
use rustix::process::{Pid, WaitOptions, getpid, set_child_subreaper, waitpid};
use tests::harness::{
    Folder, SMALL_BOUNCE, Solver, is_alive, leftovers, said, signal, solvers, start, wait_until,
};

/// Instants, as bytes that the log has reached: the first 20 kB or so are its schemas, then windows
/// follow.
const INSTANTS: [u64; 10] = [1, 24_000, 26_000, 28_000, 30_000, 34_000, 38_000, 44_000, 50_000, 60_000];

/// Ending takes a second at most; what more is granted covers a machine busy with other tests.
const SECONDS: f64 = 1.0;
const GRANTED: f64 = 3.0;

fn long_bounce() -> String {
    SMALL_BOUNCE.replace("until = 3.0", "until = 300.0")
}

/// Starts a long run and waits until its log has grown to `bytes`.
fn begun(scene: &Path, out: &Path, bytes: u64) -> (std::process::Child, Vec<Solver>) {
    let child = start(&["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    let log = out.join("exchange.mcap");
    wait_until(30.0, || std::fs::metadata(&log).is_ok_and(|data| data.len() >= bytes))
        .expect("the run begins");
    let mut found = Vec::new();
    wait_until(10.0, || {
        found = solvers(child.id());
        found.len() == 2
    })
    .expect("two solvers");
    (child, found)
}

/// The log can be read up to the last flushed step, without a gap; it is whole if the recorder lived.
fn assert_readable(log: &Path, recorder_lived: bool, bytes: u64) {
    let mut entries = 0;
    for entry in LogReader::open(log).expect("opens") {
        match entry {
            Ok(_) => entries += 1,
            Err(error) if error.is_truncation() && !recorder_lived => break,
            Err(error) => panic!("after {entries} messages: {error}"),
        }
    }
    assert!(entries > 0 || bytes < 24_000, "no message in a log of more than {bytes} bytes");
}

fn kill_a_solver(role: &str) {
    for (number, bytes) in INSTANTS.into_iter().enumerate() {
        let folder = Folder::new(&format!("kill-{role}-{number}"));
        let (scene, out) = (folder.write("bounce.toml", &long_bounce()), folder.join("out"));
        let (child, found) = begun(&scene, &out, bytes);
        let victim = found.iter().find(|solver| solver.role == role).expect("the victim runs");
        let pid = child.id();
        signal(victim.pid, "KILL");
        let took = wait_until(SECONDS + GRANTED, || !is_alive(pid)).expect("bedload ends");
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(3), "{}", said(&output));
        assert!(said(&output).contains(role), "{role} is not named: {}", said(&output));
        eprintln!(
            "{role} killed at {bytes} bytes of log: the run ended after {:.0} ms",
            took.as_secs_f64() * 1e3
        );
        for solver in &found {
            wait_until(SECONDS + GRANTED, || !is_alive(solver.pid)).expect("the solvers end");
            assert_eq!(leftovers(solver), Vec::<std::path::PathBuf>::new());
        }
        assert_readable(&out.join("exchange.mcap"), true, bytes);
    }
}

#[test]
fn a_killed_fluid_solver_ends_the_run() {
    kill_a_solver("fluid");
}

#[test]
fn a_killed_dem_ends_the_run() {
    kill_a_solver("dem");
}

/// Exit code of a solver whose parent has died: this process has become its parent.
fn exit_code_of_orphan(pid: u32) -> Option<i32> {
    let pid = Pid::from_raw(pid.try_into().ok()?)?;
    let (_, status) = waitpid(Some(pid), WaitOptions::empty()).expect("a child of ours")?;
    status.exit_status()
}

#[test]
fn a_killed_coupler_ends_the_solvers() {
    set_child_subreaper(Some(getpid())).expect("Linux 3.4");
    for (number, bytes) in INSTANTS.into_iter().enumerate() {
        let folder = Folder::new(&format!("kill-coupler-{number}"));
        let (scene, out) = (folder.write("bounce.toml", &long_bounce()), folder.join("out"));
        let (mut child, found) = begun(&scene, &out, bytes);
        signal(child.id(), "KILL");
        for solver in &found {
            wait_until(SECONDS + GRANTED, || !is_alive(solver.pid)).expect("the solvers end");
        }
        let _ = child.wait();
        for solver in &found {
            assert_eq!(exit_code_of_orphan(solver.pid), Some(3), "{}", solver.role);
            assert_eq!(leftovers(solver), Vec::<std::path::PathBuf>::new());
        }
        assert_readable(&out.join("exchange.mcap"), false, bytes);
    }
}
