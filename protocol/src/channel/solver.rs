//! A solver's end of the run.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::PortFactory;

use super::folder::Membership;
use super::outbox::{Outbox, Receivers};
use super::rendezvous::{Rendezvous, compare};
use super::topics::{self, transport};
use super::wake::{Rhythm, Wake};
use super::watch::{Member, Watch};
use crate::message::{Command, Header, Kinematics, Loads, Order, Record, Status};
use crate::participant::{Exchange, ExchangeError, Role, Window};

/// A record that a solver receives through shared memory.
///
/// Its implementations are concrete, so that the code of iceoryx2 is compiled once, in this crate.
pub trait Wire: Record {
    /// What is sent in return.
    type Answer: Record;

    /// Joins a run as its solver in `role`, which receives these records, and waits until the peer has
    /// joined too, so that no message is lost.
    ///
    /// # Errors
    /// [`ExchangeError::Mismatch`] if the coupler was built against another layout or knows another
    /// number of grains, [`ExchangeError::Deadline`] if the peer does not come,
    /// [`ExchangeError::Transport`] if the run is over or the role is taken.
    fn join(rendezvous: &Rendezvous, role: Role, grains: usize) -> Result<Joined<Self>, ExchangeError>;
}

/// A solver that has joined a run and receives `In`.
pub type Joined<In> = Box<dyn Connection<In, <In as Wire>::Answer>>;

impl Wire for Loads {
    type Answer = Kinematics;

    fn join(rendezvous: &Rendezvous, role: Role, grains: usize) -> Result<Joined<Self>, ExchangeError> {
        Ok(Box::new(SharedMemory::<Self, Kinematics>::join(rendezvous, role, grains)?))
    }
}

impl Wire for Kinematics {
    type Answer = Loads;

    fn join(rendezvous: &Rendezvous, role: Role, grains: usize) -> Result<Joined<Self>, ExchangeError> {
        Ok(Box::new(SharedMemory::<Self, Loads>::join(rendezvous, role, grains)?))
    }
}

/// A solver as connected to a run: it receives `In` and sends `Out`.
///
/// Dropped, it leaves the run; whoever leaves last removes what iceoryx2 left behind.
pub trait Connection<In: Record, Out: Record>: Exchange<In, Out> + std::fmt::Debug {
    /// The run.
    fn rendezvous(&self) -> &Rendezvous;

    /// Wall time spent sending and receiving so far, waiting excluded, s.
    fn exchange_seconds(&self) -> f64;

    /// Sends `status` to the coupler.
    ///
    /// # Errors
    /// [`ExchangeError`] if it does not take it.
    fn report(&mut self, status: Status) -> Result<(), ExchangeError>;

    /// Waits for the next command, in the order in which they were given. The time of two joins and
    /// windows is allowed: the coupler may itself be waiting for the other solver.
    ///
    /// # Errors
    /// [`ExchangeError::PeerDied`] or [`ExchangeError::Deadline`] of the coupler.
    fn next_command(&mut self) -> Result<Command, ExchangeError>;
}

/// The ports of a solver.
#[derive(Debug)]
struct SharedMemory<In: Record + ZeroCopySend, Out: Record + ZeroCopySend> {
    incoming: Subscriber<ipc::Service, [In], Header>,
    outgoing: Outbox<[Out], Header>,
    commands: Subscriber<ipc::Service, Command, ()>,
    status: Outbox<Status, ()>,
    /// Commands taken while waiting for the peer.
    backlog: VecDeque<Command>,
    wake: Wake,
    /// Of the waits for the peer.
    rhythm: Rhythm,
    watch: Watch,
    role: Role,
    peer: Option<Role>,
    step: u64,
    exchange: Duration,
    rendezvous: Rendezvous,
    // Ports go before the node, the node before the membership.
    _node: Node<ipc::Service>,
    _membership: Membership,
}

