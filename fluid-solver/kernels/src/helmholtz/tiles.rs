//! Between lines and columns: tiles of 8 × 8 values, transposed on the way.
//!
//! Lines come in blocks of eight, `[block][place][8 lines]`; a column holds eight modes,
//! `[unknown][8 modes]`. Tile `b` of a column is eight places of block `b` of the lines.

use super::blocks::store;
use crate::lanes::{Kernel, Lanes, ZERO, lanes_at_mut, load, transpose};
use crate::transform::Write;
use crate::tridiagonal::Sweep;
use pulp::Simd;

/// Where the tiles of one column lie: tile `b` is rows `first + b · apart ..+ 8`.
#[derive(Clone, Copy)]
pub(super) struct Tiles {
    pub(super) first: usize,
    pub(super) apart: usize,
}

impl Tiles {
    /// First row of tile `b`.
    #[inline(always)]
    fn at(self, b: usize) -> usize {
        self.first + b * self.apart
    }

    /// Tile `b`, transposed.
    #[inline(always)]
    fn get<S: Simd>(self, simd: S, lines: &[Lanes], b: usize) -> [Lanes; 8] {
        let mut tile = [ZERO; 8];
        for (to, from) in tile.iter_mut().zip(&lines[self.at(b)..][..8]) {
            *to = *from;
        }
        transpose(simd, tile)
    }

    /// Writes tile `b`, transposed.
    #[inline(always)]
    fn put<S: Simd>(self, simd: S, lines: &mut [Lanes], b: usize, tile: [Lanes; 8]) {
        for (to, from) in lines[self.at(b)..][..8].iter_mut().zip(transpose(simd, tile)) {
            *to = from;
        }
    }
}

/// A column from its tiles.
pub(super) struct Gather<'a> {
    pub(super) lines: &'a [Lanes],
    pub(super) tiles: Tiles,
    pub(super) column: &'a mut [Lanes],
}

impl Kernel for Gather<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for (b, to) in self.column.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            *to = self.tiles.get(simd, self.lines, b);
        }
    }
}

/// A column to its tiles.
pub(super) struct Scatter<'a> {
    pub(super) column: &'a [Lanes],
    pub(super) lines: &'a mut [Lanes],
    pub(super) tiles: Tiles,
}

impl Kernel for Scatter<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for (b, from) in self.column.as_chunks::<8>().0.iter().enumerate() {
            self.tiles.put(simd, self.lines, b, *from);
        }
    }
}

/// Elimination on `K` columns taken from their tiles, with inverse pivots (see [`super::plane_columns`]). Two
/// columns side by side hide half of the wait for the value before.
pub(super) struct Eliminate<'a, const K: usize> {
    pub(super) sweep: &'a Sweep,
    pub(super) c: f64,
    pub(super) scale: f64,
    pub(super) pivots: [&'a [Lanes]; K],
    pub(super) lines: &'a [Lanes],
    pub(super) tiles: [Tiles; K],
    pub(super) columns: [&'a mut [Lanes]; K],
}

impl<const K: usize> Kernel for Eliminate<'_, K> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
    fn run<S: Simd>(self, simd: S) {
        let Self { sweep, c, scale, pivots, lines, tiles, columns } = self;
        let (lower, _) = sweep.lower.as_chunks::<8>();
        let pivots = pivots.map(|p| p.as_chunks::<8>().0);
        let per = 8 / S::F64_LANES;
        let scale = simd.splat_f64s(scale);
        let mut previous = [[simd.splat_f64s(0.0); 8]; K];
        for (b, lower) in lower.iter().enumerate() {
            let mut tile = [[ZERO; 8]; K];
            for k in 0..K {
                tile[k] = tiles[k].get(simd, lines, b);
            }
            for r in 0..8 {
                let weight = simd.splat_f64s(c * lower[r]);
                for k in 0..K {
                    let (pivot, _) = S::as_simd_f64s(&pivots[k][b][r]);
                    let (x, _) = S::as_mut_simd_f64s(&mut tile[k][r]);
                    for t in 0..per {
                        // Only one product and one sum wait for the value before.
                        let own = simd.mul_f64s(simd.mul_f64s(scale, pivot[t]), x[t]);
                        let carried = simd.mul_f64s(simd.mul_f64s(weight, pivot[t]), previous[k][t]);
                        previous[k][t] = simd.add_f64s(own, carried);
                        x[t] = previous[k][t];
                    }
                }
            }
            for k in 0..K {
                columns[k].as_chunks_mut::<8>().0[b] = tile[k];
            }
        }
    }
}

