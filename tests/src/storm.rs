//! A storm of kills: runs, replays and ensembles of small scenes lose a random process at a random time. What
//! is promised of that is checked: nothing stays, every log can be read, and `--resume`, or the same command
//! once more, ends with the bits of one that was left alone.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Output};
use std::time::{Duration, Instant, SystemTime};

use bedload_program::ignores_hangups;

use crate::harness::{bedload, descendants, is_alive, said, signal, start, wait_until};
use crate::random::Random;

mod scenes;
mod traces;

use scenes::Work;
pub use scenes::{KINDS, Kind};
use traces::{Traces, processes};

/// Nothing here takes so long, s: what does hangs.
const HANGS: f64 = 60.0;
/// The log of a run.
const LOG: &str = "exchange.mcap";
/// Share of the wall time of a whole run in which the kill falls.
const LATEST: f64 = 0.98;

/// What a storm is to do.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Kills.
    pub kills: usize,
    /// Seed of kinds, victims, signals and times.
    pub seed: u64,
    /// Kinds of runs, of [`KINDS`].
    pub kinds: Vec<&'static Kind>,
    /// Processes of a run are gone after this, s.
    pub gone: f64,
    /// Folder for the runs; that of a run with a broken promise stays.
    pub folder: PathBuf,
}

/// What a storm found.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// By kind of run and victim, each count by its title.
    pub counts: BTreeMap<(&'static str, &'static str), BTreeMap<&'static str, usize>>,
    /// Broken promises, each with all that is needed to meet it again.
    pub broken: Vec<String>,
    /// Kills that came after the run had ended; they were drawn again.
    pub late: usize,
}

/// What is counted: the titles of the table, beside those of run and victim. Segments are of shared memory;
/// those that outlive the next start are left over.
const COLUMNS: [&str; 11] = [
    "kills",
    "of these TERM, HUP",
    "left-over processes",
    "segments until the next start",
    "left-over segments",
    "unreadable logs",
    "wrong summaries",
    "went on",
    "not the same bits",
    "resumes refused",
    "began anew",
];

impl Report {
    /// The table, in Markdown.
    pub fn table(&self) -> String {
        let mut text =
            format!("| run | victim | {} |\n|---|---|{}\n", COLUMNS.join(" | "), "---:|".repeat(11));
        let mut sum = [0; 11];
        for ((kind, victim), counts) in &self.counts {
            let row = COLUMNS.map(|column| counts.get(column).copied().unwrap_or(0));
            let _ =
                writeln!(text, "| {kind} | {victim} | {} |", row.map(|count| count.to_string()).join(" | "));
            sum.iter_mut().zip(row).for_each(|(sum, count)| *sum += count);
        }
        let _ = writeln!(text, "| all | | {} |", sum.map(|count| count.to_string()).join(" | "));
        text
    }

    /// Kills so far.
    pub fn kills(&self) -> usize {
        self.counts.values().filter_map(|counts| counts.get("kills")).sum()
    }
}

/// One kill, as it was drawn.
struct Strike {
    victim: &'static str,
    signal: &'static str,
    /// From the start of the coupler, s.
    at: f64,
}

impl Strike {
    fn draw(random: &mut Random, kind: &Kind, takes: f64) -> Self {
        // under `nohup` a hangup is ignored
        let hangup = if ignores_hangups() { "TERM" } else { "HUP" };
        let signal = random.one_of(&["KILL", "KILL", "KILL", "KILL", "TERM", hangup]);
        Self { victim: random.one_of(kind.victims), signal, at: random.between(0.0, LATEST * takes) }
    }
}

/// Does the storm; `tell` hears of every kill. Panics where the system refuses what the storm itself needs.
pub fn storm(plan: &Plan, tell: &mut dyn FnMut(&Report)) -> Report {
    let mut report = Report::default();
    let mut random = Random::new(plan.seed);
    let references: Vec<Reference> =
        plan.kinds.iter().map(|kind| Reference::make(kind, &plan.folder)).collect();
    let mut number = 0;
    while report.kills() < plan.kills {
        let reference = &references[random.one_of(&(0..references.len()).collect::<Vec<_>>())];
        number += 1;
        let mut run = Run::new(reference, plan, number);
        run.strikes(&mut random, &mut report, plan.kills);
        tell(&report);
    }
    report
}

/// Work that nobody disturbed.
struct Reference {
    kind: &'static Kind,
    /// What it wrote.
    out: PathBuf,
    /// Wall time of a whole run, s. It follows the load of the machine, so that kills fall within runs.
    takes: Cell<f64>,
}

