//! Same bits: whatever the number of threads, and after a restore.

use crate::flow::common::{Random, SCHEMES, assert_same, grid, pipe, put_back, stepper, uniform};
use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::engines::HasEngine;
use fluid_solver::field::State;
use fluid_solver::grid::Grid;
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;

/// Three steps from a random state on a pool of `threads`.
fn run<const D: usize>(grid: &Grid<D>, scheme: Scheme, threads: usize) -> State<D>
where
    Grid<D>: HasEngine<D>,
{
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of threads").install(|| {
        let mut s = stepper(grid.clone(), 0.01, scheme);
        for d in 0..D {
            Random(d as u64).fill(grid, d, &mut s.state_mut().velocity[d]);
        }
        (0..3).for_each(|_| s.step(1e-3, None));
        s.state().clone()
    })
}

/// 1, 2 and 4 threads agree bit for bit (grids large enough that four threads do take part).
#[test]
fn threads_do_not_change_a_bit() {
    let p = [Boundary::Periodic; 2];
    let w = [Boundary::WALL, Boundary::FreeSlip];
    let tube = pipe(uniform(1.0, 200), uniform(2.0, 360));
    let walls = grid([uniform(1.0, 300), uniform(1.0, 250)], [w, w]);
    let across = grid([uniform(1.0, 256), uniform(1.0, 256)], [p, w]);
    for scheme in SCHEMES {
        for plane in [&tube, &walls, &across] {
            let one = run(plane, scheme, 1);
            for threads in [2, 4] {
                assert_same(&run(plane, scheme, threads), &one);
            }
        }
    }
}

/// The same in space, where threads share planes: 1, 2, 3 and 4, walled and periodic along z, equal
/// and stretched cells, both treatments of viscosity, with a force.
#[test]
fn threads_do_not_change_a_bit_in_space() {
    let [p, w, s] = [Boundary::Periodic, Boundary::WALL, Boundary::FreeSlip].map(|face| [face; 2]);
    let faces = (0..=44).map(|k: i32| f64::from(k) * 0.02 + 1e-4 * f64::from(k * k)).collect();
    let [x, y, z] = [uniform(1.0, 40), uniform(1.0, 42), uniform(1.0, 44)];
    let grids = [
        grid([x.clone(), y.clone(), z.clone()], [p, w, s]),
        grid([x.clone(), y.clone(), z], [w, p, p]),
        grid([x, y, AxisSpec::Faces(faces)], [p, s, w]),
    ];
    for grid in &grids {
        for scheme in SCHEMES {
            for viscous in [Viscous::Implicit, Viscous::Explicit] {
                let one = run_in_space(grid, scheme, viscous, 1);
                for threads in [2, 3, 4] {
                    assert_same(&run_in_space(grid, scheme, viscous, threads), &one);
                }
            }
        }
    }
}

/// Three steps in space from a random state under a random force.
fn run_in_space(grid: &Grid<3>, scheme: Scheme, viscous: Viscous, threads: usize) -> State<3> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of threads").install(|| {
        let options =
            Options { viscosity: 0.01, scheme, viscous, convection: true, body_force: [0.1, 0.2, 0.3] };
        let mut s = Stepper::new(grid.clone(), options);
        let mut force = grid.new_vector();
        for (d, force) in force.iter_mut().enumerate() {
            Random(d as u64).fill(grid, d, &mut s.state_mut().velocity[d]);
            Random(7 + d as u64).fill(grid, d, force);
        }
        s.project_velocity();
        (0..3).for_each(|_| s.step(1e-3, Some(&force)));
        s.state().clone()
    })
}

/// A restored state goes on with the same bits, the Adams–Bashforth history included.
#[test]
fn restored_state_repeats_its_future() {
    for scheme in SCHEMES {
        let mut s = stepper(pipe(uniform(1.0, 12), uniform(1.0, 16)), 0.01, scheme);
        let g = s.grid().clone();
        Random(9).fill(&g, 1, &mut s.state_mut().velocity[1]);
        (0..3).for_each(|_| s.step(0.01, None));
        let saved = s.state().clone();
        (0..3).for_each(|_| s.step(0.02, None));
        let first = s.state().clone();
        put_back(&mut s, &saved);
        (0..3).for_each(|_| s.step(0.02, None));
        assert_eq!(*s.state(), first);
    }
}

/// The same in space, into a stepper that has never seen the state: nothing is hidden elsewhere.
#[test]
fn restored_state_repeats_its_future_in_space() {
    let g = grid(
        [uniform(1.0, 12), uniform(1.0, 10), uniform(1.0, 16)],
        [[Boundary::Periodic; 2], [Boundary::FreeSlip; 2], [Boundary::WALL; 2]],
    );
    for scheme in SCHEMES {
        for viscous in [Viscous::Implicit, Viscous::Explicit] {
            let options =
                Options { viscosity: 0.01, scheme, viscous, convection: true, body_force: [0.1, 0.2, 0.3] };
            let mut s = Stepper::new(g.clone(), options.clone());
            Random(9).fill(&g, 1, &mut s.state_mut().velocity[1]);
            (0..3).for_each(|_| s.step(0.01, None));
            let mut other = Stepper::new(g.clone(), options);
            put_back(&mut other, s.state());
            for stepper in [&mut s, &mut other] {
                (0..3).for_each(|_| stepper.step(0.02, None));
            }
            assert_same(s.state(), other.state());
        }
    }
}

/// Splitting the step into predictor and projection changes nothing if nothing is done between.
#[test]
fn split_step_equals_whole_step() {
    for scheme in SCHEMES {
        let make = || {
            let mut s = stepper(pipe(uniform(1.0, 12), uniform(1.0, 16)), 0.01, scheme);
            let g = s.grid().clone();
            Random(9).fill(&g, 1, &mut s.state_mut().velocity[1]);
            s
        };
        let (mut whole, mut split) = (make(), make());
        for _ in 0..3 {
            whole.step(0.01, None);
            split.advance_without_projection(0.01, None);
            split.project();
        }
        assert_eq!(whole.state(), split.state());
    }
}
