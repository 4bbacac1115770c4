//! Numbers and fields derived from the velocity.

use crate::field::{for_each_own_unknown, for_each_unknown};
use crate::grid::Grid;

/// ½ ∫ u² dV over the unknowns, m⁵/s² per unit density (plane: per metre of depth).
pub fn kinetic_energy<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> f64 {
    let mut energy = 0.0;
    for (d, u) in velocity.iter().enumerate() {
        for_each_unknown(grid, d, |at, index| {
            energy += 0.5 * u[index] * u[index] * grid.control_volume(d, at);
        });
    }
    energy
}

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

/// Out-of-plane vorticity on two axes, ω = ∂u₀/∂x₁ − ∂u₁/∂x₀, 1/s: stored at the corner of the
/// lower faces, that is at `(faces₀[i], faces₁[j])`, for `i, j` from 0 to `n` inclusive.
///
/// In the plane (x, z) and in (r, z) this is the component along y and along the angle. Halos must
/// be up to date; on the line r = 0 it is zero.
pub fn vorticity(grid: &Grid<2>, velocity: &[Vec<f64>; 2], out: &mut [f64]) {
    let s = grid.stride(1);
    for j in 0..=grid.cells[1] {
        for i in 0..=grid.cells[0] {
            let at = grid.index([i as isize, j as isize]);
            let across = (velocity[0][at] - velocity[0][at - s]) / grid.axes[1].distances[j];
            let along = (velocity[1][at] - velocity[1][at - 1]) / grid.axes[0].distances[i];
            out[at] = across - along;
        }
    }
}
