//! A solver in this process as a link: the absent one is played by a function of the scene, or by a log.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bedload_output::{Cost, MetricValue, OutputFolder, Summary};
use bedload_scene::CheckedScene;
use protocol::log::Logged;
use protocol::memory::peak_rss_bytes;
use protocol::message::{Command, Order};
use protocol::participant::{Participant, Role, SolverError, Window, WindowReport};
use protocol::serve::checkpoint_folder;

use crate::failure::Failure;
use crate::link::{End, Link, Messages, Ordered};
use crate::solver::Solver;
use crate::stand_in::{Answer, StandIn};

/// Measures and writes what only a solver can at its end ([`crate::Solver::finish`]).
type Finish<P> =
    fn(&mut P, &CheckedScene, &OutputFolder) -> Result<BTreeMap<String, MetricValue>, SolverError>;

/// Values of the columns that only a solver knows.
type Extras<P> = fn(&P) -> Vec<f64>;

/// A solver in this process.
pub(crate) struct InProcess<P: Participant> {
    solver: P,
    exchange: StandIn<P::Incoming, P::Outgoing>,
    ordered: Option<Ordered>,
    /// Output folder of the run, for checkpoints.
    root: PathBuf,
    /// Values of its own columns, and how they are found.
    extras: (Vec<f64>, Extras<P>),
    /// Its largest speed, where it is a fluid.
    speed: fn(&P) -> Option<f64>,
    finish: Finish<P>,
    dt_limit: f64,
    residual: f64,
}

impl<P: Participant> InProcess<P> {
    /// A solver that exchanges messages, and has neither columns nor metrics of its own.
    pub(crate) fn new(solver: P, answer: Option<Answer<P::Incoming>>) -> Self {
        Self {
            exchange: StandIn { answer, ..StandIn::of_log(solver.grains()) },
            solver,
            ordered: None,
            root: PathBuf::new(),
            extras: (Vec::new(), |_| Vec::new()),
            speed: |_| None,
            finish: |_, _, _| Ok(BTreeMap::new()),
            dt_limit: f64::INFINITY,
            residual: 0.0,
        }
    }

    /// Did it send its message of this window?
    pub(crate) fn has_sent(&self, window: &Window) -> bool {
        self.exchange.sent == Some((window.step, window.attempt))
    }
}

impl<S: Solver> InProcess<S> {
    /// A solver that runs alone into the folder `root`.
    pub(crate) fn alone(solver: S, answer: Answer<S::Incoming>, root: &Path) -> Self {
        Self {
            root: root.to_owned(),
            extras: (Vec::new(), S::scalars),
            speed: S::speed,
            finish: S::finish,
            ..Self::new(solver, Some(answer))
        }
    }
}

impl<P> Link for InProcess<P>
where
    P: Participant,
    P::Incoming: Logged,
    P::Outgoing: Logged,
{
    fn order(&mut self, ordered: Ordered) {
        self.ordered = Some(ordered);
    }

    fn takes_orders(&self) -> bool {
        self.ordered.is_none()
    }

    fn await_window(&mut self) -> Result<Option<Command>, Failure> {
        let Some(Ordered { command, keep, given }) = self.ordered.take() else { return Ok(None) };
        let window = Window::from(command);
        if command.order == Order::Repeat as u64 {
            self.solver.restore();
        } else if keep {
            self.solver.save();
        }
        self.exchange.begin(given.map(|(header, records)| (header, P::Incoming::of(records))));
        WindowReport { dt_limit: self.dt_limit, residual: self.residual, .. } =
            self.solver.advance(&window, &mut self.exchange)?;
        if self.exchange.sent.is_none_or(|sent| self.exchange.received != Some(sent)) {
            let what = format!("it did not exchange once each way in window {}", window.step);
            return Err(SolverError::Failed(what).into());
        }
        if window.output {
            self.solver.write_fields(&window)?;
        }
        self.extras.0 = self.extras.1(&self.solver);
        self.solver.totals(&mut self.extras.0);
        Ok(Some(command))
    }

    fn messages(&self) -> Messages<'_> {
        let StandIn { incoming, outgoing, header, .. } = &self.exchange;
        let (loads, kinematics) = match P::ROLE {
            Role::Fluid => (P::Outgoing::loads(outgoing), P::Incoming::kinematics(incoming)),
            Role::Dem => (P::Incoming::loads(incoming), P::Outgoing::kinematics(outgoing)),
        };
        Messages {
            loads,
            kinematics,
            loads_header: (P::ROLE == Role::Fluid).then_some(header),
            kinematics_header: (P::ROLE == Role::Dem).then_some(header),
            reports: None,
            dt_limit: self.dt_limit,
            residual: self.residual,
            extras: &self.extras.0,
            speed: (self.speed)(&self.solver),
        }
    }

    fn checkpoint(&mut self, step: u64, _: f64) -> Result<(), Failure> {
        Ok(self.solver.write_checkpoint(&checkpoint_folder(&self.root, step))?)
    }

    fn cost(&self) -> Cost {
        let (cpu, memory) = (self.solver.solver_seconds(), Some(peak_rss_bytes()));
        let mut cost = Cost::default();
        match P::ROLE {
            Role::Fluid => (cost.fluid_cpu_s, cost.peak_rss_bytes.fluid) = (cpu, memory),
            Role::Dem => (cost.dem_cpu_s, cost.peak_rss_bytes.dem) = (cpu, memory),
        }
        cost
    }

    fn finish(
        &mut self,
        scene: &CheckedScene,
        folder: &OutputFolder,
        summary: &mut Summary,
        end: Option<End>,
    ) -> Result<(), Failure> {
        if end == Some(End::Reached) {
            summary.metrics.extend((self.finish)(&mut self.solver, scene, folder)?);
        }
        Ok(())
    }
}
