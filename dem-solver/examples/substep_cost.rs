//! What a grain-sub-step costs: `cargo run --release -p bedload-dem --example substep_cost`.
//!
//! One grain that bounces on a wall in windows of 4000 sub-steps, dry and with the film; 1,000 grains
//! in a settled heap in a periodic box.

use dem_solver::lubrication::settings::LubricationSettings;
use dem_solver::{ContactLaw, Dem, DemSpec, Grain, LinearSpringDashpot, Lubrication, SpecError, Wall};
use std::time::Instant;

fn law() -> ContactLaw {
    ContactLaw::LinearSpringDashpot(LinearSpringDashpot::new(0.8, 0.02, 0.3))
}

fn film(spec: &mut DemSpec) {
    spec.viscosity = 0.01;
    spec.lubrication = Lubrication::AsPrinted(LubricationSettings::new(1e-3));
}

/// One sphere, its centre `height` above the floor.
fn single(height: f64, lubricated: bool) -> DemSpec {
    let mut spec = DemSpec::new(vec![Grain::new([0.0, 0.0, height], 0.5, 2.0)], law());
    spec.walls.push(Wall::new([0.0; 3], [0.0, 0.0, 1.0]));
    spec.gravity = [0.0, 0.0, -1.0];
    if lubricated {
        film(&mut spec);
    }
    spec
}

/// A lattice of 10 × 10 × 10 grains of two sizes, to fall into a heap.
fn heap(lubricated: bool) -> DemSpec {
    let grains = (0..1000)
        .map(|k| {
            let site = [k % 10, k / 10 % 10, k / 100];
            let shift = 0.1 * f64::from(k % 7) / 7.0;
            Grain::new(
                std::array::from_fn(|axis| 0.6 + 1.1 * f64::from(site[axis]) + shift),
                0.45 + 0.05 * f64::from(k % 3),
                2.0,
            )
        })
        .collect();
    let mut spec = DemSpec::new(grains, law());
    spec.walls.push(Wall::new([0.0; 3], [0.0, 0.0, 1.0]));
    spec.periods = [Some((0.0, 11.0)), Some((0.0, 11.0)), None];
    spec.gravity = [0.0, 0.0, -1.0];
    if lubricated {
        film(&mut spec);
    }
    spec
}

/// Best of 40 windows, each short enough not to be interrupted on a busy machine; ns per grain and
/// sub-step.
fn measure(name: &str, spec: &DemSpec, settle: u32, n_sub: u32) -> Result<(), SpecError> {
    let mut dem = Dem::new(spec)?;
    let dt = 0.02 / 50.0;
    for _ in 0..settle {
        if dem.advance(dt * 100.0, 100, &[]).is_err() {
            return Ok(());
        }
    }
    let (mut best, mut contacts) = (f64::INFINITY, 0);
    for _ in 0..40 {
        let start = Instant::now();
        if let Ok(report) = dem.advance(dt * f64::from(n_sub), n_sub, &[]) {
            contacts = report.contacts;
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    let cost = best * 1e9 / f64::from(n_sub) / spec.grains.len() as f64;
    let each = contacts as f64 / spec.grains.len() as f64;
    println!("{name:32} {cost:8.1} ns per grain-sub-step, {each:.2} contacts per grain");
    Ok(())
}

fn main() -> Result<(), SpecError> {
    measure("1 grain, free flight", &single(1e4, false), 0, 4000)?;
    measure("1 grain, resting on a wall", &single(0.5, false), 100, 4000)?;
    measure("1 grain, lubricated, free flight", &single(1e4, true), 0, 4000)?;
    measure("1 grain, lubricated at a gap", &single(0.7, true), 0, 400)?;
    measure("1 grain, lubricated, in contact", &single(0.5, true), 100, 4000)?;
    measure("1000 grains, heap", &heap(false), 300, 4)?;
    measure("1000 grains, heap with lubrication", &heap(true), 300, 4)
}
