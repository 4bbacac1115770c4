//! Whole runs with real processes: to the end, interrupted and resumed, and with solvers that die,
//! hang, lie and fail. Every end has its exit code, its words and its summary.

use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::fake_solvers::{Room, bedload, run, scene, stderr};
use protocol::log::LogReader;

#[test]
fn a_good_run_leaves_everything_behind() {
    let room = Room::new("good");
    let path = room.put(&scene("good", "good", ""));
    let output = run(&room, &path, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let summary = room.summary();
    assert_eq!(summary["status"], "completed");
    assert_eq!(summary["time"]["fluid_steps"], 20);
    assert_eq!(summary["time"]["dem_substeps"], 80, "ceil(0.01/0.003) in each of 20 windows");
    assert!((summary["time"]["simulated"].as_f64().unwrap() - 0.2).abs() < 1e-15);
    assert!(summary["cost"]["wall_s"].as_f64().unwrap() > 0.0);
    // Grain 1 starts at rest: v' = −v − 1 in steps of the fluid.
    let v = (0..20).fold(0.0, |v: f64, _| v - 0.01 * (v + 1.0));
    let series = bedload_output::Series::read(&room.out().join("series.csv")).unwrap();
    let measured = *series.column("velocity_z[1]").unwrap().last().unwrap();
    assert!((measured - v).abs() < 1e-12, "{measured} {v}");
    let reader = LogReader::open(&room.out().join("exchange.mcap")).unwrap();
    let steps: Vec<u64> = reader.map(|entry| entry.unwrap().step).collect();
    assert_eq!(steps.last(), Some(&19));
    assert!(room.read("scene.toml").contains("max_dt_over_contact_time"), "defaults are written out");
    assert!(room.out().join("plan.json").is_file());
    assert!(room.read("report.html").contains("</html>"));
    assert!(stderr(&output).contains("does not answer `check SCENE --json`"), "{}", stderr(&output));
}

#[test]
fn no_record_leaves_no_log() {
    let room = Room::new("norecord");
    let path = room.put(&scene("good", "good", ""));
    assert_eq!(run(&room, &path, &["--no-record", "--until", "0.05"]).status.code(), Some(0));
    assert!(!room.out().join("exchange.mcap").exists());
    assert_eq!(room.summary()["time"]["fluid_steps"], 5);
}

#[test]
fn a_solver_that_dies_is_named_with_its_last_words() {
    for (fluid, dem, name) in [("die:7", "good", "bedload-fluid"), ("good", "die:7", "bedload-dem")] {
        let room = Room::new(&format!("dies-{name}"));
        let path = room.put(&scene(fluid, dem, ""));
        let start = Instant::now();
        let output = run(&room, &path, &[]);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(3), "{text}");
        assert!(text.contains(&format!("{name} was killed")) && text.contains("farewell"), "{text}");
        assert!(start.elapsed() < Duration::from_secs(4), "{:?}", start.elapsed());
        let summary = room.summary();
        assert_eq!(summary["status"], "failed");
        assert!(summary["error"].as_str().unwrap().contains(name));
        let steps = summary["time"]["fluid_steps"].as_u64();
        assert!(matches!(steps, Some(6 | 7)), "what was done counts: {steps:?}");
    }
}

