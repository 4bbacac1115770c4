//! Cost of one step on one core: ns per cell and step.
//!
//! CPU time of the process over all threads (median of five runs), so a busy machine disturbs it
//! little; least wall time of them; resident bytes per cell. In space also the bound: the bytes that
//! the sweeps must move between memory and core, over what a triad moves in this very run.
//!
//! `cargo run --release -p bedload-fluid-solver --example step_cost [-- THREADS [PART OF A NAME]]`

use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::engines::HasEngine;
use fluid_solver::field::set_component;
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;
use fluid_solver::work::Work;
use std::time::Instant;

fn uniform(length: f64, cells: usize) -> AxisSpec {
    AxisSpec::Uniform { start: 0.0, end: length, cells }
}

/// (r, z) between walls, or periodic along z.
fn tube(cells: [usize; 2], ends: Boundary<2>) -> GridSpec<2> {
    GridSpec {
        geometry: Geometry::Axisymmetric,
        axes: [uniform(1.0, cells[0]), uniform(2.0, cells[1])],
        boundaries: [[Boundary::Axis, Boundary::FreeSlip], [ends; 2]],
    }
}

/// A channel or a periodic box in the plane.
fn plane(cells: [usize; 2], walls: Boundary<2>) -> GridSpec<2> {
    GridSpec {
        geometry: Geometry::Plane,
        axes: [uniform(1.0, cells[0]), uniform(1.0, cells[1])],
        boundaries: [[Boundary::Periodic; 2], [walls; 2]],
    }
}

/// A channel or a periodic box in space.
fn space(cells: [usize; 3], walls: Boundary<3>) -> GridSpec<3> {
    GridSpec {
        geometry: Geometry::Space,
        axes: cells.map(|n| uniform(n as f64 / cells[2] as f64, n)),
        boundaries: [[Boundary::Periodic; 2], [Boundary::Periodic; 2], [walls; 2]],
    }
}

/// Resident memory of the process, bytes.
fn resident() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split(' ')
        .nth(1)
        .and_then(|pages| pages.parse::<f64>().ok())
        .map_or(f64::NAN, |pages| pages * 4096.0)
}

/// Bytes per second of `a = b + s c` over arrays of 64 MB, one thread, reading before each write
/// included (32 B per value).
fn triad() -> f64 {
    let n = 8_000_000;
    let (mut a, b, c) = (vec![0.0_f64; n], vec![1.0; n], vec![2.0; n]);
    let run = |_| {
        let begin = Work::begin();
        for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
            *a = b + 3.0 * c;
        }
        std::hint::black_box(&mut a);
        32.0 * n as f64 / begin.seconds()
    };
    (0..5).map(run).fold(0.0, f64::max)
}

/// Values per cell and step that must cross between memory and core in space if each sweep reads
/// and writes each field once; a write alone counts twice, as its line is read before.
fn values_moved(scheme: Scheme, viscous: Viscous) -> Option<f64> {
    match (scheme, viscous) {
        // Velocity 6, N 6 or 3, φ 2 in a stage and once more in the columns; 8 to end the step.
        (Scheme::RungeKutta3, Viscous::Explicit) => Some(14.0 + 14.0 + 11.0 + 3.0 * 2.0 + 8.0),
        (Scheme::AdamsBashforth2, Viscous::Explicit) => Some(14.0 + 2.0 + 8.0),
        // Per stage also increments 6, columns 6, and a sweep of 14 that adds them.
        (Scheme::RungeKutta3, Viscous::Implicit) => {
            Some(16.0 + 20.0 + 17.0 + 3.0 * (6.0 + 14.0 + 2.0) + 10.0)
        }
        (Scheme::AdamsBashforth2, Viscous::Implicit) => None,
    }
}

