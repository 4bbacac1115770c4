//! A window that is done, judged: accepted, repeated, or the end of the run.

use protocol::message::Order;
use protocol::participant::Window;

use super::collected::{Collected, Whole};
use super::conductor::Conductor;
use crate::failure::Failure;
use crate::iterate::Verdict;
use crate::judge;
use crate::scheme::was_late;
use crate::unstable;

impl Conductor<'_> {
    /// With the iterated scheme: orders the next attempt, or accepts the window. Says whether it goes on.
    /// A contact that begins in a window of one sub-step gets the full count in the next attempt.
    pub(super) fn is_repeated(
        &mut self,
        window: &Window,
        slot: usize,
        whole: &Whole,
    ) -> Result<bool, Failure> {
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
        let command = window.command(Order::Accept);
        self.order(command)?;
        if let Some(recorder) = &self.recorder {
            recorder.record_command(&command)?;
        }
        Ok(false)
    }

    /// Every attempt: what crossed must be numbers, after the sub-steps ordered.
    pub(super) fn judge_messages(&self, window: &Window, slot: usize, whole: &Whole) -> Result<(), Failure> {
        let Collected { force, motion, .. } = &self.slots[slot];
        judge::headers(window, &whole.loads, &whole.kinematics)?;
        judge::reports(window, &whole.fluid, &whole.dem)?;
        judge::loads(window, force)?;
        judge::motion(window, &whole.kinematics, motion)?;
        judge::places(window, motion, &self.prepared.scene)
    }

    /// The window as it stands.
    pub(super) fn judge(&mut self, window: &Window, slot: usize, whole: &Whole) -> Result<(), Failure> {
        let plan = &self.prepared.plan;
        if let Some(found) = self.alternation.take(window, &self.slots[slot].motion)
            && !plan.forced.iter().any(|name| name == unstable::NAME)
        {
            return Err(Failure::Unstable(format!(
                "unstable from window {} on (noticed in window {}, t = {} s): {}; {}",
                found.window,
                window.step,
                window.time,
                found.text,
                unstable::REMEDY
            )));
        }
        let header = &whole.kinematics;
        judge::overlap(window, header, &whole.dem, self.largest_radius, &plan.forced)?;
        let Collected { force, motion, .. } = &self.slots[slot];
        if let Some(witness) = &mut self.witness {
            witness.judge(window, force, motion, &plan.forced)?;
        }
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
}
