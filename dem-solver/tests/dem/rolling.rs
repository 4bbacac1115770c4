//! Resistance to rolling against exact solutions of a sphere on a plane.
use crate::common::{angular_momentum, dem, floor, momentum, spec};
use dem_solver::LinearSpringDashpot;
use dem_solver::laws::rolling::Rolling;
use dem_solver::{Dem, Grain, Integrator};

const R: f64 = 5e-3;
const G: f64 = 9.81;

/// A sphere that lies on the plane z = 0 in its static overlap, under gravity inclined by `slope`.
fn on_plane(rolling: Rolling, slope: f64, speed: f64, integrator: Integrator) -> Dem {
    let mut law = LinearSpringDashpot::new(0.5, 1e-3, 0.8);
    law.rolling = Some(rolling);
    let sunk = G * slope.cos() / law.pair().stiffness;
    let mut grain = Grain::new([0.0, 0.0, R - sunk], R, 2500.0);
    grain.velocity = [speed, 0.0, 0.0];
    grain.spin = [0.0, speed / R, 0.0];
    let mut set_up = spec(vec![grain], law);
    set_up.walls.push(floor());
    set_up.gravity = [G * slope.sin(), 0.0, -G * slope.cos()].into();
    set_up.integrator = integrator;
    dem(&set_up)
}

#[test]
fn a_rolling_sphere_stops_after_the_exact_distance() {
    // 7/5 m a = −μ_r N without slip: it stops after 7 v²/(10 μ_r g).
    let (mu, v) = (0.05, 0.2);
    let exact = 0.7 * v * v / (mu * G);
    let time = v / (mu * G / 1.4);
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk3] {
        let mut sphere = on_plane(Rolling { friction: mu, damping: 0.3 }, 0.0, v, integrator);
        for _ in 0..200 {
            sphere.advance(0.01 * time, (0.01 * time / 2e-5).ceil() as u32, &[]).expect("advances");
        }
        let way = sphere.grains.position[0].x;
        println!(
            "{integrator:?}: {way:.6} of {exact:.6} m, then {:.1e} m/s",
            sphere.grains.velocity[0].norm()
        );
        // the spring fills over 2e-3 rad, 2e-4 of the way, and gives as much back at the end
        assert!((way / exact - 1.0).abs() < 1e-3, "{way} {exact}");
        assert!(sphere.grains.velocity[0].norm() < 1e-9, "it rests");
    }
}

#[test]
fn a_slope_below_the_rolling_friction_holds_and_above_it_does_not() {
    let mu = 0.1;
    let way = |slope: f64| {
        let rolling = Rolling { friction: mu, damping: 0.3 };
        let mut sphere = on_plane(rolling, slope, 0.0, Integrator::SymplecticEuler);
        sphere.advance(1.0, 50_000, &[]).expect("advances");
        (sphere.grains.position[0].x, sphere.grains.velocity[0].x)
    };
    let (held, speed) = way((0.9 * mu).atan());
    assert!(held < 0.05 * R && speed.abs() < 1e-9, "{held} {speed}");
    // 7/5 a = g (sin s − μ_r cos s)
    let slope = (3.0 * mu).atan();
    let (_, speed) = way(slope);
    let exact = G * (slope.sin() - mu * slope.cos()) / 1.4;
    assert!((speed / exact - 1.0).abs() < 5e-3, "{speed} {exact}");
}

#[test]
fn momenta_stay_and_a_restart_has_the_same_bits() {
    let grains = crate::common::cloud(64, 7);
    let mut law = LinearSpringDashpot::new(0.7, 0.02, 0.5);
    law.rolling = Some(Rolling { friction: 0.2, damping: 0.3 });
    let set_up = spec(grains, law);
    let mut run = dem(&set_up);
    run.advance(0.2, 400, &[]).expect("advances");
    let (before, turning) = (momentum(&run), angular_momentum(&run));
    let state = run.save();
    assert_eq!(state.rolling.len(), state.contacts.len());
    assert!(state.rolling.iter().any(|angle| *angle != [0.0; 3]));
    run.advance(0.2, 400, &[]).expect("advances");
    assert!((momentum(&run) - before).norm() < 1e-12);
    assert!((angular_momentum(&run) - turning).norm() < 1e-11);
    let mut again = dem(&set_up);
    again.restore(&state).expect("fits");
    again.advance(0.2, 400, &[]).expect("advances");
    assert_eq!(run.save(), again.save());
    let mut short = state;
    short.rolling.pop();
    assert!(again.restore(&short).expect_err("short").to_string().contains("rolling"));
}
