//! Drives one solver from a log, at full speed.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use super::difference::{Difference, FieldDifference};
use super::error::LogError;
use super::exchange::{LogExchange, Logged};
use super::manifest::Manifest;
use super::reader::LogReader;
use super::windows::LoggedWindow;
use crate::participant::{Participant, SolverError, Window, WindowReport};

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
#[derive(Clone, Debug)]
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

/// Why a replay could not go on. A difference is no error: it stands in the report.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The solver failed by itself.
    #[error("the {role} solver failed in window {step} of the log: {source}")]
    Solver {
        /// Its side.
        role: crate::participant::Role,
        /// Window.
        step: u64,
        /// Cause.
        source: SolverError,
    },
    /// The checkpoint cannot be read.
    #[error("cannot begin from the checkpoint: {0}")]
    Checkpoint(SolverError),
    /// Log and solver are of different scenes.
    #[error("{file}: {what}")]
    Mismatch {
        /// Name of the log.
        file: String,
        /// What differs and what to do.
        what: String,
    },
}

/// Called after each window.
pub type OnWindow<'a> = dyn FnMut(&Window, &WindowReport) + 'a;

/// What an absent peer says in a window: for the log of a solver that ran alone.
pub type StandIn<R> = dyn Fn(&Window, &mut [R]);

/// Drives `participant` through the windows of `log`.
///
/// # Errors
/// [`ReplayError`]. A log that breaks off is replayed to its last complete window and reported in
/// [`ReplayReport::truncated`]; damage inside it is an error.
pub fn replay<P>(
    participant: &mut P,
    log: LogReader,
    options: &ReplayOptions,
    on_window: &mut OnWindow<'_>,
) -> Result<ReplayReport, ReplayError>
where
    P: Participant,
    P::Incoming: Logged,
    P::Outgoing: Logged,
{
    replay_beside(participant, log, options, None, on_window)
}

/// As [`replay`]; where the log has no message of the other solver, `stand_in` says it.
///
/// # Errors
/// As [`replay`].
pub fn replay_beside<P>(
    participant: &mut P,
    log: LogReader,
    options: &ReplayOptions,
    stand_in: Option<&StandIn<P::Incoming>>,
    on_window: &mut OnWindow<'_>,
) -> Result<ReplayReport, ReplayError>
where
    P: Participant,
    P::Incoming: Logged,
    P::Outgoing: Logged,
{
    let begin = Instant::now();
    check(participant, log.name(), log.manifest(), options)?;
    if let Some(folder) = &options.checkpoint {
        participant.read_checkpoint(folder).map_err(ReplayError::Checkpoint)?;
    }
    let mut exchange = LogExchange::new(participant.grains(), options.verify);
    let mut windows = log.windows();
    let mut report = empty();
    while let Some(window) = windows.next() {
        let mut window = match window {
            Err(error) if error.is_truncation() => {
                report.truncated = Some(error);
                break;
            }
            other => other?,
        };
        if let (Some(stand_in), None) = (stand_in, P::Incoming::of(&window)) {
            let (at, mut said) = (window.window(), vec![P::Incoming::default(); participant.grains()]);
            stand_in(&at, &mut said);
            P::Incoming::put(&mut window, (at.header(), said));
        }
        let next_repeats = windows.peek().is_some_and(LoggedWindow::is_repeat);
        let go_on = step(participant, &mut exchange, window, next_repeats, options, on_window)?;
        match go_on {
            Some(done) => count(&mut report, &done),
            None => break,
        }
    }
    Ok(ReplayReport {
        compared: exchange.compared(),
        first_difference: exchange.first_difference().cloned(),
        fields: exchange.fields(),
        wall_s: begin.elapsed().as_secs_f64(),
        unfinished: windows.unfinished(),
        ..report
    })
}

fn empty() -> ReplayReport {
    ReplayReport {
        windows: 0,
        repeats: 0,
        compared: 0,
        first_difference: None,
        fields: BTreeMap::new(),
        last: None,
        time: 0.0,
        wall_s: 0.0,
        truncated: None,
        unfinished: None,
    }
}

fn count(report: &mut ReplayReport, window: &Window) {
    report.windows += 1;
    report.repeats += u64::from(window.attempt > 0);
    report.last = Some(window.step);
    report.time = window.time + window.dt;
}

/// Refuses a log that this solver cannot follow.
fn check<P: Participant>(
    participant: &P,
    file: &str,
    manifest: &Manifest,
    options: &ReplayOptions,
) -> Result<(), ReplayError> {
    let fail = |what| Err(ReplayError::Mismatch { file: file.to_owned(), what });
    let (ours, theirs) = (participant.grains(), manifest.grains());
    if ours != theirs {
        return fail(format!("it has {theirs} grains, the solver {ours}: use the log's own scene"));
    }
    if manifest.first_step > 0 && options.checkpoint.is_none() {
        let first = manifest.first_step;
        return fail(format!("it begins at step {first}: name the checkpoint of that step"));
    }
    Ok(())
}

/// One window; `None` if verification stopped it.
fn step<P>(
    participant: &mut P,
    exchange: &mut LogExchange<P::Outgoing>,
    logged: LoggedWindow,
    next_repeats: bool,
    options: &ReplayOptions,
    on_window: &mut OnWindow<'_>,
) -> Result<Option<Window>, ReplayError>
where
    P: Participant,
    P::Incoming: Logged,
    P::Outgoing: Logged,
{
    let window = logged.window();
    if logged.is_repeat() {
        participant.restore();
    } else if next_repeats {
        // Only a window that will be repeated has to be kept: saving costs a copy of the state.
        participant.save();
    }
    exchange.load(logged);
    let fail = |source| ReplayError::Solver { role: P::ROLE, step: window.step, source };
    let result = participant.advance(&window, exchange);
    if options.verify && exchange.first_difference().is_some() {
        return Ok(None);
    }
    let report = result.map_err(fail)?;
    if !exchange.is_done() {
        let what = "it did not exchange once each way".to_owned();
        return Err(fail(SolverError::Failed(what)));
    }
    if options.fields && window.output {
        participant.write_fields(&window).map_err(fail)?;
    }
    on_window(&window, &report);
    Ok(Some(window))
}
