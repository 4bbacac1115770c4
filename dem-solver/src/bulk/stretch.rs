//! A stretch: some sub-steps of all blocks without a look at the lists, by any number of threads.
//!
//! Block b may do sub-step s as soon as the blocks that it reads have done s − 1, and this alone is
//! watched; so the bits do not depend on who does what when. Each thread takes a run of blocks and goes
//! through it in a wavefront: `depth` sub-steps follow one another through the blocks, `reach` blocks
//! apart, while the rows are in the cache. Neighbouring threads go in opposite directions, so that both
//! sides of a border come to it at the same time.

use super::block::{Bench, Block, Common};
use super::row::Row;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Rows of a block, before and after a sub-step by turns; one row without extent follows the last.
pub(super) type Rows = [RwLock<Vec<Row>>; 2];

/// All blocks of a run.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    pub(super) rows: Vec<Rows>,
    pub(super) block: Vec<Mutex<Block>>,
    done: Vec<AtomicU32>,
    /// The first blocks, whose grains are all fixed, take no part: their rows stay, and they have no lists.
    asleep: usize,
    /// Which blocks each thread does; empty where nothing is known about their work.
    shares: Vec<Range<usize>>,
    /// A thread is lost: the others must not wait for it.
    lost: AtomicBool,
}

/// What a stretch does.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Time at the start of the window, s.
    pub(super) t: f64,
    /// Sub-steps of the window done before: time is counted from the window's start, so that its bits do
    /// not depend on where stretches begin.
    pub(super) done: u32,
    /// Sub-step, s.
    pub(super) dt: f64,
    /// Sub-steps.
    pub(super) steps: u32,
    /// Which rows hold the state at its start.
    pub(super) now: usize,
    /// Sub-steps that follow one another through the blocks.
    pub(super) depth: u32,
    /// How many blocks further a block reads at most.
    pub(super) reach: usize,
}

/// Takes a lock; what a lost thread left behind is never used.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn read<T>(lock: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    lock.read().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn write<T>(lock: &RwLock<T>) -> RwLockWriteGuard<'_, T> {
    lock.write().unwrap_or_else(PoisonError::into_inner)
}

/// Without a lock, where nobody else can hold it.
pub(super) fn only<T>(lock: &mut RwLock<T>) -> &mut T {
    lock.get_mut().unwrap_or_else(PoisonError::into_inner)
}

/// Without a lock, where nobody else can hold it.
pub(super) fn mine<T>(mutex: &mut Mutex<T>) -> &mut T {
    mutex.get_mut().unwrap_or_else(PoisonError::into_inner)
}

/// Says that a thread is lost, when it is.
struct Alarm<'a>(&'a AtomicBool);

impl Drop for Alarm<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.store(true, Ordering::Release);
        }
    }
}

/// Runs `task` once per thread, the last on this one.
pub(super) fn on_threads<S: Send>(scratch: &mut [S], task: impl Fn(usize, &mut S) + Sync) {
    let Some((last, rest)) = scratch.split_last_mut() else { return };
    if rest.is_empty() {
        return task(0, last);
    }
    let (here, task) = (rest.len(), &task);
    std::thread::scope(|scope| {
        for (k, own) in rest.iter_mut().enumerate() {
            scope.spawn(move || task(k, own));
        }
        task(here, last);
    });
}

impl Blocks {
    /// Blocks with their rows; the first `asleep` sleep.
    pub(super) fn new(rows: Vec<Rows>, block: Vec<Mutex<Block>>, asleep: usize) -> Self {
        let done = block.iter().map(|_| AtomicU32::new(0)).collect();
        Self { rows, block, done, asleep, shares: Vec::new(), lost: AtomicBool::new(false) }
    }

    /// How many of the first blocks sleep.
    pub(super) fn asleep(&self) -> usize {
        self.asleep
    }

    /// Lets the first `asleep` blocks sleep and all others take part.
    pub(super) fn lay_down(&mut self, asleep: usize) {
        self.asleep = asleep;
        self.shares.clear();
        self.block[..asleep].iter_mut().for_each(|block| mine(block).forget());
    }

    /// Blocks that take part.
    pub(super) fn awake_mut(&mut self) -> &mut [Mutex<Block>] {
        &mut self.block[self.asleep..]
    }

