//! The engine for many grains: the general one's results to round-off, and the same bits however it works.
use crate::common::{
    Random, angular_momentum, cloud, contacts, contacts_after, dem, floor, law, momentum, repeats, spec,
};
use dem_solver::BulkSettings;
use dem_solver::{
    Dem, DemSpec, Engine, Freedom, Grain, GrainLoad, Integrator, Motion, OverTime, Shape, Sine, State, Vec3,
    Wall,
};
use std::f64::consts::TAU;

/// Grains that fall and shear: periodic faces, a floor, a lid that moves, a gate that vanishes, fixed and
/// driven grains.
fn busy(n: usize, friction: f64) -> DemSpec {
    let mut law = law(0.6, 0.03);
    law.friction = friction;
    let mut grains = cloud(n, 5);
    let side = (1..).find(|side: &usize| side.pow(3) >= n).expect("a cube") as f64 * 1.1;
    for k in (0..n).step_by(37) {
        grains[k].motion = match k % 3 {
            0 => Motion::Fixed,
            1 => Motion::Prescribed { velocity: [0.2, 0.0, 0.05].into(), spin: [0.0, 1.0, 0.0].into() },
            _ => Motion::Prescribed {
                velocity: OverTime::sine(Sine {
                    amplitude: [0.18, 0.0, 0.09],
                    frequency: 9.0 / TAU,
                    phase: 1.9,
                    offset: [0.0; 3],
                }),
                spin: OverTime::table(vec![(0.0, [0.0; 3]), (0.03, [0.0, 2.0, 0.0])]),
            },
        };
    }
    let mut set_up = spec(grains, law);
    set_up.walls = vec![
        floor(),
        Wall { velocity: [0.3, 0.0, -0.4].into(), ..Wall::new([0.0, 0.0, side + 0.2], [0.0, 0.0, -1.0]) },
        Wall { until: Some(0.05), ..Wall::new([0.1, 0.0, 0.0], [1.0, 0.0, 0.0]) },
        Wall { from: 0.03, ..Wall::new([side, 0.0, 0.0], [-1.0, 0.0, 0.0]) },
    ];
    set_up.periods = [None, Some((-0.3, side)), None];
    set_up.gravity = [1.0, 0.0, -9.0].into();
    set_up.engine = Engine::Bulk;
    set_up
}

fn general(set_up: &DemSpec) -> DemSpec {
    DemSpec { engine: Engine::General, ..set_up.clone() }
}

/// Largest difference of positions and velocities of two runs.
fn apart(a: &Dem, b: &Dem) -> (f64, f64) {
    let largest = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    (largest(&a.grains.position, &b.grains.position), largest(&a.grains.velocity, &b.grains.velocity))
}

fn agree(set_up: &DemSpec, loads: &[GrainLoad], windows: usize) {
    let (mut bulk, mut plain) = (dem(set_up), dem(&general(set_up)));
    assert!(bulk.is_bulk() && !plain.is_bulk());
    let (mut met, mut rubbed, mut borne) = (0, false, 0.0f64);
    for window in 0..windows {
        let a = bulk.advance(2e-3, 10, loads).expect("advances");
        let b = plain.advance(2e-3, 10, loads).expect("advances");
        let touching = contacts(&bulk);
        assert_eq!((touching, a.n_sub_done), (contacts(&plain), b.n_sub_done), "window {window}");
        let [fastest, other] =
            [&bulk, &plain].map(|dem| dem.grains.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max));
        for (what, a, b) in [
            ("overlap", a.largest_overlap, b.largest_overlap),
            ("gap", a.smallest_gap, b.smallest_gap),
            ("speed", fastest, other),
        ] {
            assert!(a == b || (a - b).abs() < 1e-11, "window {window}: {what} {a} and {b}");
        }
        let seen = [&bulk, &plain].map(|dem| &dem.observations().wall_contact);
        assert_eq!(seen.map(Vec::len), [set_up.walls.len(); 2]);
        for (a, b) in seen[0].iter().zip(seen[1]) {
            assert!((a - b).norm() < 1e-9 * (1.0 + b.norm()), "window {window}: {a} and {b}");
            borne = borne.max(a.norm());
        }
        met += touching;
        rubbed |= bulk.save().contacts.iter().any(|contact| contact.spring != [0.0; 3]);
    }
    assert!(met > 10 * windows && rubbed && borne > 0.0, "{met} contacts, {borne} N on walls");
    let (x, v) = apart(&bulk, &plain);
    println!("{} grains, {windows} windows: {x:e} m, {v:e} m/s", set_up.grains.len());
    // sizes and speeds are of order 1
    assert!(x < 1e-12 && v < 1e-11, "{x:e} m, {v:e} m/s apart");
    let (a, b) = (bulk.save(), plain.save());
    let list = |state: &State| -> Vec<(u32, u32)> {
        state.contacts.iter().chain(&state.wall_contacts).map(|c| (c.first, c.second)).collect()
    };
    assert_eq!(list(&a), list(&b));
    for (a, b) in a.contacts.iter().zip(&b.contacts).chain(a.wall_contacts.iter().zip(&b.wall_contacts)) {
        assert!((Vec3::from(a.spring) - Vec3::from(b.spring)).norm() < 1e-12, "{a:?} {b:?}");
    }
    let (a, b) = (bulk.observations(), plain.observations());
    for i in 0..set_up.grains.len() {
        assert!((a.mean_contact[i] - b.mean_contact[i]).norm() < 1e-9 * (1.0 + b.mean_contact[i].norm()));
        assert!(a.gap_end[i] == b.gap_end[i] || (a.gap_end[i] - b.gap_end[i]).abs() < 1e-12);
        let turned = bulk.grains.orientation[i].angle_to(&plain.grains.orientation[i]);
        assert!(turned < 1e-7, "grain {i} is turned by {turned}");
    }
    assert!((bulk.elastic_energy() - plain.elastic_energy()).abs() < 1e-3 * plain.elastic_energy());
}

