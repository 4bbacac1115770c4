//! Walls that turn, and walls that follow a pressure.

use crate::common::{cloud, contacts_after, dem, floor, law, momentum, repeats, spec};
use dem_solver::laws::walls::Plane;
use dem_solver::{DemSpec, Engine, Freedom, Grain, Integrator, Motion, OverTime, Servo, Vec3, Wall};

const INTEGRATORS: [Integrator; 3] =
    [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk3];

/// A sphere that does not roll, at `x`, in its static overlap on a floor of friction `mu` under gravity 1.
fn slider(x: f64, mu: f64) -> DemSpec {
    let mut law = law(0.5, 0.01);
    law.friction = mu;
    let mut grain = Grain::new([x, 0.0, 0.5 - 1.0 / law.pair().stiffness], 0.5, 1.0);
    grain.free = Freedom { rotation: [false; 3], ..Freedom::SPACE };
    let mut set_up = spec(vec![grain], law);
    set_up.gravity = [0.0, 0.0, -1.0].into();
    set_up
}

/// The force on a wall is the mean over the window: it gives grains that bounce within one their momentum,
/// though none touches the wall as the window ends.
#[test]
fn a_wall_bears_the_mean_over_the_window() {
    let grains = cloud(27, 3).into_iter().enumerate().map(|(k, mut grain)| {
        grain.position = [3.0 * k as f64, 0.0, grain.radius + 1e-3 * (k + 1) as f64];
        (grain.velocity, grain.spin) = ([0.3, 0.0, -1.0], [0.0; 3]);
        grain
    });
    let mut rough = law(0.5, 0.01);
    rough.friction = 0.3;
    let mut of_bulk = spec(grains.collect(), rough);
    of_bulk.walls.push(floor());
    of_bulk.engine = Engine::Bulk;
    let general = |integrator| DemSpec { integrator, engine: Engine::General, ..of_bulk.clone() };
    for set_up in INTEGRATORS.map(general).iter().chain([&of_bulk]) {
        let mut solver = dem(set_up);
        let before = momentum(&solver);
        assert_eq!(contacts_after(&mut solver, 0.1, 1000), 0, "no contact at the end");
        let gained = momentum(&solver) - before;
        let given = solver.observations().wall_contact[0] * -0.1;
        assert!(gained.z > 1.0 && gained.x.abs() > 0.01, "{gained}");
        assert!((given - gained).norm() < 1e-9 * gained.norm(), "{given} for {gained}");
    }
}

/// A plane turns about an axis beside it as the integral of a table says, whatever the instant.
#[test]
fn a_plane_turns_along_the_integral_of_its_spin() {
    let spin = OverTime::table(vec![(0.1, [0.0; 3]), (0.5, [0.0, 2.0, 0.0]), (0.8, [0.0, -1.0, 0.0])]);
    let drift = [0.3, 0.0, -0.1];
    let about = Some([1.0, 0.0, 0.0]);
    let wall = Wall { spin: spin.clone(), about, velocity: drift.into(), ..floor() };
    let plane = Plane::from(&wall);
    for t in [0.05, 0.3, 0.62, 2.0] {
        let angle = spin.integral(t)[1];
        let (sin, cos) = angle.sin_cos();
        let stand = plane.at(t);
        assert!((stand.normal - Vec3::new(sin, 0.0, cos)).norm() < 1e-15, "at {t}: {:?}", stand.normal);
        // The point that was the origin.
        let x = Vec3::new(1.0 - cos, 0.0, sin) + Vec3::from(drift) * t;
        assert!(stand.gap(&x, 0.0).abs() < 1e-15, "at {t}");
        let speed = spin.at(t)[1];
        let surface = Vec3::new(speed * sin, 0.0, speed * cos) + Vec3::from(drift);
        assert!((stand.velocity_at(&x) - surface).norm() < 1e-14, "at {t}: {:?}", stand.velocity_at(&x));
    }
}

