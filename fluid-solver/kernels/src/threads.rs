//! Work sharing: the one place where the solver meets its threads.
//!
//! A task owns some parts of the output and writes nothing else, so the number of threads cannot
//! change a bit of any result. Small arrays are done by the calling thread. Tasks are called by
//! reference, so that sharing is compiled once for each kind of parts and not for each task.

use crate::grid::Grid;
use std::ops::Range;

/// Values per thread below which a second thread costs more than it brings.
const WORTH_A_THREAD: usize = 16_384;

/// Parts that may be shared.
pub trait Parts: Sized + Send {
    /// The first `count` parts, and the others.
    fn divide(self, count: usize) -> (Self, Self);
}

impl<T: Send> Parts for &mut [T] {
    fn divide(self, count: usize) -> (Self, Self) {
        self.split_at_mut(count)
    }
}

/// Chunks of `size` values of some fields at once; the last may be shorter.
pub struct Chunks<'a, T, const N: usize> {
    /// The fields.
    pub fields: [&'a mut [T]; N],
    /// Values of a field in a chunk.
    pub size: usize,
}

impl<T: Send, const N: usize> Parts for Chunks<'_, T, N> {
    fn divide(self, count: usize) -> (Self, Self) {
        let Self { fields, size } = self;
        let mut halves = fields.map(|field| field.split_at_mut((count * size).min(field.len())));
        let low = halves.each_mut().map(|(low, _)| std::mem::take(low));
        (Self { fields: low, size }, Self { fields: halves.map(|(_, high)| high), size })
    }
}

impl<'a, T, const N: usize> Chunks<'a, T, N> {
    /// Calls `task` with every chunk and its number, of `numbers`.
    pub(crate) fn each(self, numbers: Range<usize>, task: &(dyn Fn(usize, [&mut [T]; N]) + Sync)) {
        let mut chunks = self.fields.map(|field| field.chunks_mut(self.size));
        numbers.for_each(|i| task(i, chunks.each_mut().map(|chunks| chunks.next().expect("a chunk"))));
    }
}

impl<A: Parts, B: Parts> Parts for (A, B) {
    fn divide(self, count: usize) -> (Self, Self) {
        let (low, high) = (self.0.divide(count), self.1.divide(count));
        ((low.0, high.0), (low.1, high.1))
    }
}

/// Calls `task` with the numbers of some parts and with these parts, in halves side by side down to `most` of
/// them.
pub fn share<P: Parts>(
    parts: P,
    numbers: Range<usize>,
    most: usize,
    task: &(dyn Fn(Range<usize>, P) + Sync),
) {
    if numbers.len() <= most.max(1) {
        return task(numbers, parts);
    }
    let middle = numbers.start + numbers.len() / 2;
    let (low, high) = parts.divide(middle - numbers.start);
    rayon::join(
        || share(low, numbers.start..middle, most, task),
        || share(high, middle..numbers.end, most, task),
    );
}

/// Most of `parts` parts for a thread, where there are `threads`: all, or a fourth of an equal share.
pub fn most(parts: usize, threads: usize) -> usize {
    if threads > 1 { parts.div_ceil(4 * threads) } else { parts }
}

/// Threads that `values` values are worth.
pub(crate) fn threads(values: usize) -> usize {
    rayon::current_num_threads().min(values / WORTH_A_THREAD)
}

/// Calls `task(i, chunk)` for every chunk of `size` values of `data`, in parallel where worth it.
pub fn for_chunks<T: Send>(data: &mut [T], size: usize, task: impl Fn(usize, &mut [T]) + Sync) {
    let values = data.len() * (std::mem::size_of::<T>() / 8).max(1);
    let count = data.len().div_ceil(size);
    share(Chunks { fields: [data], size }, 0..count, most(count, threads(values)), &|numbers, chunks| {
        chunks.each(numbers, &|i, [chunk]| task(i, chunk));
    });
}

/// Calls `task` with the number of every interior row on two axes and the values `0..n` of that row of some
/// fields, in parallel where worth it.
pub fn for_rows<const D: usize, const N: usize>(
    grid: &Grid<D>,
    fields: [&mut [f64]; N],
    task: impl Fn(usize, [&mut [f64]; N]) + Sync,
) {
    debug_assert!(D == 2, "rows follow each other on two axes only");
    let (n, rows, size) = (grid.cells[0], grid.rows(), grid.stride(1));
    let range = grid.row(0)..grid.row(rows - 1) + n;
    let fields = fields.map(|field| &mut field[range.clone()]);
    share(Chunks { fields, size }, 0..rows, most(rows, threads(grid.cell_count())), &|rows, chunks| {
        chunks.each(rows, &|row, fields| task(row, fields.map(|field| &mut field[..n])));
    });
}

/// Calls `work` with the first row of every layer of this process and, from there on, the layer of some
/// fields, side by side where there are threads.
pub(crate) fn by_layers<const D: usize, const N: usize>(
    grid: &Grid<D>,
    fields: [&mut [f64]; N],
    work: impl Fn(usize, [&mut [f64]; N]) + Sync,
) {
    let (layers, size) = (grid.division.own(), grid.stride(D - 1));
    let rows = grid.rows() / grid.cells[D - 1];
    let begin = grid.row(layers.start * rows);
    let fields = fields.map(|field| &mut field[begin..]);
    let most = most(layers.len(), rayon::current_num_threads());
    share(Chunks { fields, size }, layers, most, &|layers, chunks| {
        chunks.each(layers, &|k, fields| work(k * rows, fields));
    });
}
