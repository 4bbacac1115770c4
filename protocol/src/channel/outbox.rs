//! A publisher that knows how many must receive each message, and never waits for the dead.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{BackpressureAction, BackpressureInfo, SendError};
use iceoryx2::prelude::*;

use super::topics::{Records, Single, transport};
use super::watch::{LOOK_EVERY, Member, Watch};
use crate::message::{Header, Record};
use crate::participant::ExchangeError;

/// Longest time between the end of a process's ports and that of its node.
const LEAVING: Duration = Duration::from_millis(500);

/// What a full queue of a receiver led to.
#[derive(Debug, Default)]
struct Jam {
    /// Step of the message being sent.
    step: AtomicU64,
    /// How long the present message has waited, ns.
    waited: AtomicU64,
    /// Why it was given up.
    verdict: Mutex<Option<ExchangeError>>,
}

impl Jam {
    fn give_up(&self, error: ExchangeError) -> BackpressureAction {
        *self.verdict.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
        BackpressureAction::DiscardDataAndFail
    }

    fn take_verdict(&self) -> Option<ExchangeError> {
        self.verdict.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// Decides about a message that a full queue holds up: again, until a receiver has died or the
/// deadline has passed.
fn patience(
    jam: Arc<Jam>,
    watch: Watch,
    receivers: Vec<Member>,
    limit: Duration,
) -> impl Fn(&BackpressureInfo) -> BackpressureAction + Send + 'static {
    let watch = Mutex::new((watch, Duration::ZERO));
    move |info| {
        let waited = info.elapsed_time;
        jam.waited.store(waited.as_nanos() as u64, Ordering::Relaxed);
        let step = jam.step.load(Ordering::Relaxed);
        let mut guard = watch.lock().unwrap_or_else(PoisonError::into_inner);
        let (watch, looked) = &mut *guard;
        if info.retries == 0 {
            *looked = Duration::ZERO;
        }
        if waited.saturating_sub(*looked) < LOOK_EVERY {
            return BackpressureAction::Retry;
        }
        *looked = waited;
        if let Err(error) = watch.check(&receivers, step) {
            return jam.give_up(error);
        }
        if waited < limit {
            return BackpressureAction::Retry;
        }
        jam.give_up(ExchangeError::late(names(&receivers), step, limit))
    }
}

fn names(members: &[Member]) -> String {
    let names: Vec<String> = members.iter().map(ToString::to_string).collect();
    names.join(" or ")
}

/// Who takes what a port sends, and how long it may take.
#[derive(Clone, Debug)]
pub(crate) struct Receivers {
    pub(crate) members: Vec<Member>,
    pub(crate) watch: Watch,
    pub(crate) limit: Duration,
}

/// The sending end of one topic of single records (`Command`, `Status`) or of slices.
#[derive(Debug)]
pub(crate) struct Outbox<
    Payload: ?Sized + IceoryxSend + std::fmt::Debug + 'static,
    H: ZeroCopySend + std::fmt::Debug,
> {
    publisher: Publisher<ipc::Service, Payload, H>,
    receivers: Receivers,
    jam: Arc<Jam>,
}

impl<Payload: ?Sized + IceoryxSend + std::fmt::Debug + 'static, H: ZeroCopySend + std::fmt::Debug>
    Outbox<Payload, H>
{
    /// Connects to receivers that have come since.
    pub(crate) fn connect(&self) -> Result<(), ExchangeError> {
        self.publisher.update_connections().map_err(transport("cannot connect to a receiver"))
    }

    fn begin(&self, step: u64) {
        self.jam.step.store(step, Ordering::Relaxed);
        self.jam.waited.store(0, Ordering::Relaxed);
    }

    /// Judges the outcome of a `send` and returns how long a full queue held it up.
    fn judge(&mut self, sent: Result<usize, SendError>, step: u64) -> Result<Duration, ExchangeError> {
        let expected = self.receivers.members.len();
        match sent {
            Ok(count) if count == expected => {
                Ok(Duration::from_nanos(self.jam.waited.load(Ordering::Relaxed)))
            }
            outcome => {
                if let Some(error) = self.jam.take_verdict() {
                    return Err(error);
                }
                self.await_culprit(step)?;
                Err(ExchangeError::Transport(format!(
                    "message of window {step} for {}: {outcome:?}, expected {expected} receivers",
                    names(&self.receivers.members)
                )))
            }
        }
    }

    /// A receiver that is missing has died, or is leaving and still has its node: names it.
    fn await_culprit(&mut self, step: u64) -> Result<(), ExchangeError> {
        let start = Instant::now();
        while start.elapsed() < LEAVING {
            self.receivers.watch.check(&self.receivers.members, step)?;
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }
}

macro_rules! builder {
    ($topic:expr, $jam:expr, $receivers:expr) => {
        $topic
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::RetryUntilDelivered)
            .set_backpressure_handler(patience(
                $jam.clone(),
                $receivers.watch.clone(),
                $receivers.members.clone(),
                $receivers.limit,
            ))
    };
}

impl<R: Record + ZeroCopySend> Outbox<R, ()> {
    pub(crate) fn single(topic: &Single<R>, receivers: Receivers) -> Result<Self, ExchangeError> {
        let jam = Arc::new(Jam::default());
        let publisher = builder!(topic, jam, receivers)
            .create()
            .map_err(transport("cannot publish; has another process joined in this role?"))?;
        Ok(Self { publisher, receivers, jam })
    }

    pub(crate) fn send(&mut self, record: R, step: u64) -> Result<Duration, ExchangeError> {
        self.begin(step);
        let sent = self.publisher.send_copy(record);
        self.judge(sent, step)
    }
}

impl<R: Record + ZeroCopySend> Outbox<[R], Header> {
    pub(crate) fn records(
        topic: &Records<R>,
        grains: usize,
        receivers: Receivers,
    ) -> Result<Self, ExchangeError> {
        let jam = Arc::new(Jam::default());
        let publisher = builder!(topic, jam, receivers)
            .initial_max_slice_len(grains.max(1))
            .allocation_strategy(AllocationStrategy::Static)
            .create()
            .map_err(transport("cannot publish; has another process joined in this role?"))?;
        Ok(Self { publisher, receivers, jam })
    }

    /// Sends one slice of `grains` records, written in place by `fill`.
    pub(crate) fn send(
        &mut self,
        header: Header,
        grains: usize,
        fill: &mut dyn FnMut(&mut [R]),
    ) -> Result<Duration, ExchangeError> {
        self.begin(header.step);
        let loaned =
            self.publisher.loan_slice_uninit(grains).map_err(transport("no shared memory for a message"))?;
        let mut sample = loaned.write_from_fn(|_| R::default());
        *sample.user_header_mut() = header;
        fill(sample.payload_mut());
        let sent = sample.send();
        self.judge(sent, header.step)
    }
}
