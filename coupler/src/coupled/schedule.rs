//! Which window comes next, and what becomes of one that is done: accepted, repeated, or the end of the run.

use bedload_output::{MetricValue, Observer, Summary};
use bedload_program::{Attempt, Messages, Ordered, Schedule};
use protocol::message::{Header, Order, Status};
use protocol::participant::Window;
use protocol::scheme::Scheme;
use serde::{Deserialize, Serialize};

use super::kinematics_check::{self, KinematicsCheck};
use crate::failure::Failure;
use crate::iterate::{Convergence, ConvergenceMonitor, MonitorState, Tally};
use crate::message_checks;
use crate::number::Short;
use crate::prepare::Prepared;
use crate::scheme::{ContactFreeHorizon, Planner, PlannerState, was_late};
use crate::unstable::{self, Alternation, Seen};

/// Everything of the coupler that decides, or counts, what comes next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CoupledState {
    planner: PlannerState,
    /// Windows in which something began to touch against the sub-step rule.
    late: u64,
    /// Attempts at windows, where they are repeated.
    watch: MonitorState,
    seen: Seen,
}

pub(crate) struct CoupledSchedule<'a> {
    prepared: &'a Prepared,
    planner: Planner,
    rule: ContactFreeHorizon,
    late: u64,
    /// Attempts at windows, where the scheme repeats them.
    watch: Option<ConvergenceMonitor>,
    warned_of_limit: bool,
    largest_radius: f64,
    kinematics_check: Option<KinematicsCheck>,
    alternation: Alternation,
}

impl<'a> CoupledSchedule<'a> {
    /// From the start of a run, or from a checkpoint.
    pub(super) fn new(prepared: &'a Prepared, from: Option<CoupledState>) -> Self {
        let (scene, plan) = (&prepared.scene, &prepared.plan);
        let foreign = prepared.dem.as_ref().is_some_and(|dem| !dem.solver.is_ours());
        let kinematics_check = foreign.then(|| KinematicsCheck::new(scene, from.is_some()));
        let mut planner = Planner::new(plan, &prepared.coupling, &scene.scene.observe);
        let mut alternation = Alternation::new(scene);
        let (mut late, mut watch) = (0, MonitorState::default());
        if let Some(state) = from {
            planner.resume(state.planner);
            alternation.resume(state.seen);
            (late, watch) = (state.late, state.watch);
        }
        let range = prepared.dem.as_ref().map_or(f64::INFINITY, |dem| dem.facts.interaction_range);
        Self {
            prepared,
            planner,
            rule: ContactFreeHorizon::new(scene, range),
            late,
            watch: (plan.scheme == Some(Scheme::Iterated))
                .then(|| ConvergenceMonitor::new(scene, prepared.coupling.iterations, watch)),
            warned_of_limit: false,
            largest_radius: scene.grains.iter().map(|grain| grain.radius).fold(0.0, f64::max),
            kinematics_check,
            alternation,
        }
    }

    /// Every attempt: what crossed must be numbers, after the sub-steps ordered.
    fn check_messages(&self, window: &Window, sent: &Sent<'_>) -> Result<(), Failure> {
        let Messages { loads, kinematics, .. } = *sent.messages;
        message_checks::headers(window, sent.loads_header, sent.kinematics_header)?;
        message_checks::reports(window, sent.fluid, sent.dem)?;
        message_checks::loads(window, loads)?;
        message_checks::motion(window, sent.kinematics_header, kinematics)?;
        message_checks::places(window, kinematics, &self.prepared.scene)
    }

    /// Full count of sub-steps, and whether something began to touch in a window that got only one.
    fn missed_contact(&self, window: &Window, messages: &Messages<'_>) -> (u64, bool) {
        let range = self.prepared.dem.as_ref().map_or(0.0, |dem| dem.facts.interaction_range);
        let full = self.prepared.plan.full_substeps(window.dt);
        (full, was_late(window, full, &messages.header(), range))
    }

    /// What the run keeps to, window by window.
    fn check_bounds(&mut self, window: &Window, sent: &Sent<'_>) -> Result<(), Failure> {
        let (plan, Messages { loads, kinematics, .. }) = (&self.prepared.plan, *sent.messages);
        // The advice of a bound is about time steps.
        let doubt = if self.kinematics_check.is_some() { kinematics_check::DOUBT } else { "" };
        if let Some(found) = self.alternation.take(window, kinematics)
            && !plan.forced.iter().any(|name| name == unstable::NAME)
        {
            return Err(Failure::Unstable(found.message(window, &format!("{}{doubt}", unstable::REMEDY))));
        }
        let with_doubt = |failure| match failure {
            Failure::Run(text) => Failure::Run(format!("{text}{doubt}")),
            other => other,
        };
        let header = sent.kinematics_header;
        message_checks::overlap(window, header, sent.dem, self.largest_radius, &plan.forced)
            .map_err(with_doubt)?;
        if let Some(check) = &mut self.kinematics_check {
            check.window(window, header, loads, kinematics, &plan.forced)?;
        }
        let limit = sent.fluid.dt_limit;
        if !plan.adaptive {
            let passed = message_checks::step_limit(window, limit, plan.cfl_reserve, &plan.forced)
                .map_err(with_doubt)?;
            if passed && !self.warned_of_limit {
                self.warned_of_limit = true;
                protocol::say!(
                    "bedload: warning: cfl: from window {} on the fluid would rather take dt ≤ {limit} s",
                    window.step
                );
            }
        }
        Ok(())
    }
}

