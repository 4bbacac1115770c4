//! A solver driven by a log: the windows of the run loop are those of the log, and so are the messages of the
//! absent solver. What the solver sends is compared with what was logged.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use bedload_scene::{CheckedScene, SceneSource};
use protocol::checkpoints::step_of;
use protocol::log::{
    Comparison, Difference, FieldDifference, LogError, LogReader, Logged, LoggedWindow, Records, Windows,
};
use protocol::message::{Command, Order};
use protocol::participant::{Participant, Role, Window};

use crate::failure::Failure;
use crate::in_process::InProcess;
use crate::interrupts::Interrupts;
use crate::link::{Attempt, End, Link, Messages, Ordered, Schedule};
use crate::run_loop::RunLoop;
use crate::solver::Solver;
use crate::stand_in::Answer;
use crate::threads::with_threads;

/// Takes what a solver sent in a window, beside what was logged.
pub trait Compare {
    /// Takes an attempt, the last of its window or not. False where the replay ends there.
    fn take(&mut self, logged: &LoggedWindow, sent: &Messages<'_>, is_last: bool) -> bool;
}

/// What a replay makes of a log.
#[derive(Clone, Copy)]
pub struct LogOptions<'a> {
    /// The solver that is driven.
    pub drive: Role,
    /// Does it do every attempt at a window? Else only the last one, as the first.
    pub attempts: bool,
    /// Is it notified that a window is accepted?
    pub accepts: bool,
    /// Does it write fields where the log says so?
    pub fields: bool,
    /// Number of sub-steps in place of the logged one.
    pub substeps: Option<&'a dyn Fn(&Command) -> u64>,
}

/// The windows of a log.
pub struct LogSchedule<'a, C> {
    options: LogOptions<'a>,
    windows: Windows,
    compare: C,
    /// The window under way.
    current: Option<LoggedWindow>,
    is_over: bool,
    /// Where the log breaks off.
    cut: Option<LogError>,
    repeats: u64,
    done: u64,
    /// The last window that is done.
    last: Option<Window>,
}

impl<'a, C: Compare> LogSchedule<'a, C> {
    /// The windows of `log`, which `compare` is given.
    pub fn new(log: LogReader, compare: C, options: LogOptions<'a>) -> Self {
        Self {
            options,
            windows: log.windows(),
            compare,
            current: None,
            is_over: false,
            cut: None,
            repeats: 0,
            done: 0,
            last: None,
        }
    }

    /// The next attempt that is to be done.
    fn read(&mut self) -> Result<Option<Ordered>, Failure> {
        let logged = loop {
            let logged = match self.windows.next() {
                Some(Err(error)) if error.is_truncation() => {
                    self.cut = Some(error);
                    return Ok(None);
                }
                Some(logged) => logged?,
                None => return Ok(None),
            };
            if self.options.attempts || !self.is_repeated() {
                break logged;
            }
        };
        Ok(Some(self.ordered(logged)))
    }

    /// Is the next window in the log another attempt?
    fn is_repeated(&mut self) -> bool {
        self.windows.peek().is_some_and(LoggedWindow::is_repeat)
    }

    fn ordered(&mut self, mut logged: LoggedWindow) -> Ordered {
        let LogOptions { drive, attempts, fields, substeps, .. } = self.options;
        let mut command = logged.command;
        if let Some(substeps) = substeps {
            command.substeps = substeps(&command);
        }
        if !attempts {
            (command.order, command.attempt) = (Order::Advance as u64, 0);
        }
        command.output &= u64::from(fields);
        let given = match drive {
            Role::Fluid => {
                logged.kinematics.take().map(|(header, records)| (header, Records::Kinematics(records)))
            }
            Role::Dem => logged.loads.take().map(|(header, records)| (header, Records::Loads(records))),
        };
        // Only a window that will be repeated has to be kept: that costs a copy of the state.
        let keep = attempts && self.is_repeated();
        self.current = Some(logged);
        Ordered { command, keep, given }
    }
}

