//! One sweep over the velocity: is it finite, how fast, how well is continuity met?

use crate::grid::Grid;
use crate::lanes::{Kernel, dispatch};
use pulp::Simd;
use rayon::prelude::*;

/// What the sweep found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Health {
    /// Largest Σ_a |u_a|/Δx_a over all cells, 1/s: dt times it is the CFL number.
    pub rate: f64,
    /// Largest |∇·u|, 1/s.
    pub divergence: f64,
    /// Whether every value is finite.
    pub finite: bool,
}

impl Health {
    const GOOD: Self = Self { rate: 0.0, divergence: 0.0, finite: true };

    /// The worse of both in every respect; the order does not matter.
    fn worse(self, other: Self) -> Self {
        Self {
            rate: self.rate.max(other.rate),
            divergence: self.divergence.max(other.divergence),
            finite: self.finite && other.finite,
        }
    }

    /// Looks at every cell. Halos and wall faces must be up to date.
    pub fn of<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> Self {
        let rows = 0..grid.rows();
        let row = |row| Self::of_row(grid, velocity, row);
        if rayon::current_num_threads() > 1 && grid.cell_count() > 16_384 {
            rows.into_par_iter().with_min_len(16).map(row).reduce(|| Self::GOOD, Self::worse)
        } else {
            rows.map(row).fold(Self::GOOD, Self::worse)
        }
    }

    fn of_row<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D], row: usize) -> Self {
        let mut worst = Worst { rate: [0.0; BLOCK], divergence: [0.0; BLOCK], sum: [0.0; BLOCK] };
        for from in (0..grid.cells[0]).step_by(BLOCK) {
            dispatch(Block { grid, velocity, row, from, worst: &mut worst });
        }
        Self {
            rate: worst.rate.into_iter().fold(0.0, f64::max),
            divergence: worst.divergence.into_iter().fold(0.0, f64::max),
            finite: worst.sum.iter().all(|x| x.is_finite()),
        }
    }
}

/// Cells looked at together.
const BLOCK: usize = 64;

/// The worst of a row so far, place by place within a block; `sum` is finite if everything is.
struct Worst {
    rate: [f64; BLOCK],
    divergence: [f64; BLOCK],
    sum: [f64; BLOCK],
}

/// The cells from `from` on of one row.
struct Block<'a, const D: usize> {
    grid: &'a Grid<D>,
    velocity: &'a [Vec<f64>; D],
    row: usize,
    from: usize,
    worst: &'a mut Worst,
}

impl<const D: usize> Kernel for Block<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { grid, velocity, row, from, worst } = self;
        let len = BLOCK.min(grid.cells[0] - from);
        let start = grid.row(row) + from;
        let at = [0, row % grid.cells[1], row / grid.cells[1]];
        let (mut rate, mut divergence) = ([0.0; BLOCK], [0.0; BLOCK]);
        for (a, u) in velocity.iter().enumerate() {
            let (axis, k) = (&grid.axes[a], at[a]);
            let (low, high) = (&u[start..][..len], &u[start + grid.stride(a)..][..len]);
            if a == 0 {
                let (area, next) = (&axis.face_area[from..][..len], &axis.face_area[from + 1..][..len]);
                let (width, volume) = (&axis.widths[from..][..len], &axis.cell_volume[from..][..len]);
                for i in 0..len {
                    rate[i] += low[i].abs().max(high[i].abs()) / width[i];
                    divergence[i] += (next[i] * high[i] - area[i] * low[i]) / volume[i];
                    worst.sum[i] += 0.0 * (low[i] + high[i]);
                }
            } else {
                let (area, next) = (axis.face_area[k], axis.face_area[k + 1]);
                let (width, volume) = (axis.widths[k], axis.cell_volume[k]);
                for i in 0..len {
                    rate[i] += low[i].abs().max(high[i].abs()) / width;
                    divergence[i] += (next * high[i] - area * low[i]) / volume;
                    worst.sum[i] += 0.0 * (low[i] + high[i]);
                }
            }
        }
        for i in 0..len {
            worst.rate[i] = worst.rate[i].max(rate[i]);
            worst.divergence[i] = worst.divergence[i].max(divergence[i].abs());
        }
    }
}
