//! Each term of the momentum equation as the engines compute it, against the same term by itself.
//!
//! One stage of Adams–Bashforth from rest (γ = 1, ζ = 0, α = ½) with explicit viscosity leaves N in the
//! history, and u* − u = dt (N + f − ∇p).

use crate::flow::common::{Random, plane_grids, space_grids};
use crate::flow::reference::{convection, gradient, laplacian};
use fluid_solver::engines::HasEngine;
use fluid_solver::field::for_each_unknown;
use fluid_solver::grid::Grid;
use fluid_solver::halo::{fill_scalar, fill_velocity};
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;

/// Viscosity, m²/s: with cells of about 0.1 convection and viscosity are of one size.
const NU: f64 = 0.05;

/// A velocity of size 1, halos filled.
fn random_velocity<const D: usize>(grid: &Grid<D>) -> [Vec<f64>; D] {
    let mut velocity = grid.new_vector();
    for (d, u) in velocity.iter_mut().enumerate() {
        Random(31 + d as u64).fill(grid, d, u);
        fill_velocity(grid, d, u);
    }
    velocity
}

/// One predictor of length 1.
fn predicted<const D: usize>(
    grid: &Grid<D>,
    [viscosity, force]: [f64; 2],
    convection: bool,
    fields: (&[Vec<f64>; D], &[f64]),
    forces: Option<&[Vec<f64>; D]>,
) -> Stepper<D>
where
    Grid<D>: HasEngine<D>,
{
    let options = Options {
        viscosity,
        scheme: Scheme::AdamsBashforth2,
        viscous: Viscous::Explicit,
        convection,
        body_force: std::array::from_fn(|d| force * (d + 1) as f64),
    };
    let mut stepper = Stepper::new(grid.clone(), options);
    stepper.state_mut().velocity.clone_from(fields.0);
    stepper.state_mut().pressure.copy_from_slice(fields.1);
    stepper.advance_without_projection(1.0, forces);
    stepper
}

/// Asserts that two fields of component `d` agree to `1e-13` of the largest value: sums of some 20 terms.
fn assert_agree<const D: usize>(what: &str, grid: &Grid<D>, d: usize, found: &[f64], expected: &[f64]) {
    let (mut largest, mut worst) = (0.0_f64, 0.0_f64);
    for_each_unknown(grid, d, |_, at| {
        largest = largest.max(expected[at].abs());
        worst = worst.max((found[at] - expected[at]).abs());
    });
    let label = format!("{what}, component {d}, {:?} {:?}", grid.geometry, grid.boundaries);
    assert!(largest > 0.0, "{label}: nothing to compare");
    assert!(worst < 1e-13 * largest, "{label}: {:e} of the largest", worst / largest);
}

fn combined(a: &[f64], b: &[f64], weight: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + weight * b).collect()
}

fn convection_and_viscosity<const D: usize>(grid: &Grid<D>)
where
    Grid<D>: HasEngine<D>,
{
    let (u, p) = (random_velocity(grid), grid.new_field());
    let back = u.each_ref().map(|u| u.iter().map(|u| -u).collect::<Vec<_>>());
    let n = |nu, convection, u: &[Vec<f64>; D]| {
        predicted(grid, [nu, 0.0], convection, (u, &p), None).state().history.clone()
    };
    let (alone, both, reversed, stokes) =
        (n(0.0, true, &u), n(NU, true, &u), n(NU, true, &back), n(NU, false, &u));
    for d in 0..D {
        assert_agree("convection", grid, d, &alone[d], &convection(grid, d, &u));
        // N is the sum of a part that is even in u and of one that is odd.
        let odd: Vec<_> = combined(&both[d], &reversed[d], -1.0).iter().map(|n| n / (2.0 * NU)).collect();
        let even: Vec<_> = combined(&both[d], &reversed[d], 1.0).iter().map(|n| 0.5 * n).collect();
        let viscosity = laplacian(grid, d, &u[d]);
        assert_agree("convection beside viscosity", grid, d, &even, &alone[d]);
        assert_agree("viscosity beside convection", grid, d, &odd, &viscosity);
        let stokes: Vec<_> = stokes[d].iter().map(|n| n / NU).collect();
        assert_agree("viscosity without convection", grid, d, &stokes, &viscosity);
    }
}

fn pressure_and_forces<const D: usize>(grid: &Grid<D>)
where
    Grid<D>: HasEngine<D>,
{
    let (rest, mut p, mut forces) = (grid.new_vector(), grid.new_field(), grid.new_vector());
    let mut random = Random(77);
    crate::flow::reference::for_each_cell(grid, |_, at| p[at] = random.next());
    fill_scalar(grid, &mut p);
    for (d, force) in forces.iter_mut().enumerate() {
        Random(40 + d as u64).fill(grid, d, force);
    }
    for convection in [true, false] {
        let of = |force, p: &[f64], forces| {
            predicted(grid, [NU, force], convection, (&rest, p), forces).state().velocity.clone()
        };
        let none = grid.new_field();
        let (pressure, body, given) =
            (of(0.0, &p, None), of(2.5, &none, None), of(0.0, &none, Some(&forces)));
        for d in 0..D {
            let slope: Vec<_> = gradient(grid, d, &p).iter().map(|slope| -slope).collect();
            assert_agree("pressure", grid, d, &pressure[d], &slope);
            let uniform = vec![2.5 * (d + 1) as f64; slope.len()];
            assert_agree("body force", grid, d, &body[d], &uniform);
            assert_agree("force of the caller", grid, d, &given[d], &forces[d]);
        }
    }
}

#[test]
fn convection_and_viscosity_are_the_printed_terms() {
    plane_grids().iter().for_each(convection_and_viscosity);
    space_grids().iter().for_each(convection_and_viscosity);
}

#[test]
fn pressure_and_forces_are_the_printed_terms() {
    plane_grids().iter().for_each(pressure_and_forces);
    space_grids().iter().for_each(pressure_and_forces);
}
