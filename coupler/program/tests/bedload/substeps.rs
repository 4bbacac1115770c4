//! The sub-step rule against exact motion on a line: whenever it says that nothing can touch, nothing
//! touches; and the planner's windows.

use bedload_scene::{CheckedScene, Observe, SceneSource};
use coupler::config::Coupling;
use coupler::plan::{Participants, Plan};
use coupler::scheme::{AHEAD, ContactFreeHorizon, Planner};
use protocol::message::{Kinematics, Loads};
use protocol::participant::Window;

/// SplitMix64 (Vigna 2015), so that every run tests the same cases.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Of either sign, over six decades.
    fn wide(&mut self) -> f64 {
        let size = 10f64.powf(self.between(-4.0, 2.0));
        if self.unit() < 0.5 { -size } else { size }
    }
}

const RADIUS: f64 = 0.5;

/// Two spheres on the z axis over a floor.
fn scene(low: f64, high: f64, gravity: f64) -> CheckedScene {
    let text = format!(
        "until = 1.0\ngravity = [0.0, 0.0, {gravity:?}]\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, \
         0.0]\nupper = [8.0, 8.0, 64.0]\n\
         boundary = {{ x = \"periodic\", y = \"periodic\", z = \"no-slip\" }}\n\
         [[grains]]\nposition = [4.0, 4.0, {low:?}]\nradius = {RADIUS:?}\ndensity = 2.0\n\
         [[grains]]\nposition = [4.0, 4.0, {high:?}]\nradius = {RADIUS:?}\ndensity = 2.0\n"
    );
    CheckedScene::new(SceneSource { file: "fuzz.toml".into(), text }).expect("a good scene")
}

fn smallest_gap(low: f64, high: f64) -> f64 {
    (high - low - 2.0 * RADIUS).min(low - RADIUS).min(64.0 - high - RADIUS)
}

#[test]
fn no_contact_is_ever_missed() {
    let mut random = Random(7);
    let (mut quiet, mut touched) = (0, 0);
    for _ in 0..4000 {
        let (low, high) = (random.between(0.6, 30.0), random.between(31.5, 63.0));
        let (range, gravity) = (random.between(0.0, 0.5), -random.unit() * 10.0);
        let scene = scene(low, high, gravity);
        let mass = scene.grains[0].mass();
        let rule = ContactFreeHorizon::new(&scene, range);
        let (mut z, mut v) = ([low, high], [random.wide(), random.wide()]);
        let forces = [random.wide(), random.wide()].map(|force| force * mass);
        let kinematics = |z: &[f64; 2], v: &[f64; 2]| -> Vec<Kinematics> {
            let gap = smallest_gap(z[0], z[1]);
            (0..2)
                .map(|i| Kinematics {
                    position: [4.0, 4.0, z[i]],
                    velocity: [0.0, 0.0, v[i]],
                    gap,
                    ..Kinematics::default()
                })
                .collect()
        };
        let loads: Vec<Loads> =
            forces.iter().map(|force| Loads { force: [0.0, 0.0, *force], ..Loads::default() }).collect();
        let contact_free_for = rule.contact_free_for(&loads, &kinematics(&z, &v)).min(1e3);
        assert!(contact_free_for >= 0.0);
        if contact_free_for == 0.0 {
            assert!(smallest_gap(z[0], z[1]) <= range);
            continue;
        }
        quiet += 1;
        // Loads change sign and size, up to twice, at eight random instants; between them the motion
        // is a parabola, whose turning points are looked at too.
        for _ in 0..8 {
            let dt = contact_free_for / 8.0;
            let a: [f64; 2] = std::array::from_fn(|i| gravity + forces[i] / mass * random.between(-2.0, 2.0));
            for part in 1..=16 {
                let t = dt * f64::from(part) / 16.0;
                let at = |i: usize| z[i] + v[i] * t + 0.5 * a[i] * t * t;
                assert!(smallest_gap(at(0), at(1)) >= range * (1.0 - 1e-9), "touched within the quiet time");
            }
            for i in 0..2 {
                z[i] += v[i] * dt + 0.5 * a[i] * dt * dt;
                v[i] += a[i] * dt;
            }
        }
        // The rule is no excuse for never using one sub-step: approaching grains do touch soon after.
        let approach = v[0] - v[1];
        if approach > 0.0 && smallest_gap(z[0], z[1]) < 40.0 * approach * contact_free_for {
            touched += 1;
        }
    }
    assert!(quiet > 3000, "the rule must find quiet times: {quiet}");
    assert!(touched > 500, "the cases must be dangerous: {touched}");
}

