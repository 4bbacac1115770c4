//! The sub-steps of a window: batches between two looks at the lists.

use crate::bulk::batch::Batch;
use crate::bulk::engine::Bulk;
use crate::bulk::records::SIZE;
use crate::bulk::sync::{mutex_mut, rwlock_mut};
use crate::report::Outcome;

/// Sub-steps of a batch at most.
const LONGEST: u32 = 256;

impl Bulk {
    /// `n_sub` sub-steps of `dt` from `t` on.
    pub(crate) fn advance(&mut self, t: f64, dt: f64, n_sub: u32) -> Outcome {
        let mut outcome = Outcome { done: 0, finite: true };
        while outcome.done < n_sub && outcome.finite {
            let at = t + f64::from(outcome.done) * dt;
            let steps = self.prepare(at, dt, (n_sub - outcome.done).min(LONGEST));
            self.batch(t, dt, steps, &mut outcome);
        }
        outcome
    }

    /// One batch of the window from `t` on. If a grain turns out to have outrun the lists, or to be no longer
    /// finite, it is done again up to the sub-step at which that happened.
    fn batch(&mut self, t: f64, dt: f64, steps: u32, outcome: &mut Outcome) {
        self.run(t, dt, outcome.done, steps);
        let mut good = 0;
        while good < steps && outcome.finite && self.lists_are_good() {
            let fastest2 = self.fastest2(good);
            outcome.finite = fastest2.is_finite();
            if outcome.finite {
                self.speed = fastest2.sqrt();
                self.moved(good, dt);
            }
            good += 1;
        }
        if good < steps {
            self.roll_back();
            self.run(t, dt, outcome.done, good);
        }
        outcome.done += good;
        self.now = (self.now + good as usize) % 2;
    }

    fn run(&mut self, t: f64, dt: f64, done: u32, steps: u32) {
        let reach = self.reach.max(1);
        let depth = match self.settings.depth {
            0 => depth(self.moving, reach),
            depth => depth,
        };
        let batch = Batch { t, dt, done, steps, now: self.now, depth, reach };
        self.blocks.run(&self.common, &batch, &mut self.step_scratch);
    }

    /// Square of the largest speed after sub-step `s` of the batch, NaN if not finite.
    fn fastest2(&mut self, s: u32) -> f64 {
        let mut fastest2 = 0.0f64;
        for block in self.blocks.active_mut() {
            let speed2 = mutex_mut(block).speed2[s as usize];
            if speed2.is_nan() {
                return speed2;
            }
            fastest2 = fastest2.max(speed2);
        }
        fastest2
    }

    fn roll_back(&mut self) {
        let inactive = self.blocks.inactive;
        let active = self.blocks.block.iter_mut().zip(&mut self.blocks.rows).skip(inactive);
        for (block, rows) in active {
            let rows: &mut Vec<_> = rwlock_mut(&mut rows[self.now]);
            mutex_mut(block).roll_back(rows);
        }
    }
}

/// Depth of the wavefront: none where the run fits into the cache, or where blocks read so far away
/// that a wavefront would not.
fn depth(n: usize, reach: usize) -> u32 {
    if n < 8 * SIZE || reach > 2 { 1 } else { 4 }
}
