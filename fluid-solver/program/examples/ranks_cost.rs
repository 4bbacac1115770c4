//! Cost of the solve in blocks and of the exchange between ranks:
//! `cargo run --release -p bedload-fluid --example ranks_cost -- [CELLS]`. Ranks are threads of this process;
//! built with `--features mpi` and started by `mpirun`, they are its processes, and only their number is
//! measured.
//!
//! - messages: half the time of one that goes from rank 0 to rank 1 and back, by its length;
//! - strong: a channel and a periodic box of CELLS³ for all ranks together;
//! - weak: 64³ cells for each rank, one slab upon the other.

#[cfg(feature = "mpi")]
#[path = "../src/mpi.rs"]
mod mpi;

use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::field::set_component;
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::ranks::{Ranks, threads};
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;
use fluid_solver::work::Work;
use std::time::Instant;

/// Steps before and while it is measured.
const STEPS: [usize; 2] = [3, 10];

/// Numbers of a message, and how often it goes and comes.
const MESSAGES: [(usize, usize); 5] =
    [(1, 4000), (1 << 7, 4000), (1 << 11, 1000), (1 << 15, 200), (1 << 19, 40)];

/// Cells of each rank along each axis where there are more cells with more ranks.
const EACH: usize = 64;

/// Viscosity and ends along z.
const CASES: [(&str, Boundary<3>); 2] = [("channel", Boundary::WALL), ("periodic", Boundary::Periodic)];

/// What a rank measured: CPU and wall time of all, s per step; messages and bytes of its own per step.
type Cost = [f64; 4];

fn measure(grid: &Grid<3>, viscous: Viscous, ranks: &Ranks) -> Cost {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread").install(|| {
        let options = Options {
            viscosity: 1e-3,
            scheme: Scheme::RungeKutta3,
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
        ranks.check().expect("every exchange went well");
        let (messages, bytes) = (after.messages - before.messages, after.bytes - before.bytes);
        [begin.seconds(), clock.elapsed().as_secs_f64(), messages as f64, bytes as f64]
            .map(|total| total / STEPS[1] as f64)
    })
}

/// Seconds of one way, by [`MESSAGES`]: medians over trips. Ranks but the first two wait.
fn one_way(ranks: &Ranks) -> Vec<f64> {
    let me = ranks.rank();
    let trip = |numbers: &mut [f64]| {
        let begin = Instant::now();
        for sender in [0, 1] {
            if me == sender {
                ranks.exchange(&[(1 - me, &*numbers)], &mut []);
            } else {
                ranks.exchange(&[], &mut [(1 - me, &mut *numbers)]);
            }
        }
        0.5 * begin.elapsed().as_secs_f64()
    };
    let measure = |&(length, count): &(usize, usize)| {
        let mut numbers = vec![1.0; length];
        let mut times: Vec<f64> = (0..count).map(|_| trip(&mut numbers)).collect();
        times.sort_by(f64::total_cmp);
        times[count / 2]
    };
    if me < 2 { MESSAGES.iter().map(measure).collect() } else { Vec::new() }
}

fn print_messages(over: &str, seconds: &[f64]) {
    for ((length, _), seconds) in MESSAGES.iter().zip(seconds) {
        let bytes = 8 * length;
        println!(
            "message over {over}, {bytes:>8} bytes: {:>8.2} µs, {:>6.2} GB/s",
            seconds * 1e6,
            bytes as f64 / seconds * 1e-9
        );
    }
}

fn grid([across, along]: [usize; 2], ends: Boundary<3>) -> Grid<3> {
    let axis = |cells: usize| AxisSpec::Uniform { start: 0.0, end: cells as f64 / across as f64, cells };
    let spec = GridSpec {
        geometry: Geometry::Space,
        axes: [axis(across), axis(across), axis(along)],
        boundaries: [[Boundary::Periodic; 2], [Boundary::Periodic; 2], [ends; 2]],
    };
    Grid::new(&spec).expect("the benchmark's grid is valid")
}

fn print(what: &str, grid: &Grid<3>, viscous: Viscous, [cpu, wall, messages, bytes]: Cost) {
    let (per_cell, [x, y, z]) = (1e9 / grid.cell_count() as f64, grid.cells);
    println!(
        "{what:<28} {x}x{y}x{z}, {viscous:?}: {:>6.1} ns CPU per cell and step, wall {:>6.1}, a rank sends \
         {messages:>3} messages, {:>8.1} kB a step",
        cpu * per_cell,
        wall * per_cell,
        bytes * 1e-3
    );
}

/// All that is measured with `ranks`, printed by the first of them. `each`: whether each is a process, which
/// knows its own CPU time alone.
fn shared(cells: usize, ranks: &Ranks, each: bool) {
    for (name, ends) in CASES {
        for viscous in [Viscous::Explicit, Viscous::Implicit] {
            for (kind, size) in [("strong", [cells, cells]), ("weak", [EACH, EACH * ranks.size()])] {
                let whole = grid(size, ends);
                let grid = whole.clone().divided(ranks.clone()).expect("enough blocks");
                let mut cost = measure(&grid, viscous, ranks);
                if each {
                    ranks.combine(&mut cost[..1], |sum, other| sum + other);
                }
                if ranks.is_first() {
                    print(&format!("{kind}, {name}, {} rank(s)", ranks.size()), &whole, viscous, cost);
                }
            }
        }
    }
}

fn by_threads(cells: usize) {
    let times = threads::together(2, |ranks| one_way(&ranks));
    print_messages("threads", &times[0]);
    for (name, ends) in CASES {
        for viscous in [Viscous::Explicit, Viscous::Implicit] {
            let grid = grid([cells, cells], ends);
            print(&format!("whole, {name}"), &grid, viscous, measure(&grid, viscous, &Ranks::alone()));
        }
    }
    for size in [1, 2, 4] {
        threads::together(size, |ranks| shared(cells, &ranks, false));
    }
}

#[cfg(feature = "mpi")]
fn by_mpi(cells: usize) -> bool {
    let Some((_universe, ranks)) = mpi::start().expect("MPI starts") else {
        return false;
    };
    let times = one_way(&ranks);
    if ranks.is_first() {
        print_messages("MPI", &times);
    }
    shared(cells, &ranks, true);
    true
}

#[cfg(not(feature = "mpi"))]
fn by_mpi(_: usize) -> bool {
    false
}

fn main() {
    let cells = std::env::args().nth(1).and_then(|cells| cells.parse().ok()).unwrap_or(64);
    if !by_mpi(cells) {
        by_threads(cells);
    }
}
