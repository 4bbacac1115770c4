//! The coupler's state in a coupled run.

use std::collections::VecDeque;
use std::time::Instant;

use bedload_output::{Observer, OutputFolder, Sides};
use bedload_program::Progress;
use protocol::channel::ConductorLink;
use protocol::log::Recorder;
use protocol::message::{Command, Status};
use protocol::participant::{ExchangeError, Window};
use protocol::scheme::Scheme;

use super::collected::Collected;
use super::witness::Witness;
use crate::failure::Failure;
use crate::iterate::{Watch, WatchState};
use crate::prepare::Prepared;
use crate::resume::{CouplerState, Spent};
use crate::scheme::{AHEAD, Planner, QuietRule};
use crate::supervise::{Interrupts, Supervisor};
use crate::unstable::Alternation;

/// How a run ended, besides by failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// At `until`.
    Reached,
    /// By Ctrl-C or SIGTERM, in order.
    Interrupted,
}

/// A coupled run under way.
pub(crate) struct Conductor<'a> {
    // Children go before the link, so that the coupler is the last to leave the run and removes it.
    pub(super) supervisor: Supervisor,
    pub(super) link: ConductorLink,
    pub(super) prepared: &'a Prepared,
    pub(super) folder: &'a OutputFolder,
    pub(super) planner: Planner,
    pub(super) rule: QuietRule,
    pub(super) recorder: Option<Recorder>,
    pub(super) observer: Observer,
    pub(super) interrupts: Interrupts,
    pub(super) progress: Progress,
    pub(super) ordered: VecDeque<(Command, Window)>,
    /// One slot for each window on its way; a window has the slot of its number modulo their count.
    pub(super) slots: Vec<Collected>,
    /// Last reports.
    pub(super) fluid: Status,
    pub(super) dem: Status,
    /// Costs before a resume.
    pub(super) before: Spent,
    pub(super) begin: Instant,
    pub(super) saved: Instant,
    pub(super) late: u64,
    /// Attempts at windows, where the scheme repeats them.
    pub(super) watch: Option<Watch>,
    pub(super) told_of_limit: bool,
    pub(super) stopping: bool,
    /// Window before which the run ends, where that is not its end in time.
    pub(super) last: Option<u64>,
    /// What ends the run, once everything sent before it has been read.
    pub(super) broken: Option<ExchangeError>,
    /// Solver that said so, and its words.
    pub(super) failed: Option<(String, String)>,
    pub(super) largest_radius: f64,
    /// Where the grains after the last window are, and its end in time.
    pub(super) latest: Option<(usize, f64)>,
    /// Holds a foreign DEM to what it says.
    pub(super) witness: Option<Witness>,
    /// Whether the motion alternates from window to window.
    pub(super) alternation: Alternation,
}

impl<'a> Conductor<'a> {
    /// Takes over solvers that have said `Ready`.
    ///
    /// # Errors
    /// [`Failure`] if the output cannot be opened.
    #[allow(clippy::too_many_arguments)] // each is a part that lives as long as the run
    pub(crate) fn new(
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
        let is_resumed = resumed.is_some();
        let (mut before, mut late, mut watch) = (Spent::default(), 0, WatchState::default());
        let mut alternation = Alternation::new(scene);
        let observer = match resumed {
            None => Observer::create(folder, scene, Sides::coupled(), &[])?,
            Some(state) => {
                planner.resume(state.planner);
                (before, late, watch) = (state.spent, state.late, state.watch);
                alternation.resume(state.seen);
                Observer::resume(folder, scene, Sides::coupled(), &[], state.observer)?
            }
        };
        let foreign = prepared.dem.as_ref().is_some_and(|dem| !dem.solver.is_ours());
        let witness = foreign.then(|| Witness::new(scene, is_resumed));
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
                .then(|| Watch::new(scene, prepared.coupling.iterations, watch)),
            told_of_limit: false,
            stopping: false,
            last: None,
            broken: None,
            failed: None,
            alternation,
            witness,
            latest: None,
            largest_radius: scene.grains.iter().map(|grain| grain.radius).fold(0.0, f64::max),
        })
    }

    /// Ends the run, with a checkpoint, before window `step`.
    pub(crate) fn end_before(&mut self, step: u64) {
        self.last = Some(step);
    }

    /// Windows that are done, those before a resume included.
    #[must_use]
    pub(crate) fn done(&self) -> u64 {
        self.observer.tally().windows
    }

    pub(super) fn is_over(&self) -> bool {
        self.planner.is_over() || self.last.is_some_and(|last| self.planner.step() >= last)
    }
}

/// Slot of a window among those on their way.
pub(super) fn slot_of(step: u64) -> usize {
    (step % AHEAD as u64) as usize
}
