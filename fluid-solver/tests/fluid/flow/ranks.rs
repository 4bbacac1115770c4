//! Planes shared among ranks: the same bits whatever their number, and those of the whole solve to round-off.

use crate::flow::common::{Random, SCHEMES, grid, uniform};
use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::field::State;
use fluid_solver::grid::Grid;
use fluid_solver::health::Health;
use fluid_solver::ranks::{Ranks, threads};
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;

/// What a run leaves.
struct Left {
    state: State<3>,
    health: Health,
    acceleration: f64,
}

/// What is run.
#[derive(Clone)]
struct Case {
    grid: Grid<3>,
    scheme: Scheme,
    viscous: Viscous,
    /// Along x.
    flow_rate: Option<f64>,
}

impl Case {
    /// Three steps from a random state under a random force; the last is projected by hand.
    fn steps(&self, grid: Grid<3>, threads: usize) -> Left {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of threads").install(|| {
            let options = Options {
                viscosity: 0.01,
                scheme: self.scheme,
                viscous: self.viscous,
                convection: true,
                body_force: [0.1, 0.2, 0.3],
            };
            let mut s = Stepper::new(grid.clone(), options);
            if let Some(mean) = self.flow_rate {
                s.prescribe_flow_rate(0, mean);
            }
            let mut force = grid.new_vector();
            for (d, force) in force.iter_mut().enumerate() {
                // The random numbers are those of the whole grid.
                Random(d as u64).fill(&self.grid, d, &mut s.state_mut().velocity[d]);
                Random(7 + d as u64).fill(&self.grid, d, force);
            }
            s.project_velocity();
            (0..2).for_each(|_| s.step(1e-3, Some(&force)));
            s.advance_without_projection(1e-3, Some(&force));
            s.project();
            assert!(!s.is_broken());
            grid.division.ranks().check().expect("every exchange went well");
            let health = Health::of(&grid, &s.state().velocity);
            let acceleration = s.flow_rate().map_or(0.0, |rate| rate.acceleration());
            Left { state: s.state().clone(), health, acceleration }
        })
    }

    /// The same by several ranks, each with its own threads: the planes of each, put together.
    fn shared(&self, size: usize, threads_each: usize) -> Left {
        let run = |ranks: Ranks| {
            let grid = self.grid.clone().divided(ranks).expect("enough blocks");
            let own = grid.division.own();
            (own, self.steps(grid, threads_each))
        };
        let mut parts = threads::together(size, run);
        let (_, mut all) = parts.remove(0);
        for (own, part) in parts {
            assert_eq!((part.health, part.acceleration), (all.health, all.acceleration));
            let place = self.grid.planes(own.start as isize, own.end as isize);
            for (to, from) in fields_mut(&mut all.state).into_iter().zip(fields(&part.state)) {
                to[place.clone()].copy_from_slice(&from[place.clone()]);
            }
        }
        all
    }
}

fn fields(state: &State<3>) -> Vec<&Vec<f64>> {
    state.velocity.iter().chain(&state.history).chain([&state.pressure]).collect()
}

fn fields_mut(state: &mut State<3>) -> Vec<&mut Vec<f64>> {
    state.velocity.iter_mut().chain(&mut state.history).chain([&mut state.pressure]).collect()
}

/// Largest difference of any field at the cells, and whether all bits agree there.
fn compare(grid: &Grid<3>, a: &Left, b: &Left) -> (f64, bool) {
    let (mut largest, mut same) = (0.0_f64, a.acceleration == b.acceleration);
    for (a, b) in fields(&a.state).into_iter().zip(fields(&b.state)) {
        for row in 0..grid.rows() {
            let at = grid.row(row)..grid.row(row) + grid.cells[0];
            for (a, b) in a[at.clone()].iter().zip(&b[at]) {
                largest = largest.max((a - b).abs());
                same &= a.to_bits() == b.to_bits();
            }
        }
    }
    (largest, same)
}

