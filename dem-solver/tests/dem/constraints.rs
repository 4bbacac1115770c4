//! Locked, fixed and prescribed motion; walls that vanish; periods; faults.
use crate::common::{contacts, contacts_after, dem, exact, floor, law, spec};
use dem_solver::{
    AdvanceError, Dem, Engine, Freedom, Grain, GrainLoad, Motion, OverTime, Shape, Sine, SpecError, Vec3,
    Wall,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

#[test]
fn locked_components_stay_put() {
    for free in [
        Freedom::PLANE,
        Freedom::AXIS,
        Freedom { translation: [true, false, false], rotation: [false, false, true] },
    ] {
        let mut grains = crate::common::cloud(30, 21);
        for grain in &mut grains {
            grain.free = free;
        }
        let mut law = law(0.8, 0.05);
        law.friction = 0.5;
        let mut set_up = spec(grains.clone(), law);
        set_up.gravity = [0.3, 0.2, -1.0].into();
        let mut solver = dem(&set_up);
        let load = GrainLoad {
            force: Vec3::new(0.1, 0.2, 0.3),
            torque: Vec3::new(0.1, 0.2, 0.3),
            ..GrainLoad::default()
        };
        let mut met = 0;
        for _ in 0..50 {
            solver.advance(0.01, 10, &[load; 30]).expect("advances");
            met += contacts(&solver);
        }
        assert!(met > 0);
        for (i, grain) in grains.iter().enumerate() {
            for axis in 0..3 {
                let moved = solver.grains.position[i][axis] != grain.position[axis];
                assert_eq!(moved, free.translation[axis], "grain {i}, axis {axis}");
                assert_eq!(solver.grains.spin[i][axis] != 0.0, free.rotation[axis]);
            }
        }
    }
}

/// A plane run of discs stays in its plane by itself but for round-off; the mask makes it exact.
#[test]
fn disc_mass_and_inertia_are_per_unit_length() {
    let mut set_up = spec(vec![Grain::new([0.0; 3], 0.5, 2.0)], law(0.9, 1e-3));
    set_up.shape = Shape::Disc;
    let solver = dem(&set_up);
    assert!((solver.grains.mass[0] - 2.0 * PI * 0.25).abs() < 1e-15);
    assert!((solver.grains.inertia[0] - 0.5 * solver.grains.mass[0] * 0.25).abs() < 1e-15);
}

#[test]
fn prescribed_and_oscillating_grains_follow_their_path() {
    let mut steady = Grain::new([0.0; 3], 0.5, 1.0);
    steady.motion = Motion::Prescribed { velocity: [1.0, 0.0, -0.5].into(), spin: [0.0, 2.0, 0.0].into() };
    let mut swinging = Grain::new([5.0, 0.0, 0.0], 0.5, 1.0);
    // x₀ + A (sin(ωt + φ) − sin φ), ω = 5: the velocity is Aω cos(ωt + φ).
    let swing = |amplitude: [f64; 3]| {
        let (frequency, phase) = (5.0 / TAU, 0.4 + FRAC_PI_2);
        OverTime::sine(Sine { amplitude: amplitude.map(|a| 5.0 * a), frequency, phase, offset: [0.0; 3] })
    };
    swinging.motion = Motion::Prescribed { velocity: swing([0.3, 0.0, 0.1]), spin: swing([0.0, 0.7, 0.0]) };
    let mut set_up = spec(vec![steady, swinging], law(0.9, 1e-3));
    set_up.gravity = [0.0, 0.0, -9.0].into();
    let mut solver = dem(&set_up);
    for _ in 0..10 {
        solver
            .advance(0.1, 3, &[GrainLoad { force: Vec3::x(), ..GrainLoad::default() }; 2])
            .expect("advances");
    }
    let g = &solver.grains;
    assert!((g.position[0] - Vec3::new(1.0, 0.0, -0.5)).norm() < 1e-14);
    assert!((g.orientation[0].angle() - 2.0).abs() < 1e-13);
    let phase = (5.0f64 + 0.4).sin() - 0.4f64.sin();
    assert!((g.position[1] - Vec3::new(5.0 + 0.3 * phase, 0.0, 0.1 * phase)).norm() < 1e-13);
    assert!((g.orientation[1].scaled_axis() - Vec3::new(0.0, 0.7 * phase, 0.0)).norm() < 1e-13);
    assert!((g.velocity[1] - Vec3::new(0.3, 0.0, 0.1) * (5.0 * 5.4f64.cos())).norm() < 1e-13);
}

/// A free grain hit by a prescribed one leaves at v_wall (1 + e): the prescribed mass is infinite.
#[test]
fn prescribed_grain_is_infinitely_heavy() {
    let mut hammer = Grain::new([-0.5, 0.0, 0.0], 0.5, 1.0);
    hammer.motion = Motion::Prescribed { velocity: [1e-3, 0.0, 0.0].into(), spin: [0.0; 3].into() };
    let law = exact(law(0.6, 1e-3));
    let mut solver = dem(&spec(vec![hammer, Grain::new([0.5, 0.0, 0.0], 0.5, 1.0)], law));
    solver.advance(2e-3, 20_000, &[]).expect("advances");
    assert!((solver.grains.velocity[1].x - 1.6e-3).abs() < 1e-6, "{}", solver.grains.velocity[1].x);
    assert_eq!(solver.grains.velocity[0].x, 1e-3);
}

#[test]
fn a_gate_vanishes_at_its_time() {
    let mut set_up = spec(vec![Grain::new([0.0, 0.0, 0.5], 0.5, 1.0)], law(0.5, 0.01));
    set_up.walls = vec![Wall { until: Some(1.0), ..floor() }];
    set_up.gravity = [0.0, 0.0, -1.0].into();
    let mut solver = dem(&set_up);
    for _ in 0..100 {
        solver.advance(0.01, 20, &[]).expect("advances");
    }
    assert!((solver.grains.position[0].z - 0.5).abs() < 1e-4);
    let z = solver.grains.position[0].z;
    solver.advance(1.0, 1000, &[]).expect("advances");
    assert!((z - 0.5 - solver.grains.position[0].z).abs() < 2e-3, "falls freely");
    assert!(solver.observations().gap_end[0].is_infinite() && solver.save().wall_contacts.is_empty());
}

#[test]
fn a_floor_that_takes_over_goes_down_with_its_grain() {
    let mut set_up = spec(vec![Grain::new([0.0, 0.0, 0.5], 0.5, 1.0)], law(0.5, 0.01));
    // Level with the first when that vanishes, then at 0.1 m/s downwards.
    let next =
        Wall { from: 1.0, velocity: [0.0, 0.0, -0.1].into(), ..Wall::new([0.0, 0.0, 0.1], [0.0, 0.0, 1.0]) };
    set_up.walls = vec![Wall { until: Some(1.0), ..floor() }, next];
    set_up.gravity = [0.0, 0.0, -1.0].into();
    let mut solver = dem(&set_up);
    for _ in 0..100 {
        solver.advance(0.01, 20, &[]).expect("advances");
    }
    assert!((solver.grains.position[0].z - 0.5).abs() < 1e-4, "the second floor was not there yet");
    for _ in 0..100 {
        solver.advance(0.01, 20, &[]).expect("advances");
    }
    assert!((solver.grains.position[0].z - 0.4).abs() < 1e-4, "{}", solver.grains.position[0].z);
    assert!((solver.grains.velocity[0].z + 0.1).abs() < 1e-4, "{}", solver.grains.velocity[0].z);
}

#[test]
fn grains_collide_through_a_periodic_face() {
    let mut grain = Grain::new([9.3, 0.0, 0.0], 0.5, 1.0);
    grain.velocity = [1.0, 0.0, 0.0];
    let mut set_up = spec(vec![Grain::new([0.8, 0.0, 0.0], 0.5, 1.0), grain], exact(law(1.0, 0.05)));
    set_up.periods = [Some((0.0, 10.0)), None, None];
    let mut solver = dem(&set_up);
    for _ in 0..200 {
        solver.advance(0.01, 10, &[]).expect("advances");
    }
    assert!((solver.grains.velocity[0].x - 1.0).abs() < 1e-3 && solver.grains.velocity[1].x.abs() < 1e-3);
    let x = solver.grains.position[0].x;
    assert!((0.0..10.0).contains(&x));
    for _ in 0..1000 {
        solver.advance(0.01, 1, &[]).expect("advances");
    }
    assert!(solver.grains.image[0][0] >= 0 && solver.grains.image[1][0] >= 0);
    let unrolled: f64 =
        (0..2).map(|i| solver.grains.position[i].x + 10.0 * f64::from(solver.grains.image[i][0])).sum();
    assert!((unrolled - (0.8 + 9.3 + 12.0)).abs() < 1e-9, "the centre of mass moves on at ½: {unrolled}");
}

/// A large sphere and a small one in a period of three large radii; twice as many in twice the period.
#[test]
fn a_short_period_is_half_of_one_twice_as_long() {
    let course = |copies: usize, engine: Engine| {
        let period = 1.5 * copies as f64;
        let pairs = (0..copies).flat_map(|copy| {
            let along = 1.5 * copy as f64;
            let mut small = Grain::new([along + 1.2, 0.1, 1.25], 0.1, 1.0);
            small.velocity = [0.7, 0.0, -1.0];
            [Grain::new([along + 0.3, 0.0, 0.5], 0.5, 1.0), small]
        });
        let mut law = law(0.8, 0.02);
        law.friction = 0.4;
        let mut set_up = spec(pairs.collect(), law);
        (set_up.engine, set_up.gravity) = (engine, [0.0, 0.0, -1.0].into());
        set_up.walls = vec![floor()];
        set_up.periods = [Some((0.0, period)), Some((-1.0, 2.0)), None];
        let mut solver = dem(&set_up);
        let met: usize = (0..400).map(|_| contacts_after(&mut solver, 0.01, 10)).sum();
        (met, solver.grains.velocity.clone(), set_up)
    };
    for engine in [Engine::General, Engine::Bulk] {
        let ((met, short, set_up), (twice, long, _)) = (course(1, engine), course(2, engine));
        assert!(met > 0 && twice == 2 * met, "{met} {twice}");
        // Rounding differs, and grows by every bounce.
        assert!(short.iter().zip(&long).all(|(a, b)| (a - b).norm() < 1e-7), "{short:?} {long:?}");
        assert!(short[1].y.abs() > 0.01, "they met");
        // Two large ones: a pair of them would touch twice.
        let mut crowded = set_up.clone();
        crowded.grains[1].radius = 0.5;
        assert!(
            matches!(crowded.validate(), Err(SpecError::Period { axis: "x", least, .. }) if least >= 2.0)
        );
        // A grain that reaches its own image.
        let mut narrow = set_up;
        narrow.periods[0] = Some((0.0, 0.99));
        assert!(matches!(narrow.validate(), Err(SpecError::Period { axis: "x", .. })));
    }
}

/// A sphere let go on a rough row of fixed grains comes to rest in a hollow: touching two, bearing its
/// weight by normal forces at 30° or by friction, and it stays.
#[test]
fn sphere_comes_to_rest_on_a_rough_row() {
    let mut grains: Vec<Grain> = (0..8)
        .map(|k| Grain { motion: Motion::Fixed, ..Grain::new([f64::from(k), 0.0, 0.0], 0.5, 1.0) })
        .collect();
    let mut free = Grain::new([3.35, 0.0, 1.0], 0.5, 1.0);
    free.free = Freedom::PLANE;
    free.velocity = [0.2, 0.0, 0.0];
    grains.push(free);
    let mut law = law(0.5, 5e-3);
    law.friction = 0.3;
    let mut set_up = spec(grains, law);
    set_up.gravity = [0.0, 0.0, -1.0].into();
    let mut solver = dem(&set_up);
    for _ in 0..1500 {
        solver.advance(0.01, 40, &[]).expect("advances");
    }
    let weight = solver.grains.mass[8];
    let force = solver.observations().mean_contact[8];
    assert!(
        (force.z / weight - 1.0).abs() < 1e-6 && (force.x / weight).abs() < 1e-6,
        "{force} against {weight}"
    );
    assert!(solver.grains.velocity[8].norm() < 1e-8 && solver.grains.spin[8].norm() < 1e-7);
    let hollow = (solver.grains.position[8].x - 0.5).rem_euclid(1.0);
    assert!(!(1e-2..=0.99).contains(&hollow), "{}", solver.grains.position[8].x);
    assert!((solver.grains.position[8].z - 0.75f64.sqrt()).abs() < 1e-3);
    assert!(solver.grains.position[..8].iter().enumerate().all(|(k, x)| *x == Vec3::new(k as f64, 0.0, 0.0)));
}

#[test]
fn a_state_that_is_not_finite_is_named() {
    let mut solver = dem(&spec(
        vec![Grain::new([0.0; 3], 0.5, 1.0), Grain::new([3.0, 0.0, 0.0], 0.5, 1.0)],
        law(0.9, 1e-3),
    ));
    let loads =
        [GrainLoad::default(), GrainLoad { torque: Vec3::new(0.0, 1e308, 0.0), ..GrainLoad::default() }];
    let report = solver.advance(1e3, 10, &loads).expect("no panic");
    let fault = report.first_non_finite.expect("named");
    assert_eq!((fault.grain, fault.quantity), (1, "spin"));
    assert!(report.n_sub_done < 10);
    assert_eq!(fault.to_string(), "spin of grain 1 is not finite");
}

#[test]
fn bad_windows_and_loads_are_refused() {
    let mut solver = dem(&spec(vec![Grain::new([0.0; 3], 0.5, 1.0)], law(0.9, 1e-3)));
    let before = solver.save();
    assert!(matches!(solver.advance(0.0, 1, &[]), Err(AdvanceError::Window { .. })));
    assert!(matches!(solver.advance(1.0, 0, &[]), Err(AdvanceError::Window { .. })));
    assert!(matches!(
        solver.advance(1.0, 1, &[GrainLoad::default(); 2]),
        Err(AdvanceError::LoadCount { given: 2, grains: 1 })
    ));
    let nan = GrainLoad { force: Vec3::new(0.0, f64::NAN, 0.0), ..GrainLoad::default() };
    assert!(matches!(
        solver.advance(1.0, 1, &[nan]),
        Err(AdvanceError::Load { grain: 0, quantity: "force", .. })
    ));
    let light = GrainLoad { added_mass: -1.0, ..GrainLoad::default() };
    assert!(matches!(
        solver.advance(1.0, 1, &[light]),
        Err(AdvanceError::Load { quantity: "added mass", .. })
    ));
    assert_eq!(solver.save(), before);
}

#[test]
fn bad_specs_are_refused_with_the_reason() {
    let good =
        || spec(vec![Grain::new([0.0; 3], 0.5, 1.0), Grain::new([2.0, 0.0, 0.0], 0.5, 1.0)], law(0.9, 1e-3));
    let refused = |change: &dyn Fn(&mut dem_solver::DemSpec)| {
        let mut set_up = good();
        change(&mut set_up);
        Dem::new(&set_up).expect_err("refused").to_string()
    };
    assert!(refused(&|s| s.grains[1].radius = -1.0).contains("grain 1: radius is -1"));
    assert!(refused(&|s| s.walls.push(Wall::new([0.0; 3], [0.0; 3]))).contains("wall 0"));
    assert!(refused(&|s| s.periods[0] = Some((0.0, 1.5))).contains("along x is 1.5 m; allowed: 2 m"));
    // One grain has no pair, but an image of its own.
    assert!(
        refused(&|s| {
            s.grains.truncate(1);
            s.periods[1] = Some((0.0, 0.9));
        })
        .contains("along y is 0.9 m; allowed: 1 m")
    );
    assert!(refused(&|s| s.gravity = [0.0, 0.0, f64::INFINITY].into()).contains("gravity"));
    let film =
        dem_solver::Lubrication::AsPrinted(dem_solver::lubrication::settings::LubricationSettings::new(1e-3));
    assert!(refused(&|s| s.lubrication = film).contains("viscosity"));
    assert!(
        refused(&|s| {
            s.lubrication = film;
            s.viscosity = 1.0;
            s.integrator = dem_solver::Integrator::Rk3;
        })
        .contains("rk3")
    );
    assert!(matches!(
        Dem::new(&{
            let mut s = good();
            s.contact = dem_solver::ContactLaw::LinearSpringDashpot(law(1.2, 1.0));
            s
        }),
        Err(SpecError::Model { .. })
    ));
}