#[test]
fn bulk_and_general_engine_agree_to_round_off() {
    agree(&busy(300, 0.4), &[], 30);
}

#[test]
fn they_agree_across_blocks() {
    agree(&busy(1500, 0.3), &[], 20);
}

#[test]
fn they_agree_without_a_tangential_dashpot() {
    use dem_solver::ContactLaw::LinearSpringDashpot as Linear;
    let mut set_up = busy(300, 0.2);
    let Linear(law) = &mut set_up.contact else { unreachable!() };
    law.damping_ratio = 0.0;
    agree(&set_up, &[], 20);
}

#[test]
fn they_agree_under_loads_and_locks() {
    let mut set_up = busy(300, 0.3);
    for (k, grain) in set_up.grains.iter_mut().enumerate() {
        grain.free = match k % 4 {
            0 => Freedom::PLANE,
            1 => Freedom::AXIS,
            _ => Freedom::SPACE,
        };
    }
    let load = |i: usize| GrainLoad {
        force: Vec3::new(0.01 * (i % 9) as f64, 0.0, 0.1),
        torque: Vec3::y() * 1e-3,
        added_mass: 0.2,
        added_inertia: 0.01,
    };
    set_up.gravity = OverTime::table(vec![(0.01, [0.0, 0.0, -9.0]), (0.03, [2.0, 1.0, -8.0])]);
    agree(&set_up, &(0..300).map(load).collect::<Vec<_>>(), 20);
}

#[test]
fn they_agree_for_discs() {
    let mut law = law(0.5, 0.03);
    law.friction = 0.5;
    let mut random = Random(3);
    let grains = (0..300)
        .map(|k| {
            let place = [0.55 + 1.1 * f64::from(k % 20), 0.0, 0.55 + 1.1 * f64::from(k / 20)];
            let mut grain = Grain::new(place, 0.45 + 0.1 * random.next(), 2.0);
            grain.velocity = random.vector(-1.0, 1.0);
            grain.free = Freedom::PLANE;
            grain
        })
        .collect();
    let mut set_up = spec(grains, law);
    set_up.shape = Shape::Disc;
    set_up.walls = vec![floor()];
    set_up.periods = [Some((0.0, 22.0)), None, None];
    set_up.gravity = [0.0, 0.0, -60.0].into();
    set_up.engine = Engine::Bulk;
    agree(&set_up, &[], 30);
}

/// State after some windows, and how often lists were built.
fn run(set_up: &DemSpec, bulk: BulkSettings, windows: usize) -> (State, u64) {
    let mut solver = dem(&DemSpec { bulk, ..set_up.clone() });
    for _ in 0..windows {
        solver.advance(4e-3, 20, &[]).expect("advances");
    }
    (solver.save(), solver.list_builds())
}

#[test]
fn threads_wavefront_skin_and_vectors_change_no_bit() {
    let set_up = busy(9000, 0.4);
    let standard = BulkSettings::default();
    let (reference, _) = run(&set_up, standard, 12);
    assert!(reference.contacts.len() > 1000, "{} contacts", reference.contacts.len());
    for threads in [1, 2, 4] {
        for depth in [1, 3, 8] {
            let (state, _) = run(&set_up, BulkSettings { threads, depth, ..standard }, 12);
            assert!(state == reference, "{threads} threads, depth {depth}");
        }
    }
    let (state, _) = run(&set_up, BulkSettings { plain: true, ..standard }, 12);
    assert!(state == reference, "without wide vectors");
    let (narrow, many) = run(&set_up, BulkSettings { skin: Some(0.02), ..standard }, 12);
    let (wide, few) = run(&set_up, BulkSettings { skin: Some(0.4), ..standard }, 12);
    assert!(many > 3 * few, "{many} and {few} builds");
    assert!(narrow == reference && wide == reference, "the skin changed the result");
}