    /// Numbers of the blocks of thread `k` of `threads`.
    pub(super) fn share_of(&self, k: usize, threads: usize) -> Range<usize> {
        if self.shares.len() == threads {
            return self.shares[k].clone();
        }
        let awake = self.block.len() - self.asleep;
        self.asleep + awake * k / threads..self.asleep + awake * (k + 1) / threads
    }

    /// Shares the blocks out so that all threads have about the same to do: grains that fall apart from one
    /// another cost a quarter of those in a bed.
    pub(super) fn share_out(&mut self, threads: usize) {
        let work: Vec<usize> = self.awake_mut().iter_mut().map(|block| mine(block).work()).collect();
        let (sum, asleep) = (work.iter().sum::<usize>(), self.asleep);
        let (mut done, mut at) = (0, 0);
        self.shares.clear();
        for k in 1..=threads {
            let from = at;
            while at < work.len() && (k == threads || (2 * done + work[at]) * threads <= 2 * sum * k) {
                done += work[at];
                at += 1;
            }
            self.shares.push(asleep + from..asleep + at);
        }
    }

    /// Does a stretch with as many threads as there are benches.
    pub(super) fn run(&mut self, common: &Common, plan: &Plan, benches: &mut [Bench]) {
        for (b, done) in self.done.iter_mut().enumerate() {
            *done.get_mut() = if b < self.asleep { u32::MAX } else { 0 };
        }
        let (blocks, threads) = (&*self, benches.len());
        // a wavefront needs all shares longer than its reach: see docs/decisions/bulk-engine.md
        let least = (0..threads).map(|k| blocks.share_of(k, threads).len()).min().unwrap_or(0);
        let plan = &Plan { depth: if plan.reach < least { plan.depth.max(1) } else { 1 }, ..*plan };
        on_threads(benches, |k, bench| {
            let _alarm = Alarm(&blocks.lost);
            blocks.share(common, plan, blocks.share_of(k, threads), k % 2 == 1, bench);
        });
    }

    /// One thread's blocks, from the first to the last or `down`.
    fn share(&self, common: &Common, plan: &Plan, blocks: Range<usize>, down: bool, bench: &mut Bench) {
        let count = blocks.len();
        let mut first = 0;
        while first < plan.steps {
            let depth = plan.depth.min(plan.steps - first);
            for wave in 0..count + plan.reach * (depth as usize - 1) {
                for s in 0..depth {
                    let Some(at) = wave.checked_sub(plan.reach * s as usize) else { break };
                    if at < count {
                        let b = if down { blocks.end - 1 - at } else { blocks.start + at };
                        self.step(common, plan, b, first + s, bench);
                    }
                }
            }
            first += depth;
        }
    }

    /// Sub-step `s` of block `b`.
    fn step(&self, common: &Common, plan: &Plan, b: usize, s: u32, bench: &mut Bench) {
        let mut block = lock(&self.block[b]);
        let now = (plan.now + s as usize) % 2;
        let old = read(&self.rows[b][now]);
        if s == 0 {
            block.keep(&old);
            block.speed2.clear();
        }
        if !self.gather(&block, now, s, &mut bench.halo) {
            return;
        }
        let mut new = write(&self.rows[b][1 - now]);
        let t = plan.t + f64::from(plan.done + s) * plan.dt;
        block.step(common, (t, plan.dt), &old, &mut new, bench);
        drop(new);
        self.done[b].store(s + 1, Ordering::Release);
    }

    /// The rows of other blocks that `block` reads, after `s` sub-steps; false if they will never be done.
    pub(super) fn gather(&self, block: &Block, now: usize, s: u32, halo: &mut Vec<Row>) -> bool {
        halo.clear();
        let mut from = 0;
        for segment in &block.segments {
            let end = segment.end as usize;
            if !self.wait(segment.block as usize, s) {
                return false;
            }
            let rows = read(&self.rows[segment.block as usize][now]);
            halo.extend(block.halo[from..end].iter().map(|&k| rows[k as usize]));
            from = end;
        }
        true
    }

    /// Waits until `block` has done `steps`; false if it never will.
    fn wait(&self, block: usize, steps: u32) -> bool {
        let mut tries = 0u32;
        while self.done[block].load(Ordering::Acquire) < steps {
            if self.lost.load(Ordering::Acquire) {
                return false;
            }
            tries += 1;
            if tries < 64 { std::hint::spin_loop() } else { std::thread::yield_now() }
        }
        true
    }
}
