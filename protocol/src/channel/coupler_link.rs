//! The coupler's end of a run.

use std::collections::VecDeque;
use std::time::Duration;

use iceoryx2::prelude::*;

use super::folder::Membership;
use super::observer::{Event, Observer};
use super::outbox::{Outbox, Receivers};
use super::rendezvous::{Rendezvous, compare};
use super::space;
use super::topics;
use super::wake::{Pace, Rhythm, Wake};
use super::watch::{Member, Watch};
use crate::message::{Command, Order, State, Status};
use crate::participant::{ExchangeError, Role};

/// The coupler's end: founds the run, gives orders, observes everything. Dropped, it leaves the run.
#[derive(Debug)]
pub struct CouplerLink {
    commands: Outbox<Command, ()>,
    observer: Observer,
    wake: Wake,
    pace: Pace,
    watch: Watch,
    /// Commands given that are answered by a report.
    ordered: u64,
    /// Windows of the last of them, the newest at the end.
    steps: VecDeque<u64>,
    rendezvous: Rendezvous,
    // Ports go before the node, the node before the membership.
    _node: Node<ipc::Service>,
    _membership: Membership,
}

impl CouplerLink {
    /// Founds the run of `rendezvous`; start the solvers afterwards.
    ///
    /// # Errors
    /// [`ExchangeError::Transport`] if a folder, segment or service cannot be made.
    pub fn create(rendezvous: &Rendezvous) -> Result<Self, ExchangeError> {
        space::ask(rendezvous)?;
        let membership = Membership::found(rendezvous)?;
        let own = Member::Coupler;
        space::make_nodes(rendezvous)?;
        let node = topics::node(rendezvous, own)?;
        let watch = Watch::new(node.config());
        let solvers = rendezvous.roles.iter().copied().map(Member::Solver);
        let commands = topics::commands(&node, rendezvous, own)?;
        let commands = Outbox::single(
            &commands,
            Receivers { members: solvers.collect(), watch: watch.clone(), limit: rendezvous.deadline() },
        )?;
        space::take(rendezvous)?;
        Ok(Self {
            commands,
            observer: Observer::open(&node, rendezvous)?,
            wake: Wake::open(&node, rendezvous, own)?,
            pace: Pace::default(),
            watch,
            ordered: 0,
            steps: VecDeque::new(),
            rendezvous: rendezvous.clone(),
            _node: node,
            _membership: membership,
        })
    }

    /// The run; its [`Rendezvous::token`] goes to the solvers.
    pub fn rendezvous(&self) -> &Rendezvous {
        &self.rendezvous
    }

    /// Waits until every solver has joined and said `Ready`, and checks what they know. `alive` is
    /// called every few milliseconds: there the supervisor looks after its child processes.
    ///
    /// # Errors
    /// [`ExchangeError::Mismatch`] if a solver was built against another layout or knows another
    /// number of grains, [`ExchangeError::Failed`] if it gave up, [`ExchangeError::PeerDied`],
    /// [`ExchangeError::NotJoined`], or what `alive` returned.
    pub fn wait_ready(
        &mut self,
        alive: &mut dyn FnMut() -> Result<(), ExchangeError>,
    ) -> Result<Vec<(Role, Status)>, ExchangeError> {
        self.ordered += 1;
        let mut ready = Vec::new();
        while ready.len() < self.rendezvous.roles.len() {
            let event = self.next(self.rendezvous.join(), alive).map_err(|error| match error {
                ExchangeError::Deadline { peer, seconds, .. } => {
                    let absent = self.watch.absent(&self.rendezvous.roles);
                    ExchangeError::NotJoined { peer: absent.map_or(peer, |role| role.to_string()), seconds }
                }
                other => other,
            })?;
            let Event::Status(role, status) = event else {
                return Err(ExchangeError::Order("a solver sent data before the first command".into()));
            };
            self.check_ready(role, &status)?;
            ready.push((role, status));
        }
        self.commands.connect()?;
        self.observer.connect()?;
        space::take(&self.rendezvous)?;
        self.watch.everyone_joined();
        Ok(ready)
    }

