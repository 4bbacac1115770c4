//! The step of both engines against the same step written node by node.

use crate::flow::common::{Random, SCHEMES, grid, plane_grids, space_grids, uniform};
use crate::flow::reference::{Reference, for_each_cell};
use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::engines::HasEngine;
use fluid_solver::field::{State, for_each_unknown};
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;

/// Largest difference of velocity and of pressure, each relative to its largest value.
fn differences<const D: usize>(grid: &Grid<D>, a: &State<D>, b: &State<D>) -> [f64; 2] {
    let mut u = [0.0_f64; 2];
    for d in 0..D {
        for_each_unknown(grid, d, |_, at| {
            u[0] = u[0].max((a.velocity[d][at] - b.velocity[d][at]).abs());
            u[1] = u[1].max(b.velocity[d][at].abs());
        });
    }
    let mut p = [0.0_f64; 2];
    for_each_cell(grid, |_, at| {
        p[0] = p[0].max((a.pressure[at] - b.pressure[at]).abs());
        p[1] = p[1].max(b.pressure[at].abs());
    });
    assert!(u[1] > 0.1 && p[1] > 0.0, "the flow must be alive: {u:?} {p:?}");
    [u[0] / u[1], p[0] / p[1]]
}

/// Options of the comparison.
fn options<const D: usize>(scheme: Scheme, viscous: Viscous) -> Options<D> {
    let body_force = std::array::from_fn(|d| [0.3, -0.2, 0.1][d]);
    Options { viscosity: 0.02, scheme, viscous, convection: true, body_force }
}

/// Both codes from the same divergence-free random velocity.
fn pair<const D: usize>(grid: &Grid<D>, options: &Options<D>) -> (Stepper<D>, Reference<D>)
where
    Grid<D>: HasEngine<D>,
{
    let mut stepper = Stepper::new(grid.clone(), options.clone());
    for d in 0..D {
        Random(5 + d as u64).fill(grid, d, &mut stepper.state_mut().velocity[d]);
    }
    stepper.project_velocity();
    let mut reference = Reference::new(grid, options);
    reference.state.velocity.clone_from(&stepper.state().velocity);
    (stepper, reference)
}

/// A random force.
fn random_force<const D: usize>(grid: &Grid<D>) -> [Vec<f64>; D] {
    let mut force = grid.new_vector();
    for (d, f) in force.iter_mut().enumerate() {
        Random(50 + d as u64).fill(grid, d, f);
    }
    force
}

/// Grids of [`space_grids`], and one with moving walls, stretched, cut into several slabs.
fn grids() -> Vec<Grid<3>> {
    let mut grids = space_grids();
    let move_along = |velocity| Boundary::NoSlip { velocity };
    let faces = (0..=20).map(|k: i32| f64::from(k) * 0.05 + 0.002 * f64::from(k * k)).collect();
    grids.push(grid(
        [uniform(1.0, 15), uniform(1.2, 10), AxisSpec::Faces(faces)],
        [
            [move_along([0.0, 0.5, -0.3]), Boundary::FreeSlip],
            [Boundary::WALL, move_along([0.2, 0.0, 0.4])],
            [move_along([0.7, -0.6, 0.0]), Boundary::WALL],
        ],
    ));
    grids
}

/// Grids of [`plane_grids`], and two with moving walls, in (r, z) stretched and with axes that the pressure
/// and the walls sweep the other way.
fn flat_grids() -> Vec<Grid<2>> {
    let mut grids = plane_grids();
    let move_along = |velocity| Boundary::NoSlip { velocity };
    let stretched = AxisSpec::Growing { start: 0.0, core_end: 0.4, width: 0.1, end: 2.0, cells: 11 };
    grids.push(grid(
        [stretched.clone(), uniform(1.2, 14)],
        [[move_along([0.0, 0.5]), Boundary::WALL], [Boundary::FreeSlip, move_along([-0.4, 0.0])]],
    ));
    let spec = GridSpec {
        geometry: Geometry::Axisymmetric,
        axes: [stretched, uniform(1.5, 20)],
        boundaries: [[Boundary::Axis, move_along([0.0, 0.7])], [Boundary::WALL, Boundary::FreeSlip]],
    };
    grids.push(Grid::new(&spec).expect("a valid pipe"));
    grids
}

/// Three steps of different length of both codes, for every combination of scheme and treatment of
/// viscosity, with convection and without, with a force and without; the largest differences allowed are
/// those of round-off.
fn agrees_with_the_equations<const D: usize>(
    grid: &Grid<D>,
    convection: [bool; 2],
    [most_u, most_p]: [f64; 2],
) where
    Grid<D>: HasEngine<D>,
{
    let force = random_force(grid);
    for scheme in SCHEMES {
        for viscous in [Viscous::Implicit, Viscous::Explicit] {
            for (force, convection) in [None, Some(&force)].into_iter().zip(convection) {
                let options = Options { convection, ..options(scheme, viscous) };
                let (mut fast, mut slow) = pair(grid, &options);
                for dt in [2e-3, 3e-3, 1e-3] {
                    fast.step(dt, force);
                    slow.step(dt, force, |_| ());
                }
                let [u, p] = differences(grid, fast.state(), &slow.state);
                let forced = force.is_some();
                let label = format!(
                    "{:?} {scheme:?} {viscous:?} forced {forced} convection {convection} {:?}",
                    grid.geometry, grid.boundaries
                );
                assert!(u < most_u, "{label}: velocity {u:e}");
                assert!(p < most_p, "{label}: pressure {p:e}");
            }
        }
    }
}

/// Every combination of boundaries. Sums in another order: round-off of some 20 operations.
#[test]
fn every_combination_agrees_with_the_equations() {
    for grid in grids() {
        agrees_with_the_equations(&grid, [true, true], [1e-13, 1e-12]);
    }
}

/// The same on two axes, plane and axisymmetric. The pressure is the divergence over a stage of 1e-4 s:
/// round-off of the velocity (1e-16 over cells of 0.1) makes some 1e-12 of it, and in Stokes flow it is no
/// larger than the force.
#[test]
fn every_combination_on_two_axes_agrees_with_the_equations() {
    for grid in flat_grids() {
        for convection in [[true, true], [true, false]] {
            agrees_with_the_equations(&grid, convection, [1e-13, 1e-11]);
        }
    }
}

/// What a caller does between predictor and projection sees the predictor with the pressure.
#[test]
fn forcing_before_the_projection_agrees() {
    let damp = |velocity: &mut [Vec<f64>; 3]| {
        velocity[0].iter_mut().step_by(3).for_each(|u| *u *= 0.5);
    };
    for grid in [&grids()[0], &grids()[124]] {
        for scheme in SCHEMES {
            for viscous in [Viscous::Implicit, Viscous::Explicit] {
                let (mut fast, mut slow) = pair(grid, &options(scheme, viscous));
                for dt in [2e-3, 3e-3] {
                    fast.step(dt, None);
                    slow.step(dt, None, |_| ());
                    fast.advance_without_projection(dt, None);
                    damp(&mut fast.state_mut().velocity);
                    fast.project();
                    slow.step(dt, None, damp);
                }
                let [u, p] = differences(grid, fast.state(), &slow.state);
                assert!(u < 1e-13, "{scheme:?} {viscous:?}: velocity {u:e}");
                assert!(p < 1e-12, "{scheme:?} {viscous:?}: pressure {p:e}");
            }
        }
    }
}