/// A plate that turns about its normal: what lies on it at rest gains μ g t along ω × r, and what goes with
/// it goes in a circle, held by friction below μ g.
#[test]
fn a_plate_drags_grains_as_it_turns() {
    for integrator in INTEGRATORS {
        let (omega, r) = (0.5, 1.2);
        let plate = Wall { spin: [0.0, 0.0, omega].into(), about: Some([0.2, 0.0, 0.0]), ..floor() };
        let mut set_up = DemSpec { walls: vec![plate], integrator, ..slider(0.2 + r, 0.5) };
        let mut solver = dem(&set_up);
        solver.advance(0.1, 500, &[]).expect("advances");
        let v = solver.grains.velocity[0];
        // Within a tenth of a second it turns by 0.05 against the plate.
        assert!((v.y / 0.05 - 1.0).abs() < 2e-3 && v.x.abs() < 2e-3, "{integrator:?}: {v:?}");
        set_up.grains[0].velocity = [0.0, omega * r, 0.0];
        let mut solver = dem(&set_up);
        for window in 1..=80 {
            solver.advance(0.1, 500, &[]).expect("advances");
            let x = solver.grains.position[0] - Vec3::new(0.2, 0.0, 0.0);
            let angle = omega * 0.1 * f64::from(window);
            let off = x - Vec3::new(r * angle.cos(), r * angle.sin(), x.z);
            // The spring begins without a force, and gives m ω² r/k_t.
            assert!(off.norm() < 2e-4 * r, "{integrator:?}, window {window}: {off:?}");
        }
    }
}

/// A floor that tilts to 20° under a grain that it holds by friction: m g cos θ along its normal in the end,
/// m g sin θ across, and the grain where the plane has carried it.
#[test]
fn a_plane_that_tilts_holds_its_grain() {
    let theta = 20f64.to_radians();
    for integrator in INTEGRATORS {
        let spin = OverTime::table(vec![
            (0.0, [0.0; 3]),
            (1.0, [0.0, -theta / 2.0, 0.0]),
            (2.0, [0.0, -theta / 2.0, 0.0]),
            (3.0, [0.0; 3]),
        ]);
        let about = Some([-2.0, 0.0, 0.0]);
        let mut set_up =
            DemSpec { walls: vec![Wall { spin, about, ..floor() }], integrator, ..slider(0.0, 1.0) };
        let weight = std::f64::consts::PI / 6.0;
        set_up.periods[1] = Some((-5.0, 10.0));
        let mut solver = dem(&set_up);
        for _ in 0..50 {
            solver.advance(0.1, 500, &[]).expect("advances");
        }
        let contacts = solver.contact_list(&[]);
        let [contact] = &contacts[..] else { panic!("{integrator:?}: {} contacts", contacts.len()) };
        let (sin, cos) = theta.sin_cos();
        let (n, along) = (Vec3::new(-sin, 0.0, cos), Vec3::new(cos, 0.0, sin));
        let held = (contact.force.dot(&n), contact.force.dot(&along));
        assert_eq!(contact.wall, Some(0));
        assert!((held.0 / (weight * cos) - 1.0).abs() < 1e-3, "{integrator:?}: {held:?}");
        assert!((held.1 / (weight * sin) - 1.0).abs() < 1e-3, "{integrator:?}: {held:?}");
        // It does not turn, so that the plane rolls below it by R θ.
        let place = Vec3::new(-2.0, 0.0, 0.0) + along * (2.0 + 0.5 * theta) + n * 0.5;
        let off = solver.grains.position[0] - place;
        assert!(off.norm() < 2e-4, "{integrator:?}: {off:?}");
    }
}

