//! Waiting for a message: nap while none is expected, yield for a moment, then sleep until the
//! sender's event, and look now and then whether the sender lives.
//!
//! Waking a sleeper costs its sender a system call and an interrupt to another core, and the sleeper
//! some 50 µs, in every window. Windows are much alike, so a [`Rhythm`] naps by its own timer until
//! shortly before the message is due and yields from there on: the sender finds its receiver awake. Where
//! long waits scatter by more than [`YIELDED`] it sleeps from there on: 50 µs are little beside them, and
//! yielding would take a core that others need.

use std::time::{Duration, Instant};

use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;

use super::rendezvous::{Rendezvous, Waiting};
use super::topics::{self, transport};
use super::watch::{LOOK_EVERY, Member};
use crate::participant::ExchangeError;

/// A nap ends this long before the message is due: what a timer may come too late by,
const EARLY: Duration = Duration::from_micros(60);
/// or this part of the wait, by which waits scatter that were even so far.
const SCATTER: u32 = 24;
/// A message that is late by more than this and its usual scatter is slept for.
const LATE: Duration = Duration::from_micros(300);
/// Longest time before a message is due that is yielded through.
const YIELDED: Duration = Duration::from_micros(500);
/// Shorter naps are not worth the timer.
const SHORTEST_NAP: Duration = Duration::from_micros(80);

/// How long the waits at one place last: smoothed mean and mean deviation (as Jacobson 1988 has them
/// for the answers of a network).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rhythm {
    mean: Duration,
    deviation: Duration,
}

impl Rhythm {
    /// What is left to nap after `waited`, in pieces after which the sender is looked at.
    pub(crate) fn nap(&self, waited: Duration) -> Option<Duration> {
        let left = self.mean.saturating_sub(self.early()).saturating_sub(waited);
        (left >= SHORTEST_NAP).then_some(left.min(LOOK_EVERY))
    }

    /// How long before the message is due a nap ends.
    fn early(&self) -> Duration {
        2 * self.deviation + EARLY.max(self.mean / SCATTER)
    }

    /// Until when yielding is better than sleeping.
    fn awake(&self, spin: Duration) -> Duration {
        if self.mean.is_zero() || self.early() > YIELDED {
            return spin;
        }
        spin.max(self.mean + (4 * self.deviation).min(LATE) + LATE)
    }

    /// A wait is over. A message that came during a nap may have lain there: its wait counts as shorter.
    pub(crate) fn learn(&mut self, waited: Duration, napped: bool) {
        let waited = if napped { waited * 3 / 4 } else { waited };
        let off = waited.abs_diff(self.mean);
        self.mean = if waited > self.mean { self.mean + off / 8 } else { self.mean - off / 3 };
        self.deviation = (self.deviation * 7 + off) / 8;
    }
}

/// How long a window takes, as the coupler sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    answered: u64,
    since: Option<Instant>,
    window: Duration,
}

impl Pace {
    /// `answered` orders have been answered by now.
    pub(crate) fn learn(&mut self, answered: u64) {
        if answered <= self.answered {
            return;
        }
        let now = Instant::now();
        if let Some(since) = self.since {
            let each = (now - since).div_f64((answered - self.answered) as f64);
            self.window = if self.window.is_zero() { each } else { (self.window * 7 + each) / 8 };
        }
        (self.answered, self.since) = (answered, Some(now));
    }