impl<In: Record + ZeroCopySend, Out: Record + ZeroCopySend> SharedMemory<In, Out> {
    fn join(rendezvous: &Rendezvous, role: Role, grains: usize) -> Result<Self, ExchangeError> {
        let own = Member::Solver(role);
        compare(Member::Coupler, "number of grains", rendezvous.grains, grains)?;
        if !rendezvous.roles.contains(&role) {
            return Err(ExchangeError::Transport(format!(
                "run {} has no {role}: {:?} take part",
                rendezvous.run, rendezvous.roles
            )));
        }
        let membership = Membership::join(rendezvous)?;
        let node = topics::node(rendezvous, own)?;
        let watch = Watch::new(node.config());
        let peer = rendezvous.peer_of(role);
        let to =
            |members: Vec<Member>| Receivers { members, watch: watch.clone(), limit: rendezvous.deadline() };

        let outgoing_topic = topics::records::<Out>(&node, rendezvous, own)?;
        let incoming_topic = topics::records::<In>(&node, rendezvous, own)?;
        let observers = std::iter::once(Member::Coupler).chain(peer.map(Member::Solver));
        let outgoing = Outbox::records(&outgoing_topic, grains, to(observers.collect()))?;
        let incoming = incoming_topic
            .subscriber_builder()
            .create()
            .map_err(transport("cannot subscribe to the peer"))?;
        let commands = topics::commands(&node, rendezvous, own)?
            .subscriber_builder()
            .create()
            .map_err(transport("cannot subscribe to commands"))?;
        let status = topics::status(&node, rendezvous, own, role)?;
        let status = Outbox::single(&status, to(vec![Member::Coupler]))?;
        let mut link = Self {
            incoming,
            outgoing,
            commands,
            status,
            backlog: VecDeque::with_capacity(rendezvous.ahead + 4),
            wake: Wake::open(&node, rendezvous, own)?,
            rhythm: Rhythm::default(),
            watch,
            role,
            peer,
            step: 0,
            exchange: Duration::ZERO,
            rendezvous: rendezvous.clone(),
            _node: node,
            _membership: membership,
        };
        link.await_peer(|| {
            let publishers = incoming_topic.dynamic_config().number_of_publishers();
            let subscribers = outgoing_topic.dynamic_config().number_of_subscribers();
            publishers == 1 && subscribers == 2
        })?;
        Ok(link)
    }

    /// Waits until the peer's ports exist, and connects to them.
    fn await_peer(&mut self, there: impl Fn() -> bool) -> Result<(), ExchangeError> {
        if let Some(peer) = self.peer {
            self.wake.ring(Member::Solver(peer))?;
            let watch = &mut self.watch;
            let members = [Member::Coupler, Member::Solver(peer)];
            // The coupler finds out first who did not join, and says so.
            let limit = self.rendezvous.join() + self.rendezvous.deadline();
            self.wake
                .wait(limit, &mut Rhythm::default(), &mut || Ok(there().then_some(())), &mut || {
                    watch.check(&members, 0)
                })?
                .ok_or_else(|| ExchangeError::late(peer, 0, limit))?;
            self.wake.ring(Member::Solver(peer))?;
        }
        self.incoming.update_connections().map_err(transport("cannot connect to the peer"))?;
        self.commands.update_connections().map_err(transport("cannot connect to the coupler"))?;
        self.outgoing.connect()?;
        self.status.connect()?;
        self.watch.everyone_joined();
        Ok(())
    }
}

impl<In: Record + ZeroCopySend, Out: Record + ZeroCopySend> Connection<In, Out> for SharedMemory<In, Out> {
    fn rendezvous(&self) -> &Rendezvous {
        &self.rendezvous
    }

    fn exchange_seconds(&self) -> f64 {
        self.exchange.as_secs_f64()
    }

    fn report(&mut self, status: Status) -> Result<(), ExchangeError> {
        let start = Instant::now();
        let held_up = self.status.send(status, status.step)?;
        self.wake.ring(Member::Coupler)?;
        self.exchange += start.elapsed().saturating_sub(held_up);
        Ok(())
    }

    fn next_command(&mut self) -> Result<Command, ExchangeError> {
        if let Some(command) = self.backlog.pop_front() {
            return Ok(command);
        }
        let limit = 2 * (self.rendezvous.join() + self.rendezvous.deadline());
        let (commands, watch, step) = (&self.commands, &mut self.watch, self.step);
        let found = self.wake.wait(limit, &mut Rhythm::default(), &mut || take(commands), &mut || {
            watch.check(&[Member::Coupler], step)
        })?;
        found.ok_or_else(|| ExchangeError::late(Member::Coupler, step, limit))
    }
}