impl<C: Compare> Schedule for LogSchedule<'_, C> {
    type State = ();

    fn state(&self) {}

    fn step(&self) -> u64 {
        self.last.map_or(0, |last| last.step + 1)
    }

    fn time(&self) -> f64 {
        self.last.map_or(0.0, |last| last.time + last.dt)
    }

    fn is_over(&self) -> bool {
        self.is_over
    }

    fn next_window(&mut self) -> Result<Option<Ordered>, Failure> {
        if self.current.is_some() {
            return Ok(None);
        }
        let next = self.read()?;
        self.is_over = next.is_none();
        Ok(next)
    }

    fn examine(&mut self, window: &Window, messages: &Messages<'_>) -> Result<Attempt, Failure> {
        let Some(logged) = self.current.take() else { return Ok(Attempt::Final) };
        let is_last = !self.is_repeated();
        if !self.compare.take(&logged, messages, is_last) {
            self.is_over = true;
            return Ok(Attempt::Final);
        }
        self.done += 1;
        self.repeats += u64::from(window.attempt > 0);
        self.last = Some(*window);
        if self.options.attempts
            && !is_last
            && let Some(next) = self.read()?
        {
            return Ok(Attempt::Repeat(next));
        }
        Ok(if self.options.accepts { Attempt::Accept } else { Attempt::Final })
    }

    fn accept(&mut self, _: &Window, _: &Messages<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

/// A solver that was driven by a log.
#[derive(Debug)]
pub struct Driven<C> {
    /// What was compared.
    pub compare: C,
    /// Where the log breaks off, if it does.
    pub cut: Option<LogError>,
    /// A window that breaks off at the end, and was not done: step, attempt.
    pub unfinished: Option<(u64, u64)>,
    /// How the run ended.
    pub outcome: Result<(), Failure>,
}

/// Drives the solver behind `link` through the windows of `schedule`.
pub fn drive<L: Link, C: Compare>(
    link: L,
    schedule: LogSchedule<'_, C>,
    interrupts: &Interrupts,
) -> Driven<C> {
    let mut run = RunLoop::new(link, schedule, interrupts);
    let outcome = run.advance().and_then(finished);
    let LogSchedule { compare, cut, windows, .. } = run.into_parts().1;
    Driven { compare, cut, unfinished: windows.unfinished(), outcome }
}

/// A replay that was interrupted leaves nothing to go on from.
fn finished(end: End) -> Result<(), Failure> {
    match end {
        End::Reached | End::Rewound => Ok(()),
        End::Interrupted => Err(Failure::Interrupted("the replay was not finished".into())),
    }
}

/// How to replay.
#[derive(Clone, Debug, Default)]
pub struct ReplayOptions {
    /// Compare bit for bit and stop at the first difference.
    pub verify: bool,
    /// Folder of the checkpoint to begin from: needed where the log begins after step 0.
    pub checkpoint: Option<PathBuf>,
    /// Write fields where the logged order says so.
    pub fields: bool,
}

/// What a replay found.
#[derive(Debug)]
pub struct ReplayReport {
    /// Windows done, repeats included.
    pub windows: u64,
    /// Repeats among them.
    pub repeats: u64,
    /// Messages compared.
    pub compared: u64,
    /// First difference, if any: with `verify` the replay stopped there.
    pub first_difference: Option<Difference>,
    /// How far each field is off (without `verify`).
    pub fields: BTreeMap<String, FieldDifference>,
    /// Last window done, if any was.
    pub last: Option<u64>,
    /// Simulated time reached, s.
    pub time: f64,
    /// Wall time, s.
    pub wall_s: f64,
    /// Where the log breaks off, if it does; all before was replayed.
    pub truncated: Option<LogError>,
    /// A window that breaks off at the end, and was not replayed: step, attempt.
    pub unfinished: Option<(u64, u64)>,
}

/// Bit by bit.
struct Bits {
    role: Role,
    comparison: Comparison,
}

impl Compare for Bits {
    fn take(&mut self, logged: &LoggedWindow, sent: &Messages<'_>, _: bool) -> bool {
        let header = sent.header();
        // Nothing was logged of a window that was not observed.
        match (self.role, &logged.loads, &logged.kinematics) {
            (Role::Fluid, Some((theirs, records)), _) => {
                self.comparison.message((theirs, records), (&header, sent.loads));
            }
            (Role::Dem, _, Some((theirs, records))) => {
                self.comparison.message((theirs, records), (&header, sent.kinematics));
            }
            _ => {}
        }
        !self.comparison.is_over()
    }
}

/// Drives `participant` through the windows of `log`, in this process. Where the log has no message of the
/// other solver, `answer` gives it.
///
/// # Errors
/// [`Failure`] of the solver or of the log, and on a signal. A difference is no error, nor is a log that
/// breaks off: both stand in the report.
pub fn replay<P>(
    mut participant: P,
    log: LogReader,
    options: &ReplayOptions,
    answer: Option<Answer<P::Incoming>>,
    interrupts: &Interrupts,
) -> Result<ReplayReport, Failure>
where
    P: Participant<Incoming: Logged, Outgoing: Logged>,
{
    let begin = Instant::now();
    check(&participant, &log, options)?;
    if let Some(folder) = &options.checkpoint {
        participant
            .read_checkpoint(folder)
            .map_err(|error| Failure::Run(format!("cannot begin from the checkpoint: {error}")))?;
    }
    let bits = Bits { role: P::ROLE, comparison: Comparison::new(options.verify) };
    let of_log =
        LogOptions { drive: P::ROLE, attempts: true, accepts: false, fields: options.fields, substeps: None };
    let schedule = LogSchedule::new(log, bits, of_log);
    let mut run = RunLoop::new(InProcess::new(participant, answer), schedule, interrupts);
    let outcome = run.advance().and_then(finished);
    let (link, mut schedule) = run.into_parts();
    if let Err(failure) = outcome {
        // A solver that fails after it sent another message than the logged one: the difference came first.
        let failed = schedule.current.take();
        let sent = failed.as_ref().filter(|logged| link.has_sent(&logged.window()));
        if sent.is_none_or(|logged| schedule.compare.take(logged, &link.messages(), true)) {
            return Err(match (failed, failure) {
                (Some(logged), Failure::Run(what)) => Failure::Run(format!(
                    "the {} solver failed in window {} of the log: {what}",
                    P::ROLE,
                    logged.command.step
                )),
                (_, failure) => failure,
            });
        }
    }
    let (windows, repeats, last) = (schedule.done, schedule.repeats, schedule.last);
    let time = schedule.time();
    let LogSchedule { compare: Bits { comparison, .. }, cut: truncated, windows: log, .. } = schedule;
    Ok(ReplayReport {
        windows,
        repeats,
        compared: comparison.messages(),
        first_difference: comparison.first().cloned(),
        fields: comparison.fields(),
        last: last.map(|last| last.step),
        time,
        wall_s: begin.elapsed().as_secs_f64(),
        truncated,
        unfinished: log.unfinished(),
    })
}

/// Refuses a log that this solver cannot follow.
fn check<P: Participant>(participant: &P, log: &LogReader, options: &ReplayOptions) -> Result<(), Failure> {
    let (file, manifest) = (log.name(), log.manifest());
    let (ours, theirs) = (participant.grains(), manifest.grains());
    if ours != theirs {
        let what = format!("it has {theirs} grains, the solver {ours}: use the log's own scene");
        return Err(Failure::Run(format!("{file}: {what}")));
    }
    let first = manifest.first_step;
    if first > 0 && options.checkpoint.is_none() {
        let what = format!("it begins at step {first}: name the checkpoint of that step");
        return Err(Failure::Run(format!("{file}: {what}")));
    }
    let named = options.checkpoint.as_ref().and_then(|folder| Some((folder, step_of(folder)?)));
    if let Some((folder, step)) = named.filter(|(_, step)| *step != first) {
        return Err(Failure::Input(format!(
            "--checkpoint {} is of step {step}, and {file} begins at step {first}: {}",
            folder.display(),
            if first > 0 { "name the checkpoint of that step" } else { "leave it out" }
        )));
    }
    Ok(())
}

/// `replay`: does again what a log says the solver did.
pub(crate) fn command<S: Solver>(
    log: &Path,
    verify: bool,
    checkpoint: Option<&Path>,
    out: Option<&Path>,
    threads: usize,
) -> Result<(), Failure> {
    let interrupts = Interrupts::listen(2)?;
    let reader = LogReader::open(log)?;
    if reader.manifest().scene.is_empty() {
        let what = "its scene was lost by damage, so it drives no solver; `bedload log cat` reads it";
        return Err(Failure::Input(format!("{}: {what}", log.display())));
    }
    let name = format!("{} (its scene)", log.display());
    let mut scene = CheckedScene::new(SceneSource { file: name, text: reader.manifest().scene.clone() })?;
    bedload_output::refuse_changed_files(&scene, &reader.manifest().scene)?;
    let alone = !(reader.manifest().has(Role::Fluid) && reader.manifest().has(Role::Dem));
    if alone {
        // Its checkpoints are of the scene as it was read, which the log has written out.
        scene.written_from = bedload_output::state_of(&reader.manifest().scene).map(str::to_owned);
    }
    let folder = out.map_or_else(|| PathBuf::from("out/replay"), Path::to_owned);
    let solver = S::build(&scene, &folder)?;
    let options = ReplayOptions { verify, checkpoint: checkpoint.map(Path::to_owned), fields: out.is_some() };
    let answer = if alone { Some(S::stand_in(&scene)?) } else { None };
    let report = with_threads(threads, || replay(solver, reader, &options, answer, &interrupts))??;
    println!(
        "{}: {} windows to t = {} s in {:.3} s, {} messages compared",
        S::PROGRAM,
        report.windows,
        report.time,
        report.wall_s,
        report.compared
    );
    for (field, difference) in &report.fields {
        println!("  {field}: {difference}");
    }
    if let Some(difference) = report.first_difference.as_ref().filter(|_| verify) {
        return Err(Failure::Run(format!("first difference: {difference}")));
    }
    match &report.truncated {
        Some(cut) => Err(Failure::BreaksOff(breaks_off(&report, cut, verify))),
        None if report.windows == 0 => {
            let what = "it holds no window to do again; a log of `log thin` has frames for viewers alone";
            Err(Failure::Input(format!("{}: {what}", log.display())))
        }
        None => Ok(()),
    }
}

/// Up to where a log that breaks off holds.
fn breaks_off(report: &ReplayReport, cut: &LogError, verify: bool) -> String {
    let outcome = if verify { "is the same" } else { "was done again" };
    let whole = match report.last {
        Some(step) => format!("all up to window {step}, t = {} s, {outcome}", report.time),
        None => "no whole window is there".to_owned(),
    };
    let cut_short =
        report.unfinished.map_or_else(String::new, |(step, _)| format!(", window {step} is cut short"));
    format!("{cut}: {whole}{cut_short}")
}