#[test]
fn a_prescribed_swing_and_a_moving_wall_count() {
    let text = "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [8.0, 8.0, 8.0]\n\
        boundary = { x = \"periodic\", y = \"periodic\", z_lower = \"no-slip\", z_upper = { type \
        = \"no-slip\", velocity = [3.0, 0.0, 0.0] } }\n\
        [[grains]]\nposition = [4.0, 4.0, 4.0]\nradius = 0.5\ndensity = 2.0\nmotion = \"prescribed\"\n\
        velocity = { amplitude = [0.0, 0.0, 2.0], frequency = 5.0 }\n";
    let scene = CheckedScene::new(SceneSource { file: "swing.toml".into(), text: text.into() }).unwrap();
    let rule = ContactFreeHorizon::new(&scene, 0.1);
    // At rest for an instant, 1 m from the wall: with a = 2π·5·2 = 62.8 the rule must not wait long.
    let still = Kinematics { gap: 1.0, ..Kinematics::default() };
    let quiet = rule.contact_free_for(&[Loads::default()], &[still]);
    let (room, v, a) = (0.9, 2.0 * 3.0, 2.0 * 62.83185307179586);
    assert!((v * quiet + 0.5 * a * quiet * quiet - room).abs() < 1e-12, "{quiet}");
    assert_eq!(rule.contact_free_for(&[Loads::default()], &[Kinematics::default()]), 0.0, "no gap is known");
    let lost = Kinematics { gap: f64::NAN, ..Kinematics::default() };
    assert_eq!(rule.contact_free_for(&[Loads::default()], &[lost]), 0.0, "NaN is no room");
}

