//! Eight lines side by side: the unit in which transforms and sweeps work.

use bedload_vectors::arch;
use pulp::{Simd, WithSimd};

/// One value of each of eight lines.
pub type Lanes = [f64; 8];

/// Eight zeros.
pub const ZERO: Lanes = [0.0; 8];

/// Transposes an 8 × 8 tile, in 24 instructions where the machine has vectors of eight.
#[inline(always)]
pub(crate) fn transpose<S: Simd>(simd: S, tile: [Lanes; 8]) -> [Lanes; 8] {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = (&simd as &dyn std::any::Any).downcast_ref::<pulp::x86::V4>() {
        return transpose_v4(*simd, tile);
    }
    let _ = simd;
    let mut out = [ZERO; 8];
    for i in 0..8 {
        for j in 0..8 {
            out[i][j] = tile[j][i];
        }
    }
    out
}

/// Pairs of neighbouring rows are interleaved, then quarters of the vectors exchanged twice.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose_v4(simd: pulp::x86::V4, rows: [Lanes; 8]) -> [Lanes; 8] {
    const EVEN: i32 = 0x88;
    const ODD: i32 = 0xdd;
    let f = simd.avx512f;
    let mut pairs = [[pulp::bytemuck::cast(rows[0]); 4]; 2];
    for k in 0..4 {
        let (a, b) = (pulp::bytemuck::cast(rows[2 * k]), pulp::bytemuck::cast(rows[2 * k + 1]));
        pairs[0][k] = f._mm512_unpacklo_pd(a, b);
        pairs[1][k] = f._mm512_unpackhi_pd(a, b);
    }
    let mut out = rows;
    for (odd, p) in pairs.into_iter().enumerate() {
        let (a, b) = (f._mm512_shuffle_f64x2::<EVEN>(p[0], p[1]), f._mm512_shuffle_f64x2::<EVEN>(p[2], p[3]));
        let (c, d) = (f._mm512_shuffle_f64x2::<ODD>(p[0], p[1]), f._mm512_shuffle_f64x2::<ODD>(p[2], p[3]));
        out[odd] = pulp::bytemuck::cast(f._mm512_shuffle_f64x2::<EVEN>(a, b));
        out[odd + 4] = pulp::bytemuck::cast(f._mm512_shuffle_f64x2::<ODD>(a, b));
        out[odd + 2] = pulp::bytemuck::cast(f._mm512_shuffle_f64x2::<EVEN>(c, d));
        out[odd + 6] = pulp::bytemuck::cast(f._mm512_shuffle_f64x2::<ODD>(c, d));
    }
    out
}

/// The part of working memory that begins on a cache line, one entry shorter.
///
/// A vector that lies across two cache lines costs twice.
#[inline(always)]
pub(crate) fn aligned(memory: &mut [Lanes]) -> &mut [Lanes] {
    let rows = memory.len() - 1;
    let values = memory.as_flattened_mut();
    let skip = values.as_ptr().align_offset(64).min(7);
    &mut values[skip..].as_chunks_mut().0[..rows]
}

/// Working memory that begins on a cache line.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    values: Vec<f64>,
    skip: usize,
    count: usize,
}

impl Aligned {
    pub(crate) fn zeros(count: usize) -> Self {
        let values = vec![0.0; if count > 0 { count + 7 } else { 0 }];
        let skip = values.as_ptr().align_offset(64).min(values.len() - count);
        Self { values, skip, count }
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        let mut copy = Self::zeros(self.count);
        copy.copy_from_slice(self);
        copy
    }
}

impl std::ops::Deref for Aligned {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        &self.values[self.skip..][..self.count]
    }
}

impl std::ops::DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.values[self.skip..][..self.count]
    }
}

/// Copies up to eight values into lanes, the rest zero.
#[inline(always)]
pub fn load(values: &[f64]) -> Lanes {
    // A length known beforehand spares a call of memcpy per cache line.
    if let Some(lanes) = values.first_chunk::<8>() {
        return *lanes;
    }
    let mut lanes = ZERO;
    for (lane, value) in lanes.iter_mut().zip(values) {
        *lane = *value;
    }
    lanes
}

/// Eight values from place `at` on.
#[inline(always)]
pub(crate) fn lanes_at(values: &[f64], at: usize) -> &Lanes {
    values[at..].first_chunk().expect("rows are whole vectors")
}

/// Eight values from place `at` on, to be changed.
#[inline(always)]
pub(crate) fn lanes_at_mut(values: &mut [f64], at: usize) -> &mut Lanes {
    values[at..].first_chunk_mut().expect("rows are whole vectors")
}

/// The body of a hot loop, written once and compiled for every vector width.
///
/// `run` and all that it calls must be `#[inline(always)]`, and closures are left out: what is not
/// inlined is compiled for the oldest machine.
pub(crate) trait Kernel {
    /// Does the work with the vectors of `simd`.
    fn run<S: Simd>(self, simd: S);
}

/// Runs a kernel with the vectors of [`arch`].
///
/// Not inlined: where it is passed as a function it would be compiled twice.
#[inline(never)]
pub(crate) fn dispatch(kernel: impl Kernel) {
    arch().dispatch(Widest(kernel));
}

/// A kernel as `pulp` wants it.
struct Widest<K>(K);

impl<K: Kernel> WithSimd for Widest<K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.run(simd);
    }
}
