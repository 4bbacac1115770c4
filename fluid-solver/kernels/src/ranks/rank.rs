//! One of the processes that share a fluid, and its link to the others.

use protocol::participant::SolverError;
use pulp::bytemuck;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

/// How long a rank waits for another until it is told, s: while the fluid is built.
const AT_FIRST: Duration = Duration::from_secs(60);

/// How many times as long where the others write or read files; as the coupler waits for a solver.
const FILES_TAKE: u32 = 6;

/// What brings bytes from rank to rank.
pub trait Link: Send + Sync {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn size(&self) -> usize;

    /// Sends every message, calls `meanwhile`, and waits for all that are to come, in any order. Messages
    /// between the same two ranks arrive in the order in which they were sent. `patience`: how long to wait;
    /// without: for ever.
    ///
    /// # Errors
    /// With the rank that is gone or does not answer.
    fn exchange(
        &self,
        messages: &[(usize, &[u8])],
        into: &mut [(usize, &mut [u8])],
        patience: Option<Duration>,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<(), String>;
}

/// Messages and bytes that a rank has sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Messages.
    pub messages: u64,
    /// Bytes.
    pub bytes: u64,
}

/// One of the processes that share a fluid.
#[derive(Clone, Default)]
pub struct Ranks(Option<Arc<Member>>);

struct Member {
    link: Box<dyn Link>,
    failure: Mutex<Option<String>>,
    messages: AtomicU64,
    bytes: AtomicU64,
    /// How long to wait for another rank, ms.
    patience: AtomicU64,
}

impl std::fmt::Debug for Ranks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.size())
    }
}

/// Number of processes that a launcher of MPI started, if one did.
pub fn launched() -> Option<usize> {
    let names = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"];
    names.iter().find_map(|name| std::env::var(name).ok()?.parse().ok())
}

/// What this process is, if it was started as one of several.
static PROCESS: OnceLock<Ranks> = OnceLock::new();

impl Ranks {
    /// There is nobody else.
    pub fn alone() -> Self {
        Self::default()
    }

    /// One of several.
    pub fn linked(link: impl Link + 'static) -> Self {
        let (failure, messages, bytes) = Default::default();
        let patience = AtomicU64::new(AT_FIRST.as_millis() as u64);
        Self(Some(Arc::new(Member { link: Box::new(link), failure, messages, bytes, patience })))
    }

    /// What this process is: alone unless [`Ranks::set_process`] said otherwise.
    pub fn of_process() -> Self {
        PROCESS.get().cloned().unwrap_or_default()
    }

    /// Says what this process is, before any solver is built. Only the first call counts.
    pub fn set_process(self) {
        // A second call would be a second start of MPI, which there is not.
        let _ = PROCESS.set(self);
    }

    /// Number of this rank.
    pub fn rank(&self) -> usize {
        self.0.as_ref().map_or(0, |member| member.link.rank())
    }

    /// Number of ranks.
    pub fn size(&self) -> usize {
        self.0.as_ref().map_or(1, |member| member.link.size())
    }

    /// Whether there is nobody else.
    pub fn is_alone(&self) -> bool {
        self.size() == 1
    }

    /// Whether this is the rank that speaks for all.
    pub fn is_first(&self) -> bool {
        self.rank() == 0
    }

    /// Says how long to wait for another rank within a window from now on.
    pub fn set_patience(&self, patience: Duration) {
        if let Some(member) = &self.0 {
            let milliseconds = u64::try_from(patience.as_millis()).unwrap_or(u64::MAX);
            member.patience.store(milliseconds.max(1), Ordering::Relaxed);
        }
    }

    /// How long to wait for another rank within a window.
    fn patience(&self) -> Duration {
        let told = |member: &Arc<Member>| Duration::from_millis(member.patience.load(Ordering::Relaxed));
        self.0.as_ref().map_or(AT_FIRST, told)
    }

    /// What this rank has sent so far.
    pub fn traffic(&self) -> Traffic {
        let count = |count: &AtomicU64| count.load(Ordering::Relaxed);
        let of =
            |member: &Arc<Member>| Traffic { messages: count(&member.messages), bytes: count(&member.bytes) };
        self.0.as_ref().map_or_else(Traffic::default, of)
    }

