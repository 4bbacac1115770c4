//! The direct solver against the discrete operators it inverts, for every kind of boundary.

use crate::flow::common::{Random, laplacian_of, plane_grids, space_grids};
use crate::flow::reference::largest_divergence;
use crate::flow::reference::{divergence, for_each_cell, gradient};
use fluid_solver::engines::HasEngine;
use fluid_solver::field::for_each_unknown;
use fluid_solver::grid::Grid;
use fluid_solver::halo::{fill_scalar, fill_velocity};
use fluid_solver::helmholtz::{Helmholtz, Unknown, Write};
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;

/// Largest |x − c ∇²x − b| over the unknowns of component `d`, for a random b of size 1.
fn viscous_residual<const D: usize>(grid: &Grid<D>, d: usize, c: f64) -> f64
where
    Grid<D>: HasEngine<D>,
{
    let mut b = grid.new_field();
    Random(7 + d as u64).fill(grid, d, &mut b);
    let mut x = grid.new_field();
    let mut solver = Helmholtz::new(grid, Unknown::Component(d));
    solver.solve(grid, [1.0, c], &mut b.clone(), &mut x, Write::Set);
    fill_velocity(grid, d, &mut x);
    let (laplacian, mut worst) = (laplacian_of(grid, d, &x), 0.0_f64);
    for_each_unknown(grid, d, |_, at| worst = worst.max((x[at] - c * laplacian[at] - b[at]).abs()));
    worst
}

/// x − c ∇²x = b holds to round-off: the solution is of size 1 and c ∇² amplifies it at most by
/// 4c Σ 1/Δx² (about 4000 for the smallest cells here), hence 1e-12.
#[test]
fn viscous_solve_inverts_the_discrete_operator() {
    for c in [1e-3, 0.7] {
        for grid in plane_grids() {
            for d in 0..2 {
                let residual = viscous_residual(&grid, d, c);
                assert!(residual < 1e-12, "{:?} d={d} c={c}: {residual:e}", grid.boundaries);
            }
        }
        for grid in space_grids() {
            for d in 0..3 {
                let residual = viscous_residual(&grid, d, c);
                assert!(residual < 1e-12, "{:?} d={d} c={c}: {residual:e}", grid.boundaries);
            }
        }
    }
}

/// Divergence after making a random velocity of size 1 divergence-free, and after one whole step.
fn divergence_left<const D: usize>(grid: Grid<D>, scheme: Scheme) -> [f64; 2]
where
    Grid<D>: HasEngine<D>,
{
    let options = Options {
        viscosity: 0.01,
        scheme,
        viscous: Viscous::Implicit,
        convection: true,
        body_force: [0.3; D],
    };
    let mut stepper = Stepper::new(grid, options);
    let grid = stepper.grid().clone();
    for d in 0..D {
        Random(1 + d as u64).fill(&grid, d, &mut stepper.state_mut().velocity[d]);
    }
    stepper.project_velocity();
    let first = largest_divergence(&grid, &stepper.state().velocity);
    stepper.step(0.01, None);
    [first, largest_divergence(&grid, &stepper.state().velocity)]
}

/// ∇·u = 0 after every projection. A divergence of size 1/Δx ≈ 30 is removed; 1e-12 is 3e-14 of it.
#[test]
fn divergence_is_round_off_for_every_combination_of_boundaries() {
    for scheme in crate::flow::common::SCHEMES {
        for grid in plane_grids() {
            let boundaries = grid.boundaries;
            let left = divergence_left(grid, scheme);
            assert!(left.iter().all(|d| *d < 1e-12), "{boundaries:?}: {left:?}");
        }
        for grid in space_grids() {
            let boundaries = grid.boundaries;
            let left = divergence_left(grid, scheme);
            assert!(left.iter().all(|d| *d < 1e-12), "{boundaries:?}: {left:?}");
        }
    }
}

/// ∇²p = b with zero mean of p, where b = ∇²q for a random q: p = q − mean(q).
#[test]
fn pressure_solve_has_zero_mean() {
    for grid in plane_grids() {
        let mut q = grid.new_field();
        let mut random = Random(3);
        let (mut mean, mut volume) = (0.0, 0.0);
        for row in 0..grid.rows() {
            for i in 0..grid.cells[0] {
                let v = grid.cell_volume([i, row]);
                q[grid.row(row) + i] = random.next();
                mean += v * q[grid.row(row) + i];
                volume += v;
            }
        }
        fill_scalar(&grid, &mut q);
        let mut slopes: [Vec<f64>; 2] = std::array::from_fn(|d| gradient(&grid, d, &q));
        for (d, slope) in slopes.iter_mut().enumerate() {
            fill_velocity(&grid, d, slope);
        }
        let (mut b, mut p) = (divergence(&grid, &slopes), grid.new_field());
        let mut solver = Helmholtz::new(&grid, Unknown::Pressure);
        solver.solve(&grid, [0.0, -1.0], &mut b, &mut p, Write::Set);
        for_each_cell(&grid, |_, index| {
            // Condition number of the Neumann operator here ≤ 1e3, p of size 1.
            let wrong = (p[index] - q[index] + mean / volume).abs();
            assert!(wrong < 1e-11, "{:?}: {wrong:e}", grid.boundaries);
        });
    }
}
