//! What the coupler hears, put into the order in which it happened.

use std::collections::VecDeque;

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;

use super::rendezvous::Rendezvous;
use super::topics::{self, transport};
use super::watch::Member;
use crate::message::{Header, Kinematics, Loads, Record, State, Status};
use crate::participant::{ExchangeError, Role};

/// An observed message, still in shared memory. Hold one at a time and not for long: while it is
/// held, its sender has one buffer less.
#[derive(Debug)]
pub struct Lent<R: Record + ZeroCopySend>(Sample<ipc::Service, [R], Header>);

impl<R: Record + ZeroCopySend> Lent<R> {
    /// What stands before the slice.
    #[must_use]
    pub fn header(&self) -> &Header {
        self.0.user_header()
    }

    /// One record per grain.
    #[must_use]
    pub fn records(&self) -> &[R] {
        self.0.payload()
    }
}

/// What the coupler hears.
#[derive(Debug)]
#[allow(clippy::large_enum_variant)] // moved once; boxing the report would allocate in each window
pub enum Event {
    /// The fluid sent loads.
    Loads(Lent<Loads>),
    /// The DEM sent kinematics.
    Kinematics(Lent<Kinematics>),
    /// A solver reported.
    Status(Role, Status),
}

/// A topic of data with the message taken from it and not yet given out.
#[derive(Debug)]
struct Feed<R: Record + ZeroCopySend> {
    subscriber: Subscriber<ipc::Service, [R], Header>,
    held: Option<Lent<R>>,
    /// Messages given out, to tell who is behind.
    given: u64,
}

impl<R: Record + ZeroCopySend> Feed<R> {
    fn open(node: &Node<ipc::Service>, rendezvous: &Rendezvous) -> Result<Self, ExchangeError> {
        let subscriber = topics::records::<R>(node, rendezvous, Member::Coupler)?
            .subscriber_builder()
            .create()
            .map_err(transport("cannot observe the solvers"))?;
        Ok(Self { subscriber, held: None, given: 0 })
    }

    fn fill(&mut self) -> Result<(), ExchangeError> {
        if self.held.is_none() {
            let taken = self.subscriber.receive();
            self.held = taken.map_err(transport("cannot observe"))?.map(Lent);
        }
        Ok(())
    }

    fn key(&self) -> Option<(u64, u64)> {
        let header = self.held.as_ref()?.header();
        Some((header.step, header.attempt))
    }

    fn give(&mut self) -> Option<Lent<R>> {
        self.given += 1;
        self.held.take()
    }
}

/// A solver as the coupler sees it.
#[derive(Debug)]
struct Participant {
    role: Role,
    subscriber: Subscriber<ipc::Service, Status, ()>,
    held: VecDeque<Status>,
    /// Reports given out.
    answered: u64,
    /// Those about windows (and tries).
    windows: u64,
    /// It has left in order.
    stopped: bool,
}

impl Participant {
    fn open(node: &Node<ipc::Service>, rendezvous: &Rendezvous, role: Role) -> Result<Self, ExchangeError> {
        let subscriber = topics::status(node, rendezvous, Member::Coupler, role)?
            .subscriber_builder()
            .create()
            .map_err(transport("cannot subscribe to status"))?;
        Ok(Self {
            role,
            subscriber,
            held: VecDeque::with_capacity(rendezvous.ahead + 8),
            answered: 0,
            windows: 0,
            stopped: false,
        })
    }

    fn fill(&mut self) -> Result<(), ExchangeError> {
        if self.held.is_empty() {
            let taken = self.subscriber.receive();
            if let Some(status) = taken.map_err(transport("cannot receive a status"))? {
                self.held.push_back(*status.payload());
            }
        }
        Ok(())
    }

    fn key(&self) -> Option<(u64, u64)> {
        self.held.front().map(|status| (status.step, status.attempt))
    }

    fn give(&mut self) -> Option<Status> {
        let status = self.held.pop_front()?;
        self.answered += 1;
        self.windows += u64::from(status.state == State::Done as u64);
        self.stopped |= status.state == State::Stopped as u64;
        Some(status)
    }
}

/// Every topic that the coupler listens to.
#[derive(Debug)]
pub(crate) struct Observer {
    loads: Feed<Loads>,
    kinematics: Feed<Kinematics>,
    participants: Vec<Participant>,
}

impl Observer {
    pub(crate) fn open(node: &Node<ipc::Service>, rendezvous: &Rendezvous) -> Result<Self, ExchangeError> {
        let participants = rendezvous.roles.iter();
        Ok(Self {
            loads: Feed::open(node, rendezvous)?,
            kinematics: Feed::open(node, rendezvous)?,
            participants: participants
                .map(|role| Participant::open(node, rendezvous, *role))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Connects to publishers that have come since.
    pub(crate) fn connect(&self) -> Result<(), ExchangeError> {
        let failed = transport("cannot observe a solver");
        self.loads.subscriber.update_connections().map_err(&failed)?;
        self.kinematics.subscriber.update_connections().map_err(&failed)
    }

    /// The next event, if there is one: the earliest window first, in it loads, kinematics, reports.
    ///
    /// Reports are looked for first, then loads, then kinematics, against the order of events: what
    /// is found was then sent after everything it depends on, which the later looks find too.
    pub(crate) fn poll(&mut self) -> Result<Option<Event>, ExchangeError> {
        for participant in &mut self.participants {
            participant.fill()?;
        }
        self.loads.fill()?;
        self.kinematics.fill()?;
        let data = [(self.loads.key(), 0), (self.kinematics.key(), 1)];
        let reports =
            self.participants.iter().zip(2..).map(|(participant, place)| (participant.key(), place));
        let first =
            data.into_iter().chain(reports).filter_map(|(key, place)| key.map(|key| (key, place))).min();
        Ok(first.and_then(|(_, place): (_, usize)| match place {
            0 => self.loads.give().map(Event::Loads),
            1 => self.kinematics.give().map(Event::Kinematics),
            _ => {
                let participant = &mut self.participants[place - 2];
                participant.give().map(|status| Event::Status(participant.role, status))
            }
        }))
    }

    /// Solvers that have not left in order.
    pub(crate) fn running(&self) -> impl Iterator<Item = Member> {
        let running = self.participants.iter().filter(|participant| !participant.stopped);
        running.map(|participant| Member::Solver(participant.role))
    }

    /// Reports of the solver that has given the fewest.
    pub(crate) fn answered(&self) -> u64 {
        let answers = self.participants.iter().map(|participant| participant.answered);
        answers.min().unwrap_or(0)
    }

    /// The solver that the run waits for: the DEM where it owes motion for loads, whatever it reports; else
    /// the one that owes a report; else, of two, the DEM where all was sent, as it reports before the fluid;
    /// else the fluid, which sends first.
    pub(crate) fn behind(&self) -> Role {
        let least = self.answered();
        let mut owing = self.participants.iter().filter(|participant| participant.answered == least);
        match (owing.next(), owing.next()) {
            _ if self.loads.given > self.kinematics.given => Role::Dem,
            (Some(participant), None) => participant.role,
            (Some(participant), _) if self.kinematics.given > participant.windows => Role::Dem,
            _ => Role::Fluid,
        }
    }
}
