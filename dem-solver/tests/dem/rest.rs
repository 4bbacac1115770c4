//! Stacks at rest stay at rest for a million sub-steps: no drift, no heating.
use crate::common::{contacts_after, dem, floor, law, spec};
use dem_solver::{DemSpec, Engine, Freedom, Grain, Integrator, Motion, Shape, Vec3};

const T_C: f64 = 0.02;
/// Sub-steps of t_c/50.
const DT: f64 = T_C / 50.0;

/// Five spheres on each other, free along z only.
fn column() -> DemSpec {
    let mut law = law(0.5, T_C);
    law.friction = 0.5;
    let grains = (0..5).map(|k| {
        let mut grain = Grain::new([0.0, 0.0, 0.5 + f64::from(k)], 0.5, 1.0);
        grain.free = Freedom::AXIS;
        grain
    });
    let mut set_up = spec(grains.collect(), law);
    (set_up.walls, set_up.gravity) = (vec![floor()], [0.0, 0.0, -1.0].into());
    set_up
}

/// Rows of 4, 3, 2 and 1 discs on a row of five that is held. (On a plane the outer discs of such a pile roll
/// away, with any friction: they turn like cog wheels.)
fn pyramid() -> DemSpec {
    let mut set_up = column();
    set_up.shape = Shape::Disc;
    set_up.grains.clear();
    for row in 0..5u32 {
        for k in 0..5 - row {
            let x = f64::from(k) + 0.5 * f64::from(row);
            let mut grain = Grain::new([x, 0.0, 0.5 + f64::from(row) * 0.75f64.sqrt()], 0.5, 1.0);
            grain.free = Freedom::PLANE;
            grain.motion = if row == 0 { Motion::Fixed } else { Motion::Free };
            set_up.grains.push(grain);
        }
    }
    set_up
}

/// Largest move and largest kinetic energy over a million sub-steps after 1e5 to settle; the floor must bear
/// the weight.
fn watch(mut set_up: DemSpec, engine: Engine, integrator: Integrator) -> (f64, f64) {
    (set_up.engine, set_up.integrator) = (engine, integrator);
    let mut solver = dem(&set_up);
    for _ in 0..10 {
        solver.advance(1e4 * DT, 10_000, &[]).expect("advances");
    }
    let start = solver.grains.position.clone();
    let (mut moved, mut energy) = (0.0f64, 0.0f64);
    for _ in 0..100 {
        let contacts = contacts_after(&mut solver, 1e4 * DT, 10_000);
        assert!(contacts >= set_up.grains.len(), "{contacts} contacts");
        energy = energy.max(solver.kinetic_energy());
        let far = |(a, b): (&Vec3, &Vec3)| (a - b).norm();
        moved = solver.grains.position.iter().zip(&start).map(far).fold(moved, f64::max);
    }
    let free = || (0..set_up.grains.len()).filter(|&i| set_up.grains[i].motion == Motion::Free);
    let loads: Vec3 = free().map(|i| solver.observations().mean_contact[i]).sum();
    let weight: f64 = free().map(|i| solver.grains.mass[i]).sum();
    assert!((loads.z / weight - 1.0).abs() < 1e-10, "the floor bears {} of {weight}", loads.z);
    (moved, energy)
}

/// D = g = ρ = 1: positions keep to round-off of their size, and what moves is round-off too.
#[test]
fn stacks_stay_at_rest_for_a_million_sub_steps() {
    for (name, set_up) in [("column", column()), ("pyramid", pyramid())] {
        for (engine, integrator) in [
            (Engine::General, Integrator::SymplecticEuler),
            (Engine::General, Integrator::VelocityVerlet),
            (Engine::Bulk, Integrator::SymplecticEuler),
        ] {
            let (moved, energy) = watch(set_up.clone(), engine, integrator);
            println!("{name}, {engine:?}, {integrator:?}: moved {moved:.1e}, kinetic energy {energy:.1e}");
            assert!(moved < 1e-12, "{name}, {engine:?}, {integrator:?}: moved by {moved}");
            // one unit in the last place of a position, taken in one sub-step, is 4e-16/4e-4 = 1e-12 in speed
            assert!(energy < 1e-23, "{name}, {engine:?}, {integrator:?}: kinetic energy {energy}");
        }
    }
}
