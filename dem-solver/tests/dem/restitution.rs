//! Normal collisions: the clipped linear law gives back exp(−r(π − 2 atan r)), r = −ln(e_n)/π.
use crate::common::{contacts_after, dem, effective, exact, floor, law, spec};
use dem_solver::LinearSpringDashpot;
use dem_solver::{Grain, Integrator};

/// Rebound over impact speed, and duration over t_c, of a sphere on a wall: `n` sub-steps per t_c.
fn collide(law: LinearSpringDashpot, n: u32, integrator: Integrator) -> (f64, f64) {
    let mut grain = Grain::new([0.0, 0.0, 0.5], 0.5, 1.0);
    grain.velocity = [0.0, 0.0, -1e-3];
    let mut set_up = spec(vec![grain], law);
    set_up.walls.push(floor());
    set_up.integrator = integrator;
    let mut solver = dem(&set_up);
    let dt = law.contact_time_of(1.0) / f64::from(n);
    let mut lasted = 0u32;
    for _ in 0..4 * n {
        lasted += contacts_after(&mut solver, dt, 1) as u32;
    }
    (solver.grains.velocity[0].z / 1e-3, f64::from(lasted) * dt / law.contact_time_of(1.0))
}

/// Richardson's extrapolation of a first-order result (damping jumps at the first touch).
fn limit(law: LinearSpringDashpot, n: u32) -> f64 {
    let e: Vec<f64> =
        [n, 2 * n, 4 * n].iter().map(|&n| collide(law, n, Integrator::VelocityVerlet).0).collect();
    let once = [2.0 * e[1] - e[0], 2.0 * e[2] - e[1]];
    (4.0 * once[1] - once[0]) / 3.0
}

#[test]
fn seed_form_gives_the_published_effective_values() {
    for (asked, published) in [(0.97, 0.9702), (0.87, 0.8734), (0.5, 0.5503), (0.3, 0.3971)] {
        let law = law(asked, 1e-3);
        assert!((effective(&law).0 - published).abs() < 5e-5, "{asked}: {:?}", effective(&law));
    }
}

#[test]
fn collision_converges_to_the_formula_of_both_forms() {
    for asked in [0.97, 0.87, 0.5, 0.3] {
        for law in [law(asked, 1e-3), exact(law(asked, 1e-3))] {
            let expected = effective(&law).0;
            let found = limit(law, 4000);
            println!("e_n {asked} {:?}: formula {expected:.8}, found {found:.8}", law.form);
            assert!(
                (found - expected).abs() < 1e-6,
                "e_n {asked}, {:?}: {found} instead of {expected}",
                law.form
            );
        }
    }
}

#[test]
fn exact_form_returns_what_is_asked() {
    for asked in [1.0, 0.97, 0.5, 0.2, 0.14] {
        let (restitution, time) = effective(&exact(law(asked, 2e-4)));
        assert!((restitution - asked).abs() < 1e-12 && (time - 2e-4).abs() < 1e-15, "{restitution} {time}");
    }
    assert!(exact(law(0.13, 1e-3)).validate().is_err(), "below critical damping there is no exact form");
}

#[test]
fn contact_lasts_as_long_as_the_formula_says() {
    for law in [law(0.3, 1e-3), exact(law(0.3, 1e-3)), law(0.87, 1e-3)] {
        let (_, lasted) = collide(law, 2000, Integrator::SymplecticEuler);
        let expected = effective(&law).1 / law.contact_time_of(1.0);
        assert!((lasted - expected).abs() < 2e-3, "{lasted} instead of {expected}");
    }
}

/// t_c/20 is accurate, t_c/5 costs about 2 %, t_c/2 is wrong (docs/numerics.md, Contact and sub-steps).
#[test]
fn substep_limit_of_symplectic_euler() {
    let law = law(0.97, 1e-3);
    let worst = |n: u32| {
        (0..16)
            .map(|phase| {
                let mut grain = Grain::new([0.0, 0.0, 0.5], 0.5, 1.0);
                grain.velocity = [0.0, 0.0, -1e-3];
                let dt = law.contact_time_of(1.0) / f64::from(n);
                grain.position[2] += 1e-3 * dt * f64::from(phase) / 16.0;
                let mut set_up = spec(vec![grain], law);
                set_up.walls.push(floor());
                let mut solver = dem(&set_up);
                solver.advance(4.0 * law.contact_time_of(1.0), 4 * n, &[]).expect("advances");
                (solver.grains.velocity[0].z / 1e-3 - effective(&law).0).abs()
            })
            .fold(0.0, f64::max)
    };
    let (fine, limit, coarse, wrong) = (worst(20), worst(10), worst(5), worst(2));
    println!("worst error of e at t_c/20 {fine:.4}, t_c/10 {limit:.4}, t_c/5 {coarse:.4}, t_c/2 {wrong:.4}");
    assert!(fine < 0.01 && limit < 0.015 && coarse < 0.05 && wrong > 0.1, "{limit}");
}

#[test]
fn impact_and_rebound_speeds_are_observed() {
    let law = law(0.87, 1e-3);
    let mut grain = Grain::new([0.0, 0.0, 0.5 + 1e-7], 0.5, 1.0);
    grain.velocity = [0.0, 0.0, -1e-3];
    let mut set_up = spec(vec![grain], law);
    set_up.walls.push(floor());
    let mut solver = dem(&set_up);
    solver.advance(4e-3, 4000, &[]).expect("advances");
    let seen = solver.observations();
    assert!((seen.impact_speed[0] - 1e-3).abs() < 1e-12);
    assert_eq!(seen.rebound_speed[0], solver.grains.velocity[0].z);
    solver.advance(1e-3, 10, &[]).expect("advances");
    assert_eq!((solver.observations().impact_speed[0], solver.observations().rebound_speed[0]), (0.0, 0.0));
}
