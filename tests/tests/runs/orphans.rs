//! What a solver that runs alone does when its `bedload` is gone, and programs at a closed pipe.

use std::process::{Command, Stdio};

use tests::harness::{
    Folder, LONG_FLIGHT, SMALL_BOUNCE, bedload, is_alive, program, said, signal, solvers, start, summary,
    wait_until,
};

/// Children of a process.
fn children(pid: u32) -> Vec<u32> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
    text.split_whitespace().filter_map(|pid| pid.parse().ok()).collect()
}

/// Kill -9, and the end of the terminal: the solver of a dry run is gone a second later.
#[test]
fn the_solver_of_a_dry_run_ends_with_its_bedload() {
    for how in ["KILL", "HUP"] {
        let folder = Folder::new(&format!("orphan-{how}"));
        let (scene, out) = (folder.write("long.toml", LONG_FLIGHT), folder.join("out"));
        let mut run = start(&["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
        let mut found = Vec::new();
        let begun = || std::fs::metadata(out.join("series.csv")).is_ok_and(|data| data.len() > 0);
        wait_until(20.0, || {
            found = children(run.id());
            !found.is_empty() && begun()
        })
        .expect("the solver runs");
        signal(run.id(), how);
        for pid in &found {
            wait_until(4.0, || !is_alive(*pid)).unwrap_or_else(|why| panic!("{how}: {why}"));
        }
        let _ = run.wait();
        if how == "HUP" {
            assert!(out.join("summary.json").exists(), "as at SIGTERM");
        }
    }
}

/// A reader that goes away is no fault.
#[test]
fn a_closed_pipe_is_no_error() {
    for (name, arguments) in
        [("bedload", ["schema"]), ("bedload-fluid", ["schema"]), ("bedload-dem", ["schema"])]
    {
        let mut child = Command::new(program(name))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("ends");
        assert_eq!(output.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stderr.is_empty(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn programs_have_their_own_names() {
    for name in ["bedload", "bedload-fluid", "bedload-dem"] {
        let output = Command::new(program(name)).arg("--version").output().expect("runs");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.starts_with(&format!("{name} ")), "{name}: {text}");
    }
}

#[test]
fn an_override_without_a_key_is_refused() {
    let folder = Folder::new("no-key");
    let scene = folder.write("long.toml", LONG_FLIGHT);
    let output = bedload(&["check", scene.to_str().expect("UTF-8"), "--set", "=1"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("names no key"), "{}", said(&output));
}

/// A coupled run that goes on for long, its solvers up and exchanging.
fn long_coupled(folder: &Folder) -> (std::process::Child, std::path::PathBuf) {
    let (scene, out) = (folder.write("bounce.toml", SMALL_BOUNCE), folder.join("out"));
    let keys = [
        "until=1e4",
        "coupling.deadline=0.5",
        "coupling.startup_deadline=1.0",
        "coupling.checkpoint_every=0.2",
    ];
    let mut arguments = vec!["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
    arguments.extend(keys.iter().flat_map(|key| ["--set", key]));
    let run = start(&arguments);
    wait_until(20.0, || out.join("series.csv").exists() && solvers(run.id()).len() == 2)
        .expect("both solvers run");
    (run, out)
}

/// A coupler that is stopped is as good as gone: its solvers leave by their limit, 2 (1 s + 2 · 0.5 s + 1 s).
#[test]
fn the_solvers_of_a_stopped_coupler_leave_by_their_limit() {
    let folder = Folder::new("stopped-coupler");
    let (mut run, out) = long_coupled(&folder);
    let found = solvers(run.id());
    signal(run.id(), "STOP");
    wait_until(15.0, || found.iter().all(|solver| !is_alive(solver.pid))).expect("they leave");
    signal(run.id(), "CONT");
    let code = run.wait().expect("it ends").code();
    assert_eq!((code, &summary(&out)["status"]), (Some(3), &"failed".into()));
}

/// The output folder is removed while the run goes on: that is told, with a code, at the next write.
#[test]
fn a_removed_output_folder_is_noticed() {
    let folder = Folder::new("removed");
    let (run, out) = long_coupled(&folder);
    std::fs::remove_dir_all(&out).expect("removed");
    let output = run.wait_with_output().expect("ends");
    let text = said(&output);
    assert!(matches!(output.status.code(), Some(1 | 5)), "{:?}: {text}", output.status);
    assert!(text.contains("out") && !text.contains("panicked"), "{text}");
}