fn grids() -> Vec<Grid<3>> {
    let [p, w, s] = [Boundary::Periodic, Boundary::WALL, Boundary::FreeSlip].map(|face| [face; 2]);
    let faces = (0..=44).map(|k: i32| f64::from(k) * 0.02 + 1e-4 * f64::from(k * k)).collect();
    let axes = |z| [uniform(1.0, 40), uniform(1.0, 42), z];
    let moving = [Boundary::NoSlip { velocity: [0.5, -0.2, 0.0] }, Boundary::WALL];
    vec![
        grid(axes(uniform(1.0, 44)), [p, p, moving]),
        grid(axes(uniform(1.0, 33)), [p, w, p]),
        grid(axes(AxisSpec::Faces(faces)), [p, s, [Boundary::FreeSlip, Boundary::WALL]]),
    ]
}

/// 1 to 4 ranks, with 1 and 2 threads each: walled and periodic along z, equal and stretched cells, every
/// scheme, both treatments of viscosity, with and without a prescribed flow rate.
#[test]
fn ranks_do_not_change_a_bit() {
    for grid in grids() {
        for scheme in SCHEMES {
            for viscous in [Viscous::Implicit, Viscous::Explicit] {
                for flow_rate in [None, Some(0.3)] {
                    let case = Case { grid: grid.clone(), scheme, viscous, flow_rate };
                    let blocks = grid.clone().divided(Ranks::alone()).expect("enough planes");
                    let one = case.steps(blocks, 1);
                    for (size, threads) in [(2, 1), (3, 2), (4, 1)] {
                        let several = case.shared(size, threads);
                        let (largest, same) = compare(&grid, &several, &one);
                        assert!(
                            same,
                            "{size} ranks, {scheme:?}, {viscous:?}, {:?}: {largest:e}",
                            grid.boundaries
                        );
                        assert_eq!(several.health, one.health);
                    }
                }
            }
        }
    }
}

/// 512 planes are shared by up to 64 ranks, by a number that no power of two is, too.
#[test]
fn sixty_four_ranks_share_512_planes() {
    let [p, w] = [Boundary::Periodic, Boundary::WALL].map(|face| [face; 2]);
    for ends in [p, w] {
        let grid = grid([uniform(1.0, 8), uniform(1.0, 8), uniform(64.0, 512)], [p, p, ends]);
        let [scheme, ..] = SCHEMES;
        let case = Case { grid: grid.clone(), scheme, viscous: Viscous::Implicit, flow_rate: Some(0.3) };
        let one = case.steps(grid.clone().divided(Ranks::alone()).expect("enough planes"), 1);
        for size in [23, 64] {
            let (largest, same) = compare(&grid, &case.shared(size, 1), &one);
            assert!(same, "{size} ranks, {ends:?}: {largest:e}");
        }
        let (largest, _) = compare(&grid, &case.steps(grid.clone(), 1), &one);
        assert!(largest < 1e-9, "{ends:?}: {largest:e}");
    }
}

/// Blocks solve the same equations: three steps from a random state of size 1 differ by round-off, which the
/// pressure (of size 1e3 after so rough a start) shows most.
#[test]
fn blocks_solve_what_the_whole_solves() {
    for grid in grids() {
        for viscous in [Viscous::Implicit, Viscous::Explicit] {
            let case = Case { grid: grid.clone(), scheme: SCHEMES[0], viscous, flow_rate: None };
            let blocks = grid.clone().divided(Ranks::alone()).expect("enough planes");
            let (largest, same) = compare(&grid, &case.steps(blocks, 1), &case.steps(grid.clone(), 1));
            assert!(largest < 1e-9 && !same, "{viscous:?} {:?}: {largest:e}", grid.boundaries);
        }
    }
}

/// What a rank sends in a step, beside what it works on: a few planes, and the edges of the blocks.
#[test]
fn little_is_sent() {
    let grid = grids().remove(0);
    let case = Case { grid: grid.clone(), scheme: SCHEMES[0], viscous: Viscous::Explicit, flow_rate: None };
    let sent = threads::together(4, |ranks| {
        let before = ranks.traffic();
        case.steps(grid.clone().divided(ranks.clone()).expect("enough blocks"), 1);
        (before, ranks.traffic())
    });
    for (before, after) in sent {
        assert_eq!(before.bytes, 0);
        // Nine stages and the start; a slab has 11 planes of 48 × 44 values.
        let field = 11.0 * 48.0 * 44.0 * 8.0;
        let per_stage = after.bytes as f64 / (10.0 * field);
        assert!(per_stage > 0.1 && per_stage < 3.0, "{per_stage} fields in each stage");
    }
}
