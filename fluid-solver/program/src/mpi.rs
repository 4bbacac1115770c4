//! Ranks that are processes started by `mpirun`, over the crate `mpi` (feature `mpi`). The only file that
//! knows MPI.
//!
//! All messages are sent and received without blocking and then polled, so that a rank that hangs is named. A
//! rank that dies is noticed by `mpirun`, which names it and ends the others.

use ::mpi::Threading;
use ::mpi::environment::Universe;
use ::mpi::request::{Request, Scope};
use ::mpi::topology::{Communicator, SimpleCommunicator};
use ::mpi::traits::{Destination, Source};
use fluid_solver::ranks::{Link, Ranks, launched};
use std::time::{Duration, Instant};

/// Polls before a rank begins to sleep between them, and how long.
const SPINS: u32 = 200;
const NAP: Duration = Duration::from_micros(20);

/// What this process is: one of the ranks that `mpirun` started.
struct Mpi {
    rank: usize,
    size: usize,
}

/// MPI, until it is dropped, if `mpirun` started this process as one of several.
///
/// # Errors
/// If the MPI library cannot be called from the threads of a pool.
pub(crate) fn start() -> Result<Option<(Universe, Ranks)>, String> {
    if launched().is_none_or(|size| size < 2) {
        return Ok(None);
    }
    // One thread at a time calls it, not always the same.
    let (universe, threading) = ::mpi::initialize_with_threading(Threading::Serialized)
        .ok_or("MPI was started twice in one process")?;
    if threading < Threading::Serialized {
        return Err(format!(
            "the MPI library gives {threading:?}, and Serialized is needed: take another one"
        ));
    }
    let world = universe.world();
    let link = Mpi { rank: world.rank() as usize, size: world.size() as usize };
    Ok(Some((universe, Ranks::linked(link))))
}

/// Polls `requests` until all are done. If one is not in time the run is over: what MPI was lent cannot be
/// taken back.
fn poll<'a, D: ?Sized, S: Scope<'a>>(
    requests: Vec<(usize, Request<'a, D, S>)>,
    (begin, patience): (Instant, Option<Duration>),
) {
    let mut polls = 0;
    for (rank, mut request) in requests {
        loop {
            match request.test() {
                Ok(_) => break,
                Err(again) => request = again,
            }
            if let Some(patience) = patience.filter(|patience| begin.elapsed() > *patience) {
                protocol::say!(
                    "bedload-fluid: rank {rank} did not answer within {} s: it hangs, and the run ends; if it is only \
                     slow raise coupling.deadline",
                    patience.as_secs_f64()
                );
                SimpleCommunicator::world().abort(1);
            }
            // Who waits long leaves the core to the rank that it waits for: there may be fewer cores than
            // ranks.
            polls += 1;
            if polls < SPINS { std::thread::yield_now() } else { std::thread::sleep(NAP) }
        }
    }
}

impl Link for Mpi {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange(
        &self,
        messages: &[(usize, &[u8])],
        into: &mut [(usize, &mut [u8])],
        patience: Option<Duration>,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<(), String> {
        let world = SimpleCommunicator::world();
        let wait = (Instant::now(), patience);
        ::mpi::request::scope(|scope| {
            let (mut coming, mut going) = (Vec::new(), Vec::new());
            for (from, bytes) in into {
                let process = world.process_at_rank(*from as i32);
                coming.push((*from, process.immediate_receive_into(scope, &mut **bytes)));
            }
            for (to, bytes) in messages {
                going.push((*to, world.process_at_rank(*to as i32).immediate_send(scope, *bytes)));
            }
            meanwhile();
            poll(coming, wait);
            poll(going, wait);
        });
        Ok(())
    }
}
