//! Cost of one step on one core: ns per cell and step, and the share of each part.
//!
//! CPU time of the process over all threads, so a busy machine disturbs it little.
//!
//! `cargo run --release -p fluid-solver --example step_cost [-- THREADS [PART OF A NAME]]`

use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::field::set_component;
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::scheme::{Projections, Scheme, Viscous};
use fluid_solver::step::{Options, Stepper};
use fluid_solver::timings::Part;
use fluid_solver::work::Work;

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
fn space(n: usize, walls: Boundary<3>) -> GridSpec<3> {
    GridSpec {
        geometry: Geometry::Space,
        axes: [uniform(1.0, n), uniform(1.0, n), uniform(1.0, n)],
        boundaries: [[Boundary::Periodic; 2], [Boundary::Periodic; 2], [walls; 2]],
    }
}

/// Median of five timed runs.
fn measure<const D: usize>(name: &str, spec: &GridSpec<D>, scheme: Scheme, viscous: Viscous) {
    if std::env::args().nth(2).is_some_and(|part| !name.contains(&part)) {
        return;
    }
    let grid = Grid::new(spec).expect("the benchmark's grid is valid");
    let cells = grid.cell_count();
    let options = Options { viscosity: 1e-3, scheme, viscous, convection: true, body_force: [0.0; D] };
    let mut stepper = Stepper::new(grid.clone(), options);
    for d in 0..D {
        let u = &mut stepper.state_mut().velocity[d];
        set_component(&grid, d, u, |x| (3.0 * x[0] + d as f64).sin() * (5.0 * x[D - 1]).cos());
    }
    stepper.project_velocity();
    let dt = 0.2 * grid.smallest_width();
    (0..3).for_each(|_| stepper.step(dt, None));
    let steps = (10_000_000 / cells).clamp(2, 2000);
    stepper.reset_timings();
    let mut costs: Vec<f64> = (0..5)
        .map(|_| {
            let begin = Work::begin();
            (0..steps).for_each(|_| stepper.step(dt, None));
            begin.seconds() * 1e9 / (cells * steps) as f64
        })
        .collect();
    costs.sort_by(f64::total_cmp);
    let per_cell = |part| stepper.timings().seconds(part) * 1e9 / (cells * steps * 5) as f64;
    let [momentum, viscous, projection, pressure] =
        [Part::Momentum, Part::Viscous, Part::Projection, Part::Pressure].map(per_cell);
    println!(
        "{name:<34} {cells:>8} cells {:>7.1} ns  momentum {momentum:>5.1}  viscous {viscous:>5.1}  \
         pressure solve {pressure:>5.1}  rest of projection {:>5.1}",
        costs[2],
        projection - pressure
    );
}

fn main() {
    let threads = std::env::args().nth(1).and_then(|t| t.parse().ok()).unwrap_or(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of threads").install(run);
}

fn run() {
    let rk = |projections| Scheme::RungeKutta3 { projections };
    let full = rk(Projections::EveryStage);
    let (wall, free) = (Boundary::WALL, Boundary::FreeSlip);
    for cells in [[64, 160], [128, 800], [512, 2048]] {
        measure("r-z walls, RK3 x3, implicit", &tube(cells, wall), full, Viscous::Implicit);
    }
    for n in [100, 320, 1000] {
        measure("plane channel, RK3 x3, implicit", &plane([n, n], wall), full, Viscous::Implicit);
    }
    let middle = [128, 800];
    let once = rk(Projections::OncePerStep);
    let cheap = Scheme::AdamsBashforth2;
    measure("r-z free-slip, RK3 x3, implicit", &tube(middle, free), full, Viscous::Implicit);
    measure("r-z periodic, RK3 x3, implicit", &tube(middle, Boundary::Periodic), full, Viscous::Implicit);
    measure("r-z walls, RK3 x3, explicit", &tube(middle, wall), full, Viscous::Explicit);
    measure("r-z walls, RK3 x1, implicit", &tube(middle, wall), once, Viscous::Implicit);
    measure("r-z walls, AB2, implicit", &tube(middle, wall), cheap, Viscous::Implicit);
    measure("r-z walls, AB2, explicit", &tube(middle, wall), cheap, Viscous::Explicit);
    measure(
        "plane periodic, RK3 x3, implicit",
        &plane([256, 256], Boundary::Periodic),
        full,
        Viscous::Implicit,
    );
    measure("space channel, RK3 x3, explicit", &space(64, Boundary::WALL), full, Viscous::Explicit);
    measure("space periodic, RK3 x3, explicit", &space(64, Boundary::Periodic), full, Viscous::Explicit);
    measure("space channel, RK3 x3, implicit", &space(64, Boundary::WALL), full, Viscous::Implicit);
    measure("space channel, AB2, explicit", &space(64, Boundary::WALL), cheap, Viscous::Explicit);
}
