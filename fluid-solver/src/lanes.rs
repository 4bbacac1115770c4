//! Eight lines side by side: the unit in which transforms and sweeps work.

/// One value of each of eight lines.
pub type Lanes = [f64; 8];

/// Eight zeros.
pub const ZERO: Lanes = [0.0; 8];

/// Transposes an 8 × 8 tile.
#[inline(always)]
pub fn transpose(tile: &[Lanes; 8]) -> [Lanes; 8] {
    std::array::from_fn(|i| std::array::from_fn(|j| tile[j][i]))
}

/// Copies up to eight values into lanes, the rest zero.
#[inline(always)]
pub fn load(values: &[f64]) -> Lanes {
    let mut lanes = ZERO;
    let n = values.len().min(8);
    lanes[..n].copy_from_slice(&values[..n]);
    lanes
}

/// The tile whose lines are rows `first..first + 8` of `rows`, zero where there are none.
#[inline(always)]
pub fn tile(rows: &[Lanes], first: usize) -> [Lanes; 8] {
    std::array::from_fn(|i| rows.get(first + i).copied().unwrap_or(ZERO))
}