/// 64 spheres between a floor and a lid with a servo, periodic along the floor.
fn pressed(pressure: OverTime<f64>, integrator: Integrator) -> DemSpec {
    let mut law = law(0.3, 0.01);
    (law.friction, law.damping_ratio) = (0.3, 0.5);
    let mut grains = cloud(64, 5);
    grains.iter_mut().for_each(|grain| (grain.velocity, grain.spin) = ([0.0; 3], [0.0; 3]));
    let mass = 16.0 / 0.95f64.powi(2);
    let servo = Servo { pressure, area: 4.4 * 4.4, largest_speed: 0.5, mass };
    let lid = Wall { servo: Some(servo), ..Wall::new([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]) };
    let walls = vec![floor(), lid];
    let periods = [Some((0.0, 4.4)), Some((0.0, 4.4)), None];
    DemSpec { walls, periods, integrator, ..spec(grains, law) }
}

/// The bed comes to rest at the pressure given, on lid and floor; the lid is never faster than allowed; and
/// another pressure later moves it again. What is saved on the way goes on in the same bits.
#[test]
fn a_lid_presses_a_bed_as_given() {
    for integrator in &INTEGRATORS[..2] {
        let pressure = OverTime::table(vec![(12.0, 5.0), (12.5, 20.0)]);
        let set_up = pressed(pressure, *integrator);
        let mut solver = dem(&set_up);
        let mut fastest = 0.0f64;
        for (until, pressure) in [(1200, 5.0), (2400, 20.0)] {
            while solver.windows() < until {
                solver.advance(0.01, 20, &[]).expect("advances");
                let (_, servo) = solver.servos().next().expect("a servo");
                fastest = fastest.max(servo.speed.abs());
                if solver.windows() == 300 {
                    let saved = repeats("a lid", &set_up, &mut solver, |dem| {
                        let report = dem.advance(0.01, 20, &[]).expect("advances");
                        (report, dem.servos().next().map(|(_, servo)| [servo.way, servo.speed]))
                    });
                    assert!(saved.servos[0][0] > 0.1, "{:?}: the lid is on its way", saved.servos);
                }
            }
            let (_, servo) = solver.servos().next().expect("a servo");
            let on = |wall: usize| {
                let contacts = solver.contact_list(&[]);
                let here = contacts.iter().filter(|contact| contact.wall == Some(wall));
                here.map(|contact| contact.force.z).sum::<f64>().abs() / (4.4 * 4.4)
            };
            for stress in [on(0), on(1), servo.stress().z] {
                assert!((stress / pressure - 1.0).abs() < 0.01, "{integrator:?}: {stress} for {pressure}");
            }
            // A thousandth of what it may do: the bed still creeps.
            assert!(servo.speed.abs() < 5e-4, "{integrator:?}: {} m/s", servo.speed);
        }
        assert!(fastest <= 0.5 && fastest > 0.3, "{integrator:?}: at most 0.5 m/s, {fastest}");
    }
}

/// A lid with nothing below: V = V_max (1 − e^(−t/τ)), τ = m V_max/(p A), from when it is there.
#[test]
fn a_lid_without_a_bed_keeps_its_limit() {
    let mut set_up = pressed(1.0.into(), Integrator::SymplecticEuler);
    set_up.grains.truncate(1);
    set_up.walls[1].from = 0.5;
    let mut solver = dem(&set_up);
    for _ in 0..100 {
        solver.advance(0.01, 20, &[]).expect("advances");
    }
    let (_, servo) = solver.servos().next().expect("a servo");
    let tau = 16.0 / 0.95f64.powi(2) * 0.5 / 4.4f64.powi(2);
    let part = 1.0 - (-0.5 / tau).exp();
    let (way, speed) = (0.5 * (0.5 - tau * part), 0.5 * part);
    let wrong = [servo.way_at(1.0) / way - 1.0, servo.speed / speed - 1.0];
    // The step is implicit and of first order, τ/1000.
    assert!(wrong.iter().all(|wrong| wrong.abs() < 2e-3), "{wrong:?}");
}

