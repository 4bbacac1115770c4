//! What a solver that runs alone, or a run of a study, does when its `bedload` is gone, and programs at a
//! closed pipe.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use bedload_output::Claim;
use bedload_program::ignores_hangups;

use tests::harness::{
    Folder, LONG_FLIGHT, SMALL_BOUNCE, bedload, children, descendants, is_alive, program, said, signal,
    solvers, start, summary, wait_until,
};

/// Is a run into `out` under way?
fn has_begun(out: &Path) -> bool {
    std::fs::metadata(out.join("series.csv")).is_ok_and(|data| data.len() > 0)
}

/// A run of a scene that one solver does by itself, under way: the run, its folder, its solver.
fn alone(folder: &Folder, scene: &str, more: &[&str]) -> (Child, PathBuf, u32) {
    let (scene, out) = (folder.write("long.toml", scene), folder.join("out"));
    let words = ["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
    let run = start(&[&words[..], more].concat());
    let mut found = Vec::new();
    wait_until(20.0, || {
        found = children(run.id());
        !found.is_empty() && has_begun(&out)
    })
    .expect("the solver runs");
    (run, out, found[0])
}

/// Kill -9, and the end of the terminal: the solver of a dry run is gone a second later.
#[test]
fn the_solver_of_a_dry_run_ends_with_its_bedload() {
    for how in ["KILL", "HUP"].into_iter().filter(|how| *how != "HUP" || !ignores_hangups()) {
        let folder = Folder::new(&format!("orphan-{how}"));
        let (mut run, out, solver) = alone(&folder, LONG_FLIGHT, &[]);
        signal(run.id(), how);
        wait_until(4.0, || !is_alive(solver)).unwrap_or_else(|why| panic!("{how}: {why}"));
        let _ = run.wait();
        if how == "HUP" {
            assert!(out.join("summary.json").exists(), "as at SIGTERM");
        }
    }
}

/// Under `nohup` a run goes on when its terminal closes: neither the run nor its solver heeds the hangup.
#[test]
fn a_run_that_ignores_hangups_goes_on() {
    let folder = Folder::new("nohup");
    let longer = LONG_FLIGHT.replace("until = 1e6", "until = 1e9");
    let (scene, out) = (folder.write("long.toml", &longer), folder.join("out"));
    let mut run = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$0\" run \"$1\" --out \"$2\""])
        .args([program("bedload"), scene, out.clone()])
        .stderr(Stdio::null())
        .spawn()
        .expect("starts");
    let mut found = Vec::new();
    wait_until(20.0, || {
        found = children(run.id());
        !found.is_empty() && has_begun(&out)
    })
    .expect("the solver runs");
    for pid in [run.id(), found[0]] {
        signal(pid, "HUP");
    }
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert!(is_alive(run.id()) && is_alive(found[0]), "a hangup ended what ignores it");
    signal(run.id(), "TERM");
    run.wait().expect("it ends");
    assert_eq!(summary(&out)["status"], "interrupted");
}

/// A solver that comes up when its `bedload` is dead already does not begin; it tells a process that nobody
/// has waited for from one that lives, and numbers of another place from its own.
#[test]
fn a_solver_whose_bedload_has_died_before_it_began_ends() {
    let folder = Folder::new("late");
    let scene = folder.write("long.toml", LONG_FLIGHT);
    let mut dead = Command::new("true").spawn().expect("starts");
    wait_until(5.0, || !is_alive(dead.id())).expect("it ends");
    let own = bedload_program::parent_name();
    let (_, place) = own.split_once(' ').expect("a number and a place");
    let begin = |parent: String| {
        let arguments = ["run".into(), scene.clone(), "--until".into(), "1".into(), "--out".into()];
        let mut command = Command::new(program("bedload-dem"));
        command.args(arguments).arg(folder.join("out")).env(bedload_program::PARENT, parent);
        command.stderr(Stdio::piped()).output().expect("runs")
    };
    let output = begin(format!("{} {place}", dead.id()));
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("has died"), "{}", said(&output));
    assert!(!folder.join("out").exists(), "nothing was begun");
    let output = begin(format!("{} elsewhere", dead.id()));
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    dead.wait().expect("waited for");
}

