//! Ranks that are threads of one process: for tests, and to see a division without MPI.

use super::rank::{Link, Ranks};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// One of the threads.
struct Threads {
    rank: usize,
    senders: Vec<Mutex<Sender<Vec<u8>>>>,
    receivers: Vec<Mutex<Receiver<Vec<u8>>>>,
}

/// As many ranks as asked, each to be handed to a thread of its own.
pub fn ranks(size: usize) -> Vec<Ranks> {
    let mut senders: Vec<Vec<_>> = (0..size).map(|_| Vec::new()).collect();
    let mut receivers: Vec<Vec<_>> = (0..size).map(|_| Vec::new()).collect();
    for from in &mut senders {
        for to in &mut receivers {
            let (sender, receiver) = channel();
            from.push(Mutex::new(sender));
            to.push(Mutex::new(receiver));
        }
    }
    let pairs = senders.into_iter().zip(receivers).enumerate();
    pairs.map(|(rank, (senders, receivers))| Ranks::linked(Threads { rank, senders, receivers })).collect()
}

/// Calls `task` with each of `size` ranks on a thread of its own; what each made of it, in their order.
///
/// # Panics
/// If `task` does.
pub fn together<R: Send>(size: usize, task: impl Fn(Ranks) -> R + Sync) -> Vec<R> {
    let task = &task;
    std::thread::scope(|scope| {
        let threads: Vec<_> = ranks(size).into_iter().map(|ranks| scope.spawn(move || task(ranks))).collect();
        let join = |thread: std::thread::ScopedJoinHandle<'_, R>| match thread.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        threads.into_iter().map(join).collect()
    })
}

impl Link for Threads {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.senders.len()
    }

    fn exchange(
        &self,
        messages: &[(usize, &[u8])],
        into: &mut [(usize, &mut [u8])],
        patience: Option<Duration>,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<(), String> {
        let gone = |rank: usize| format!("rank {rank} of the fluid is gone");
        for (to, bytes) in messages {
            let sender = self.senders[*to].lock().unwrap_or_else(PoisonError::into_inner);
            sender.send(bytes.to_vec()).map_err(|_| gone(*to))?;
        }
        meanwhile();
        let end = patience.map(|patience| Instant::now() + patience);
        for (from, out) in into {
            let receiver = self.receivers[*from].lock().unwrap_or_else(PoisonError::into_inner);
            let bytes = match end {
                None => receiver.recv().map_err(|_| gone(*from))?,
                Some(end) => {
                    let left = end.saturating_duration_since(Instant::now());
                    receiver.recv_timeout(left).map_err(|error| match error {
                        RecvTimeoutError::Timeout => format!(
                            "rank {from} of the fluid did not answer within {} s: if it is only slow raise coupling.deadline",
                            patience.unwrap_or_default().as_secs_f64()
                        ),
                        RecvTimeoutError::Disconnected => gone(*from),
                    })?
                }
            };
            if bytes.len() != out.len() {
                return Err(format!(
                    "rank {from} of the fluid sent {} bytes where {} were asked for: the ranks are not in step",
                    bytes.len(),
                    out.len()
                ));
            }
            out.copy_from_slice(&bytes);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relay_sums_in_the_order_of_the_ranks() {
        let terms = [0.1, 1e16, -1e16, 0.7];
        let whole = terms.iter().fold(0.0, |sum, term| sum + term);
        for size in [1, 2, 4] {
            let found = together(size, |ranks| {
                let mut sum = [0.0];
                let own = 4 * ranks.rank() / size..4 * (ranks.rank() + 1) / size;
                ranks.relay(&mut sum, |sum| terms[own].iter().for_each(|term| sum[0] += term));
                sum[0]
            });
            assert!(found.iter().all(|sum| sum.to_bits() == whole.to_bits()), "{found:?}");
        }
    }

    #[test]
    fn everybody_hears_the_first_and_the_first_hears_everybody() {
        let heard = together(3, |ranks| {
            let text = ranks.broadcast(if ranks.is_first() { b"go".to_vec() } else { Vec::new() });
            let parts = ranks.gather(&vec![1.0; ranks.rank()]);
            (text.expect("all live"), parts.iter().map(Vec::len).collect::<Vec<_>>(), ranks.all(true))
        });
        assert!(heard.iter().all(|(text, _, all)| text == b"go" && *all));
        assert_eq!(heard[0].1, [0, 1, 2]);
    }

    /// What is done meanwhile is done once, whether the numbers come or not.
    #[test]
    fn a_rank_that_does_not_answer_is_named_after_the_time_it_was_given() {
        let told = together(2, |ranks| {
            ranks.set_patience(Duration::from_millis(50));
            let mut done = 0;
            if ranks.rank() == 0 {
                ranks.exchange_while(&[], &mut [(1, &mut [0.0])], &mut || done += 1);
                ranks.exchange_while(&[], &mut [(1, &mut [0.0])], &mut || done += 1);
            } else {
                std::thread::sleep(Duration::from_millis(400));
            }
            (ranks.check().err().map(|error| error.to_string()), done)
        });
        let what = told[0].0.as_deref().unwrap_or_default();
        assert!(what.contains("rank 1") && what.contains("0.05 s"), "{told:?}");
        assert_eq!((told[0].1, &told[1].0), (2, &None));
    }

    #[test]
    fn a_rank_that_is_gone_is_named() {
        let told = together(2, |ranks| {
            if ranks.rank() == 1 {
                return String::new();
            }
            ranks.exchange(&[], &mut [(1, &mut [0.0])]);
            ranks.check().expect_err("rank 1 left").to_string()
        });
        assert!(told[0].contains("rank 1"), "{told:?}");
    }
}
