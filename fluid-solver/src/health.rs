//! One sweep over the velocity: is it finite, how fast, how well is continuity met?

use crate::grid::Grid;
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
        let (start, n) = (grid.row(row), grid.cells[0]);
        let at = [0, row % grid.cells[1], row / grid.cells[1]];
        let mut health = Self::GOOD;
        for i in 0..n {
            let (mut rate, mut divergence, mut sum) = (0.0, 0.0, 0.0);
            for (a, u) in velocity.iter().enumerate() {
                let axis = &grid.axes[a];
                let k = if a == 0 { i } else { at[a] };
                let (low, high) = (u[start + i], u[start + i + grid.stride(a)]);
                rate += low.abs().max(high.abs()) / axis.widths[k];
                divergence += (axis.face_area[k + 1] * high - axis.face_area[k] * low) / axis.cell_volume[k];
                sum += low + high;
            }
            health.rate = health.rate.max(rate);
            health.divergence = health.divergence.max(divergence.abs());
            health.finite &= sum.is_finite();
        }
        health
    }
}
