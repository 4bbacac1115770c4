//! Symmetries: momentum, angular momentum, rotation of the frame, of a pair as a rigid body.
use crate::common::{angular_momentum, cloud, contacts_after, dem, law, momentum, spec};
use dem_solver::laws::tangential::carry;
use dem_solver::{Grain, Integrator, Vec3};
use nalgebra::{Rotation3, UnitQuaternion};

#[test]
fn momentum_and_angular_momentum_are_kept_to_round_off() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let mut law = law(0.8, 0.05);
        law.friction = 0.5;
        let mut set_up = spec(cloud(60, 1), law);
        set_up.integrator = integrator;
        let mut solver = dem(&set_up);
        let (p, l) = (momentum(&solver), angular_momentum(&solver));
        let energy = solver.kinetic_energy();
        let mut met = 0;
        for _ in 0..100 {
            met += contacts_after(&mut solver, 0.01, 10);
        }
        assert!(met > 100, "the grains must collide");
        let scale = (2.0 * energy * solver.grains.mass.iter().sum::<f64>()).sqrt();
        assert!(
            (momentum(&solver) - p).norm() < 1e-13 * scale,
            "{integrator:?}: {}",
            (momentum(&solver) - p).norm()
        );
        assert!(
            (angular_momentum(&solver) - l).norm() < 1e-12 * 4.0 * scale,
            "{integrator:?}: {}",
            (angular_momentum(&solver) - l).norm()
        );
    }
}

/// The same run seen from a turned frame is the turned run.
#[test]
fn a_turned_frame_sees_the_turned_run() {
    let mut law = law(0.8, 0.05);
    law.friction = 0.4;
    let turn = Rotation3::from_euler_angles(0.7, -1.1, 2.3);
    let grains = cloud(20, 3);
    let turned: Vec<Grain> = grains
        .iter()
        .map(|grain| {
            let mut turned = grain.clone();
            turned.position = (turn * Vec3::from(grain.position)).into();
            turned.velocity = (turn * Vec3::from(grain.velocity)).into();
            turned.spin = (turn * Vec3::from(grain.spin)).into();
            turned
        })
        .collect();
    let (mut here, mut there) = (dem(&spec(grains, law)), dem(&spec(turned, law)));
    let mut met = 0;
    for _ in 0..20 {
        met += contacts_after(&mut here, 0.01, 10);
        there.advance(0.01, 10, &[]).expect("advances");
    }
    assert!(met > 10);
    for i in 0..here.grains.len() {
        let apart = (turn * here.grains.position[i] - there.grains.position[i]).norm();
        assert!(apart < 1e-9, "grain {i}: {apart}");
    }
}

/// A pressed, sheared pair that turns as a rigid body about any axis, twist included, keeps the length
/// of its spring, and the spring turns with it.
#[test]
fn spring_turns_with_the_pair() {
    let axes = [Vec3::y(), Vec3::x(), Vec3::new(1.0, 2.0, -0.5).normalize()];
    for axis in axes {
        let mut errors = Vec::new();
        for steps in [200, 400] {
            let omega = axis * (2.0 * std::f64::consts::PI);
            let dt = 1.0 / f64::from(steps) * 0.37;
            let mut spring = Vec3::new(0.0, 3e-3, 4e-3);
            let length = spring.norm();
            for step in 1..=steps {
                let n = UnitQuaternion::from_scaled_axis(omega * (dt * f64::from(step))) * Vec3::x();
                // n × ṅ + n (ω·n) of a rigid rotation is ω itself
                let turn = (n.cross(&omega.cross(&n)) + n * n.dot(&omega)) * dt;
                spring = carry(spring, &n, &turn);
            }
            let exact = UnitQuaternion::from_scaled_axis(omega * (dt * f64::from(steps)))
                * Vec3::new(0.0, 3e-3, 4e-3);
            assert!((spring.norm() - length).abs() < 1e-15);
            errors.push((spring - exact).norm() / length);
        }
        println!("axis {axis:?}: errors {errors:?}");
        assert!(errors[1] < 2e-4 && errors[1] < 0.3 * errors[0] + 1e-12, "{errors:?}");
    }
}

/// The whole solver: a pair in contact with a wound-up spring is turned by 2 rad as one body. The spring
/// keeps its length and turns with the pair, to first order in the sub-step as all of symplectic Euler.
#[test]
fn force_of_a_rigidly_turning_pair_keeps_its_size() {
    let mut law = law(0.9, 0.1);
    law.friction = 0.5;
    let omega = Vec3::new(0.3, 0.9, -0.4);
    let place = [Vec3::new(-0.495, 0.0, 0.0), Vec3::new(0.495, 0.0, 0.0)];
    let grains = || place.map(|x| Grain::new(x.into(), 0.5, 1.0)).to_vec();
    let mut errors = Vec::new();
    for steps in [250u32, 500] {
        let mut solver = dem(&spec(grains(), law));
        solver.grains.spin[0] = Vec3::new(0.0, 0.0, 0.5);
        solver.advance(1e-3, 10, &[]).expect("advances");
        let spring = Vec3::from(solver.save().contacts[0].spring);
        assert!(spring.norm() > 1e-5);
        let dt = 2.0 / omega.norm() / f64::from(steps);
        for step in 0..steps {
            let turn = UnitQuaternion::from_scaled_axis(omega * (dt * f64::from(step)));
            for (i, x) in place.iter().enumerate() {
                solver.grains.position[i] = turn * x;
                solver.grains.velocity[i] = omega.cross(&(turn * x));
                solver.grains.spin[i] = omega;
            }
            solver.advance(dt, 1, &[]).expect("advances");
        }
        let found = Vec3::from(solver.save().contacts[0].spring);
        let exact = UnitQuaternion::from_scaled_axis(omega * (dt * f64::from(steps))) * spring;
        assert!((found.norm() / spring.norm() - 1.0).abs() < 1e-9, "{} of {}", found.norm(), spring.norm());
        errors.push((found - exact).norm() / spring.norm());
    }
    println!("{errors:?}");
    assert!(errors[1] < 0.01 && errors[1] < 0.6 * errors[0], "{errors:?}");
}
