//! Discrete identities of the operators, in plane, axisymmetric and space grids.

use crate::flow::common::{Random, convection_of, grid, laplacian_of, plane_grids, space_grids, uniform};
use fluid_solver::boundary::Boundary;
use fluid_solver::engines::HasEngine;
use fluid_solver::field::for_each_unknown;
use fluid_solver::grid::Grid;
use fluid_solver::halo::fill_velocity;
use fluid_solver::health::Health;
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;

/// A random divergence-free velocity of size about 1, halos filled.
fn solenoidal<const D: usize>(grid: &Grid<D>) -> [Vec<f64>; D]
where
    Grid<D>: HasEngine<D>,
{
    let options = Options {
        viscosity: 0.0,
        scheme: Scheme::AdamsBashforth2,
        viscous: Viscous::Explicit,
        convection: false,
        body_force: [0.0; D],
    };
    let mut stepper = Stepper::new(grid.clone(), options);
    for d in 0..D {
        Random(11 + d as u64).fill(grid, d, &mut stepper.state_mut().velocity[d]);
    }
    stepper.project_velocity();
    stepper.state().velocity.clone()
}

/// ∫ a b dV over the unknowns of component `d`, and ∫ |a b| dV.
fn product<const D: usize>(grid: &Grid<D>, d: usize, a: &[f64], b: &[f64]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for_each_unknown(grid, d, |at, index| {
        let x = a[index] * b[index] * grid.control_volume(d, at);
        sums[0] += x;
        sums[1] += x.abs();
    });
    sums
}

/// Σ_d ∫ u_d N_d dV relative to Σ ∫ |u_d N_d| dV.
fn convective_power<const D: usize>(grid: &Grid<D>) -> f64
where
    Grid<D>: HasEngine<D>,
{
    let u = solenoidal(grid);
    let n = convection_of(grid, &u);
    let mut total = [0.0; 2];
    for d in 0..D {
        let p = product(grid, d, &u[d], &n[d]);
        total = [total[0] + p[0], total[1] + p[1]];
    }
    total[0].abs() / total[1]
}

/// Convection of a divergence-free field does no work, ∫ u·N dV = 0, with every boundary, metric
/// and stretching. The divergence left is 1e-12, hence 1e-12.
#[test]
fn convection_conserves_energy() {
    for grid in plane_grids() {
        let power = convective_power(&grid);
        assert!(power < 1e-12, "{:?} {:?}: {power:e}", grid.geometry, grid.boundaries);
    }
    for grid in space_grids() {
        let power = convective_power(&grid);
        assert!(power < 1e-12, "{:?}: {power:e}", grid.boundaries);
    }
}

/// Relative asymmetry ∫ (a ∇²b − b ∇²a) dV, and the sign of ∫ a ∇²a dV.
fn laplacian_symmetry<const D: usize>(grid: &Grid<D>, d: usize) -> (f64, f64)
where
    Grid<D>: HasEngine<D>,
{
    let [mut a, mut b] = [grid.new_field(), grid.new_field()];
    Random(5).fill(grid, d, &mut a);
    Random(6).fill(grid, d, &mut b);
    fill_velocity(grid, d, &mut a);
    fill_velocity(grid, d, &mut b);
    let (la, lb) = (laplacian_of(grid, d, &a), laplacian_of(grid, d, &b));
    let (ab, ba) = (product(grid, d, &a, &lb), product(grid, d, &b, &la));
    ((ab[0] - ba[0]).abs() / ab[1], product(grid, d, &a, &la)[0])
}