    fn check_ready(&self, role: Role, status: &Status) -> Result<(), ExchangeError> {
        if status.state == State::Failed as u64 {
            return Err(ExchangeError::Failed { peer: role.to_string(), text: status.text() });
        }
        if status.state != State::Ready as u64 {
            let what = format!("expected Ready of the {role}, got state {}", status.state);
            return Err(ExchangeError::Order(what));
        }
        let peer = Member::Solver(role);
        compare(peer, "protocol and layout", status.text(), Rendezvous::greeting())?;
        compare(peer, "number of grains", status.grains, self.rendezvous.grains as u64)
    }

    /// Gives an order to every solver. Up to [`Rendezvous::ahead`] may be unanswered at once.
    /// `Stop` reaches those who are left, also after one has died.
    ///
    /// # Errors
    /// [`ExchangeError::Order`] for a window more than that, [`ExchangeError`] if a solver does not
    /// take it.
    pub fn order(&mut self, command: Command) -> Result<(), ExchangeError> {
        let window = [Order::Advance as u64, Order::Repeat as u64].contains(&command.order);
        if window && self.unanswered() >= self.rendezvous.ahead as u64 {
            return Err(ExchangeError::Order(format!(
                "window {} ordered with {} unanswered: at most {} may be ordered ahead",
                command.step,
                self.unanswered(),
                self.rendezvous.ahead
            )));
        }
        let sent = self.commands.send(command, command.step);
        if command.order != Order::Accept as u64 {
            self.ordered += 1;
            self.steps.push_back(command.step);
            while self.steps.len() as u64 > self.unanswered().max(1) {
                self.steps.pop_front();
            }
        }
        for role in &self.rendezvous.roles {
            self.wake.ring(Member::Solver(*role))?;
        }
        match sent {
            Err(ExchangeError::PeerDied { .. }) if command.order == Order::Stop as u64 => Ok(()),
            sent => sent.map(drop),
        }
    }

    /// Orders that some solver has not answered yet.
    pub fn unanswered(&self) -> u64 {
        self.ordered.saturating_sub(self.observer.answered())
    }

    /// Window of the oldest order that a solver has not answered, else of the last one.
    pub fn step(&self) -> u64 {
        let answered = (self.steps.len() as u64).saturating_sub(self.unanswered().max(1));
        self.steps.get(answered as usize).copied().unwrap_or(0)
    }

    /// Waits at most `limit` for the next event. `alive` is called every few milliseconds; with it
    /// the nodes of all solvers that have not said `Stopped` are looked at.
    ///
    /// Events come in an order in which they may have happened: the loads of a window, its
    /// kinematics, the reports about it; loads of the next window after the kinematics of this one.
    /// (A solver that was ordered ahead may send again before the other one has reported.)
    ///
    /// # Errors
    /// [`ExchangeError::Deadline`] naming the solver that is behind, [`ExchangeError::PeerDied`], or
    /// what `alive` returned.
    pub fn next(
        &mut self,
        limit: Duration,
        alive: &mut dyn FnMut() -> Result<(), ExchangeError>,
    ) -> Result<Event, ExchangeError> {
        let step = self.step();
        let members: Vec<Member> = self.observer.running().collect();
        // With a window in hand nobody waits for the coupler: it looks once a window, unasked.
        let spare = self.unanswered() >= 2;
        let Self { wake, watch, observer, pace, .. } = self;
        pace.learn(observer.answered());
        if let Some(event) = observer.poll()? {
            return Ok(event);
        }
        if let Some(nap) = pace.nap().filter(|_| spare) {
            std::thread::sleep(nap);
        }
        let found = wake.wait(limit, &mut Rhythm::default(), &mut || observer.poll(), &mut || {
            alive()?;
            watch.check(&members, step)
        })?;
        found.ok_or_else(|| ExchangeError::late(self.observer.behind(), step, limit))
    }

    /// The next event if there is one already.
    ///
    /// # Errors
    /// [`ExchangeError::Transport`].
    pub fn try_next(&mut self) -> Result<Option<Event>, ExchangeError> {
        self.observer.poll()
    }
}
