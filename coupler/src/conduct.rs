//! A coupled run: the master of time.
//!
//! One window: order it, collect loads, kinematics and both reports, judge, record, observe, learn for
//! the next plan. Data go from solver to solver; what is read here is a second copy. With the iterated
//! scheme a window is ordered again, from its start, until the motion stays the same ([`crate::iterate`]).

use std::collections::VecDeque;
use std::path::Path;
use std::time::{Duration, Instant};

use protocol::channel::{ConductorLink, Event};
use protocol::log::Recorder;
use protocol::message::{Command, Header, Kinematics, Loads, Order, State, Status};
use protocol::output::{Observer, OutputFolder, Progress, Sample, Sides};
use protocol::participant::{ExchangeError, Role, Window};
use protocol::scheme::Scheme;

use crate::bounds::Short;
use crate::failure::Failure;
use crate::iterate::{Tally, Verdict, Watch};
use crate::judge;
use crate::prepare::Prepared;
use crate::resume::{self, CouplerState, Spent};
use crate::scheme::{AHEAD, Planner, QuietRule, was_late};
use crate::supervise::{Exit, Interrupts, Supervisor};

/// Writing files may take longer than a window.
const FILES_TAKE: u32 = 6;

/// How a run ended, besides by failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At `until`.
    Reached,
    /// By Ctrl-C or SIGTERM, in order.
    Interrupted,
}

/// What has come of a window on its way. Copies, because the fluid may send the loads of the next
/// window before the DEM has reported this one.
#[derive(Debug, Default)]
struct Collected {
    loads: Option<Header>,
    kinematics: Option<Header>,
    fluid: Option<Status>,
    dem: Option<Status>,
    /// Loads, one per grain, once there is a header of them.
    force: Vec<Loads>,
    /// Kinematics likewise.
    motion: Vec<Kinematics>,
}

impl Collected {
    fn begin(&mut self) {
        self.loads = None;
        self.kinematics = None;
        self.fluid = None;
        self.dem = None;
    }

    /// Headers and reports, once all four are there.
    fn whole(&self) -> Option<Whole> {
        Some(Whole { loads: self.loads?, kinematics: self.kinematics?, fluid: self.fluid?, dem: self.dem? })
    }
}

/// Headers and reports of a window that is done.
struct Whole {
    loads: Header,
    kinematics: Header,
    fluid: Status,
    dem: Status,
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
        let command = command_of(order, &window);
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

    /// The next event. After a failure those that are there already, so that every window that was
    /// done counts, then the failure.
    fn next(&mut self) -> Result<Event, Failure> {
        loop {
            let event = if self.broken.is_none() { self.wait() } else { self.link.try_next() };
            match event {
                Ok(Some(Event::Status(role, status))) if status.state == State::Failed as u64 => {
                    self.hear_failure(role, &status);
                }
                Ok(Some(event)) => return Ok(event),
                result => match (self.broken.take(), result) {
                    (Some(error), _) => return Err(self.diagnose(error)),
                    (None, result) => self.broken = result.err(),
                },
            }
        }
    }

    /// Keeps the words of the cause: the other solver fails too, because its peer is gone.
    fn hear_failure(&mut self, role: Role, status: &Status) {
        let (peer, text) = (role.to_string(), status.text());
        self.broken.get_or_insert_with(|| ExchangeError::Failed { peer: peer.clone(), text: text.clone() });
        if self.failed.as_ref().is_none_or(|(_, text)| is_about_a_peer(text)) {
            self.failed = Some((peer, text));
        }
    }

    /// Waits for an event; children and interrupts are looked at meanwhile.
    fn wait(&mut self) -> Result<Option<Event>, ExchangeError> {
        let slow = self.ordered.iter().any(|(_, window)| window.output) || self.ordered.is_empty();
        let deadline = Duration::from_secs_f64(self.prepared.coupling.deadline);
        let limit = if slow { deadline * FILES_TAKE } else { deadline };
        let Self { link, supervisor, interrupts, stopping, .. } = self;
        let step = self.ordered.front().map_or(0, |(_, window)| window.step);
        link.next(limit, &mut || alive(supervisor, interrupts, *stopping, step)).map(Some)
    }