impl Reference {
    fn make(kind: &'static Kind, folder: &Path) -> Self {
        let home = folder.join(format!("whole-{}", kind.name.replace(' ', "-")));
        let (scene, out) = write_scene(kind, &home);
        let done = |arguments: &[String]| {
            let output = bedload(arguments);
            assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        };
        if kind.work == Work::Replay {
            done(&arguments(Work::Run, &scene, &out, false));
        }
        let begin = Instant::now();
        done(&arguments(kind.work, &scene, &out, false));
        Self { kind, out, takes: Cell::new(begin.elapsed().as_secs_f64()) }
    }

    /// A kill came too late, or not.
    fn learn(&self, late: bool) {
        self.takes.set(self.takes.get() * if late { 0.9 } else { 1.02 });
    }
}

fn write_scene(kind: &Kind, home: &Path) -> (PathBuf, PathBuf) {
    let _ = std::fs::remove_dir_all(home);
    std::fs::create_dir_all(home).expect("a folder for the run");
    let scene = home.join("scene.toml");
    std::fs::write(&scene, kind.scene()).expect("a file for the run");
    (scene, home.join("out"))
}

fn arguments(work: Work, scene: &Path, out: &Path, resume: bool) -> Vec<String> {
    let (scene, log) = (scene.display().to_string(), out.join(LOG).display().to_string());
    let out = out.display().to_string();
    let mut words = match work {
        Work::Run => vec!["run", &scene, "--out", &out, "--threads", "1"],
        Work::Replay => vec!["replay", &log, "--drive", "fluid", "--verify"],
        Work::Ensemble => vec!["ensemble", &scene, "--seeds", "3", "--jobs", "2", "--out", &out],
    };
    words.extend(resume.then_some("--resume"));
    words.into_iter().map(str::to_owned).collect()
}

/// A run that is struck, perhaps more than once, and brought to its end.
struct Run<'a> {
    reference: &'a Reference,
    home: PathBuf,
    scene: PathBuf,
    out: PathBuf,
    /// Where it stands in the storm.
    name: String,
    /// Traces of the last kill in shared memory, to be gone after the next start.
    traces: Traces,
    victim: &'static str,
    gone: f64,
}

impl<'a> Run<'a> {
    fn new(reference: &'a Reference, plan: &Plan, number: usize) -> Self {
        let Plan { folder, seed, gone, .. } = plan;
        let home = folder.join(format!("run-{number}"));
        let (scene, out) = write_scene(reference.kind, &home);
        if reference.kind.work == Work::Replay {
            std::fs::create_dir_all(&out).expect("a folder");
            std::fs::copy(reference.out.join(LOG), out.join(LOG)).expect("the log of the whole run");
        }
        let name = format!("seed {seed}, run {number} ({})", reference.kind.name);
        Self { reference, home, scene, out, name, traces: Traces::default(), victim: "", gone: *gone }
    }

    /// Strikes, goes on, is perhaps struck again, and ends.
    fn strikes(&mut self, random: &mut Random, report: &mut Report, most: usize) {
        let before = report.broken.len();
        loop {
            let strike = Strike::draw(random, self.reference.kind, self.reference.takes.get());
            let again = random.unit() < 0.3;
            let hit = self.strike(&strike, report);
            self.reference.learn(!hit);
            if !hit {
                report.late += 1;
                break;
            }
            if !again || report.kills() >= most {
                self.go_on(report);
                break;
            }
        }
        if report.broken.len() == before {
            let _ = std::fs::remove_dir_all(&self.home);
        }
    }

    fn count(&self, report: &mut Report, column: &'static str, number: usize) {
        assert!(COLUMNS.contains(&column), "{column}");
        let counts = report.counts.entry((self.reference.kind.name, self.victim)).or_default();
        *counts.entry(column).or_default() += number;
    }

    fn blame(&self, report: &mut Report, column: &'static str, what: &str) {
        self.count(report, column, 1);
        report.broken.push(format!("{}, {} killed: {what}", self.name, self.victim));
    }

