//! Observed order of the integrators, and energy.
use crate::common::{dem, effective, floor, law, spec};
use dem_solver::{Grain, Integrator};

const ALL: [Integrator; 3] = [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk3];

/// Height after one t_c of a sphere that swings on its contact spring without leaving the wall:
/// a damped oscillator, smooth; also the exact height.
fn swing(integrator: Integrator, n: u32) -> (f64, f64) {
    let (law, g) = (law(0.5, 1.0), 0.1);
    let pair = law.pair();
    let rest = -g / pair.stiffness;
    let away = 0.2 * rest;
    let mut set_up = spec(vec![Grain::new([0.0, 0.0, 0.5 + rest + away], 0.5, 1.0)], law);
    set_up.walls.push(floor());
    set_up.gravity = [0.0, 0.0, -g].into();
    set_up.integrator = integrator;
    let mut solver = dem(&set_up);
    solver.advance(1.0, n, &[]).expect("advances");
    let decay = 0.5 * pair.damping;
    let omega = (pair.stiffness - decay * decay).sqrt();
    let exact = rest + away * (-decay).exp() * (omega.cos() + decay / omega * omega.sin());
    ((solver.grains.position[0].z - 0.5 - exact).abs() / away.abs(), exact)
}

#[test]
fn order_on_a_smooth_contact() {
    for (integrator, order) in ALL.into_iter().zip([1.0, 2.0, 3.0]) {
        let errors = [32, 64, 128].map(|n| swing(integrator, n).0);
        let observed = (errors[1] / errors[2]).log2();
        println!("{integrator:?}: errors {errors:?}, order {observed:.3}");
        assert!((observed - order).abs() < 0.1, "{integrator:?}: order {observed} instead of {order}");
    }
}

/// With friction and spin: tangential oscillation of a pressed sphere on its tangential spring.
#[test]
fn order_with_the_tangential_spring() {
    let run = |integrator, n| {
        let mut law = law(0.5, 1.0);
        law.friction = 10.0;
        let g = 0.1;
        let rest = -g / law.pair().stiffness;
        let mut grain = Grain::new([0.0, 0.0, 0.5 + rest], 0.5, 1.0);
        grain.velocity = [1e-4, 0.0, 0.0];
        let mut set_up = spec(vec![grain], law);
        set_up.walls.push(floor());
        set_up.gravity = [0.0, 0.0, -g].into();
        set_up.integrator = integrator;
        let mut solver = dem(&set_up);
        solver.advance(1.0, n, &[]).expect("advances");
        solver.grains.velocity[0].x
    };
    for (integrator, order) in ALL.into_iter().zip([1.0, 2.0, 3.0]) {
        let fine = [64, 128, 256, 512].map(|n| run(integrator, n));
        let observed = ((fine[1] - fine[0]) / (fine[2] - fine[1])).abs().log2();
        println!("{integrator:?}: {fine:?}, order {observed:.3}");
        assert!((observed - order).abs() < 0.35, "{integrator:?}: order {observed} instead of {order}");
    }
}

/// Across a whole collision: the worst error over the phase of the first touch. The force jumps at the touch:
/// Verlet knows the moment of it and keeps its order, RK3 does not, Euler's dashpots are half a step late.
#[test]
fn order_on_a_collision() {
    let worst = |integrator, e: f64, n: u32| {
        let law = law(e, 1.0);
        (0..32)
            .map(|phase| {
                let mut grain =
                    Grain::new([0.0, 0.0, 0.5 + f64::from(phase) / 32.0 / f64::from(n)], 0.5, 1.0);
                grain.velocity = [0.0, 0.0, -1.0];
                let mut set_up = spec(vec![grain], law);
                set_up.walls.push(floor());
                set_up.integrator = integrator;
                let mut solver = dem(&set_up);
                solver.advance(3.0, 3 * n, &[]).expect("advances");
                (solver.grains.velocity[0].z - effective(&law).0).abs()
            })
            .fold(0.0, f64::max)
    };
    for (integrator, e, least) in [
        (Integrator::SymplecticEuler, 0.5, 0.9),
        (Integrator::VelocityVerlet, 0.5, 1.7),
        (Integrator::Rk3, 0.5, 0.9),
        (Integrator::SymplecticEuler, 1.0, 0.9),
        (Integrator::VelocityVerlet, 1.0, 1.9),
        (Integrator::Rk3, 1.0, 1.8),
    ] {
        let errors = [50, 100, 200].map(|n| worst(integrator, e, n));
        let observed = (errors[0] / errors[2]).log2() / 2.0;
        println!("{integrator:?} e {e}: errors {errors:?}, order {observed:.2}");
        assert!(observed > least, "{integrator:?}, e {e}: order {observed}, errors {errors:?}");
    }
}

/// An undamped sphere bouncing under gravity keeps its energy: no drift over 200 bounces.
#[test]
fn energy_does_not_drift_without_damping() {
    for (integrator, bound) in [(Integrator::SymplecticEuler, 2e-2f64), (Integrator::VelocityVerlet, 2e-3)] {
        let mut set_up = spec(vec![Grain::new([0.0, 0.0, 0.6], 0.5, 1.0)], law(1.0, 0.1));
        set_up.walls.push(floor());
        set_up.gravity = [0.0, 0.0, -1.0].into();
        set_up.integrator = integrator;
        let mut solver = dem(&set_up);
        let mass = solver.grains.mass[0];
        let start = mass * 0.6;
        let mut early = 0.0f64;
        let mut late = 0.0f64;
        for window in 0..2000 {
            solver.advance(0.1, 100, &[]).expect("advances");
            let energy =
                solver.kinetic_energy() + solver.elastic_energy() + mass * solver.grains.position[0].z;
            let error = ((energy - start) / (mass * 0.1)).abs();
            if window < 200 { early = early.max(error) } else { late = late.max(error) }
        }
        println!("{integrator:?}: energy error {early:.2e} in the first tenth, {late:.2e} after");
        assert!(late < bound, "{integrator:?}: {early} then {late}");
    }
}