fn take(commands: &Subscriber<ipc::Service, Command, ()>) -> Result<Option<Command>, ExchangeError> {
    let taken = commands.receive().map_err(transport("cannot receive a command"))?;
    Ok(taken.map(|sample| *sample.payload()))
}

/// Keeps the commands that are there for later; fails with [`ExchangeError::Stopped`] at `Stop`.
fn take_until_stop(
    commands: &Subscriber<ipc::Service, Command, ()>,
    backlog: &mut VecDeque<Command>,
) -> Result<(), ExchangeError> {
    while let Some(command) = take(commands)? {
        if command.order == Order::Stop as u64 {
            return Err(ExchangeError::Stopped);
        }
        backlog.push_back(command);
    }
    Ok(())
}

impl<In: Record + ZeroCopySend, Out: Record + ZeroCopySend> Exchange<In, Out> for SharedMemory<In, Out> {
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Out])) -> Result<(), ExchangeError> {
        let start = Instant::now();
        self.step = header.step;
        let sent = self.outgoing.send(header, self.rendezvous.grains, fill);
        let held_up = sent.or_else(|error| {
            // As in `receive`: a receiver that has gone may have obeyed Stop.
            take_until_stop(&self.commands, &mut self.backlog)?;
            Err(error)
        })?;
        if let Some(peer) = self.peer {
            self.wake.ring(Member::Solver(peer))?;
        }
        self.exchange += start.elapsed().saturating_sub(held_up);
        Ok(())
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[In]),
    ) -> Result<(), ExchangeError> {
        let Some(peer) = self.peer else {
            let what = format!("the {} waits for {} in a run without its sender", self.role, In::NAME);
            return Err(ExchangeError::Order(what));
        };
        self.step = window.step;
        let members = [Member::Solver(peer), Member::Coupler];
        let (incoming, commands) = (&self.incoming, &self.commands);
        let (watch, backlog) = (&mut self.watch, &mut self.backlog);
        let limit = self.rendezvous.deadline();
        let found = self.wake.wait(
            limit,
            &mut self.rhythm,
            &mut || incoming.receive().map_err(transport("cannot receive")),
            &mut || {
                // A peer that has obeyed Stop is gone: the orders are read after the look at the peer, as
                // what made it leave is among them by then.
                let there = watch.check(&members, window.step);
                take_until_stop(commands, backlog)?;
                there
            },
        )?;
        let start = Instant::now();
        let sample = found.ok_or_else(|| ExchangeError::late(peer, window.step, limit))?;
        let (header, records) = (sample.user_header(), sample.payload());
        belongs(window, header, records.len(), self.rendezvous.grains)?;
        read(header, records);
        drop(sample);
        self.exchange += start.elapsed();
        Ok(())
    }
}

/// Refuses a message of another window, another try, or another number of grains.
fn belongs(window: &Window, header: &Header, count: usize, grains: usize) -> Result<(), ExchangeError> {
    if (header.step, header.attempt) != (window.step, window.attempt) {
        return Err(ExchangeError::Order(format!(
            "expected window {} attempt {}, got window {} attempt {}",
            window.step, window.attempt, header.step, header.attempt
        )));
    }
    if count != grains {
        let what = format!("expected {grains} grains in window {}, got {count}", window.step);
        return Err(ExchangeError::Order(what));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_of_another_window_try_or_count_is_refused() {
        let window = Window { step: 7, attempt: 2, time: 0.0, dt: 0.1, substeps: 5, output: false };
        let header = window.header();
        assert!(belongs(&window, &header, 4, 4).is_ok());
        for (step, attempt, count, named) in [
            (6, 2, 4, "got window 6 attempt 2"),
            (8, 2, 4, "got window 8 attempt 2"),
            (7, 1, 4, "got window 7 attempt 1"),
            (7, 2, 3, "expected 4 grains in window 7, got 3"),
            (7, 2, 5, "expected 4 grains in window 7, got 5"),
        ] {
            let header = Header { step, attempt, ..header };
            let error = belongs(&window, &header, count, 4).unwrap_err();
            assert!(matches!(error, ExchangeError::Order(_)));
            assert!(error.to_string().contains(named), "{error}");
        }
    }
}
