//! The loop over windows: which is ordered when, checkpoints, the stop.

use std::time::Instant;

use bedload_output::Sample;
use protocol::message::{Command, Order, State};
use protocol::participant::{Role, Window};

use super::collected::{Collected, Whole};
use super::conductor::{Conductor, End, slot_of};
use crate::failure::Failure;
use crate::iterate::Watch;
use crate::number::Short;
use crate::resume::{self, CouplerState};

impl Conductor<'_> {
    /// Runs to the end, or to an interrupt.
    ///
    /// # Errors
    /// [`Failure`]; children may live still, [`Conductor::close`] ends them.
    pub(crate) fn conduct(&mut self) -> Result<End, Failure> {
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
    pub(super) fn order_window(&mut self, order: Order, window: Window) {
        let command = window.command(order);
        self.slots[slot_of(window.step)].begin();
        self.ordered.push_back((command, window));
        self.broken = self.link.order(command).err();
    }

    pub(super) fn order(&mut self, command: Command) -> Result<(), Failure> {
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
        self.judge(&window, slot, &whole)?;
        let Collected { force, motion, .. } = &self.slots[slot];
        let sample = Sample {
            window: &window,
            loads: force,
            header: &whole.kinematics,
            kinematics: motion,
            extras: &[whole.fluid.pressure_gradient],
        };
        self.observer.record(&sample)?;
        self.latest = Some((slot, sample.time()));
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
            watch: self.watch.as_ref().map(Watch::state).cloned().unwrap_or_default(),
            seen: self.alternation.seen().clone(),
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
