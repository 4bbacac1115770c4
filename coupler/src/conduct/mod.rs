//! A coupled run: the master of time.
//!
//! One window: order it, collect loads, kinematics and both reports, judge, record, observe, learn for
//! the next plan. Data go from solver to solver; what is read here is a second copy. With the iterated
//! scheme a window is ordered again, from its start, until the motion stays the same ([`crate::iterate`]).
//!
//! | file | what it holds |
//! |---|---|
//! | this one | the loop: which window is ordered when, checkpoints, the stop |
//! | `collect` | what the solvers send, put where it belongs |
//! | `verdict` | a window that is done: accepted, repeated, or the end of the run |
//! | `cause` | why a run ends early |
//! | `close` | costs, summary, children gone |

mod cause;
mod close;
mod collect;
mod verdict;

use std::collections::VecDeque;
use std::time::Instant;

use bedload_output::{Observer, OutputFolder, Sample, Sides};
use bedload_program::Progress;
use protocol::channel::ConductorLink;
use protocol::log::Recorder;
use protocol::message::{Command, Order, State, Status};
use protocol::participant::{ExchangeError, Role, Window};
use protocol::scheme::Scheme;

use crate::failure::Failure;
use crate::iterate::{Tally, Watch};
use crate::number::Short;
use crate::prepare::Prepared;
use crate::resume::{self, CouplerState, Spent};
use crate::scheme::{AHEAD, Planner, QuietRule};
use crate::supervise::{Interrupts, Supervisor};
pub(crate) use cause::{alive, explain};
use collect::{Collected, Whole};

/// How a run ended, besides by failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At `until`.
    Reached,
    /// By Ctrl-C or SIGTERM, in order.
    Interrupted,
}

/// A coupled run under way.
pub struct Conductor<'a> {
    // Children go before the link, so that the coupler is the last to leave the run and removes it.
    supervisor: Supervisor,
    link: ConductorLink,
    prepared: &'a Prepared,
    folder: &'a OutputFolder,
    planner: Planner,
    rule: QuietRule,
    recorder: Option<Recorder>,
    observer: Observer,
    interrupts: Interrupts,
    progress: Progress,
    ordered: VecDeque<(Command, Window)>,
    /// One slot for each window on its way; a window has the slot of its number modulo their count.
    slots: Vec<Collected>,
    /// Last reports.
    fluid: Status,
    dem: Status,
    /// Costs before a resume.
    before: Spent,
    begin: Instant,
    saved: Instant,
    late: u64,
    /// Attempts at windows, where the scheme repeats them.
    watch: Option<Watch>,
    told_of_limit: bool,
    stopping: bool,
    /// Window before which the run ends, where that is not its end in time.
    last: Option<u64>,
    /// What ends the run, once everything sent before it has been read.
    broken: Option<ExchangeError>,
    /// Solver that said so, and its words.
    failed: Option<(String, String)>,
    largest_radius: f64,
}

impl<'a> Conductor<'a> {
    /// Takes over solvers that have said `Ready`.
    ///
    /// # Errors
    /// [`Failure`] if the output cannot be opened.
    #[allow(clippy::too_many_arguments)] // each is a part that lives as long as the run
    pub fn new(
        supervisor: Supervisor,
        link: ConductorLink,
        prepared: &'a Prepared,
        folder: &'a OutputFolder,
        recorder: Option<Recorder>,
        interrupts: Interrupts,
        resumed: Option<CouplerState>,
        begin: Instant,
    ) -> Result<Self, Failure> {
        let (scene, plan) = (&prepared.scene, &prepared.plan);
        let mut planner = Planner::new(plan, &prepared.coupling, &scene.scene.observe);
        let (mut before, mut late, mut attempts) = (Spent::default(), 0, Tally::default());
        let observer = match resumed {
            None => Observer::create(folder, scene, Sides::coupled(), &[])?,
            Some(state) => {
                planner.resume(state.planner);
                (before, late, attempts) = (state.spent, state.late, state.attempts);
                Observer::resume(folder, scene, Sides::coupled(), &[], state.observer)?
            }
        };
        let range = prepared.dem.as_ref().map_or(f64::INFINITY, |dem| dem.facts.interaction_range);
        Ok(Self {
            supervisor,
            link,
            prepared,
            folder,
            progress: Progress::new("bedload", planner.time(), plan.until, false),
            planner,
            rule: QuietRule::new(scene, range),
            recorder,
            observer,
            interrupts,
            ordered: VecDeque::new(),
            slots: (0..AHEAD).map(|_| Collected::default()).collect(),
            fluid: Status::default(),
            dem: Status::default(),
            before,
            begin,
            saved: Instant::now(),
            late,
            watch: (plan.scheme == Some(Scheme::Iterated))
                .then(|| Watch::new(scene, prepared.coupling.iterations, attempts)),
            told_of_limit: false,
            stopping: false,
            last: None,
            broken: None,
            failed: None,
            largest_radius: scene.grains.iter().map(|grain| grain.radius).fold(0.0, f64::max),
        })
    }

    /// Ends the run, with a checkpoint, before window `step`.
    pub fn end_before(&mut self, step: u64) {
        self.last = Some(step);
    }