    /// Whether every exchange so far went well.
    ///
    /// # Errors
    /// The first failure.
    pub fn check(&self) -> Result<(), SolverError> {
        let failure = self.0.as_ref().and_then(|member| member.failure().clone());
        failure.map_or(Ok(()), |failure| Err(SolverError::Failed(failure)))
    }

    /// Keeps a failure, so that nothing is exchanged any more.
    pub fn fail(&self, what: String) {
        if let Some(member) = &self.0 {
            member.failure().get_or_insert(what);
        }
    }

    /// Sends and receives numbers, see [`Link::exchange`].
    pub fn exchange(&self, messages: &[(usize, &[f64])], into: &mut [(usize, &mut [f64])]) {
        self.exchange_while(messages, into, &mut || {});
    }

    /// The same, and `meanwhile` while the numbers are on their way; it is done whatever becomes of them.
    pub fn exchange_while(
        &self,
        messages: &[(usize, &[f64])],
        into: &mut [(usize, &mut [f64])],
        meanwhile: &mut dyn FnMut(),
    ) {
        let messages: Vec<(usize, &[u8])> =
            messages.iter().map(|(to, values)| (*to, bytemuck::cast_slice(values))).collect();
        let mut into: Vec<(usize, &mut [u8])> =
            into.iter_mut().map(|(from, values)| (*from, bytemuck::cast_slice_mut(values))).collect();
        self.transfer_while(&messages, &mut into, Some(self.patience()), meanwhile);
    }

    fn transfer(
        &self,
        messages: &[(usize, &[u8])],
        into: &mut [(usize, &mut [u8])],
        patience: Option<Duration>,
    ) {
        self.transfer_while(messages, into, patience, &mut || {});
    }

    fn transfer_while(
        &self,
        messages: &[(usize, &[u8])],
        into: &mut [(usize, &mut [u8])],
        patience: Option<Duration>,
        meanwhile: &mut dyn FnMut(),
    ) {
        let Some(member) = self.0.as_ref().filter(|member| member.failure().is_none()) else {
            return meanwhile();
        };
        let mut done = false;
        let mut once = || {
            if !std::mem::replace(&mut done, true) {
                meanwhile();
            }
        };
        member.messages.fetch_add(messages.len() as u64, Ordering::Relaxed);
        let bytes: usize = messages.iter().map(|(_, bytes)| bytes.len()).sum();
        member.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
        if let Err(what) = member.link.exchange(messages, into, patience, &mut once) {
            member.failure().get_or_insert(what);
        }
        once();
    }

    /// The bytes of rank 0, on every rank; the others wait for them as long as it takes.
    ///
    /// # Errors
    /// As [`Ranks::check`].
    pub fn broadcast(&self, bytes: Vec<u8>) -> Result<Vec<u8>, SolverError> {
        if self.is_alone() {
            return Ok(bytes);
        }
        let (mut bytes, mut length) = (bytes, [0_u8; 8]);
        if self.is_first() {
            length = (bytes.len() as u64).to_le_bytes();
            let all: Vec<(usize, &[u8])> =
                (1..self.size()).flat_map(|to| [(to, &length[..]), (to, &bytes[..])]).collect();
            self.transfer(&all, &mut [], None);
        } else {
            self.transfer(&[], &mut [(0, &mut length)], None);
            self.check()?;
            bytes = vec![0; u64::from_le_bytes(length) as usize];
            self.transfer(&[], &mut [(0, &mut bytes)], Some(self.patience()));
        }
        self.check().map(|()| bytes)
    }

    /// `values` becomes that of all ranks, combined in their order; every rank gets the same.
    pub fn combine(&self, values: &mut [f64], combine: impl Fn(f64, f64) -> f64) {
        if self.is_alone() {
            return;
        }
        if !self.is_first() {
            self.exchange(&[(0, &*values)], &mut []);
        } else {
            let mut parts = vec![values.to_vec(); self.size()];
            self.exchange(&[], &mut of_others(&mut parts));
            for part in &parts[1..] {
                values.iter_mut().zip(part).for_each(|(value, other)| *value = combine(*value, *other));
            }
        }
        self.spread(values);
    }