    /// One window, where it is long enough for a timer and short enough not to miss a death.
    pub(crate) fn nap(&self) -> Option<Duration> {
        (self.window >= 4 * SHORTEST_NAP && self.window <= LOOK_EVERY).then_some(self.window)
    }
}

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
        let solvers = rendezvous.roles.iter().copied().map(Member::Solver);
        for member in std::iter::once(Member::Coupler).chain(solvers).filter(|member| *member != own) {
            let bell = topics::event(node, member)?
                .notifier_builder()
                .create()
                .map_err(transport("cannot make a notifier"))?;
            bells.push((member, bell));
        }
        make_timers_sharp();
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
        for (_, bell) in self.bells.iter().filter(|(whom, _)| *whom == member) {
            bell.notify().map_err(transport("cannot notify"))?;
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
        rhythm: &mut Rhythm,
        ready: &mut dyn FnMut() -> Result<Option<T>, ExchangeError>,
        look: &mut dyn FnMut() -> Result<(), ExchangeError>,
    ) -> Result<Option<T>, ExchangeError> {
        if let Some(found) = ready()? {
            rhythm.learn(Duration::ZERO, false);
            return Ok(Some(found));
        }
        let start = Instant::now();
        let (mut last, mut looked, mut waited) = (start, start, Duration::ZERO);
        let awake = rhythm.awake(self.spin);
        loop {
            let nap = rhythm.nap(last - start).filter(|_| self.sleeps);
            match nap {
                Some(nap) => std::thread::sleep(nap.min(limit.saturating_sub(waited))),
                None if self.sleeps && last - start >= awake => {
                    self.sleep(LOOK_EVERY.min(limit.saturating_sub(waited)))?;
                }
                None => std::thread::yield_now(),
            }
            if let Some(found) = ready()? {
                rhythm.learn(start.elapsed(), nap.is_some());
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

/// Asks for timers of this thread within a microsecond, where the system would round naps up by 50. Refused,
/// naps are longer and nothing else changes.
fn make_timers_sharp() {
    #[cfg(target_os = "linux")]
    let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1_000));
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn micros(n: u64) -> Duration {
        Duration::from_micros(n)
    }

    /// Waits `of` one after the other; returns how long each message would have lain unread.
    fn keep(rhythm: &mut Rhythm, of: &[u64]) -> Vec<Duration> {
        let meet = |&due: &u64| {
            let (due, mut now, mut napped) = (micros(due), Duration::ZERO, false);
            while now < due {
                let nap = rhythm.nap(now);
                napped = nap.is_some();
                now = nap.map_or(due, |nap| now + nap);
            }
            rhythm.learn(now, napped);
            now - due
        };
        of.iter().map(meet).collect()
    }

    #[test]
    fn even_waits_are_napped_through_and_met_awake() {
        let mut rhythm = Rhythm::default();
        keep(&mut rhythm, &[2400; 200]);
        let lain = keep(&mut rhythm, &[2400, 2300, 2500, 2350, 2450].repeat(20));
        assert!(lain.iter().all(Duration::is_zero), "{lain:?}");
        assert!(rhythm.nap(Duration::ZERO).unwrap() > micros(1700));
        assert!(rhythm.awake(micros(50)) > micros(2500));
    }

    #[test]
    fn long_waits_are_slept_through_where_they_scatter() {
        let mut rhythm = Rhythm::default();
        keep(&mut rhythm, &[600_000; 200]);
        assert!(rhythm.nap(Duration::ZERO).is_some());
        assert_eq!(rhythm.awake(micros(50)), micros(50));
        let mut uneven = Rhythm::default();
        keep(&mut uneven, &[4_000, 6_000].repeat(100));
        assert_eq!(uneven.awake(micros(50)), micros(50));
    }

    #[test]
    fn early_messages_are_overslept_a_few_times_only() {
        let mut rhythm = Rhythm::default();
        keep(&mut rhythm, &[2400; 200]);
        let lain = keep(&mut rhythm, &[300; 20]);
        assert!(lain[0] > micros(1000) && lain[0] < micros(2100));
        assert!(lain.iter().filter(|time| !time.is_zero()).count() <= 5, "{lain:?}");
    }

    #[test]
    fn short_waits_are_not_napped() {
        let mut rhythm = Rhythm::default();
        keep(&mut rhythm, &[15; 100]);
        assert_eq!(rhythm.nap(Duration::ZERO), None);
        assert!(rhythm.awake(micros(50)) < micros(400));
        assert_eq!(Rhythm::default().awake(micros(50)), micros(50));
    }
}
