//! A long coupled run of a scene as small as can be, and the resident memory of its processes against the
//! window.
//!
//! ```text
//! cargo build --release
//! cargo run --release -p tests --example soak -- --windows 10000000 [--minutes 15] [--no-record]
//! ```
//!
//! After `--minutes` the run is interrupted, and the table says how far it came.

use std::path::Path;
use std::process::{Child, ExitCode};
use std::time::{Duration, Instant};

use tests::harness::{Folder, is_alive, said, signal, solvers, start};

/// A sphere that drifts through a coarse box and touches nothing: windows of one sub-step.
const SCENE: &str = r#"
title = "Soak"
gravity = [0.0, 0.0, 0.0]

[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [1.5, 3.0]
cells = [8, 16]

[domain.boundary]
r_upper = "free-slip"
z = "periodic"

[medium]
density = 1.0
viscosity = 0.05

[[grains]]
position = [0.0, 0.0, 1.5]
velocity = [0.0, 0.0, 0.1]
radius = 0.5
density = 8.0

[fluid.time]
dt = 0.01

[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.97
contact_time = 2e-3
"#;

/// Length of a window, as in the scene.
const DT: f64 = 0.01;
/// Samples of a whole run.
const SAMPLES: f64 = 1000.0;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |name: &str, default: f64| {
        let place = arguments.iter().position(|argument| argument == name);
        place.and_then(|place| arguments.get(place + 1)?.parse().ok()).unwrap_or(default)
    };
    let windows: f64 = number("--windows", 1e7);
    let minutes: f64 = number("--minutes", f64::INFINITY);
    let folder = Folder::new("soak");
    let until = windows * DT;
    let scene = folder.write(
        "soak.toml",
        &format!("until = {until:?}\n{SCENE}\n[observe]\nevery = {:?}\n", until / SAMPLES),
    );
    let out = folder.join("out");
    let mut words =
        vec!["run".to_owned(), scene.display().to_string(), "--out".to_owned(), out.display().to_string()];
    words.extend(["--threads".to_owned(), "1".to_owned()]);
    words.extend(arguments.iter().filter(|word| *word == "--no-record").cloned());
    let child = start(&words);
    let rows = watch(child, &out, minutes);
    println!("| window | coupler: resident, peak, MB | fluid | DEM |\n|---:|---|---|---|");
    for (row, next) in rows.iter().zip(rows.iter().skip(1).map(Some).chain([None])) {
        // One row for each third of a decade, and the last.
        let third = |row: &Row| (3.0 * row.window.max(1.0).log10()).floor();
        if next.is_none_or(|next| third(next) > third(row)) {
            println!("{row}");
        }
    }
    ExitCode::SUCCESS
}

/// Memory at a window.
struct Row {
    window: f64,
    /// Resident and peak of coupler, fluid and DEM, kB.
    memory: [[f64; 2]; 3],
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "| {:.0} |", self.window)?;
        for [resident, peak] in self.memory {
            write!(f, " {:.2}, {:.2} |", resident * 1e-3, peak * 1e-3)?;
        }
        Ok(())
    }
}

/// Samples the run until it ends; after `minutes` it is interrupted.
fn watch(child: Child, out: &Path, minutes: f64) -> Vec<Row> {
    let (begin, pid, mut rows) = (Instant::now(), child.id(), Vec::new());
    let mut asked = false;
    while is_alive(pid) {
        std::thread::sleep(Duration::from_millis(250));
        if !asked && begin.elapsed().as_secs_f64() > 60.0 * minutes {
            asked = true;
            signal(pid, "INT");
        }
        rows.extend(sample(pid, out));
    }
    let seconds = begin.elapsed().as_secs_f64();
    let output = child.wait_with_output().expect("it has ended");
    let text = std::fs::read_to_string(out.join("summary.json")).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let done = summary["time"]["fluid_steps"].as_f64().unwrap_or(0.0);
    println!(
        "{done} windows in {seconds:.0} s, {:.1} µs each, exit code {:?}, status {}",
        seconds / done * 1e6,
        output.status.code(),
        summary["status"]
    );
    println!("peak at the end, bytes: {}", summary["cost"]["peak_rss_bytes"]);
    for log in std::fs::read_dir(out).into_iter().flatten().flatten() {
        if let (true, Ok(data)) = (log.path().extension().is_some_and(|end| end == "mcap"), log.metadata()) {
            println!("log: {:.3} GB", data.len() as f64 * 1e-9);
        }
    }
    if done == 0.0 {
        println!("{}", said(&output));
    }
    rows
}

fn sample(pid: u32, out: &Path) -> Option<Row> {
    let found = solvers(pid);
    let of =
        |role: &str| found.iter().find(|solver| solver.role == role).and_then(|solver| memory(solver.pid));
    let series = std::fs::read_to_string(out.join("series.csv")).ok()?;
    let mut lines = series.lines();
    let place = lines.next()?.split(',').position(|name| name == "t")?;
    let time: f64 = series[..=series.rfind('\n')?].lines().last()?.split(',').nth(place)?.parse().ok()?;
    Some(Row { window: (time / DT).round(), memory: [memory(pid)?, of("fluid")?, of("dem")?] })
}

/// Resident memory and its peak, kB.
fn memory(pid: u32) -> Option<[f64; 2]> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let value = |name: &str| {
        let line = text.lines().find(|line| line.starts_with(name))?;
        line.split_whitespace().nth(1)?.parse().ok()
    };
    Some([value("VmRSS:")?, value("VmHWM:")?])
}