/// A bed on 900 fixed grains, slow but for a few grains that fall into it fast.
fn rain_on_a_bed() -> DemSpec {
    let mut grains = cloud(6000, 11);
    for (k, grain) in grains.iter_mut().enumerate() {
        grain.velocity = if k > 5800 && k % 40 == 0 { [0.0, 0.0, -60.0] } else { [0.0; 3] };
        grain.spin = [0.0; 3];
    }
    for k in 0..900 {
        let mut grain = Grain::new([f64::from(k % 30) * 0.7, f64::from(k / 30) * 0.7, 0.1], 0.45, 1.0);
        grain.motion = Motion::Fixed;
        // not in one piece by their numbers either
        grains.insert(7 * k as usize, grain);
    }
    let mut law = law(0.6, 0.03);
    law.friction = 0.4;
    let mut set_up = spec(grains, law);
    set_up.walls = vec![floor()];
    set_up.gravity = [0.0, 0.0, -9.0].into();
    set_up.engine = Engine::Bulk;
    set_up
}

#[test]
fn blocks_of_fixed_grains_change_nothing_asleep_or_awake() {
    let awake = rain_on_a_bed();
    let asleep = DemSpec { observations: false, orientation: false, ..awake.clone() };
    agree(&awake, &[], 20);
    let (mut a, mut b, mut c) = (dem(&awake), dem(&asleep), dem(&asleep));
    for window in 0..20 {
        let touching = contacts_after(&mut a, 4e-3, 20);
        assert_eq!(touching, contacts_after(&mut b, 4e-3, 20), "window {window}");
        // now and then somebody looks
        c.set_observations(window % 3 == 1);
        assert_eq!(touching, contacts_after(&mut c, 4e-3, 20), "window {window}");
        if window % 3 == 1 {
            assert!(a.observations().mean_contact == c.observations().mean_contact, "window {window}");
        }
    }
    let strip = |dem: &Dem| State { orientation: Vec::new(), ..dem.save() };
    assert!(strip(&a).contacts.len() > 1000);
    assert!(strip(&a) == strip(&b) && strip(&a) == strip(&c));
}

#[test]
fn skins_that_differ_from_block_to_block_change_no_bit() {
    let set_up = DemSpec { observations: false, ..rain_on_a_bed() };
    let standard = BulkSettings::default();
    let (reference, _) = run(&set_up, standard, 20);
    for threads in [1, 2, 3] {
        for skin in [None, Some(0.02), Some(0.4)] {
            let (state, _) = run(&set_up, BulkSettings { threads, skin, ..standard }, 20);
            assert!(state == reference, "{threads} threads, skin {skin:?}");
        }
    }
    let mut solver = dem(&set_up);
    solver.advance(4e-3, 20, &[]).expect("advances");
    repeats("rain on a bed", &set_up, &mut solver, |solver| solver.advance(4e-3, 20, &[]).expect("advances"));
}

/// At rest nothing tells how fast the grains will be: a stretch must be given up and done again.
#[test]
fn outrun_lists_are_noticed() {
    let mut set_up = busy(600, 0.4);
    for grain in &mut set_up.grains {
        grain.motion = Motion::Free;
        grain.velocity = [0.0; 3];
        grain.spin = [0.0; 3];
    }
    set_up.walls.truncate(1);
    set_up.gravity = [0.0, 0.0, -400.0].into();
    set_up.bulk.skin = Some(0.01);
    let (mut bulk, mut plain) = (dem(&set_up), dem(&general(&set_up)));
    for _ in 0..2 {
        assert_eq!(contacts_after(&mut bulk, 0.02, 200), contacts_after(&mut plain, 0.02, 200));
    }
    assert!(bulk.list_builds() > 10);
    let (x, v) = apart(&bulk, &plain);
    assert!(x < 1e-11 && v < 1e-9, "{x:e} m, {v:e} m/s apart");
}

#[test]
fn momentum_and_angular_momentum_are_kept_to_round_off() {
    let mut law = law(0.8, 0.05);
    law.friction = 0.5;
    let mut set_up = spec(cloud(1200, 1), law);
    set_up.engine = Engine::Bulk;
    let mut solver = dem(&set_up);
    let (p, l) = (momentum(&solver), angular_momentum(&solver));
    let scale = (2.0 * solver.kinetic_energy() * solver.grains.mass.iter().sum::<f64>()).sqrt();
    let mut met = 0;
    for _ in 0..100 {
        met += contacts_after(&mut solver, 0.01, 10);
    }
    assert!(met > 10_000, "the grains must collide");
    assert!((momentum(&solver) - p).norm() < 1e-13 * scale, "{}", (momentum(&solver) - p).norm());
    let turned = (angular_momentum(&solver) - l).norm();
    assert!(turned < 1e-12 * 12.0 * scale, "{turned}");
}

