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
    pub fn header(&self) -> &Header {
        self.0.user_header()
    }

    /// One record per grain.
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

    /// Takes the next message where none is in hand; whether one is then.
    fn fill(&mut self) -> Result<bool, ExchangeError> {
        if self.held.is_none() {
            let taken = self.subscriber.receive();
            self.held = taken.map_err(transport("cannot observe"))?.map(Lent);
        }
        Ok(self.held.is_some())
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

/// A look for messages of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Look {
    Loads,
    Kinematics,
    Reports,
}

/// The looks of one poll; `look` says whether a message of the kind is in hand. What is found was sent after
/// everything that it depends on, which a later look finds too: reports follow kinematics, loads the
/// kinematics of the window before. Kinematics found without loads were sent, like their loads, between the
/// two looks, so a last one finds the loads.
fn look_for_all<E>(mut look: impl FnMut(Look) -> Result<bool, E>) -> Result<(), E> {
    look(Look::Reports)?;
    look(Look::Loads)?;
    if look(Look::Kinematics)? {
        look(Look::Loads)?;
    }
    Ok(())
}

/// Place of the message that happened first, by its window and attempt, among loads (0), kinematics (1) and
/// the reports (2 and on).
fn earliest<K: Ord>(
    loads: Option<K>,
    kinematics: Option<K>,
    reports: impl Iterator<Item = Option<K>>,
) -> Option<usize> {
    let all = [loads, kinematics].into_iter().chain(reports).enumerate();
    all.filter_map(|(place, key)| Some((key?, place))).min().map(|(_, place)| place)
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
    pub(crate) fn poll(&mut self) -> Result<Option<Event>, ExchangeError> {
        look_for_all(|look| match look {
            Look::Reports => self.participants.iter_mut().try_for_each(Participant::fill).map(|()| true),
            Look::Loads => self.loads.fill(),
            Look::Kinematics => self.kinematics.fill(),
        })?;
        let reports = self.participants.iter().map(Participant::key);
        Ok(match earliest(self.loads.key(), self.kinematics.key(), reports) {
            None => None,
            Some(0) => self.loads.give().map(Event::Loads),
            Some(1) => self.kinematics.give().map(Event::Kinematics),
            Some(place) => {
                let participant = &mut self.participants[place - 2];
                participant.give().map(|status| Event::Status(participant.role, status))
            }
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Messages of windows in the order in which they are sent: loads, kinematics, the report of the DEM.
    const SENT: [Look; 9] = [
        Look::Loads,
        Look::Kinematics,
        Look::Reports,
        Look::Loads,
        Look::Kinematics,
        Look::Loads,
        Look::Reports,
        Look::Kinematics,
        Look::Reports,
    ];

    /// Messages taken and in hand, by kind: loads, kinematics, reports.
    #[derive(Default)]
    struct Model {
        taken: [usize; 3],
        held: [Option<usize>; 3],
    }

    impl Model {
        /// One poll with `seen` messages sent at each look; whether the event it gives keeps the order.
        fn poll(&mut self, seen: [usize; 4]) -> bool {
            let mut seen = seen.into_iter();
            look_for_all(|look| {
                let kind = look as usize;
                let sent = SENT[..seen.next().ok_or(())?].iter().filter(|sent| **sent == look).count();
                if self.held[kind].is_none() && self.taken[kind] < sent {
                    self.held[kind] = Some(self.taken[kind]);
                    self.taken[kind] += 1;
                }
                Ok::<_, ()>(self.held[kind].is_some())
            })
            .expect("four looks at most");
            let [loads, kinematics, reports] = self.held;
            let Some(kind) = earliest(loads, kinematics, [reports].into_iter()) else { return true };
            let window = self.held[kind].take().expect("in hand");
            let given =
                |kind: Look| self.taken[kind as usize] - usize::from(self.held[kind as usize].is_some());
            match kind {
                0 => given(Look::Kinematics) == window,
                1 => given(Look::Loads) == window + 1,
                _ => given(Look::Kinematics) > window,
            }
        }

        fn done(&self) -> bool {
            self.taken.iter().sum::<usize>() == SENT.len() && self.held.iter().all(Option::is_none)
        }
    }

    /// Whatever is sent between any two looks of the first polls, events come in their order.
    #[test]
    fn events_keep_their_order_wherever_messages_arrive_between_the_looks() {
        for code in 0..4_usize.pow(8) {
            let mut model = Model::default();
            let mut seen = 0;
            let arrivals: [usize; 8] = std::array::from_fn(|look| {
                seen = SENT.len().min(seen + code / 4_usize.pow(look as u32) % 4);
                seen
            });
            for poll in arrivals.chunks(4) {
                assert!(model.poll(poll.try_into().unwrap()), "messages there at the looks: {arrivals:?}");
            }
            while !model.done() {
                assert!(model.poll([SENT.len(); 4]), "after {arrivals:?}");
            }
        }
    }
}