#[test]
fn a_solver_that_hangs_runs_into_the_deadline() {
    let room = Room::new("hangs");
    let path = room.put(&scene("good", "hang:3", ""));
    let start = Instant::now();
    let output = run(&room, &path, &["--set", "coupling.deadline=0.5"]);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(text.contains("dem did not answer within 0.5 s in window"), "{text}");
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

#[test]
fn a_solver_that_miscounts_or_sends_nonsense_or_gives_up_stops_the_run() {
    for (fluid, dem, words) in [
        ("good", "miscount:4", vec!["the dem solver did 3 sub-steps in window 4 where 4 were ordered"]),
        ("good", "nan:4", vec!["the dem solver sent velocity[2]", "grain 1", "window 4"]),
        ("nan:4", "good", vec!["the fluid solver sent force[1]", "grain 0", "window 4"]),
        ("good", "quaternion:4", vec!["orientation = [0.0, 0.0, 0.0, 0.0]", "grain 1", "window 4"]),
        ("good", "outside:4", vec!["position[2] = 4.6, outside the box", "grain 1", "window 4"]),
        ("good", "jump:4", vec!["grain 1", "window 4"]),
        ("good", "overlap:4", vec!["grain", "window 4"]),
        ("good", "gap:4", vec!["gap = NaN of grain 1", "window 4"]),
        ("good", "smallest-gap:4", vec!["smallest_gap = NaN", "window 4"]),
        ("good", "largest-overlap:4", vec!["largest_overlap = NaN", "window 4"]),
        ("good", "time:4", vec!["Kinematics with time", "window 4", "coupler's time"]),
        ("good", "dt-limit:4", vec!["the dem solver reports dt_limit = NaN after window 4"]),
        ("dt-limit:4", "good", vec!["the fluid solver reports dt_limit = NaN after window 4"]),
        ("residual:4", "good", vec!["the fluid solver reports residual = NaN after window 4"]),
        ("good", "spun:4", vec!["the spin of grain 0", "window 4"]),
        ("good", "gap-infinite:4", vec!["gap = -inf of grain 1", "window 4"]),
        ("good", "gap-deep:4", vec!["gap = -1e300 of grain 1", "window 4"]),
        ("good", "smallest-gap-infinite:4", vec!["smallest_gap = -inf in window 4"]),
        ("good", "smallest-gap-far:4", vec!["smallest_gap = 1e308", "window 4"]),
        ("good", "contact:4", vec!["contact_force = [1e300", "of grain 1", "window 4"]),
        ("good", "impact:4", vec!["impact_speed = -1e300 of grain 1", "window 4"]),
        ("good", "grains:4", vec!["the dem solver reports grains = 3 after window 4", "where 2 was due"]),
        (
            "good",
            "substeps:4",
            vec!["the dem solver reports substeps = 16 after window 4", "where 20 was due"],
        ),
        ("fail:4", "good", vec!["the fluid solver failed: the pressure solver diverged"]),
        ("good", "fail:4", vec!["the dem solver failed: the pressure solver diverged"]),
        ("leave:4", "good", vec!["bedload-fluid left with exit code 1"]),
    ] {
        let room = Room::new(&format!("stops-{}-{}", fluid.replace(':', ""), dem.replace(':', "")));
        let path = room.put(&scene(fluid, dem, ""));
        let output = run(&room, &path, &[]);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{fluid} {dem}: {text}");
        for word in words {
            assert!(text.contains(word), "{fluid} {dem}: {word:?} in {text}");
        }
        assert_eq!(room.summary()["status"], "failed");
        let steps = room.summary()["time"]["fluid_steps"].as_u64();
        // Windows 0 to 2 are done; the other solver may not have reported window 3 yet.
        assert!(matches!(steps, Some(3 | 4)), "{fluid} {dem}: {steps:?}");
    }
}

/// A few windows of places beside the velocity: each is possible, together they are not.
#[test]
fn places_that_do_not_follow_the_velocity_stop_the_run() {
    for how in ["frozen:4", "drift:4"] {
        let room = Room::new(&format!("beside-{}", &how[..5]));
        let path = room.put(&scene("good", how, ""));
        let output = run(&room, &path, &["--until", "2.0"]);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{how}: {text}");
        assert!(text.contains("places of grain 0") && text.contains("touched nothing"), "{how}: {text}");
    }
}

/// Which process is at fault, and in which window, whatever was ordered ahead and whatever it reports.
#[test]
fn the_solver_that_is_behind_is_named_with_its_window() {
    let limits = ["--set", "coupling.deadline=0.5", "--set", "coupling.startup_deadline=2.0"];
    for (fluid, dem, code, words) in [
        ("good", "hang:5", 3, "dem did not answer within 0.5 s in window 5:"),
        ("hang:5", "good", 3, "fluid did not answer within 0.5 s in window 5:"),
        ("good", "unsent:5", 3, "dem did not answer within 0.5 s in window 5:"),
        ("good", "spaced:5", 1, "Kinematics of window 6 attempt 0 came, where window 5 attempt 0 was due"),
        ("good", "absent", 3, "dem did not join within 2 s"),
        ("absent", "good", 3, "fluid did not join within 2 s"),
    ] {
        let room = Room::new(&format!("behind-{}-{}", fluid.replace(':', ""), dem.replace(':', "")));
        let path = room.put(&scene(fluid, dem, ""));
        let output = run(&room, &path, &limits);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{fluid} {dem}: {text}");
        assert!(text.contains(words), "{fluid} {dem}: {words:?} in {text}");
    }
}

#[test]
fn a_window_whose_last_report_is_late_counts_although_the_other_solver_fails() {
    let room = Room::new("late");
    let path = room.put(&scene("fail:4", "late:3", ""));
    let output = run(&room, &path, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("the pressure solver diverged"), "{}", stderr(&output));
    assert_eq!(room.summary()["time"]["fluid_steps"], 4, "windows 0 to 3 are done");
}

#[test]
fn an_interrupted_run_goes_on_bit_for_bit() {
    let whole = Room::new("whole");
    let path = whole.put(&scene("good", "slow", ""));
    let output = run(&whole, &path, &["--until", "1.0"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));

    let cut = Room::new("cut");
    let out = cut.out();
    let arguments = ["run", path.to_str().unwrap(), "--out", out.to_str().unwrap(), "--until", "1.0"];
    let child = bedload(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while !out.join("exchange.mcap").exists() && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(400));
    let pid = rustix::process::Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    let summary = cut.summary();
    assert_eq!(summary["status"], "interrupted");
    let done = summary["time"]["fluid_steps"].as_u64().unwrap();
    assert!((1..100).contains(&done), "interrupted in the middle: {done}");
    assert!(LogReader::open(&out.join("exchange.mcap")).unwrap().all(|entry| entry.is_ok()));

    let output = run(&cut, &path, &["--until", "1.0", "--resume"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(cut.read("series.csv"), whole.read("series.csv"));
    assert_eq!(cut.summary()["time"], whole.summary()["time"]);
    for role in ["fluid", "dem"] {
        let file = format!("checkpoint/0000000100/{role}.checkpoint");
        let bytes = |room: &Room| std::fs::read(room.out().join(&file)).unwrap();
        assert_eq!(bytes(&cut), bytes(&whole), "{role}");
    }
    let second = LogReader::open(&out.join("exchange.2.mcap")).unwrap();
    assert_eq!(second.manifest().first_step, done);
    assert!(second.inspect(|entry| assert!(entry.is_ok())).count() > 0);

    // Another scene must not go on from this checkpoint.
    let other = ["--until", "1.0", "--resume", "--set", "gravity=[0.0, 0.0, -2.0]"];
    let output = run(&cut, &path, &other);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}

/// As a run leaves it that is killed between its last checkpoint and its end.
#[test]
fn a_run_that_is_resumed_at_its_end_leaves_what_it_would_have_left() {
    let room = Room::new("resumed-at-end");
    let metric =
        "[[metrics]]\nname = \"height\"\nkind = \"deposit-height\"\nhalf_length = 1.0\ncentre = 2.0\n";
    let path = room.put(&scene("good", "good", metric));
    let output = run(&room, &path, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let left = || (room.read("grains.csv"), room.read("deposit.csv"), room.summary()["metrics"].clone());
    let before = left();
    assert!(before.2["height"]["value"].as_f64().is_some_and(|height| height > 0.0), "{}", before.2);
    for name in ["grains.csv", "deposit.csv", "summary.json"] {
        std::fs::remove_file(room.out().join(name)).expect(name);
    }
    for command in ["report", "film"] {
        let output = bedload(&[command, room.out().to_str().unwrap()]).output().unwrap();
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("under way or was cut off") && text.contains("--resume"), "{text}");
    }
    let output = run(&room, &path, &["--resume"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(left(), before);
}

#[test]
fn a_folder_that_cannot_be_made_is_bad_input() {
    let room = Room::new("place");
    let path = room.put(&scene("good", "good", ""));
    let place = path.join("out");
    let output =
        bedload(&["run", path.to_str().unwrap(), "--out", place.to_str().unwrap()]).output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("cannot make the output folder") && text.contains("name another with --out"),
        "{text}"
    );
}

/// Below the limit of files that a coupled run needs it says so, and above it runs.
#[test]
fn a_limit_of_open_files_is_named_with_what_is_needed() {
    let room = Room::new("descriptors");
    let path = room.put(&scene("good", "good", ""));
    let (out, program) = (room.out(), env!("CARGO_BIN_EXE_bedload"));
    for limit in [8, 16, 32, 48, 64, 95, 96] {
        let script = format!("ulimit -n {limit}; exec \"$@\"");
        let mut command = std::process::Command::new("sh");
        command.args(["-c", &script, "sh", program, "run"]).arg(&path);
        let output = command.args(["--overwrite", "--out"]).arg(&out).output().unwrap();
        let text = stderr(&output);
        if limit < 96 {
            assert_eq!(output.status.code(), Some(1), "{limit}: {text}");
            let needed = if limit < 32 { 32 } else { 96 };
            let words = format!("may have {limit} files open at once here, this run needs {needed}");
            assert!(text.contains(&words), "{limit}: {text}");
        } else {
            assert_eq!(output.status.code(), Some(0), "{limit}: {text}");
        }
    }
}

/// What steers a terminal, in the words of a solver and in those of a scene, is written out.
#[test]
fn text_of_others_does_not_steer_the_terminal() {
    let room = Room::new("terminal");
    let path = room.put(&scene("good", "paint:4", ""));
    let output = run(&room, &path, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("\\u{1b}[31mred"), "{}", stderr(&output));
    assert!(stderr(&output).contains("\\u{1b}]0;words"), "{}", stderr(&output));
    assert!(!output.stderr.contains(&0x1b), "{}", stderr(&output));
    let text = scene("good", "good", "\"\\u001b[31mkey\" = 1\n")
        .replace("title = \"fakes\"", "title = \"\\u001b[31m\"");
    let path = room.put(&text);
    let output = run(&room, &path, &["--overwrite"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(!stderr(&output).contains("\u{1b}[31mkey"), "{}", stderr(&output));
    let path = room.put(&text.replace("\"\\u001b[31mkey\" = 1\n", ""));
    assert_eq!(run(&room, &path, &["--overwrite"]).status.code(), Some(0));
    let log = room.out().join("exchange.mcap");
    let output = bedload(&["log", "info", log.to_str().unwrap()]).output().unwrap();
    assert!(output.status.success() && !output.stdout.contains(&0x1b));
}

#[test]
fn a_second_signal_kills() {
    let room = Room::new("second");
    let path = room.put(&scene("good", "hang:2", "startup_deadline = 5.0"));
    let out = room.out();
    let arguments =
        ["run", path.to_str().unwrap(), "--out", out.to_str().unwrap(), "--set", "coupling.deadline=60"];
    let child = bedload(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while !out.join("exchange.mcap").exists() && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(200));
    let pid = rustix::process::Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
    let start = Instant::now();
    for _ in 0..2 {
        rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
        std::thread::sleep(Duration::from_millis(100));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(start.elapsed() < Duration::from_secs(3), "{:?}", start.elapsed());
}
