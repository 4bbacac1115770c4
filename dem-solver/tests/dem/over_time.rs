//! Gravity, walls and grains whose values change over time, against exact motion.

use crate::common::{contacts_after, dem, floor, law, repeats, spec};
use dem_solver::{BulkSettings, DemSpec, Engine, Freedom, Grain, Integrator, Motion, OverTime, Sine, Wall};
use std::f64::consts::TAU;

fn sine(amplitude: [f64; 3], frequency: f64) -> OverTime<[f64; 3]> {
    OverTime::sine(Sine { amplitude, frequency, phase: 0.4, offset: [0.1, 0.0, 0.0] })
}

const ENGINES: [(Engine, Integrator); 4] = [
    (Engine::Bulk, Integrator::SymplecticEuler),
    (Engine::General, Integrator::SymplecticEuler),
    (Engine::General, Integrator::VelocityVerlet),
    (Engine::General, Integrator::Rk3),
];

/// A sphere that does not turn, in its static overlap on a floor of friction µ.
fn block(mu: f64) -> DemSpec {
    let mut law = law(0.5, 0.01);
    law.friction = mu;
    let mut grain = Grain::new([0.0, 0.0, 0.5 - 1.0 / law.pair().stiffness], 0.5, 1.0);
    grain.free = Freedom { translation: [true, false, true], rotation: [false; 3] };
    let mut set_up = spec(vec![grain], law);
    set_up.walls = vec![floor()];
    set_up
}

/// Gravity that turns from (0, −1) to (1, −1) in 40 s: the block slides from tan θ = µ on, and then gains
/// ∫ (g_x − µ g) dt. What the spring lets it creep before that is 4e-3 of it.
#[test]
fn a_block_slides_from_the_angle_of_friction_on() {
    let (mu, until) = (0.4, 40.0);
    for (engine, integrator) in ENGINES {
        let mut set_up = block(mu);
        (set_up.engine, set_up.integrator) = (engine, integrator);
        set_up.gravity = OverTime::table(vec![(0.0, [0.0, 0.0, -1.0]), (until, [1.0, 0.0, -1.0])]);
        let mut solver = dem(&set_up);
        let mut before = f64::NAN;
        for window in 0..400 {
            solver.advance(0.1, 200, &[]).expect("advances");
            if window == 155 {
                before = solver.grains.velocity[0].x;
            }
        }
        // At 15.6 s of the 16 s it sticks.
        assert!(before.abs() < 1e-4, "{engine:?} {integrator:?}: slides at {before} too early");
        let slides = 0.5 * (1.0 - mu).powi(2) * until;
        let gained = solver.grains.velocity[0].x;
        assert!((gained / slides - 1.0).abs() < 4e-3, "{engine:?} {integrator:?}: {gained} of {slides}");
    }
}

/// A sphere on a floor that shakes with half of gravity goes with it, pressed in by m (g + a)/k.
#[test]
fn a_sphere_goes_with_a_shaken_floor() {
    let (frequency, g) = (0.5, 1.0);
    let speed = 0.5 * g / (TAU * frequency);
    for (engine, integrator) in ENGINES {
        let mut set_up = block(0.3);
        let swing = Sine { amplitude: [0.0, 0.0, speed], frequency, phase: 0.0, offset: [0.0; 3] };
        set_up.walls = vec![Wall { velocity: OverTime::sine(swing), ..floor() }];
        set_up.gravity = [0.0, 0.0, -g].into();
        (set_up.engine, set_up.integrator) = (engine, integrator);
        let mut solver = dem(&set_up);
        let stiffness = law(0.5, 0.01).pair().stiffness;
        for window in 1..=200 {
            solver.advance(0.05, 250, &[]).expect("advances");
            let angle = TAU * frequency * 0.05 * f64::from(window);
            let (height, acceleration) =
                (speed / (TAU * frequency) * (1.0 - angle.cos()), 0.5 * g * angle.cos());
            let overlap = (height + 0.5 - solver.grains.position[0].z) * stiffness;
            // The contact rings for some contact times after the start.
            if window > 4 {
                let wrong = overlap - (g + acceleration);
                assert!(wrong.abs() < 0.01 * g, "{engine:?} {integrator:?}, window {window}: {wrong}");
            }
        }
    }
}