    /// Windows that are done, those before a resume included.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.observer.tally().windows
    }

    fn is_over(&self) -> bool {
        self.planner.is_over() || self.last.is_some_and(|last| self.planner.step() >= last)
    }

    /// Runs to the end, or to an interrupt.
    ///
    /// # Errors
    /// [`Failure`]; children may live still, [`Conductor::close`] ends them.
    pub fn conduct(&mut self) -> Result<End, Failure> {
        loop {
            if let Some(error) = self.broken.take_if(|_| self.ordered.is_empty()) {
                return Err(self.diagnose(error));
            }
            let interrupted = self.interrupts.count() > 0;
            let save = self.is_checkpoint_due();
            if !interrupted && !save {
                self.order_ahead();
            }
            if !self.ordered.is_empty() {
                self.window()?;
                continue;
            }
            if !interrupted && !self.is_over() {
                self.checkpoint()?;
                continue;
            }
            let end = if self.is_over() { End::Reached } else { End::Interrupted };
            self.checkpoint()?;
            self.stop()?;
            return Ok(end);
        }
    }

    fn is_checkpoint_due(&self) -> bool {
        let every = self.prepared.coupling.checkpoint_every;
        every > 0.0 && self.saved.elapsed().as_secs_f64() >= every
    }

    /// Orders every window that the planner gives; it gives `ahead` at most.
    fn order_ahead(&mut self) {
        while self.broken.is_none()
            && !self.is_over()
            && let Some(window) = self.planner.next_window()
        {
            self.order_window(Order::Advance, window);
        }
    }

    /// Orders a window, or another attempt at it.
    fn order_window(&mut self, order: Order, window: Window) {
        let command = window.command(order);
        self.slots[slot_of(window.step)].begin();
        self.ordered.push_back((command, window));
        self.broken = self.link.order(command).err();
    }

    fn order(&mut self, command: Command) -> Result<(), Failure> {
        self.link.order(command).map_err(|error| self.diagnose(error))
    }

    /// The oldest ordered window, from its first message to the plan that it allows.
    fn window(&mut self) -> Result<(), Failure> {
        let Some((command, window)) = self.ordered.front().copied() else { return Ok(()) };
        let slot = slot_of(window.step);
        let whole = loop {
            if let Some(whole) = self.slots[slot].whole() {
                break whole;
            }
            let event = self.next()?;
            self.take(event)?;
        };
        self.ordered.pop_front();
        self.record(&command, slot, &whole)?;
        self.judge_messages(&window, slot, &whole)?;
        if self.is_repeated(&window, slot, &whole)? {
            return Ok(());
        }
        self.judge(&window, &whole)?;
        let Collected { force, motion, .. } = &self.slots[slot];
        let sample = Sample {
            window: &window,
            loads: force,
            header: &whole.kinematics,
            kinematics: motion,
            extras: &[whole.fluid.pressure_gradient],
        };
        self.observer.record(&sample)?;
        let quiet_until = sample.time() + self.rule.quiet_for(force, motion);
        self.planner.learn(quiet_until, whole.fluid.dt_limit.min(whole.dem.dt_limit));
        let (time, until) = (window.time + window.dt, self.prepared.plan.until);
        self.progress.tell(time, || {
            let (step, substeps) = (window.step, window.substeps);
            format!("t = {} of {} s, window {step}, {substeps} sub-steps", Short(time), Short(until))
        });
        Ok(())
    }

    /// Into the log, before it is judged: what broke a run is worth seeing.
    fn record(&self, command: &Command, slot: usize, whole: &Whole) -> Result<(), Failure> {
        let Some(recorder) = &self.recorder else { return Ok(()) };
        let Collected { force, motion, .. } = &self.slots[slot];
        recorder.record_command(command)?;
        recorder.record_loads(&whole.loads, force)?;
        recorder.record_kinematics(&whole.kinematics, motion)?;
        recorder.record_status(Role::Fluid, &whole.fluid)?;
        Ok(recorder.record_status(Role::Dem, &whole.dem)?)
    }

    /// Both solvers and the coupler write what decides the next window. Nothing is on its way.
    fn checkpoint(&mut self) -> Result<(), Failure> {
        self.order_between(Order::Checkpoint, State::Saved)?;
        let state = CouplerState {
            planner: self.planner.state().clone(),
            observer: self.observer.state()?,
            spent: self.spent(),
            late: self.late,
            attempts: self.watch.as_ref().map(Watch::tally).unwrap_or_default(),
        };
        resume::complete(self.folder, self.planner.step(), &self.prepared.scene.state_sha256(), &state)?;
        self.saved = Instant::now();
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Failure> {
        self.stopping = true;
        self.order_between(Order::Stop, State::Stopped)
    }

    /// Gives an order between windows, and waits for the answer of both solvers.
    fn order_between(&mut self, order: Order, answer: State) -> Result<(), Failure> {
        let (step, time) = (self.planner.step(), self.planner.time());
        self.order(Command { order: order as u64, step, time, ..Command::default() })?;
        self.collect(answer)
    }
}

fn slot_of(step: u64) -> usize {
    (step % AHEAD as u64) as usize
}