/// A case of one long run, and the folder of that.
fn long_case(folder: &Folder) -> (PathBuf, PathBuf) {
    let _ = folder.write("long.toml", &LONG_FLIGHT.replace("until = 1e6", "until = 1e9"));
    let case = "[case]\nname = \"long\"\ntitle = \"t\"\nsource = \"s\"\n[[case.runs]]\nlabel = \"a\"\n\
                scene = \"long.toml\"\n[[case.checks]]\nrun = \"a\"\nmetric = \"m\"\nkind = \"reported\"\n";
    (folder.write("case.toml", case), folder.join("out/long/a"))
}

/// Starts `validate`, waits until its run is under way, and finds that run and its solver.
fn validating(folder: &Folder) -> (Child, Vec<u32>) {
    let (case, run) = long_case(folder);
    let out = folder.join("out");
    let words = ["validate", case.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
    let study = start(&words);
    let mut found = Vec::new();
    wait_until(20.0, || {
        found = descendants(study.id());
        found.len() >= 2 && has_begun(&run)
    })
    .expect("the run and its solver");
    (study, found)
}

/// A study that is killed, or ended alone, takes its runs with it, and these leave a checkpoint.
#[test]
fn the_runs_of_a_study_end_with_it() {
    for how in ["KILL", "TERM", "HUP"].into_iter().filter(|how| *how != "HUP" || !ignores_hangups()) {
        let folder = Folder::new(&format!("study-{how}"));
        let (mut study, found) = validating(&folder);
        signal(study.id(), how);
        study.wait().expect("it ends");
        for pid in &found {
            wait_until(20.0, || !is_alive(*pid)).unwrap_or_else(|why| panic!("{how}: {why}"));
        }
        assert_eq!(summary(&folder.join("out/long/a"))["status"], "interrupted", "{how}");
    }
}

/// A run that could not be made, as its folder is in use, or that was interrupted, is no failed check.
#[test]
fn a_run_that_was_not_carried_out_fails_no_check() {
    let folder = Folder::new("not-carried-out");
    let (case, run) = long_case(&folder);
    std::fs::create_dir_all(&run).expect("made");
    let claim = Claim::of(&run).expect("free");
    let output =
        bedload(&["validate".as_ref(), case.as_os_str(), "--out".as_ref(), folder.join("out").as_os_str()]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(7), "{text}");
    assert!(text.contains("long/a was not carried out") && text.contains("in use"), "{text}");
    assert!(!text.contains("checks failed") && !folder.join("out/validation.md").exists(), "{text}");
    drop(claim);
    let (study, found) = validating(&folder);
    signal(found[0], "TERM");
    let output = study.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert!(said(&output).contains("long/a was not carried out"), "{}", said(&output));
}

/// A driven cavity, for hours.
const LONG_CAVITY: &str = r#"
until = 1e6
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = [16, 16]
boundary = { x = "no-slip", z_lower = "no-slip", z_upper = { type = "no-slip", velocity = [1.0, 0.0, 0.0] } }
[medium]
density = 1.0
viscosity = 0.01
[observe]
every = 10.0
"#;

/// A solver that runs by itself and is stopped, or hangs, is given up after six times the deadline, as a
/// coupled one is while files are written; one that goes on is not.
#[test]
fn a_stopped_solver_that_runs_by_itself_is_given_up() {
    for scene in [LONG_FLIGHT, LONG_CAVITY] {
        let folder = Folder::new("stopped");
        let keys = ["--until", "1e9", "--set", "coupling.deadline=0.2"];
        let (run, out, solver) = alone(&folder, scene, &keys);
        std::thread::sleep(std::time::Duration::from_millis(2500));
        assert!(is_alive(run.id()), "twice the limit, and it goes on");
        signal(solver, "STOP");
        wait_until(10.0, || !is_alive(run.id())).expect("it is given up");
        let output = run.wait_with_output().expect("ends");
        assert_eq!(output.status.code(), Some(3), "{}", said(&output));
        assert!(said(&output).contains("did nothing for 1.2 s"), "{}", said(&output));
        assert_eq!(summary(&out)["status"], "failed");
        assert!(!is_alive(solver));
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
fn long_coupled(folder: &Folder) -> (Child, PathBuf) {
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