    /// Starts the run, or goes on with it, and kills a process of it. False: it ended before that.
    fn strike(&mut self, strike: &Strike, report: &mut Report) -> bool {
        let resume = self.has_checkpoint();
        let began = SystemTime::now();
        let work = self.reference.kind.work;
        let mut child = start(&arguments(work, &self.scene, &self.out, resume));
        let begin = Instant::now();
        while begin.elapsed().as_secs_f64() < strike.at {
            std::thread::sleep(Duration::from_micros(200));
        }
        let Some(pid) = self.victim_of(&mut child, strike.victim) else {
            let output = ended(child);
            self.end(&output, report);
            return false;
        };
        let family = self.family(&child);
        let traces = Traces::of(&family);
        signal(pid, strike.signal);
        let resumed = if resume { ", resumed" } else { "" };
        let after = format!("{:.4} s after the start by {}{resumed}", strike.at, strike.signal);
        self.check_traces(report);
        self.victim = strike.victim;
        self.traces = traces;
        self.count(report, "kills", 1);
        self.count(report, "of these TERM, HUP", usize::from(strike.signal != "KILL"));
        // an ensemble that loses a run goes on with the others
        let goes_on = work == Work::Ensemble && strike.victim != "coupler";
        let left = |child: &mut Child| -> BTreeSet<u32> {
            reap(&family, child.id());
            let _ = child.try_wait();
            let alive = family.iter().copied().filter(|pid| is_alive(*pid));
            alive.chain(processes(&self.home)).collect()
        };
        let gone = wait_until(if goes_on { HANGS } else { self.gone }, || left(&mut child).is_empty());
        if gone.is_err() {
            let left = left(&mut child);
            let what = format!("{after}: {} processes are left: {left:?}", left.len());
            self.blame(report, "left-over processes", &what);
            left.iter().for_each(|pid| signal(*pid, "KILL"));
        }
        let output = ended(child);
        let stayed = !self.traces.left().is_empty();
        self.count(report, "segments until the next start", usize::from(stayed));
        if work == Work::Run && (strike.victim != "coupler" || strike.signal != "KILL") {
            self.check_words(&output, began, &after, report);
        }
        self.check_logs(&after, report);
        true
    }

    /// The victim's process; waits for it to start. None: the run has ended.
    fn victim_of(&self, child: &mut Child, victim: &str) -> Option<u32> {
        let own = child.id();
        let mut found = None;
        let waited = wait_until(HANGS, || {
            if !matches!(child.try_wait(), Ok(None)) {
                return true;
            }
            found = if victim == "coupler" { Some(own) } else { traces::solver_of(own, victim) };
            found.is_some()
        });
        waited.expect("the victim starts, or the run ends");
        found
    }

    /// The work's processes, its first one too.
    fn family(&self, child: &Child) -> BTreeSet<u32> {
        let own = child.id();
        processes(&self.home).into_iter().chain([own]).chain(descendants(own)).collect()
    }

    fn has_checkpoint(&self) -> bool {
        protocol::checkpoints::newest(&self.out.join("checkpoint")).is_some()
    }

    /// Nothing of the last kill is left in shared memory once a run has started since.
    fn check_traces(&mut self, report: &mut Report) {
        let traces = std::mem::take(&mut self.traces);
        let left = traces.left();
        if !left.is_empty() {
            let what = format!("left in shared memory after the next start: {left:?}");
            self.blame(report, "left-over segments", &what);
        }
    }

    /// A coupler that lived says what happened.
    fn check_words(&self, output: &Output, began: SystemTime, after: &str, report: &mut Report) {
        let code = output.status.code();
        let text = std::fs::read_to_string(self.out.join("summary.json")).unwrap_or_default();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let status = summary["status"].as_str().unwrap_or("");
        let right = match code {
            Some(0) => status == "completed",
            // Before it listens to signals there is nothing to sum up.
            None => !self.wrote_since(began),
            Some(130) => status == "interrupted" || !self.wrote_since(began),
            Some(_) => status == "failed" && summary["error"].is_string() || !self.wrote_since(began),
        };
        if !right {
            let words =
                format!("{after}: exit code {code:?}, summary `{status}`, said: {}", said(output).trim());
            self.blame(report, "wrong summaries", &words);
        }
    }

    /// Has the run come so far that it wrote its scene? A tick of the file system's clock is granted.
    fn wrote_since(&self, began: SystemTime) -> bool {
        let written = std::fs::metadata(self.out.join("scene.toml")).and_then(|data| data.modified());
        written.is_ok_and(|written| written + Duration::from_millis(10) >= began)
    }

    /// Every log is read to its end, and repaired where it breaks off.
    fn check_logs(&self, after: &str, report: &mut Report) {
        for log in logs(&self.out) {
            if let Err(what) = readable(&log) {
                self.blame(report, "unreadable logs", &format!("{after}: {what}"));
            }
        }
    }

