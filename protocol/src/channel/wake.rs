//! Waiting for a message: yield for a moment, then sleep until the sender's event, and look now and
//! then whether the sender lives.

use std::time::{Duration, Instant};

use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;

use super::rendezvous::{Rendezvous, Waiting};
use super::topics::{self, transport};
use super::watch::{LOOK_EVERY, Member};
use crate::participant::ExchangeError;

/// The ear of this process, and the bells of the others.
#[derive(Debug)]
pub(crate) struct Wake {
    listener: Listener<ipc::Service>,
    bells: Vec<(Member, Notifier<ipc::Service>)>,
    spin: Duration,
    sleeps: bool,
}

impl Wake {
    pub(crate) fn open(
        node: &Node<ipc::Service>,
        rendezvous: &Rendezvous,
        own: Member,
    ) -> Result<Self, ExchangeError> {
        let listener = topics::event(node, own)?
            .listener_builder()
            .create()
            .map_err(transport("cannot listen for events"))?;
        let mut bells = Vec::new();
        for member in Member::ALL {
            if member != own && topics::takes_part(rendezvous, member) {
                let bell = topics::event(node, member)?
                    .notifier_builder()
                    .create()
                    .map_err(transport("cannot make a notifier"))?;
                bells.push((member, bell));
            }
        }
        let waiting = rendezvous.waiting.on_this_machine(rendezvous.roles.len() + 1);
        Ok(Self {
            listener,
            bells,
            spin: Duration::from_micros(rendezvous.spin_us),
            sleeps: waiting == Waiting::Event,
        })
    }

    /// Wakes `member`. Costs no system call while it has not slept since the last ring: events are
    /// drained only just before sleeping, so the pending one stands for all.
    pub(crate) fn ring(&self, member: Member) -> Result<(), ExchangeError> {
        for (whom, bell) in &self.bells {
            if *whom == member {
                bell.notify().map_err(transport("cannot notify"))?;
            }
        }
        Ok(())
    }

    /// Waits until `ready` gives something, `limit` has passed (`None`), or `look`, called every
    /// [`LOOK_EVERY`], fails. What a peer sent before it died is still taken.
    ///
    /// Time in which this process itself was stopped does not count towards `limit`.
    pub(crate) fn wait<T>(
        &self,
        limit: Duration,
        ready: &mut dyn FnMut() -> Result<Option<T>, ExchangeError>,
        look: &mut dyn FnMut() -> Result<(), ExchangeError>,
    ) -> Result<Option<T>, ExchangeError> {
        if let Some(found) = ready()? {
            return Ok(Some(found));
        }
        let start = Instant::now();
        let (mut last, mut looked, mut waited) = (start, start, Duration::ZERO);
        loop {
            if self.sleeps && last - start >= self.spin {
                self.sleep(LOOK_EVERY.min(limit.saturating_sub(waited)))?;
            } else {
                std::thread::yield_now();
            }
            if let Some(found) = ready()? {
                return Ok(Some(found));
            }
            let now = Instant::now();
            waited += (now - last).min(4 * LOOK_EVERY);
            last = now;
            if now - looked >= LOOK_EVERY {
                looked = now;
                if let Err(error) = look() {
                    return ready()?.map_or(Err(error), |found| Ok(Some(found)));
                }
            }
            if waited >= limit {
                return Ok(None);
            }
        }
    }

    fn sleep(&self, at_most: Duration) -> Result<(), ExchangeError> {
        // A timeout of zero would mean no timeout to the socket.
        let at_most = at_most.max(Duration::from_micros(100));
        match self.listener.timed_wait(|_| (), at_most) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(transport("cannot wait for an event")(error)),
        }
    }
}