    /// Puts a message where it belongs: the window under way, or one ordered ahead.
    fn take(&mut self, event: Event) -> Result<(), Failure> {
        let grains = self.prepared.scene.grains.len();
        match event {
            Event::Loads(lent) => {
                judge::belongs(self.window_of(lent.header().step), lent.header(), lent.records(), grains)?;
                let slot = &mut self.slots[slot_of(lent.header().step)];
                slot.loads = Some(*lent.header());
                slot.force.clear();
                slot.force.extend_from_slice(lent.records());
            }
            Event::Kinematics(lent) => {
                judge::belongs(self.window_of(lent.header().step), lent.header(), lent.records(), grains)?;
                let slot = &mut self.slots[slot_of(lent.header().step)];
                slot.kinematics = Some(*lent.header());
                slot.motion.clear();
                slot.motion.extend_from_slice(lent.records());
            }
            Event::Status(role, status) => {
                self.expect(role, &status, State::Done)?;
                if self.window_of(status.step).is_none() {
                    return Err(Failure::Run(format!(
                        "the {role} solver reports window {}, which was not ordered",
                        status.step
                    )));
                }
                let slot = &mut self.slots[slot_of(status.step)];
                match role {
                    Role::Fluid => slot.fluid = Some(status),
                    Role::Dem => slot.dem = Some(status),
                }
            }
        }
        Ok(())
    }

    /// The window on its way that has this number.
    fn window_of(&self, step: u64) -> Option<&Window> {
        self.ordered.iter().map(|(_, window)| window).find(|window| window.step == step)
    }

    /// Keeps a report, and refuses one that is not `wanted`.
    fn expect(&mut self, role: Role, status: &Status, wanted: State) -> Result<(), Failure> {
        match role {
            Role::Fluid => self.fluid = *status,
            Role::Dem => self.dem = *status,
        }
        if status.state == wanted as u64 {
            return Ok(());
        }
        Err(Failure::Run(format!(
            "the {role} solver answered with state {} where {wanted:?} was due",
            status.state
        )))
    }

    /// With the iterated scheme: orders the next attempt, or accepts the window. Says whether it goes on.
    /// A contact that begins in a window of one sub-step gets the full count in the next attempt.
    fn is_repeated(&mut self, window: &Window, slot: usize, whole: &Whole) -> Result<bool, Failure> {
        let (full, late) = self.lateness(window, whole);
        let Some(watch) = &mut self.watch else { return Ok(false) };
        match watch.judge(window, &self.slots[slot].motion, late) {
            Verdict::Repeat => {
                let substeps = if late { full } else { window.substeps };
                let next = Window { attempt: window.attempt + 1, substeps, ..*window };
                self.order_window(Order::Repeat, next);
                return Ok(true);
            }
            Verdict::Unconverged(change) if watch.tally().unconverged == 1 => {
                let (step, attempts) = (window.step, window.attempt + 1);
                let tolerance = self.prepared.coupling.iterations.tolerance;
                protocol::say!(
                    "bedload: warning: window {step} did not converge in {attempts} attempts: the motion still \
                     changes by {change:.1e}, asked is {tolerance:.1e}; it is accepted, and such windows are \
                     counted (unconverged_windows); see coupling.iterations"
                );
            }
            Verdict::Converged | Verdict::Unconverged(_) => {}
        }
        let command = command_of(Order::Accept, window);
        self.order(command)?;
        if let Some(recorder) = &self.recorder {
            recorder.record_command(&command)?;
        }
        Ok(false)
    }

    /// Every attempt: what crossed must be numbers, after the sub-steps ordered.
    fn judge_messages(&self, window: &Window, slot: usize, whole: &Whole) -> Result<(), Failure> {
        let Collected { force, motion, .. } = &self.slots[slot];
        judge::loads(window, force)?;
        judge::motion(window, &whole.kinematics, motion)
    }

    /// The window as it stands.
    fn judge(&mut self, window: &Window, whole: &Whole) -> Result<(), Failure> {
        let plan = &self.prepared.plan;
        let header = &whole.kinematics;
        judge::overlap(window, header, &whole.dem, self.largest_radius, &plan.forced)?;
        if !plan.adaptive {
            let passed = judge::step_limit(window, whole.fluid.dt_limit, plan.cfl_reserve, &plan.forced)?;
            if passed && !self.told_of_limit {
                self.told_of_limit = true;
                let limit = whole.fluid.dt_limit;
                protocol::say!(
                    "bedload: warning: cfl: from window {} on the fluid would rather take dt ≤ {limit} s",
                    window.step
                );
            }
        }
        if self.lateness(window, whole).1 {
            if self.late == 0 {
                protocol::say!(
                    "bedload: warning: something came within range in window {} although one sub-step was planned; if this worries you, --set coupling.substeps=full",
                    window.step
                );
            }
            self.late += 1;
        }
        Ok(())
    }