    /// Goes on, or begins anew where there is nothing to go on from, and compares.
    fn go_on(&mut self, report: &mut Report) {
        let resume = self.has_checkpoint();
        let work = self.reference.kind.work;
        let output = ended(start(&arguments(work, &self.scene, &self.out, resume)));
        self.check_traces(report);
        self.count(report, if resume { "went on" } else { "began anew" }, 1);
        self.end(&output, report);
    }

    /// A run that nobody disturbed from its last start on has come to its end with the right bits.
    fn end(&mut self, output: &Output, report: &mut Report) {
        self.check_traces(report);
        if output.status.code() != Some(0) {
            let words =
                format!("it does not go on: exit code {:?}: {}", output.status.code(), said(output).trim());
            self.blame(report, "resumes refused", &words);
            return;
        }
        for file in differences(self.reference.kind.work, &self.reference.out, &self.out) {
            self.blame(report, "not the same bits", &format!("{file} differs"));
        }
    }
}

/// Waits for the end of a process, which has a limit.
fn ended(mut child: Child) -> Output {
    // What a run says fits the pipe; whoever fills it would hang here.
    let waited = wait_until(HANGS, || !matches!(child.try_wait(), Ok(None)));
    if waited.is_err() {
        signal(child.id(), "KILL");
    }
    child.wait_with_output().expect("it ends")
}

/// Takes the dead that have become children of this process; `own` is waited for by its owner.
fn reap(family: &BTreeSet<u32>, own: u32) {
    use rustix::process::{Pid, WaitOptions, waitpid};
    for pid in family.iter().filter(|pid| **pid != own && !is_alive(**pid)) {
        if let Some(pid) = i32::try_from(*pid).ok().and_then(Pid::from_raw) {
            // Not a child of ours: another one takes it.
            let _ = waitpid(Some(pid), WaitOptions::NOHANG);
        }
    }
}

fn logs(out: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(out).into_iter().flatten().flatten().map(|entry| entry.path());
    entries.filter(|path| path.extension().is_some_and(|end| end == "mcap")).collect()
}

/// `log info` says of a log that it is whole, or truncated; then `log repair` makes it whole.
fn readable(log: &Path) -> Result<(), String> {
    let name = log.display().to_string();
    let info = |path: &str| {
        let output = bedload(&["log", "info", path]);
        let words = said(&output);
        match output.status.code() {
            Some(0) => Ok(words),
            // All that could be read was told.
            Some(6) if words.contains("truncated:") || words.contains("damaged:") => Ok(words),
            _ => Err(words),
        }
    };
    let words = info(&name)?;
    if words.contains("damaged:") {
        return Err(format!("{name}: {words}"));
    }
    if words.contains("truncated:") {
        let whole = log.with_extension("repaired");
        let output = bedload(&["log", "repair", &name, &whole.display().to_string()]);
        if output.status.code() != Some(0) {
            return Err(format!("{name} is not repaired: {}", said(&output)));
        }
        let words = info(&whole.display().to_string())?;
        let _ = std::fs::remove_file(&whole);
        if words.contains("truncated:") || words.contains("damaged:") {
            return Err(format!("{name} is not whole after its repair: {words}"));
        }
    }
    Ok(())
}

/// Files whose bytes differ: of runs the series, the grains, and the solvers' last checkpoints; of ensembles
/// the table; of replays, whose exit code says that every message is the same, the log that they read.
fn differences(work: Work, whole: &Path, out: &Path) -> Vec<String> {
    let mut names = vec![PathBuf::from(match work {
        Work::Run => "series.csv",
        Work::Replay => LOG,
        Work::Ensemble => "ensemble.csv",
    })];
    let differs = |name: &PathBuf| std::fs::read(whole.join(name)).ok() != std::fs::read(out.join(name)).ok();
    if work != Work::Run {
        return names.into_iter().filter(differs).map(|name| name.display().to_string()).collect();
    }
    names.extend(whole.join("grains.csv").exists().then(|| PathBuf::from("grains.csv")));
    for folder in std::fs::read_dir(whole.join("checkpoint")).into_iter().flatten().flatten() {
        for role in ["fluid", "dem"] {
            let file = Path::new("checkpoint").join(folder.file_name()).join(format!("{role}.checkpoint"));
            names.extend(whole.join(&file).exists().then_some(file));
        }
    }
    assert!(names.len() > 1, "a finished run has a checkpoint");
    names.into_iter().filter(differs).map(|name| name.display().to_string()).collect()
}
