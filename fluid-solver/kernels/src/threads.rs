//! Work sharing: the one place where the solver meets its threads.
//!
//! A task owns one chunk of the output and writes nothing else, so the number of threads cannot
//! change a bit of any result. Small arrays are done by the calling thread.

use crate::grid::Grid;
use rayon::prelude::*;

/// Values per thread below which a second thread costs more than it brings.
const WORTH_A_THREAD: usize = 16_384;

/// Calls `task(i, chunk)` for every chunk of `chunk` values of `data`, in parallel where worth it.
pub fn for_chunks<T: Send>(data: &mut [T], chunk: usize, task: impl Fn(usize, &mut [T]) + Sync) {
    let values = data.len() * (std::mem::size_of::<T>() / 8).max(1);
    let threads = rayon::current_num_threads().min(values / WORTH_A_THREAD);
    if threads < 2 {
        data.chunks_mut(chunk).enumerate().for_each(|(i, c)| task(i, c));
    } else {
        let least = data.len().div_ceil(chunk).div_ceil(4 * threads);
        data.par_chunks_mut(chunk).enumerate().with_min_len(least).for_each(|(i, c)| task(i, c));
    }
}

/// Calls `task(row, [a, b, c])` for every interior row of three fields on two axes at once, each
/// being the values `0..n` of that row, in parallel where worth it.
pub fn for_row_triples<const D: usize>(
    grid: &Grid<D>,
    fields: [&mut [f64]; 3],
    task: impl Fn(usize, [&mut [f64]; 3]) + Sync,
) {
    debug_assert!(D == 2, "rows follow each other on two axes only");
    let (n, stride) = (grid.cells[0], grid.stride(1));
    let range = grid.row(0)..grid.row(grid.rows() - 1) + n;
    let [a, b, c] = fields.map(|field| &mut field[range.clone()]);
    let threads = rayon::current_num_threads().min(grid.cell_count() / WORTH_A_THREAD);
    if threads < 2 {
        let rows = a.chunks_mut(stride).zip(b.chunks_mut(stride)).zip(c.chunks_mut(stride));
        rows.enumerate().for_each(|(row, ((a, b), c))| task(row, [a, b, c].map(|x| &mut x[..n])));
    } else {
        a.par_chunks_mut(stride)
            .zip(b.par_chunks_mut(stride))
            .zip(c.par_chunks_mut(stride))
            .enumerate()
            .with_min_len(grid.cells[1].div_ceil(4 * threads))
            .for_each(|(row, ((a, b), c))| task(row, [a, b, c].map(|x| &mut x[..n])));
    }
}

/// Calls `task(row, a, b)` for every interior row of two fields at once, `a` and `b` being the
/// values `0..n` of that row, in parallel where worth it.
pub fn for_rows<const D: usize>(
    grid: &Grid<D>,
    a: &mut [f64],
    b: &mut [f64],
    task: impl Fn(usize, &mut [f64], &mut [f64]) + Sync,
) {
    let (n, inner) = (grid.cells[0], grid.rows() / grid.cells[D - 1]);
    let (layer, stride) = (grid.stride(D - 1), grid.stride(1));
    let range = grid.row(0)..grid.row(grid.rows() - 1) + n;
    let share = |k: usize, a: &mut [f64], b: &mut [f64]| {
        for j in 0..inner {
            let at = j * stride..j * stride + n;
            task(k * inner + j, &mut a[at.clone()], &mut b[at]);
        }
    };
    let (a, b) = (&mut a[range.clone()], &mut b[range]);
    let threads = rayon::current_num_threads().min(grid.cell_count() / WORTH_A_THREAD);
    if threads < 2 {
        let layers = a.chunks_mut(layer).zip(b.chunks_mut(layer));
        layers.enumerate().for_each(|(k, (a, b))| share(k, a, b));
    } else {
        a.par_chunks_mut(layer)
            .zip(b.par_chunks_mut(layer))
            .enumerate()
            .with_min_len(grid.cells[D - 1].div_ceil(4 * threads))
            .for_each(|(k, (a, b))| share(k, a, b));
    }
}
