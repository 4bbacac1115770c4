//! Working memory of the direct solvers, and blocks of eight lines.

use crate::lanes::{Lanes, ZERO};
use crate::transform::Write;
use std::sync::Mutex;

/// Blocks of eight modes side by side in space: their sweeps do not wait for each other.
pub(super) const SIDE: usize = 4;

/// Packs values into lanes; lanes beyond the end get −1, a harmless eigenvalue.
pub(super) fn pack(values: &[f64]) -> Vec<Lanes> {
    let pad = |c: &[f64]| std::array::from_fn(|l| c.get(l).copied().unwrap_or(-1.0));
    values.chunks(8).map(pad).collect()
}

/// Working memory, one per thread; a lock that nobody else wants costs nothing measurable.
pub(super) struct Pool<T>(Vec<Mutex<T>>);

impl<T> Pool<T> {
    /// One piece of memory for each thread of the current pool, and one for the caller.
    pub(super) fn new(make: impl Fn() -> T) -> Self {
        let threads = rayon::current_num_threads() + 1;
        Self((0..threads).map(|_| Mutex::new(make())).collect())
    }

    /// Lends a piece of memory to `task`.
    pub(super) fn with<R>(&self, task: impl FnOnce(&mut T) -> R) -> R {
        let me = rayon::current_thread_index().map_or(0, |i| i + 1);
        let mut memory = self.0[me % self.0.len()].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        task(&mut memory)
    }
}

/// `out = x` or `out += x`.
#[inline(always)]
pub(super) fn store(out: &mut [f64], x: &[f64], write: Write) {
    // A length known beforehand spares a call of memcpy per cache line.
    if let (Ok(out), Some(x)) = (<&mut Lanes>::try_from(&mut *out), x.first_chunk::<8>()) {
        for l in 0..8 {
            out[l] = if write == Write::Add { out[l] + x[l] } else { x[l] };
        }
    } else if write == Write::Add {
        out.iter_mut().zip(x).for_each(|(o, x)| *o += x);
    } else {
        out.iter_mut().zip(x).for_each(|(o, x)| *o = *x);
    }
}

/// Length of a block of `rows` rows: an odd number of tiles, so that the same row of many blocks
/// does not fall on the same few places of the cache.
pub(super) fn block_length(rows: usize) -> usize {
    (rows.div_ceil(8) | 1) * 8
}

/// `count` blocks of zeros for `rows` rows each, and one row to [`crate::lanes::aligned`] them.
pub(super) fn blocks(count: usize, rows: usize) -> Vec<Lanes> {
    vec![ZERO; count * block_length(rows) + 1]
}
