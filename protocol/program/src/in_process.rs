//! A solver in this process as a link: the absent one is played by a function of the scene, or by a log.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bedload_output::{Cost, MetricValue, OutputFolder, Summary};
use bedload_scene::CheckedScene;
use protocol::log::Logged;
use protocol::memory::peak_rss_bytes;
use protocol::message::{Command, Header, Order, Record};
use protocol::participant::{Exchange, ExchangeError, Participant, Role, SolverError, Window};
use protocol::serve::checkpoint_folder;

use crate::failure::Failure;
use crate::link::{End, Link, Messages, Ordered};
use crate::solver::Solver;

/// What the absent peer would send in a window.
pub type Answer<R> = Box<dyn Fn(&Window, &mut [R]) + Send>;

/// The exchange of a solver alone: takes what it sends, gives it the answer.
pub struct StandIn<In: Record, Out: Record> {
    answer: Option<Answer<In>>,
    /// A message from a log, in place of the answer.
    given: Option<Header>,
    incoming: Vec<In>,
    outgoing: Vec<Out>,
    header: Header,
    /// Window and attempt in which it sent last, and received last.
    sent: Option<(u64, u64)>,
    received: Option<(u64, u64)>,
}

impl<In: Record, Out: Record> StandIn<In, Out> {
    /// For `grains` grains, with `answer` in place of the peer.
    #[must_use]
    pub fn new(grains: usize, answer: Answer<In>) -> Self {
        Self { answer: Some(answer), ..Self::of_log(grains) }
    }

    /// For `grains` grains, with the messages of a log in place of the peer.
    fn of_log(grains: usize) -> Self {
        Self {
            answer: None,
            given: None,
            incoming: vec![In::default(); grains],
            outgoing: vec![Out::default(); grains],
            header: Header::default(),
            sent: None,
            received: None,
        }
    }

    /// What the solver sent in the last window.
    #[must_use]
    pub fn outgoing(&self) -> (&Header, &[Out]) {
        (&self.header, &self.outgoing)
    }

    /// Begins a window, with the peer's message if the log has one.
    fn begin(&mut self, given: Option<(Header, Vec<In>)>) {
        (self.sent, self.received) = (None, None);
        self.given = given.map(|(header, records)| {
            self.incoming = records;
            header
        });
    }
}

impl<In: Record, Out: Record> Exchange<In, Out> for StandIn<In, Out> {
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Out])) -> Result<(), ExchangeError> {
        let window = Some((header.step, header.attempt));
        if std::mem::replace(&mut self.sent, window) == window {
            let what = format!("{} sent twice in window {}", Out::NAME, header.step);
            return Err(ExchangeError::Order { what });
        }
        self.header = header;
        fill(&mut self.outgoing);
        Ok(())
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[In]),
    ) -> Result<(), ExchangeError> {
        let asked = Some((window.step, window.attempt));
        if std::mem::replace(&mut self.received, asked) == asked {
            let what = format!("{} asked for twice in window {}", In::NAME, window.step);
            return Err(ExchangeError::Order { what });
        }
        match (&self.given, &self.answer) {
            (Some(header), _) if Some((header.step, header.attempt)) != asked => {
                let what = format!(
                    "window {} attempt {} asked for, the log is at {} attempt {}",
                    window.step, window.attempt, header.step, header.attempt
                );
                return Err(ExchangeError::Order { what });
            }
            (Some(header), _) => read(header, &self.incoming),
            (None, Some(answer)) => {
                answer(window, &mut self.incoming);
                read(&window.header(), &self.incoming);
            }
            (None, None) => {
                let what = format!("the log has no {}: that solver took no part", In::NAME);
                return Err(ExchangeError::Order { what });
            }
        }
        Ok(())
    }
}

/// Measures and writes what only a solver can at its end ([`crate::Solver::finish`]).
type Finish<P> =
    fn(&mut P, &CheckedScene, &OutputFolder) -> Result<BTreeMap<String, MetricValue>, SolverError>;

/// A solver in this process.
pub(crate) struct InProcess<P: Participant> {
    solver: P,
    exchange: StandIn<P::Incoming, P::Outgoing>,
    ordered: Option<Ordered>,
    /// Output folder of the run, for checkpoints.
    root: PathBuf,
    /// Values of its own columns, and how they are found.
    extras: (Vec<f64>, fn(&P) -> Vec<f64>),
    finish: Finish<P>,
    dt_limit: f64,
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
            finish: |_, _, _| Ok(BTreeMap::new()),
            dt_limit: f64::INFINITY,
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
        self.dt_limit = self.solver.advance(&window, &mut self.exchange)?.dt_limit;
        if !self.exchange.sent.is_some_and(|sent| self.exchange.received == Some(sent)) {
            let what = format!("it did not exchange once each way in window {}", window.step);
            return Err(SolverError::Failed(what).into());
        }
        if window.output {
            self.solver.write_fields(&window)?;
        }
        self.extras.0 = self.extras.1(&self.solver);
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
            extras: &self.extras.0,
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

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::message::{Kinematics, Loads};

    fn window(step: u64) -> Window {
        Window { step, attempt: 0, time: 0.0, dt: 0.1, substeps: 1, output: false }
    }

    fn receive(exchange: &mut StandIn<Loads, Kinematics>, step: u64) -> Result<f64, ExchangeError> {
        let mut force = f64::NAN;
        exchange.receive(&window(step), &mut |_, loads| force = loads[0].force[2])?;
        Ok(force)
    }

    #[test]
    fn an_exchange_out_of_turn_is_refused() {
        let mut exchange = StandIn::<Loads, Kinematics>::of_log(1);
        assert!(receive(&mut exchange, 0).is_err(), "neither a message nor an answer");
        let logged =
            |step| Some((window(step).header(), vec![Loads { force: [0.0, 0.0, 2.0], ..Loads::default() }]));
        exchange.begin(logged(0));
        assert!(receive(&mut exchange, 1).is_err(), "another window");
        exchange.begin(logged(0));
        assert_eq!(receive(&mut exchange, 0).expect("the logged message"), 2.0);
        assert!(receive(&mut exchange, 0).is_err(), "twice");
        let send = |exchange: &mut StandIn<Loads, Kinematics>, step| {
            Exchange::<Loads, Kinematics>::send(exchange, window(step).header(), &mut |_| {})
        };
        assert!(send(&mut exchange, 0).is_ok());
        assert!(send(&mut exchange, 0).is_err(), "twice");
        assert!(send(&mut exchange, 1).is_ok());
        let mut alone =
            StandIn::<Loads, Kinematics>::new(1, Box::new(|window, loads| loads[0].force[2] = window.dt));
        assert_eq!(receive(&mut alone, 7).expect("the answer"), 0.1);
    }
}
