//! Grains inserted during a run: they come last in the order, and the blocks that were there keep what
//! they know. Only the last of them and those about the new grains search again.

use crate::bulk::batch::Blocks;
use crate::bulk::block::Block;
use crate::bulk::engine::{Bulk, mean_diameter};
use crate::bulk::records::{GrainRecord, SIZE};
use crate::bulk::sync::{mutex_mut, rwlock_mut};
use crate::grains::Grains;

impl Bulk {
    /// Takes the last of `grains` up, which it does not know yet; false if that needs a new engine.
    pub(crate) fn insert(&mut self, grains: &Grains) -> bool {
        let (from, n) = (self.n, grains.len());
        // a block of fixed grains may be inactive: it does not take any that move
        let last = self.order.chunks(SIZE).last();
        let all_fixed = last.is_some_and(|last| last.iter().all(|&i| grains.is_fixed(i as usize)));
        if all_fixed || !(from..n).all(|i| grains.translation[i].norm() > 0.0) {
            return false;
        }
        self.n = n;
        self.moving += n - from;
        self.diameter = mean_diameter(&grains.radius);
        self.largest = grains.radius[from..].iter().copied().fold(self.largest, f64::max);
        self.set_threads(self.settings.threads);
        if self.order.is_empty() {
            return true;
        }
        let whole = self.order.len() / SIZE; // blocks that stay as they are
        self.order.extend(from as u32..n as u32);
        self.extend_blocks(grains, whole);
        if self.valid {
            self.candidates.extend(self.blocks.inactive, whole, self.blocks.block.len());
        }
        self.loaded = true; // what acts on the grains must be set
        self.listed = false;
        true
    }

    /// Fills the last block and appends others: all from block `whole` on are other than they were.
    fn extend_blocks(&mut self, grains: &Grains, whole: usize) {
        let inactive = self.blocks.inactive;
        let Blocks { mut rows, block: mut blocks, .. } = std::mem::take(&mut self.blocks);
        for (b, numbers) in self.order.chunks(SIZE).enumerate().skip(whole) {
            if b == blocks.len() {
                blocks.push(Block { first: (b * SIZE) as u32, ..Block::default() }.into());
                rows.push([vec![GrainRecord::NONE].into(), vec![GrainRecord::NONE].into()]);
            }
            let block = mutex_mut(&mut blocks[b]);
            block.save_history();
            for (k, &i) in numbers.iter().enumerate().skip(block.len()) {
                for rows in &mut rows[b] {
                    let (rows, r) = (rwlock_mut(rows), grains.radius[i as usize]);
                    rows[k] = GrainRecord::NONE;
                    (rows[k].a[3], rows[k].b[3]) = (r, r);
                    rows[k].a[..3].copy_from_slice(grains.position[i as usize].as_slice());
                    rows.push(GrainRecord::NONE);
                }
                if !grains.responds(i as usize) {
                    block.prescribed.push((k as u16, grains.motion[i as usize].clone()));
                }
            }
            block.inverse_inertia.resize(numbers.len(), 0.0);
        }
        self.blocks = Blocks::new(rows, blocks, inactive);
    }
}
