//! Cost of the solve in blocks and of the exchange between ranks: `cargo run --release -p bedload-fluid --example
//! ranks_cost -- [CELLS]`, for a channel and a periodic box of CELLS³, ranks being threads of this process.

use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::field::set_component;
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::ranks::{Ranks, threads};
use fluid_solver::scheme::{Options, Projections, Scheme, Viscous};
use fluid_solver::step::Stepper;
use fluid_solver::work::Work;
use std::time::Instant;

/// Steps before and while it is measured.
const STEPS: [usize; 2] = [3, 10];

/// What a rank measured: CPU and wall time of all, s per step; messages and bytes of its own per step.
type Cost = [f64; 4];

fn measure(grid: &Grid<3>, viscous: Viscous, ranks: &Ranks) -> Cost {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread").install(|| {
        let options = Options {
            viscosity: 1e-3,
            scheme: Scheme::RungeKutta3 { projections: Projections::EveryStage },
            viscous,
            convection: true,
            body_force: [0.0; 3],
        };
        let mut stepper = Stepper::new(grid.clone(), options);
        for d in 0..3 {
            let u = &mut stepper.state_mut().velocity[d];
            set_component(grid, d, u, |x| (3.0 * x[0] + d as f64).sin() * (5.0 * x[2]).cos());
        }
        stepper.project_velocity();
        let dt = 0.2 * grid.smallest_width();
        (0..STEPS[0]).for_each(|_| stepper.step(dt, None));
        let (begin, clock, before) = (Work::begin(), Instant::now(), ranks.traffic());
        (0..STEPS[1]).for_each(|_| stepper.step(dt, None));
        let after = ranks.traffic();
        let (messages, bytes) = (after.messages - before.messages, after.bytes - before.bytes);
        [begin.seconds(), clock.elapsed().as_secs_f64(), messages as f64, bytes as f64]
            .map(|total| total / STEPS[1] as f64)
    })
}

fn main() {
    let n = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(64);
    for (name, ends) in [("channel", Boundary::WALL), ("periodic", Boundary::Periodic)] {
        let spec = GridSpec {
            geometry: Geometry::Space,
            axes: std::array::from_fn(|_| AxisSpec::Uniform { start: 0.0, end: 1.0, cells: n }),
            boundaries: [[Boundary::Periodic; 2], [Boundary::Periodic; 2], [ends; 2]],
        };
        let grid = Grid::new(&spec).expect("the benchmark's grid is valid");
        for viscous in [Viscous::Explicit, Viscous::Implicit] {
            let print = |what: &str, [cpu, wall, messages, bytes]: Cost| {
                let per_cell = 1e9 / grid.cell_count() as f64;
                println!(
                    "{name} {n}^3, {viscous:?}, {what:<12} {:>6.1} ns CPU per cell, wall {:>6.1}, a rank sends \
                     {messages:>3} messages, {:>8.1} kB a step",
                    cpu * per_cell,
                    wall * per_cell,
                    bytes * 1e-3
                );
            };
            print("whole", measure(&grid, viscous, &Ranks::alone()));
            for size in [1, 2, 4] {
                let costs = threads::together(size, |ranks| {
                    let grid = grid.clone().divided(ranks.clone()).expect("enough blocks");
                    measure(&grid, viscous, &ranks)
                });
                print(&format!("{size} rank(s)"), costs[size / 2]);
            }
        }
    }
}