/// ∫ a ∇²b dV = ∫ b ∇²a dV and ∫ a ∇²a dV < 0, to round-off of the sums.
#[test]
fn laplacian_is_symmetric_and_negative() {
    for grid in plane_grids() {
        for d in 0..2 {
            let (asymmetry, form) = laplacian_symmetry(&grid, d);
            assert!(asymmetry < 1e-13, "{:?} d={d}: {asymmetry:e}", grid.boundaries);
            assert!(form < 0.0, "{:?} d={d}: {form:e}", grid.boundaries);
        }
    }
    for grid in space_grids() {
        for d in 0..3 {
            let (asymmetry, form) = laplacian_symmetry(&grid, d);
            assert!(asymmetry < 1e-13, "{:?} d={d}: {asymmetry:e}", grid.boundaries);
            assert!(form < 0.0, "{:?} d={d}: {form:e}", grid.boundaries);
        }
    }
}

/// The control volumes of each component, with the wall halves, fill the domain exactly.
#[test]
fn control_volumes_fill_the_domain() {
    for grid in plane_grids() {
        let total: f64 = (0..grid.rows())
            .flat_map(|j| (0..grid.cells[0]).map(move |i| [i, j]))
            .map(|at| grid.cell_volume(at))
            .sum();
        for d in 0..2 {
            let mut sum = 0.0;
            for_each_unknown(&grid, d, |at, _| sum += grid.control_volume(d, at));
            if !grid.periodic(d) {
                let walls = [0, grid.cells[d]].map(|i| grid.volumes(d, d)[i]);
                let across: f64 = grid.volumes(d, 1 - d).iter().sum();
                sum += grid.turn() * across * (walls[0] + walls[1]);
            }
            // Sums of a few hundred terms.
            assert!((sum / total - 1.0).abs() < 1e-13, "{:?} d={d}", grid.boundaries);
        }
    }
}

/// Courant rate and divergence of every cell, one by one.
fn worst_of_cells<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> [f64; 2] {
    let mut worst = [0.0f64; 2];
    for row in 0..grid.rows() {
        for i in 0..grid.cells[0] {
            let at = [i, row % grid.cells[1], row / grid.cells[1]];
            let (mut rate, mut divergence) = (0.0, 0.0);
            for a in 0..D {
                let (axis, k, index) = (&grid.axes[a], at[a], grid.row(row) + i);
                let (low, high) = (velocity[a][index], velocity[a][index + grid.stride(a)]);
                rate += low.abs().max(high.abs()) / axis.widths[k];
                divergence += (axis.face_area[k + 1] * high - axis.face_area[k] * low) / axis.cell_volume[k];
            }
            worst = [worst[0].max(rate), worst[1].max(divergence.abs())];
        }
    }
    worst
}

fn health_is_that_of_the_worst_cell<const D: usize>(grids: &[Grid<D>]) {
    for grid in grids {
        let mut velocity = grid.new_vector();
        for (d, u) in velocity.iter_mut().enumerate() {
            Random(5 + d as u64).fill(grid, d, u);
            fill_velocity(grid, d, u);
        }
        let health = Health::of(grid, &velocity);
        let [rate, divergence] = worst_of_cells(grid, &velocity);
        assert!(health.finite && (health.rate / rate - 1.0).abs() < 1e-13, "{health:?} for {rate}");
        assert!((health.divergence / divergence - 1.0).abs() < 1e-12, "{health:?} for {divergence}");
        for d in 0..D {
            let mut places = Vec::new();
            for_each_unknown(grid, d, |_, index| places.push(index));
            for (index, wrong) in places.into_iter().zip([f64::NAN, f64::INFINITY].into_iter().cycle()) {
                let right = std::mem::replace(&mut velocity[d][index], wrong);
                assert!(!Health::of(grid, &velocity).finite, "{wrong} at {index} of component {d} passed");
                velocity[d][index] = right;
            }
        }
    }
}

#[test]
fn no_broken_value_passes_and_the_worst_cell_counts() {
    let narrow =
        |cells| grid([uniform(1.0, cells), uniform(1.2, 6)], [[Boundary::Periodic; 2], [Boundary::WALL; 2]]);
    health_is_that_of_the_worst_cell(&[4, 7, 8, 17].map(narrow));
    health_is_that_of_the_worst_cell(&plane_grids()[..12]);
    health_is_that_of_the_worst_cell(&space_grids()[..4]);
}