/// Everything at once: both engines agree to round-off, and what is saved goes on in the same bits.
#[test]
fn engines_agree_and_go_on() {
    let mut grains = Vec::new();
    for k in 0..27 {
        let [x, y, z] = [k % 3, k / 3 % 3, k / 9].map(|n| 0.5 + 1.02 * f64::from(n));
        grains.push(Grain::new([x, y, z], 0.5, 1.0));
    }
    let swing = sine([0.3, 0.0, 0.2], 3.0);
    grains[13].motion =
        Motion::Prescribed { velocity: swing, spin: sine([0.0, 2.0, 0.0], 2.0).map(|w| [0.0, w[1], 0.0]) };
    let mut law = law(0.6, 0.02);
    law.friction = 0.4;
    let mut set_up = spec(grains, law);
    let lid = OverTime::table(vec![(0.05, [0.0; 3]), (0.2, [0.5, 0.0, -0.4]), (0.31, [0.5, 0.0, 0.0])]);
    set_up.walls = vec![floor(), Wall { velocity: lid, ..Wall::new([0.0, 0.0, 3.1], [0.0, 0.0, -1.0]) }];
    set_up.gravity = OverTime::table(vec![(0.0, [0.0, 0.0, -9.0]), (0.25, [4.0, 1.0, -8.0])]);
    set_up.engine = Engine::Bulk;
    let (mut bulk, mut general) = (dem(&set_up), dem(&DemSpec { engine: Engine::General, ..set_up.clone() }));
    let mut fine = dem(&DemSpec { bulk: BulkSettings { plain: true, ..set_up.bulk }, ..set_up.clone() });
    for window in 0..30 {
        let met = [&mut bulk, &mut general, &mut fine].map(|dem| contacts_after(dem, 0.01, 20));
        assert!(met[0] == met[1] && met[0] == met[2], "window {window}: {met:?}");
        for i in 0..bulk.grains.len() {
            let apart = (bulk.grains.position[i] - general.grains.position[i]).norm();
            assert!(apart < 1e-10, "window {window}, grain {i}: {apart}");
            assert_eq!(bulk.grains.position[i], fine.grains.position[i], "window {window}, grain {i}");
        }
    }
    assert!(bulk.grains.velocity.iter().any(|v| v.x > 0.1), "something moves");
    for (what, solver) in [("bulk", &mut bulk), ("general", &mut general)] {
        let own = DemSpec {
            engine: if solver.is_bulk() { Engine::Bulk } else { Engine::General },
            ..set_up.clone()
        };
        repeats(what, &own, solver, |dem| dem.advance(0.01, 20, &[]).expect("advances"));
    }
}

/// A path is exact whatever the sub-steps: the integral of a table with corners within them.
#[test]
fn a_table_leads_along_its_integral() {
    let velocity =
        OverTime::table(vec![(0.011, [0.0; 3]), (0.5, [1.0, 0.0, -2.0]), (0.7731, [-1.0, 0.0, 0.5])]);
    let spin = OverTime::table(vec![(0.0, [0.0, 1.0, 0.0]), (0.63, [0.0, -2.0, 0.0])]);
    let mut grain = Grain::new([0.0; 3], 0.5, 1.0);
    grain.motion = Motion::Prescribed { velocity: velocity.clone(), spin: spin.clone() };
    for (engine, integrator) in &ENGINES[..3] {
        let mut set_up = spec(vec![grain.clone()], law(0.5, 0.01));
        (set_up.engine, set_up.integrator) = (*engine, *integrator);
        let mut solver = dem(&set_up);
        for _ in 0..10 {
            solver.advance(0.1, 7, &[]).expect("advances");
        }
        let g = &solver.grains;
        for c in 0..3 {
            let wrong = g.position[0][c] - velocity.integral(1.0)[c];
            assert!(wrong.abs() < 1e-14, "{engine:?} {integrator:?}: {wrong:e} along {c}");
        }
        let turned = g.orientation[0].scaled_axis().y - spin.integral(1.0)[1];
        assert!(turned.abs() < 1e-13, "{engine:?} {integrator:?}: {turned:e}");
        assert_eq!(<[f64; 3]>::from(g.velocity[0]), [-1.0, 0.0, 0.5]);
    }
}

/// Where nothing can be touched a window is one sub-step, and its path exact.
#[test]
fn a_lone_grain_falls_as_gravity_says_whatever_the_window() {
    let ramp = OverTime::table(vec![(0.0, [0.0; 3]), (1.0, [0.0, 0.0, -10.0])]);
    for (gravity, falls) in [(ramp, -35.0 / 3.0), (sine([0.0, 0.0, 3.0], 1.0), f64::NAN)] {
        // of the sine: 3 ∫ sin(2π s + 0.4) (2 − s) ds
        let falls = if falls.is_nan() { 3.0 * 2.0 * 0.4_f64.cos() / TAU } else { falls };
        for windows in [1, 7, 200] {
            let mut set_up = spec(vec![Grain::new([0.0; 3], 0.5, 1.0)], law(0.5, 0.01));
            set_up.gravity = gravity.clone();
            let mut solver = dem(&set_up);
            for _ in 0..windows {
                solver.advance(2.0 / f64::from(windows), 1, &[]).expect("advances");
            }
            let wrong = solver.grains.position[0].z - falls;
            assert!(wrong.abs() < 1e-12, "{gravity:?} in {windows} windows: {wrong:e}");
        }
    }
}