/// Median of five timed runs.
fn measure<const D: usize>(name: &str, spec: &GridSpec<D>, scheme: Scheme, viscous: Viscous)
where
    Grid<D>: HasEngine<D>,
{
    if std::env::args().nth(2).is_some_and(|part| !name.contains(&part)) {
        return;
    }
    let grid = Grid::new(spec).expect("the benchmark's grid is valid");
    let cells = grid.cell_count();
    let options = Options { viscosity: 1e-3, scheme, viscous, convection: true, body_force: [0.0; D] };
    let before = resident();
    let mut stepper = Stepper::new(grid.clone(), options);
    for d in 0..D {
        let u = &mut stepper.state_mut().velocity[d];
        set_component(&grid, d, u, |x| (3.0 * x[0] + d as f64).sin() * (5.0 * x[D - 1]).cos());
    }
    stepper.project_velocity();
    let dt = 0.2 * grid.smallest_width();
    (0..3).for_each(|_| stepper.step(dt, None));
    let memory = (resident() - before) / cells as f64;
    let steps = (10_000_000 / cells).clamp(2, 2000);
    let mut wall = f64::INFINITY;
    let mut costs: Vec<f64> = (0..5)
        .map(|_| {
            let (begin, clock) = (Work::begin(), Instant::now());
            (0..steps).for_each(|_| stepper.step(dt, None));
            wall = wall.min(clock.elapsed().as_secs_f64() * 1e9 / (cells * steps) as f64);
            begin.seconds() * 1e9 / (cells * steps) as f64
        })
        .collect();
    costs.sort_by(f64::total_cmp);
    print!("{name:<36} {cells:>8} cells {:>6.1} ns  wall {wall:>6.1}  {memory:>4.0} B/cell", costs[2]);
    if let Some(values) = values_moved(scheme, viscous).filter(|_| D == 3) {
        let bound = 8.0 * values * 1e9 / triad();
        print!("  {:>5.0} B/step, bound {bound:>5.1} ns, ratio {:.2}", 8.0 * values, costs[2] / bound);
    }
    println!();
}

fn main() {
    let threads = std::env::args().nth(1).and_then(|t| t.parse().ok()).unwrap_or(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of threads").install(run);
}

fn run() {
    let full = Scheme::RungeKutta3;
    let (wall, free) = (Boundary::WALL, Boundary::FreeSlip);
    for cells in [[64, 160], [128, 800], [512, 2048]] {
        measure("r-z walls, RK3 x3, implicit", &tube(cells, wall), full, Viscous::Implicit);
    }
    for n in [100, 320, 1000] {
        measure("plane channel, RK3 x3, implicit", &plane([n, n], wall), full, Viscous::Implicit);
    }
    let middle = [128, 800];
    let cheap = Scheme::AdamsBashforth2;
    measure("r-z free-slip, RK3 x3, implicit", &tube(middle, free), full, Viscous::Implicit);
    measure("r-z periodic, RK3 x3, implicit", &tube(middle, Boundary::Periodic), full, Viscous::Implicit);
    measure("r-z walls, RK3 x3, explicit", &tube(middle, wall), full, Viscous::Explicit);
    measure("r-z walls, AB2, implicit", &tube(middle, wall), cheap, Viscous::Implicit);
    measure("r-z walls, AB2, explicit", &tube(middle, wall), cheap, Viscous::Explicit);
    measure(
        "plane periodic, RK3 x3, implicit",
        &plane([256, 256], Boundary::Periodic),
        full,
        Viscous::Implicit,
    );
    // The plane as a slice of space: two rows along y, the fewest that a grid has. Its cost per cell is the
    // least that one row would cost, see docs/decisions/two-fluid-engines.md.
    for n in [100, 320, 1000] {
        let slice = space([n, 2, n], Boundary::WALL);
        measure("slice of space, RK3 x3, implicit", &slice, full, Viscous::Implicit);
        measure("plane channel, RK3 x3, implicit", &plane([n, n], wall), full, Viscous::Implicit);
    }
    println!("triad: {:.1} GB/s, one thread", triad() * 1e-9);
    for n in [[64, 64, 64], [128, 128, 128], [256, 128, 128]] {
        let [x, y, z] = n;
        for (kind, ends) in [("channel", Boundary::WALL), ("periodic", Boundary::Periodic)] {
            let grid = space(n, ends);
            let name = |what: &str| format!("space {kind} {x}x{y}x{z}, {what}");
            measure(&name("RK3 x3, explicit"), &grid, full, Viscous::Explicit);
            measure(&name("AB2, explicit"), &grid, cheap, Viscous::Explicit);
            measure(&name("RK3 x3, implicit"), &grid, full, Viscous::Implicit);
        }
    }
}