/// Substitution, the second half: the solution goes to tiles.
pub(super) struct Substitute<'a, const K: usize> {
    pub(super) sweep: &'a Sweep,
    pub(super) c: f64,
    pub(super) pivots: [&'a [Lanes]; K],
    pub(super) columns: [&'a [Lanes]; K],
    pub(super) lines: &'a mut [Lanes],
    pub(super) tiles: [Tiles; K],
}

impl<const K: usize> Kernel for Substitute<'_, K> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
    fn run<S: Simd>(self, simd: S) {
        let Self { sweep, c, pivots, columns, lines, tiles } = self;
        let (upper, _) = sweep.upper.as_chunks::<8>();
        let pivots = pivots.map(|p| p.as_chunks::<8>().0);
        let columns = columns.map(|x| x.as_chunks::<8>().0);
        let per = 8 / S::F64_LANES;
        let mut previous = [[simd.splat_f64s(0.0); 8]; K];
        for (b, upper) in upper.iter().enumerate().rev() {
            let mut tile = [[ZERO; 8]; K];
            for k in 0..K {
                tile[k] = columns[k][b];
            }
            for r in (0..8).rev() {
                let weight = simd.splat_f64s(c * upper[r]);
                for k in 0..K {
                    let (pivot, _) = S::as_simd_f64s(&pivots[k][b][r]);
                    let (x, _) = S::as_mut_simd_f64s(&mut tile[k][r]);
                    for t in 0..per {
                        let share = simd.mul_f64s(weight, pivot[t]);
                        previous[k][t] = simd.add_f64s(x[t], simd.mul_f64s(share, previous[k][t]));
                        x[t] = previous[k][t];
                    }
                }
            }
            for k in 0..K {
                tiles[k].put(simd, lines, b, tile[k]);
            }
        }
    }
}

/// Removes the volume mean of the first mode of a column (the singular one of pressure) in its tiles.
pub(super) fn remove_mean(sweep: &Sweep, lines: &mut [Lanes], tiles: Tiles) {
    let volume = sweep.volume.as_chunks::<8>().0;
    let total: f64 = sweep.volume.iter().sum();
    let values = volume.iter().enumerate().flat_map(|(b, v)| lines[tiles.at(b)].iter().zip(v));
    let sum: f64 = values.map(|(x, v)| x * v).sum();
    (0..volume.len()).for_each(|b| lines[tiles.at(b)].iter_mut().for_each(|x| *x -= sum / total));
}

/// Up to eight rows of a field as lanes, transposed; lanes beyond `height` are zero.
pub(super) struct LoadRows<'a> {
    pub(super) field: &'a [f64],
    pub(super) stride: usize,
    pub(super) height: usize,
    pub(super) to: &'a mut [Lanes],
}

impl Kernel for LoadRows<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for (t, to) in self.to.chunks_mut(8).enumerate() {
            let mut rows = [ZERO; 8];
            for (l, row) in rows.iter_mut().enumerate().take(self.height) {
                *row = load(&self.field[l * self.stride + 8 * t..][..to.len()]);
            }
            let tile = transpose(simd, rows);
            match to.first_chunk_mut::<8>() {
                Some(to) => *to = tile,
                None => to.copy_from_slice(&tile[..to.len()]),
            }
        }
    }
}

/// Lanes back to the rows of a field, `stride` apart, see [`LoadRows`].
pub(super) struct StoreRows<'a> {
    pub(super) from: &'a [Lanes],
    pub(super) field: &'a mut [f64],
    pub(super) stride: usize,
    pub(super) height: usize,
    pub(super) write: Write,
}

impl Kernel for StoreRows<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { from, field, stride, height, write } = self;
        let (whole, rest) = from.as_chunks::<8>();
        for (t, from) in whole.iter().enumerate() {
            let tile = transpose(simd, *from);
            for (l, values) in tile.iter().enumerate().take(height) {
                let row = lanes_at_mut(field, l * stride + 8 * t);
                for (to, value) in row.iter_mut().zip(values) {
                    *to = if write == Write::Add { *to + value } else { *value };
                }
            }
        }
        if !rest.is_empty() {
            let mut tile = [ZERO; 8];
            tile[..rest.len()].copy_from_slice(rest);
            for (l, values) in transpose(simd, tile).iter().enumerate().take(height) {
                store(&mut field[l * stride + 8 * whole.len()..][..rest.len()], values, write);
            }
        }
    }
}
