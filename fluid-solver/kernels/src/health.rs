//! One sweep over the velocity: is it finite, how fast, how well is continuity met?

use crate::grid::Grid;
use crate::lanes::{Kernel, Lanes, ZERO, dispatch};
use crate::threads::{most, threads};
use pulp::Simd;
use std::ops::Range;

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

    /// Looks at every cell, of all ranks. Halos and wall faces must be up to date.
    pub fn of<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> Self {
        let rows = grid.own_rows();
        let most = most(rows.len(), threads(grid.cell_count()));
        let found = Self::of_rows(grid, velocity, rows, most);
        let mut all = [found.rate, found.divergence, f64::from(u8::from(!found.finite))];
        grid.division.ranks().combine(&mut all, f64::max);
        Self { rate: all[0], divergence: all[1], finite: all[2] == 0.0 }
    }

    /// Looks at the cells of some rows, in halves side by side down to `most` rows.
    fn of_rows<const D: usize>(
        grid: &Grid<D>,
        velocity: &[Vec<f64>; D],
        rows: Range<usize>,
        most: usize,
    ) -> Self {
        let mut found = Self::GOOD;
        if rows.len() <= most.max(1) {
            dispatch(Slab { grid, velocity, rows, found: &mut found });
            return found;
        }
        let middle = rows.start.midpoint(rows.end);
        let half = |rows| Self::of_rows(grid, velocity, rows, most);
        let (low, high) = rayon::join(|| half(rows.start..middle), || half(middle..rows.end));
        low.worse(high)
    }
}

/// Some rows.
struct Slab<'a, const D: usize> {
    grid: &'a Grid<D>,
    velocity: &'a [Vec<f64>; D],
    rows: Range<usize>,
    found: &'a mut Health,
}

/// The worst of eight places side by side; `broken` is finite if everything is.
struct Worst {
    rate: Lanes,
    divergence: Lanes,
    broken: Lanes,
}

impl<const D: usize> Kernel for Slab<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let mut worst = Worst { rate: ZERO, divergence: ZERO, broken: ZERO };
        let n = self.grid.cells[0];
        for row in self.rows.clone() {
            if let Some(last) = n.checked_sub(8) {
                // The last eight cells overlap those before: the worst of both is the same.
                for at in (0..last).step_by(8).chain([last]) {
                    self.look::<8>(row, at, &mut worst);
                }
            } else {
                for at in 0..n {
                    self.look::<1>(row, at, &mut worst);
                }
            }
        }
        *self.found = Health {
            rate: worst.rate.into_iter().fold(0.0, larger),
            divergence: worst.divergence.into_iter().fold(0.0, larger),
            finite: worst.broken.iter().all(|x| x.is_finite()),
        };
    }
}

impl<const D: usize> Slab<'_, D> {
    /// Looks at `W` cells of a row from cell `at` on.
    #[inline(always)]
    fn look<const W: usize>(&self, row: usize, at: usize, worst: &mut Worst) {
        let Self { grid, velocity, .. } = self;
        let (start, across) = (grid.row(row) + at, [row % grid.cells[1], row / grid.cells[1]]);
        let along = &grid.axes[0];
        let [per_width, per_volume] =
            [&along.inverse_widths, &along.inverse_cell_volume].map(|v| take::<W>(v, at));
        let (area, next) = (take::<W>(&along.face_area, at), take::<W>(&along.face_area, at + 1));
        let (low, high) = (take::<W>(&velocity[0], start), take::<W>(&velocity[0], start + 1));
        let (mut rate, mut divergence) = ([0.0; W], [0.0; W]);
        for l in 0..W {
            rate[l] = larger(low[l].abs(), high[l].abs()) * per_width[l];
            divergence[l] = (next[l] * high[l] - area[l] * low[l]) * per_volume[l];
        }
        for a in 1..D {
            let (axis, k) = (&grid.axes[a], across[a - 1]);
            let (per_width, per_volume) = (axis.inverse_widths[k], axis.inverse_cell_volume[k]);
            let (area, next) = (axis.face_area[k] * per_volume, axis.face_area[k + 1] * per_volume);
            let u = &velocity[a];
            let (low, high) = (take::<W>(u, start), take::<W>(u, start + grid.stride(a)));
            for l in 0..W {
                rate[l] += larger(low[l].abs(), high[l].abs()) * per_width;
                divergence[l] += next * high[l] - area * low[l];
            }
        }
        for l in 0..W {
            worst.rate[l] = larger(rate[l], worst.rate[l]);
            worst.divergence[l] = larger(divergence[l].abs(), worst.divergence[l]);
            // The divergence takes every value in.
            worst.broken[l] += 0.0 * divergence[l];
        }
    }
}

/// `W` values from place `at` on.
#[inline(always)]
fn take<const W: usize>(values: &[f64], at: usize) -> &[f64; W] {
    values[at..].first_chunk().expect("inside the field")
}

/// The larger one; `b` where either is no number. One operation, where [`f64::max`] takes three.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