    /// Full count of sub-steps, and whether something began to touch in a window that got only one.
    fn lateness(&self, window: &Window, whole: &Whole) -> (u64, bool) {
        let range = self.prepared.dem.as_ref().map_or(0.0, |dem| dem.facts.interaction_range);
        let full = self.prepared.plan.full_substeps(window.dt);
        (full, was_late(window, full, &whole.kinematics, range))
    }

    /// Both solvers and the coupler write what decides the next window. Nothing is on its way.
    fn checkpoint(&mut self) -> Result<(), Failure> {
        let step = self.planner.step();
        let command = Command {
            order: Order::Checkpoint as u64,
            step,
            time: self.planner.time(),
            ..Command::default()
        };
        self.order(command)?;
        self.collect(State::Saved)?;
        let state = CouplerState {
            planner: self.planner.state().clone(),
            observer: self.observer.state()?,
            spent: self.spent(),
            late: self.late,
            attempts: self.watch.as_ref().map(Watch::tally).unwrap_or_default(),
        };
        resume::complete(self.folder, step, &self.prepared.scene.sha256(), &state)?;
        self.saved = Instant::now();
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Failure> {
        self.stopping = true;
        let command = Command {
            order: Order::Stop as u64,
            step: self.planner.step(),
            time: self.planner.time(),
            ..Command::default()
        };
        self.order(command)?;
        self.collect(State::Stopped)
    }

    /// Waits for one report of each solver.
    fn collect(&mut self, wanted: State) -> Result<(), Failure> {
        let (mut fluid, mut dem) = (false, false);
        while !(fluid && dem) {
            match self.next()? {
                Event::Status(role, status) => {
                    self.expect(role, &status, wanted)?;
                    match role {
                        Role::Fluid => fluid = true,
                        Role::Dem => dem = true,
                    }
                }
                Event::Loads(_) | Event::Kinematics(_) => {
                    return Err(Failure::Run("a solver sent data of a window that was not ordered".into()));
                }
            }
        }
        Ok(())
    }

    /// What really happened behind an error of the exchange.
    fn diagnose(&mut self, error: ExchangeError) -> Failure {
        let patience = Instant::now();
        // A dead peer makes the others give up too: the first to go is the cause.
        while self.failed.is_none() && patience.elapsed() < Duration::from_millis(200) {
            while let Ok(Some(event)) = self.link.try_next() {
                if let Event::Status(role, status) = event
                    && status.state == State::Failed as u64
                {
                    self.hear_failure(role, &status);
                }
            }
            if self.supervisor.any_exit() || matches!(error, ExchangeError::Deadline { .. }) {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        explain(&error, self.failed.take(), &self.supervisor)
    }

    /// Costs so far, those before a resume included.
    fn spent(&self) -> Spent {
        let record = self.recorder.as_ref().map(Recorder::statistics).unwrap_or_default();
        Spent {
            wall: self.before.wall + self.begin.elapsed().as_secs_f64(),
            fluid: self.before.fluid + self.fluid.solver_s,
            dem: self.before.dem + self.dem.solver_s,
            coupler: self.before.coupler + own_cpu_seconds(),
            exchange: self.before.exchange + self.fluid.exchange_s + self.dem.exchange_s,
            record: self.before.record + record.call_s + record.write_s,
        }
    }

    /// Ends the children, finishes log and series, and fills the summary.
    ///
    /// # Errors
    /// [`Failure`] if the log or the series could not be finished.
    pub fn close(mut self, summary: &mut protocol::output::Summary, in_order: bool) -> Result<(), Failure> {
        self.progress.finish();
        let grace = Duration::from_millis(if in_order { 2000 } else { 300 });
        if !(in_order && self.supervisor.wait_all(grace)) {
            self.supervisor.end(grace);
        }
        let spent = self.spent();
        let recorded = self.recorder.take().map_or(Ok(()), |recorder| recorder.finish().map(|_| ()));
        self.observer.finish(summary, self.prepared.plan.ladder.contact_time)?;
        if self.late > 0 {
            let value = protocol::output::MetricValue::measured(self.late as f64, "windows", None, None);
            summary.metrics.insert("late_contacts".into(), value);
        }
        if let Some(Tally { windows, attempts, unconverged }) = self.watch.as_ref().map(Watch::tally) {
            let mut metric = |name: &str, value: f64, unit: &str| {
                let value = protocol::output::MetricValue::measured(value, unit, None, None);
                summary.metrics.insert(name.into(), value);
            };
            metric("attempts_per_window", attempts as f64 / windows.max(1) as f64, "-");
            metric("unconverged_windows", unconverged as f64, "windows");
        }
        let cost = &mut summary.cost;
        cost.wall_s = spent.wall;
        cost.fluid_cpu_s = spent.fluid;
        cost.dem_cpu_s = spent.dem;
        cost.coupler_cpu_s = spent.coupler;
        cost.exchange_s = spent.exchange;
        cost.record_s = spent.record;
        cost.peak_rss_bytes.fluid = Some(self.fluid.peak_rss);
        cost.peak_rss_bytes.dem = Some(self.dem.peak_rss);
        cost.peak_rss_bytes.coupler = Some(protocol::output::peak_rss_bytes());
        Ok(recorded?)
    }
}

fn command_of(order: Order, window: &Window) -> Command {
    Command {
        order: order as u64,
        step: window.step,
        attempt: window.attempt,
        time: window.time,
        dt: window.dt,
        substeps: window.substeps,
        output: u64::from(window.output),
    }
}

fn slot_of(step: u64) -> usize {
    (step % AHEAD as u64) as usize
}

/// Looks after children and interrupts while the coupler waits.
pub(crate) fn alive(
    supervisor: &Supervisor,
    interrupts: &Interrupts,
    stopping: bool,
    step: u64,
) -> Result<(), ExchangeError> {
    if interrupts.count() >= 2 {
        return Err(ExchangeError::Stopped);
    }
    if !supervisor.any_exit() {
        return Ok(());
    }
    let bad = |exit: &Exit| !(stopping && exit.code() == Some(0));
    match supervisor.exits().into_iter().find(bad) {
        Some(exit) => Err(ExchangeError::PeerDied { peer: exit.role.to_string(), step }),
        None => Ok(()),
    }
}

/// The cause as the user should read it, with the exit code that it stands for.
pub(crate) fn explain(
    error: &ExchangeError,
    failed: Option<(String, String)>,
    supervisor: &Supervisor,
) -> Failure {
    if matches!(error, ExchangeError::Stopped) {
        return Failure::Interrupted("killed by a second signal; the last checkpoint stands".into());
    }
    if matches!(error, ExchangeError::Deadline { .. }) {
        return Failure::Peer(error.to_string());
    }
    let exits = supervisor.exits();
    let killed = exits.iter().find(|exit| exit.was_killed());
    if let Some(exit) = killed {
        return Failure::Peer(with_words(&format!("{exit} ({error})"), supervisor, exit.role));
    }
    let own = failed.filter(|(_, text)| !is_about_a_peer(text));
    match (own, exits.first()) {
        (Some((peer, text)), _) => Failure::Run(format!("the {peer} solver failed: {text}")),
        (None, Some(exit)) => {
            let text = with_words(&exit.to_string(), supervisor, exit.role);
            match exit.code() {
                Some(1) => Failure::Run(text),
                Some(2) => Failure::Input(text),
                _ => Failure::Peer(text),
            }
        }
        (None, None) => match error {
            ExchangeError::PeerDied { .. } | ExchangeError::Failed { .. } => Failure::Peer(error.to_string()),
            _ => Failure::Run(error.to_string()),
        },
    }
}

/// A solver that failed because the other one went: its words name the consequence, not the cause.
fn is_about_a_peer(text: &str) -> bool {
    text.contains(" died during window ") || text.contains(" did not answer within ")
}

fn with_words(what: &str, supervisor: &Supervisor, role: Role) -> String {
    // The thread that reads stderr may be a moment behind the exit.
    std::thread::sleep(Duration::from_millis(20));
    match supervisor.last_words(role) {
        words if words.is_empty() => format!("{what}; it left no words"),
        words => format!("{what}; its last words:\n{words}"),
    }
}

/// CPU time of this process, user and system, s; 0 where the system does not tell.
fn own_cpu_seconds() -> f64 {
    let Ok(text) = std::fs::read_to_string(Path::new("/proc/self/stat")) else { return 0.0 };
    // Fields 14 and 15, counted from 1, after the name in brackets, which may hold spaces.
    let after = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks: f64 =
        after.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum();
    // USER_HZ is 100 on every Linux that runs Rust.
    ticks / 100.0
}