#[test]
fn restored_runs_repeat_bit_for_bit() {
    let set_up = busy(1200, 0.4);
    let mut solver = dem(&set_up);
    let start = solver.save();
    for _ in 0..60 {
        solver.advance(4e-3, 20, &[]).expect("advances");
    }
    let saved =
        repeats("bulk", &set_up, &mut solver, |solver| solver.advance(4e-3, 20, &[]).expect("advances"));
    // from the very beginning, before there is an order
    solver.restore(&start).expect("restores");
    for _ in 0..60 {
        solver.advance(4e-3, 20, &[]).expect("advances");
    }
    assert!(solver.save() == saved);
}

#[test]
fn an_order_that_is_none_is_refused() {
    let mut solver = dem(&busy(300, 0.4));
    solver.advance(4e-3, 20, &[]).expect("advances");
    let mut state = solver.save();
    state.order[3] = state.order[4];
    assert!(matches!(solver.restore(&state), Err(dem_solver::RestoreError::Order { grains: 300 })));
}

#[test]
fn scenes_it_cannot_run_are_refused_by_name() {
    let refusal = |change: &dyn Fn(&mut DemSpec)| {
        let mut set_up = busy(300, 0.4);
        change(&mut set_up);
        let automatic = DemSpec { engine: Engine::Auto, ..set_up.clone() };
        assert!(!dem(&automatic).is_bulk());
        Dem::new(&set_up).expect_err("refused").to_string()
    };
    let text = refusal(&|set_up| set_up.integrator = Integrator::VelocityVerlet);
    assert!(text.contains("symplectic-euler"), "{text}");
    let text = refusal(&|set_up| set_up.grains[7].free.translation = [false; 3]);
    assert!(text.contains("grain 7"), "{text}");
    assert!(dem(&DemSpec { engine: Engine::Auto, ..busy(300, 0.4) }).is_bulk());
    assert!(!dem(&DemSpec { engine: Engine::Auto, ..busy(30, 0.4) }).is_bulk());
}

#[test]
fn a_state_that_stops_being_finite_is_named() {
    let mut set_up = busy(5000, 0.4);
    set_up.bulk.threads = 2;
    let mut solver = dem(&set_up);
    solver.advance(2e-3, 10, &[]).expect("advances");
    solver.grains.velocity[700].x = 1e200;
    let report = solver.advance(2e-3, 10, &[]).expect("advances");
    assert_eq!(report.n_sub_done, 1);
    assert_eq!(report.first_non_finite.map(|fault| fault.grain), Some(700));
}

#[test]
fn a_grain_that_leaves_through_a_wall_is_named() {
    let mut set_up = busy(300, 0.4);
    set_up.grains[200].velocity = [0.0, 0.0, -3000.0];
    set_up.grains[200].motion = Motion::Free;
    for engine in [Engine::Bulk, Engine::General] {
        let mut solver = dem(&DemSpec { engine, ..set_up.clone() });
        let report = solver.advance(0.02, 4, &[]).expect("advances");
        assert_eq!((report.first_non_finite, report.lost), (None, Some(200)), "{engine:?}");
    }
}

/// The smallest gap of a window in which nothing is near is that of all pairs and walls, however many there
/// are, across a period, too.
#[test]
fn the_smallest_gap_is_known_where_nothing_is_near() {
    for (engine, count) in [(Engine::General, 64), (Engine::General, 65), (Engine::Bulk, 300)] {
        // spheres on a line, the nearest ones over the edge of the box, or one above a floor
        for (edge, height, gap) in [(0.3, 9.0, 0.3), (8.0, 9.0, 2.0), (8.0, 2.2, 1.7)] {
            let grain = |k: usize| Grain::new([3.0 * k as f64, 0.0, height], 0.5, 1.0);
            let mut set_up = spec((0..count).map(grain).collect(), law(0.5, 0.01));
            (set_up.engine, set_up.walls) = (engine, vec![floor()]);
            set_up.periods[0] = Some((0.0, 3.0 * (count - 1) as f64 + 1.0 + edge));
            let mut solver = dem(&set_up);
            let found = solver.advance(0.01, 2, &[]).expect("advances").smallest_gap;
            assert!((found - gap).abs() < 1e-9, "{engine:?}, {count}: {found} for {gap}");
        }
    }
}