/// Headers and reports of both solvers, which a coupled run always has.
struct Sent<'a> {
    messages: &'a Messages<'a>,
    loads_header: &'a Header,
    kinematics_header: &'a Header,
    fluid: &'a Status,
    dem: &'a Status,
}

impl<'a> Sent<'a> {
    fn of(messages: &'a Messages<'a>) -> Result<Self, Failure> {
        match *messages {
            Messages {
                loads_header: Some(loads_header),
                kinematics_header: Some(kinematics_header),
                reports: Some([fluid, dem]),
                ..
            } => Ok(Self { messages, loads_header, kinematics_header, fluid, dem }),
            _ => Err(Failure::Run("a solver took no part in a window of a coupled run".into())),
        }
    }
}

impl Schedule for CoupledSchedule<'_> {
    type State = CoupledState;

    fn state(&self) -> CoupledState {
        CoupledState {
            planner: self.planner.state().clone(),
            late: self.late,
            watch: self.watch.as_ref().map(ConvergenceMonitor::state).cloned().unwrap_or_default(),
            seen: self.alternation.seen().clone(),
        }
    }

    fn step(&self) -> u64 {
        self.planner.step()
    }

    fn time(&self) -> f64 {
        self.planner.time()
    }

    fn is_over(&self) -> bool {
        self.planner.is_over()
    }

    fn next_window(&mut self) -> Result<Option<Ordered>, Failure> {
        Ok(self.planner.next_window().map(Ordered::from))
    }

    /// With the iterated scheme: the next attempt, or the window accepted. A contact that begins in a window
    /// of one sub-step gets the full count in the next attempt.
    fn examine(&mut self, window: &Window, messages: &Messages<'_>) -> Result<Attempt, Failure> {
        self.check_messages(window, &Sent::of(messages)?)?;
        let (full, late) = self.missed_contact(window, messages);
        let Some(watch) = &mut self.watch else { return Ok(Attempt::Final) };
        match watch.assess(window, messages.kinematics, late) {
            Convergence::Repeat => {
                let substeps = if late { full } else { window.substeps };
                let next = Window { attempt: window.attempt + 1, substeps, ..*window };
                let command = next.command(Order::Repeat);
                return Ok(Attempt::Repeat(Ordered { command, keep: false, given: None }));
            }
            Convergence::Unconverged(change) if watch.tally().unconverged == 1 => {
                let (step, attempts) = (window.step, window.attempt + 1);
                let tolerance = self.prepared.coupling.iterations.tolerance;
                protocol::say!(
                    "bedload: warning: window {step} did not converge in {attempts} attempts: the motion still \
                     changes by {change:.1e}, asked is {tolerance:.1e}; it is accepted, and such windows are \
                     counted (unconverged_windows); see coupling.iterations"
                );
            }
            Convergence::Converged | Convergence::Unconverged(_) => {}
        }
        Ok(Attempt::Accept)
    }

    fn accept(&mut self, window: &Window, messages: &Messages<'_>) -> Result<(), Failure> {
        self.check_bounds(window, &Sent::of(messages)?)?;
        if self.missed_contact(window, messages).1 {
            if self.late == 0 {
                protocol::say!(
                    "bedload: warning: something came within range in window {} although one sub-step was \
                     planned; if this worries you, --set coupling.substeps=full",
                    window.step
                );
            }
            self.late += 1;
        }
        let contact_free_for = self.rule.contact_free_for(messages.loads, messages.kinematics);
        self.planner.learn(window.time + window.dt + contact_free_for, messages.dt_limit);
        Ok(())
    }

    fn progress(&self, window: &Window, _: &Messages<'_>, _: &Observer) -> String {
        let (step, substeps) = (window.step, window.substeps);
        let (time, until) = (Short(window.time + window.dt), Short(self.prepared.plan.until));
        format!("t = {time} of {until} s, window {step}, {substeps} sub-steps")
    }

    fn measure(&self, summary: &mut Summary) {
        let mut metric = |name: &str, value: f64, unit: &str| {
            let value = MetricValue::measured(value, unit, None, None);
            summary.metrics.insert(name.into(), value);
        };
        if self.late > 0 {
            metric("late_contacts", self.late as f64, "windows");
        }
        if let Some(Tally { windows, attempts, unconverged }) =
            self.watch.as_ref().map(ConvergenceMonitor::tally)
        {
            metric("attempts_per_window", attempts as f64 / windows.max(1) as f64, "-");
            metric("unconverged_windows", unconverged as f64, "windows");
        }
    }
}