/// A rectangle that spins beside the floor reaches it by its corner, by its spin alone; a disc does not.
#[test]
fn the_spin_of_a_body_counts() {
    let rule = |shape: &str| {
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [8.0, 8.0]\n\
             boundary = {{ x = \"periodic\", z = \"no-slip\" }}\n[[grains]]\nposition = [4.0, 0.0, 1.0]\n{shape}\n\
             density = 2.0\n"
        );
        let scene = CheckedScene::new(SceneSource { file: "spin.toml".into(), text }).unwrap();
        ContactFreeHorizon::new(&scene, 0.1)
    };
    let turning = Kinematics { gap: 0.5, spin: [0.0, 3.0, 0.0], ..Kinematics::default() };
    let load = Loads { torque: [0.0, 2.0, 0.0], ..Loads::default() };
    assert_eq!(rule("radius = 0.5").contact_free_for(&[load], &[turning]), f64::INFINITY);
    let quiet = rule("shape = \"rectangle\"\nsides = [2.0, 1.0]").contact_free_for(&[load], &[turning]);
    // R = √5/2, I = m (4 + 1)/12 with m = 4: twice ω R, and twice ω² R + 2 R M/I.
    let (reach, inertia) = (1.25f64.sqrt(), 4.0 * 5.0 / 12.0);
    let (v, a) = (2.0 * 3.0 * reach, 2.0 * (9.0 * reach + 2.0 * reach * 2.0 / inertia));
    assert!((v * quiet + 0.5 * a * quiet * quiet - 0.4).abs() < 1e-12, "{quiet}");
}

fn plan(dt: f64, dt_dem: f64, until: f64, adaptive: bool) -> Plan {
    Plan {
        participants: Participants::Coupled,
        scheme: None,
        cells: 0,
        grains: 1,
        memory: 0,
        log: 0,
        files: coupler::files::Files::default(),
        steps: coupler::bounds::TimeSteps { dt_fluid: dt, dt_dem, substeps: 1, contact_time: 1.0 },
        dt_dem_target: dt_dem,
        adaptive,
        cfl_reserve: 1.0,
        dt_first: dt,
        dt_max: f64::INFINITY,
        until,
        windows: 0,
        cost: 0.0,
        drag: None,
        bounds: Vec::new(),
        forced: Vec::new(),
        notices: Vec::new(),
    }
}

fn collect(planner: &mut Planner, learn: impl Fn(&Window) -> (f64, f64)) -> Vec<Window> {
    let (mut ordered, mut done) = (Vec::new(), 0);
    while !planner.is_over() || done < ordered.len() {
        while let Some(window) = planner.next_window() {
            ordered.push(window);
        }
        let (quiet, limit) = learn(&ordered[done]);
        planner.learn(quiet, limit);
        done += 1;
    }
    ordered
}

#[test]
fn fixed_windows_land_on_the_end_without_drift() {
    let mut planner = Planner::new(&plan(0.1, 0.03, 1.05, false), &Coupling::default(), &Observe::default());
    let windows = collect(&mut planner, |_| (-1.0, f64::INFINITY));
    assert_eq!(windows.len(), 11);
    assert_eq!(windows[7].time, 7.0 * 0.1);
    let last = windows[10];
    assert!((last.time + last.dt - 1.05).abs() < 1e-15, "{last:?}");
    assert!(windows[..9].iter().all(|window| window.substeps == 4));
    // The last two share what is left.
    assert!(
        windows[9..].iter().all(|window| (window.dt - 0.075).abs() < 1e-15 && window.substeps == 3),
        "{last:?}"
    );
    // A whole number of windows makes no sliver.
    let mut planner = Planner::new(&plan(0.1, 0.1, 0.7, false), &Coupling::default(), &Observe::default());
    assert_eq!(collect(&mut planner, |_| (-1.0, f64::INFINITY)).len(), 7);
}

/// What a resume with a later end goes on from.
#[test]
fn fixed_windows_that_go_on_after_a_shared_rest_lose_no_time() {
    let mut planner = Planner::new(&plan(0.1, 0.03, 1.05, false), &Coupling::default(), &Observe::default());
    collect(&mut planner, |_| (-1.0, f64::INFINITY));
    let mut longer = Planner::new(&plan(0.1, 0.03, 2.0, false), &Coupling::default(), &Observe::default());
    longer.resume(planner.state().clone());
    let windows = collect(&mut longer, |_| (-1.0, f64::INFINITY));
    for pair in windows.windows(2) {
        assert!((pair[0].time + pair[0].dt - pair[1].time).abs() < 1e-12, "{pair:?}");
    }
    let sum: f64 = windows.iter().map(|window| window.dt).sum();
    assert!((sum - 0.95).abs() < 1e-12, "{sum}");
}

#[test]
fn adaptive_windows_follow_the_limit_and_share_the_rest() {
    let mut planner = Planner::new(&plan(0.1, 1.0, 1.0, true), &Coupling::default(), &Observe::default());
    let mut alone = planner.clone();
    assert!(alone.next_window().is_some() && alone.next_window().is_none(), "one is on its way at once");
    let windows = collect(&mut planner, |window| (-1.0, if window.step < 3 { 0.05 } else { 0.2 }));
    assert_eq!(windows[0].dt, 0.1);
    assert_eq!(windows[1].dt, 0.05);
    assert!((windows[4].dt - 0.0625).abs() < 1e-15, "grows by a quarter at most");
    let sum: f64 = windows.iter().map(|window| window.dt).sum();
    assert!((sum - 1.0).abs() < 1e-12);
    let last: Vec<f64> = windows[windows.len() - 2..].iter().map(|window| window.dt).collect();
    assert!(last[1] > 0.45 * last[0], "no sliver at the end: {last:?}");
}

#[test]
fn one_sub_step_exactly_where_the_window_of_four_before_allows_it() {
    let mut planner = Planner::new(&plan(0.1, 0.01, 2.0, false), &Coupling::default(), &Observe::default());
    // Known after window 5 (end 0.6): quiet until 1.05.
    let windows = collect(&mut planner, |window| (if window.step == 5 { 1.05 } else { -1.0 }, f64::INFINITY));
    let singles: Vec<u64> =
        windows.iter().filter(|window| window.substeps == 1).map(|window| window.step).collect();
    assert_eq!(singles, [5 + AHEAD as u64], "windows ends at 1.0, inside the quiet time");
    let full = Coupling { substeps: coupler::config::Substeps::Full, ..Coupling::default() };
    let mut planner = Planner::new(&plan(0.1, 0.01, 2.0, false), &full, &Observe::default());
    assert!(collect(&mut planner, |_| (1e9, 1e9)).iter().all(|window| window.substeps == 10));
}

#[test]
fn a_resume_plans_the_same_windows() {
    let coupling = Coupling::default();
    let plan = plan(0.1, 0.01, 3.0, false);
    let quiet = |window: &Window| {
        (if window.step.is_multiple_of(3) { window.time + 0.6 } else { -1.0 }, f64::INFINITY)
    };
    let whole = collect(&mut Planner::new(&plan, &coupling, &Observe::default()), quiet);
    assert!(
        whole.iter().any(|window| window.substeps == 1) && whole.iter().any(|window| window.substeps == 10)
    );
    // Drained after 11 windows, then gone on from the saved state.
    let mut first = Planner::new(&plan, &coupling, &Observe::default());
    let (mut ordered, mut done) = (Vec::new(), 0);
    while done < 11 {
        while ordered.len() < 11 {
            match first.next_window() {
                Some(window) => ordered.push(window),
                None => break,
            }
        }
        let (until, limit) = quiet(&ordered[done]);
        first.learn(until, limit);
        done += 1;
    }
    let mut second = Planner::new(&plan, &coupling, &Observe::default());
    second.resume(first.state().clone());
    ordered.extend(collect(&mut second, quiet));
    assert_eq!(ordered, whole);
}

#[test]
fn fields_are_due_once_each() {
    let observe = Observe { fields_at: vec![0.0, 0.25, 0.3], fields_every: Some(0.5), ..Observe::default() };
    let mut planner = Planner::new(&plan(0.1, 1.0, 1.2, false), &Coupling::default(), &observe);
    let due: Vec<u64> = collect(&mut planner, |_| (-1.0, 1.0))
        .iter()
        .filter(|window| window.output)
        .map(|window| window.step)
        .collect();
    assert_eq!(due, [0, 2, 4, 9]);
}