    /// `values` goes from rank to rank, each adding its part to what those before it found; every rank
    /// gets the end of it. A sum so made has the same bits as one over all planes in their order.
    pub fn relay(&self, values: &mut [f64], own: impl FnOnce(&mut [f64])) {
        let (rank, last) = (self.rank(), self.size() - 1);
        if rank > 0 {
            self.exchange(&[], &mut [(rank - 1, &mut *values)]);
        }
        own(values);
        if rank < last {
            self.exchange(&[(rank + 1, &*values)], &mut []);
            self.exchange(&[], &mut [(last, values)]);
        } else if last > 0 {
            let all: Vec<(usize, &[f64])> = (0..last).map(|to| (to, &*values)).collect();
            self.exchange(&all, &mut []);
        }
    }

    /// What each rank has, of any length, on rank 0 in the order of the ranks; nothing elsewhere.
    pub fn gather(&self, own: &[f64]) -> Vec<Vec<f64>> {
        if !self.is_first() {
            self.exchange(&[(0, &[own.len() as f64]), (0, own)], &mut []);
            return Vec::new();
        }
        let mut lengths = vec![[0.0]; self.size()];
        self.exchange(&[], &mut of_others(&mut lengths));
        let mut parts: Vec<Vec<f64>> = lengths.iter().map(|[length]| vec![0.0; *length as usize]).collect();
        parts[0].extend_from_slice(own);
        self.exchange(&[], &mut of_others(&mut parts));
        parts
    }

    /// What each rank did with its files: on rank 0 what all of them say, in their order; nothing elsewhere.
    /// Files take long, so it is waited for longer than within a window.
    ///
    /// # Errors
    /// The first rank's failure, or there that of another one with its number.
    pub fn report(&self, own: Result<Vec<u8>, SolverError>) -> Result<Vec<Vec<u8>>, SolverError> {
        if self.is_alone() {
            return own.map(|own| vec![own]);
        }
        let told = match &own {
            Ok(bytes) => [&[1], &bytes[..]].concat(),
            Err(error) => [&[0], error.to_string().as_bytes()].concat(),
        };
        let patience = Some(self.patience().saturating_mul(FILES_TAKE));
        if !self.is_first() {
            self.transfer(&[(0, &(told.len() as u64).to_le_bytes()), (0, &told)], &mut [], patience);
            return own.map(|_| Vec::new());
        }
        let mut lengths = vec![[0; 8]; self.size()];
        self.transfer(&[], &mut of_others(&mut lengths), patience);
        self.check()?;
        let mut parts: Vec<Vec<u8>> =
            lengths.iter().map(|length| vec![0; u64::from_le_bytes(*length) as usize]).collect();
        self.transfer(&[], &mut of_others(&mut parts), patience);
        self.check()?;
        parts[0] = [&[1], &own?[..]].concat();
        let heard = |(rank, part): (usize, Vec<u8>)| match part.split_first() {
            Some((1, bytes)) => Ok(bytes.to_vec()),
            _ => {
                let what = String::from_utf8_lossy(part.get(1..).unwrap_or_default());
                Err(SolverError::Failed(format!("rank {rank} of the fluid: {what}")))
            }
        };
        parts.into_iter().enumerate().map(heard).collect()
    }

    /// `values` of rank 0 on every rank.
    pub fn spread(&self, values: &mut [f64]) {
        if self.is_first() {
            let all: Vec<(usize, &[f64])> = (1..self.size()).map(|to| (to, &*values)).collect();
            self.exchange(&all, &mut []);
        } else {
            self.exchange(&[], &mut [(0, values)]);
        }
    }

    /// Whether it holds on every rank.
    pub fn all(&self, here: bool) -> bool {
        let mut values = [f64::from(u8::from(here))];
        self.combine(&mut values, f64::min);
        values[0] == 1.0
    }
}

/// The parts of all ranks but the first, by rank.
fn of_others<T>(parts: &mut [impl AsMut<[T]>]) -> Vec<(usize, &mut [T])> {
    parts.iter_mut().enumerate().skip(1).map(|(from, part)| (from, part.as_mut())).collect()
}

impl Member {
    fn failure(&self) -> std::sync::MutexGuard<'_, Option<String>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
