//! Numbers and fields derived from the velocity.

use crate::field::{for_each_own_unknown, for_each_unknown};
use crate::grid::Grid;

/// ∫ u_d dV over the unknowns of component `d`, m⁴/s (plane: per metre of depth).
pub fn momentum<const D: usize>(grid: &Grid<D>, d: usize, u: &[f64]) -> f64 {
    let mut sum = 0.0;
    for_each_unknown(grid, d, |at, index| sum += u[index] * grid.control_volume(d, at));
    sum
}

/// Mean of component `d` over the box, grains included, m/s: along a periodic axis the superficial
/// velocity, which is the same through every cross-section. One rank adds its planes after the other.
pub fn mean_velocity<const D: usize>(grid: &Grid<D>, d: usize, u: &[f64]) -> f64 {
    mean_of(grid, d, |index| u[index])
}

/// Mean of u² over the box, grains included, m²/s²; one rank adds its planes after the other.
pub fn mean_square<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> f64 {
    velocity.iter().enumerate().map(|(d, u)| mean_of(grid, d, |index| u[index] * u[index])).sum()
}

/// Mean over the unknowns of component `d` of what stands there.
fn mean_of<const D: usize>(grid: &Grid<D>, d: usize, value: impl Fn(usize) -> f64) -> f64 {
    let mut sums = [0.0, 0.0];
    grid.division.ranks().relay(&mut sums, |sums| {
        let (mut sum, mut volume) = (sums[0], sums[1]);
        for_each_own_unknown(grid, d, |at, index| {
            let control = grid.control_volume(d, at);
            sum += value(index) * control;
            volume += control;
        });
        sums.copy_from_slice(&[sum, volume]);
    });
    sums[0] / sums[1]
}
