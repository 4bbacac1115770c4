//! Eight lines side by side: the unit in which transforms and sweeps work.

use pulp::{Arch, Simd, WithSimd};

/// One value of each of eight lines.
pub type Lanes = [f64; 8];

/// Eight zeros.
pub const ZERO: Lanes = [0.0; 8];

/// Transposes an 8 × 8 tile.
#[inline(always)]
pub fn transpose(tile: &[Lanes; 8]) -> [Lanes; 8] {
    let mut out = [ZERO; 8];
    for i in 0..8 {
        for j in 0..8 {
            out[i][j] = tile[j][i];
        }
    }
    out
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

/// The tile whose lines are rows `first..first + 8` of `rows`, zero where there are none.
#[inline(always)]
pub fn tile(rows: &[Lanes], first: usize) -> [Lanes; 8] {
    let mut out = [ZERO; 8];
    for (to, from) in out.iter_mut().zip(&rows[first..]) {
        *to = *from;
    }
    out
}

/// The body of a hot loop, written once and compiled for every vector width.
///
/// `run` and all that it calls must be `#[inline(always)]`, and closures are left out: what is not
/// inlined is compiled for the oldest machine.
pub(crate) trait Kernel {
    /// Does the work.
    fn run(self);
}

/// Runs a kernel with the widest vectors of this machine.
#[inline(always)]
pub(crate) fn dispatch(kernel: impl Kernel) {
    Arch::new().dispatch(Widest(kernel));
}

/// A kernel as `pulp` wants it.
struct Widest<K>(K);

impl<K: Kernel> WithSimd for Widest<K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.run();
    }
}