/// A layer that goes with the lid: it keeps its place on it, and its contacts are the lid's.
#[test]
fn a_layer_goes_with_its_lid() {
    for integrator in &INTEGRATORS[..2] {
        let mut set_up = pressed(5.0.into(), *integrator);
        set_up.walls[1].velocity = [0.2, 0.0, 0.0].into();
        for k in 0..16 {
            let [x, y] = [k % 4, k / 4].map(|n| 0.55 + 1.1 * f64::from(n));
            let mut grain = Grain::new([x, y, 5.0], 0.4, 1.0);
            grain.motion = Motion::Prescribed { velocity: [0.2, 0.0, 0.0].into(), spin: OverTime::default() };
            grain.wall = Some(1);
            set_up.grains.push(grain);
        }
        let mut solver = dem(&set_up);
        let (mut mean, mut begin) = (Vec3::zeros(), [0.0; 2]);
        for window in 0..2000 {
            solver.advance(0.01, 20, &[]).expect("advances");
            let (_, servo) = solver.servos().next().expect("a servo");
            let height = 5.0 - servo.way_at(solver.time());
            let off = solver.grains.position[70].z - height;
            assert!(off.abs() < 1e-12, "{integrator:?}, window {window}: {off}");
            if window >= 1000 {
                mean += servo.stress() / 1000.0;
            } else {
                begin = [servo.way_at(solver.time()), servo.speed];
            }
        }
        // Momentum of the lid over ten seconds: what is not its load has settled the bed, or is in its speed.
        let (_, servo) = solver.servos().next().expect("a servo");
        let [way, speed] = [servo.way_at(solver.time()) - begin[0], servo.speed - begin[1]];
        let gained = 16.0 / 0.95f64.powi(2) / 4.4f64.powi(2) * speed / 10.0;
        let load = 5.0 * (1.0 - way / (0.5 * 10.0)) - gained;
        // Verlet's force is that of the end of a sub-step.
        assert!((mean.z / load - 1.0).abs() < 1e-5, "{integrator:?}: {mean:?} for {load}");
        assert!((load / 5.0 - 1.0).abs() < 0.05, "{integrator:?}: {load}");
        assert!(mean.x < -0.3, "{integrator:?}: {mean:?} holds the lid back");
    }
}

/// What cannot be is named.
#[test]
fn wrong_walls_are_refused() {
    type Change<'a> = &'a dyn Fn(&mut DemSpec);
    let refused = |change: Change<'_>| {
        let mut set_up = pressed(1.0.into(), Integrator::SymplecticEuler);
        change(&mut set_up);
        set_up.validate().expect_err("wrong").to_string()
    };
    let servo = |set_up: &mut DemSpec, change: &dyn Fn(&mut Servo)| {
        change(set_up.walls[1].servo.as_mut().expect("a servo"));
    };
    let cases: [(&str, Change<'_>); 10] = [
        ("the bulk engine", &|s| s.engine = Engine::Bulk),
        ("rk3", &|s| s.integrator = Integrator::Rk3),
        ("along every periodic axis", &|s| s.walls[0].spin = [0.0, 0.0, 1.0].into()),
        ("along the normal", &|s| {
            s.periods = [None; 3];
            s.walls[1].spin = [1.0, 0.0, 0.0].into();
        }),
        ("keeps its direction", &|s| {
            s.walls[0].spin = OverTime::table(vec![(0.0, [1.0, 0.0, 0.0]), (1.0, [0.0, 1.0, 0.0])]);
        }),
        ("area is 0", &|s| servo(s, &|it| it.area = 0.0)),
        ("largest speed is -1", &|s| servo(s, &|it| it.largest_speed = -1.0)),
        ("pressure is -2", &|s| servo(s, &|it| it.pressure = (-2.0).into())),
        ("grain 3: wall is 7", &|s| {
            s.grains[3].motion = Motion::Fixed;
            s.grains[3].wall = Some(7);
        }),
        ("wall is 1", &|s| s.grains[3].wall = Some(1)),
    ];
    for (words, change) in cases {
        let error = refused(change);
        assert!(error.contains(words), "{words}: {error}");
    }
}
