//! A batch: some sub-steps of all blocks without a look at the lists, by any number of threads.
//!
//! Block b may do sub-step s as soon as the blocks that it reads have done s − 1, and this alone is
//! watched; so the bits do not depend on who does what when. Each thread takes a run of blocks and goes
//! through it in a wavefront: `depth` sub-steps follow one another through the blocks, `reach` blocks
//! apart, while the rows are in the cache. Neighbouring threads go in opposite directions, so that both
//! sides of a border come to it at the same time.

use crate::bulk::block::{Block, Common, StepScratch};
use crate::bulk::records::GrainRecord;
use crate::bulk::sync::{lock, mutex_mut, on_threads, read, write};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, RwLock};

/// Rows of a block, before and after a sub-step by turns; one row without extent follows the last.
pub(super) type Rows = [RwLock<Vec<GrainRecord>>; 2];

#[derive(Debug, Default)]
pub(super) struct Blocks {
    pub(super) rows: Vec<Rows>,
    pub(super) block: Vec<Mutex<Block>>,
    done: Vec<AtomicU32>,
    /// The first blocks, whose grains are all fixed, take no part: their rows stay, and they have no lists.
    pub(super) inactive: usize,
    /// Which blocks each thread does; empty where nothing is known about their work.
    ranges: Vec<Range<usize>>,
    /// A thread is lost: the others must not wait for it.
    lost: AtomicBool,
}

/// What a batch does.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    /// Time at the start of the window, s.
    pub(super) t: f64,
    /// Sub-steps of the window done before: time is counted from the window's start, so that its bits do
    /// not depend on where batches begin.
    pub(super) done: u32,
    /// Sub-step, s.
    pub(super) dt: f64,
    pub(super) steps: u32,
    /// Which rows hold the state at its start.
    pub(super) now: usize,
    /// Sub-steps that follow one another through the blocks.
    pub(super) depth: u32,
    /// How many blocks further a block reads at most.
    pub(super) reach: usize,
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

impl Clone for Blocks {
    fn clone(&self) -> Self {
        let rows = self.rows.iter().map(|[a, b]| [read(a).clone().into(), read(b).clone().into()]);
        let block = self.block.iter().map(|block| lock(block).clone().into());
        Self::new(rows.collect(), block.collect(), self.inactive)
    }
}

impl Blocks {
    /// Blocks with their rows; the first `inactive` take no part.
    pub(super) fn new(rows: Vec<Rows>, block: Vec<Mutex<Block>>, inactive: usize) -> Self {
        let done = block.iter().map(|_| AtomicU32::new(0)).collect();
        Self { rows, block, done, inactive, ranges: Vec::new(), lost: AtomicBool::new(false) }
    }

    /// Takes the first `inactive` blocks out and all others in.
    pub(super) fn deactivate(&mut self, inactive: usize) {
        self.inactive = inactive;
        self.ranges.clear();
        self.block[..inactive].iter_mut().for_each(|block| mutex_mut(block).forget());
    }

    /// Blocks that take part.
    pub(super) fn active_mut(&mut self) -> &mut [Mutex<Block>] {
        &mut self.block[self.inactive..]
    }

    /// Numbers of the blocks of thread `k` of `threads`.
    pub(super) fn blocks_of_thread(&self, k: usize, threads: usize) -> Range<usize> {
        if self.ranges.len() == threads {
            return self.ranges[k].clone();
        }
        let active = self.block.len() - self.inactive;
        self.inactive + active * k / threads..self.inactive + active * (k + 1) / threads
    }

    /// Divides the blocks so that all threads have about the same to do: grains that fall apart from one
    /// another cost a quarter of those in a bed.
    pub(super) fn balance(&mut self, threads: usize) {
        let work: Vec<usize> = self.active_mut().iter_mut().map(|block| mutex_mut(block).work()).collect();
        let (sum, inactive) = (work.iter().sum::<usize>(), self.inactive);
        let (mut done, mut at) = (0, 0);
        self.ranges.clear();
        for k in 1..=threads {
            let from = at;
            while at < work.len() && (k == threads || (2 * done + work[at]) * threads <= 2 * sum * k) {
                done += work[at];
                at += 1;
            }
            self.ranges.push(inactive + from..inactive + at);
        }
    }

    /// Does a batch with as many threads as there are step_scratch.
    pub(super) fn run(&mut self, common: &Common, batch: &Batch, step_scratch: &mut [StepScratch]) {
        for (b, done) in self.done.iter_mut().enumerate() {
            *done.get_mut() = if b < self.inactive { u32::MAX } else { 0 };
        }
        let (blocks, threads) = (&*self, step_scratch.len());
        // a wavefront needs all ranges longer than its reach: see docs/decisions/bulk-engine.md
        let least = (0..threads).map(|k| blocks.blocks_of_thread(k, threads).len()).min().unwrap_or(0);
        let batch = &Batch { depth: if batch.reach < least { batch.depth.max(1) } else { 1 }, ..*batch };
        on_threads(step_scratch, |k, scratch| {
            let _alarm = Alarm(&blocks.lost);
            blocks.thread(common, batch, blocks.blocks_of_thread(k, threads), k % 2 == 1, scratch);
        });
    }

    /// One thread's blocks, from the first to the last or `down`.
    fn thread(
        &self,
        common: &Common,
        batch: &Batch,
        blocks: Range<usize>,
        down: bool,
        scratch: &mut StepScratch,
    ) {
        let count = blocks.len();
        let mut first = 0;
        while first < batch.steps {
            let depth = batch.depth.min(batch.steps - first);
            for wave in 0..count + batch.reach * (depth as usize - 1) {
                for s in 0..depth {
                    let Some(at) = wave.checked_sub(batch.reach * s as usize) else { break };
                    if at < count {
                        let b = if down { blocks.end - 1 - at } else { blocks.start + at };
                        self.step(common, batch, b, first + s, scratch);
                    }
                }
            }
            first += depth;
        }
    }

    /// Sub-step `s` of block `b`.
    fn step(&self, common: &Common, batch: &Batch, b: usize, s: u32, scratch: &mut StepScratch) {
        let mut block = lock(&self.block[b]);
        let now = (batch.now + s as usize) % 2;
        let old = read(&self.rows[b][now]);
        if s == 0 {
            block.keep(&old);
            block.speed2.clear();
        }
        if !self.gather(&block, now, s, &mut scratch.halo) {
            return;
        }
        let mut new = write(&self.rows[b][1 - now]);
        let t = batch.t + f64::from(batch.done + s) * batch.dt;
        block.step(common, (t, batch.dt), &old, &mut new, scratch);
        drop(new);
        self.done[b].store(s + 1, Ordering::Release);
    }

    /// The rows of other blocks that `block` reads, after `s` sub-steps; false if they will never be done.
    pub(super) fn gather(&self, block: &Block, now: usize, s: u32, halo: &mut Vec<GrainRecord>) -> bool {
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
