//! Metrics against exact values of analytic trajectories.

use bedload_output::{Columns, Metrics, MetricsState, Sides};
use bedload_scene::{CheckedScene, SceneSource};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::Window;

use crate::stage::{Watch, discs, falling, sphere};

const BOUNCE: &str = r#"
[[metrics]]
name = "impact"
kind = "impact-velocity-ratio"
reference = 0.5
source = "exact"
[[metrics]]
name = "rebound"
kind = "rebound-velocity-ratio"
[[metrics]]
name = "restitution"
kind = "restitution-at-gap"
gap = 0.1
[[metrics]]
name = "height"
kind = "rebound-height"
[[metrics]]
name = "second"
kind = "second-rebound-height"
[[metrics]]
name = "stokes"
kind = "stokes"
[[metrics]]
name = "reynolds"
kind = "reynolds"
[[metrics]]
name = "resting"
kind = "resting-force-ratio"
[[metrics]]
name = "terminal"
kind = "terminal-reynolds"
[[metrics]]
name = "acceleration"
kind = "initial-acceleration"
"#;

/// (velocity, gap, impact, rebound, contact force along z)
type Instant = (f64, f64, f64, f64, f64);

fn feed(watch: &mut Watch, way: &[Instant]) {
    for (velocity, gap, impact_speed, rebound_speed, force) in way {
        let contact_force = [0.0, 0.0, *force];
        watch.feed(Kinematics {
            impact_speed: *impact_speed,
            rebound_speed: *rebound_speed,
            contact_force,
            ..falling(*velocity, *gap)
        });
    }
}

/// Down at 4, touches at 3, leaves at 2, rises to 0.5, comes down, bounces to 0.125, rests.
const WAY: [Instant; 10] = [
    (-4.0, 1.0, 0.0, 0.0, 0.0),
    (-3.5, 0.2, 0.0, 0.0, 0.0),
    (-3.1, 0.05, 0.0, 0.0, 0.0),
    (-1.0, -0.01, 3.0, 0.0, 50.0),
    (2.0, 0.02, 0.0, 2.0, 20.0),
    (1.6, 0.18, 0.0, 0.0, 0.0),
    (0.0, 0.5, 0.0, 0.0, 0.0),
    (-1.0, 0.3, 0.0, 0.0, 0.0),
    (0.5, 0.125, 1.0, 0.5, 30.0),
    (0.0, -0.001, 0.2, 0.0, 84.0),
];

#[test]
fn a_bounce_has_its_exact_ratios() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    feed(&mut watch, &WAY);
    // V_T = 4: largest at the end of a window before the first contact.
    assert_eq!(watch.value("impact"), 3.0 / 4.0);
    assert_eq!(watch.value("rebound"), 2.0 / 4.0);
    // In: a third of the way back from gap 0.05 to 0.2; out: halfway from 0.02 to 0.18.
    let inward = 3.5 + (3.1 - 3.5) * (0.1 - 0.2) / (0.05 - 0.2);
    let outward = 2.0 + (1.6 - 2.0) * (0.1 - 0.02) / (0.18 - 0.02);
    assert_eq!(watch.value("restitution"), outward / inward);
    assert_eq!(watch.value("height"), 0.5 / 2.0);
    assert_eq!(watch.value("second"), 0.125 / 2.0);
    assert_eq!(watch.value("stokes"), (3.0 + 0.5) * 4.0 * 2.0 / (9.0 * 0.5));
    assert_eq!(watch.value("reynolds"), 4.0 * 2.0 / 0.5);
    // Speed 4 gained in one second under gravity 10.
    assert_eq!(watch.value("acceleration"), 4.0 / 10.0);
    // Last tenth of 10 s: the last window alone.
    let submerged = (3.0 - 1.0) * 4.0 / 3.0 * std::f64::consts::PI * 10.0;
    assert!((watch.value("resting") - 84.0 / submerged).abs() < 1e-15);
    // At rest in the last tenth: a speed there is no terminal one.
    let terminal = &watch.metrics.finish()["terminal"];
    assert!(terminal.value.is_none() && terminal.note.as_ref().is_some_and(|note| note.contains("rests")));
}

#[test]
fn references_give_relative_errors() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    feed(&mut watch, &WAY);
    let values = watch.metrics.finish();
    assert_eq!(values["impact"].reference, Some(0.5));
    assert_eq!(values["impact"].relative_error, Some(0.5));
    assert_eq!(values["impact"].source.as_deref(), Some("exact"));
    assert_eq!(values["rebound"].relative_error, None);
}

/// Up to 4 over the floor, under a lid that is nearer from 2.5 on.
#[test]
fn a_rebound_rises_from_what_it_touched_under_a_lid_too() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    for (velocity, height, impact_speed) in [
        (-4.0, 3.0, 0.0),
        (3.0, 0.5, 3.5),
        (2.0, 2.0, 0.0),
        (1.0, 3.0, 0.0),
        (0.0, 4.0, 0.0),
        (-1.0, 3.5, 0.0),
    ] {
        let position = [0.0, 0.0, 1.0 + height];
        watch.feed(Kinematics {
            position,
            impact_speed,
            ..falling(velocity, f64::min(height, 5.0 - height))
        });
    }
    assert_eq!(watch.value("height"), 4.0 / 2.0);
}

#[test]
fn a_contact_shorter_than_a_window_uses_the_speeds_of_the_touch() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    feed(&mut watch, &[(-4.0, 1.0, 0.0, 0.0, 0.0), (2.0, 0.4, 3.0, 2.5, 10.0), (0.0, 0.6, 0.0, 0.0, 0.0)]);
    let inward = 4.0 + (3.0 - 4.0) * (0.1 - 1.0) / (0.0 - 1.0);
    let outward = 2.5 + (2.0 - 2.5) * 0.1 / 0.4;
    assert!((watch.value("restitution") - outward / inward).abs() < 1e-15);
    assert_eq!(watch.value("height"), 0.6 / 2.0);
    assert_eq!(watch.note("second"), "there was no second contact");
}

#[test]
fn without_a_contact_ratios_are_missing_with_a_reason() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    feed(&mut watch, &[(-1.0, 5.0, 0.0, 0.0, 0.0), (-2.0, 4.0, 0.0, 0.0, 0.0)]);
    for name in ["impact", "rebound", "restitution", "height"] {
        assert_eq!(watch.note(name), "there was no contact");
    }
    assert!(watch.note("resting").contains("ended before t = 9"));
    assert_eq!(watch.value("reynolds"), 2.0 * 2.0 / 0.5);
}

#[test]
fn a_grain_that_sticks_has_zero_rebound_and_restitution() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    feed(
        &mut watch,
        &[
            (-2.0, 1.0, 0.0, 0.0, 0.0),
            (-2.0, 0.05, 0.0, 0.0, 0.0),
            (-0.1, -0.01, 2.0, 0.0, 9.0),
            (0.0, -0.01, 0.0, 0.0, 9.0),
        ],
    );
    for name in ["rebound", "restitution", "height"] {
        assert_eq!(watch.value(name), 0.0);
    }
    assert!(
        watch.metrics.finish()["restitution"]
            .note
            .as_deref()
            .is_some_and(|note| note.contains("never came back"))
    );
}

#[test]
fn a_solver_that_reports_no_impact_speed_still_has_contacts() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    feed(
        &mut watch,
        &[
            (-2.0, 1.0, 0.0, 0.0, 0.0),
            (-1.0, -0.01, 0.0, 0.0, 9.0),
            (1.0, 0.01, 0.0, 0.0, 4.0),
            (0.5, 0.8, 0.0, 0.0, 0.0),
            (0.0, -0.01, 0.0, 0.0, 3.0),
            (0.0, 0.9, 0.0, 0.0, 0.0),
        ],
    );
    assert_eq!(watch.note("impact"), "the DEM reports no impact speed");
    assert_eq!(watch.value("height"), 0.8 / 2.0);
    assert_eq!(watch.value("second"), 0.9 / 2.0);
}

/// Free fall from h, restitution e: V_C = √(2gh), rise e²h; sampled every 1 ms the peak is missed by
/// at most g dt²/8.
#[test]
fn a_ballistic_bounce_rises_to_e_squared_h() {
    let (g, h, e, dt) = (10.0f64, 3.0f64, 0.8f64, 1e-3);
    let mut watch = Watch::new(&sphere(BOUNCE), dt);
    let touch = (2.0 * h / g).sqrt();
    let speed = g * touch;
    let second = touch + 2.0 * e * speed / g;
    let mut step = 1u64;
    loop {
        let t = step as f64 * dt;
        if t >= second {
            break;
        }
        let hit = t >= touch && t - dt < touch;
        let (velocity, gap) = if t < touch {
            (-g * t, h - 0.5 * g * t * t)
        } else {
            let s = t - touch;
            (e * speed - g * s, e * speed * s - 0.5 * g * s * s)
        };
        let (impact_speed, rebound_speed) = if hit { (speed, e * speed) } else { (0.0, 0.0) };
        watch.feed(Kinematics { impact_speed, rebound_speed, ..falling(velocity, gap) });
        step += 1;
    }
    let sampled = 10.0 * dt;
    assert!((watch.value("impact") - 1.0).abs() < sampled / speed);
    assert!((watch.value("height") - e * e * h / 2.0).abs() <= g * dt * dt / 8.0 / 2.0);
    // At gap a: in √(2g(h−a)), out √(2g(e²h−a)); interpolation errs by about g dt²/(8·v).
    let a = 0.1;
    let exact = ((e * e * h - a) / (h - a)).sqrt();
    assert!((watch.value("restitution") - exact).abs() < 1e-5, "{} {exact}", watch.value("restitution"));
}

#[test]
fn a_light_sphere_settles_upwards() {
    let text = sphere("").source.text.replace("density = 3.0", "density = 0.5");
    let scene = crate::stage::scene(&format!("{text}{BOUNCE}"));
    let mut watch = Watch::new(&scene, 1.0);
    watch.feed(falling(3.0, 5.0));
    assert_eq!(watch.value("reynolds"), 3.0 * 2.0 / 0.5);
}

const COLUMNS: &str = r#"
[[metrics]]
name = "mean"
kind = "mean"
column = "hydrodynamic_force_z[0]"
from = 1.5
[[metrics]]
name = "last"
kind = "final"
column = "velocity_z[0]"
[[metrics]]
name = "most"
kind = "max"
column = "hydrodynamic_force_z[0]"
"#;

#[test]
fn means_weigh_with_time_from_their_start() {
    let mut watch = Watch::new(&sphere(COLUMNS), 1.0);
    for (step, force) in [7.0, 2.0, 8.0].into_iter().enumerate() {
        let motion = falling(-(step as f64), 1.0);
        let loads = Loads { force: [0.0, 0.0, force], ..Loads::default() };
        watch.feed_all(&[loads], &Header::default(), &[motion], &[]);
    }
    // Half of the second window, the whole of the third.
    assert_eq!(watch.value("mean"), (0.5 * 2.0 + 8.0) / 1.5);
    assert_eq!(watch.value("last"), -2.0);
    assert_eq!(watch.value("most"), 8.0);
    assert_eq!(watch.metrics.finish()["mean"].unit, "N");
}

/// Of a sphere whose velocity is 2 + sin 3t and whose force is the mean of that over each window, in uneven
/// windows, `parts` of each: mean velocity from 0 and from within a window, its deviation, mean force.
fn in_uneven_windows(parts: u32) -> [f64; 4] {
    let metric = |name: &str, kind: &str, column: &str, from: f64| {
        format!(
            "[[metrics]]\nname = \"{name}\"\nkind = \"{kind}\"\ncolumn = \"{column}_z[0]\"\nfrom = {from:?}\n"
        )
    };
    let metrics = [
        metric("whole", "mean", "velocity", 0.0),
        metric("part", "mean", "velocity", FROM),
        metric("deviation", "deviation", "velocity", FROM),
        metric("force", "mean", "hydrodynamic_force", 0.0),
    ];
    let mut watch = Watch::new(&sphere(&metrics.concat()), 1.0);
    let mut time = 0.0;
    for step in [0.1, 0.3, 0.05, 0.2].repeat(3).into_iter().flat_map(|step| vec![step; parts as usize]) {
        let dt = step / f64::from(parts);
        let force = (INTEGRAL(time + dt) - INTEGRAL(time)) / dt;
        let window = Window { time, dt, ..crate::stage::window(watch.step, dt) };
        time += dt;
        let loads = [Loads { force: [0.0, 0.0, force], ..Loads::default() }];
        let motion = [falling(2.0 + (3.0 * time).sin(), 1.0)];
        watch.feed_window(&window, &loads, &Header::default(), &motion, &[]);
    }
    assert!((time - UNTIL).abs() < 1e-12);
    ["whole", "part", "deviation", "force"].map(|name| watch.value(name))
}

/// Within a window, however it is divided.
const FROM: f64 = 0.237;
const UNTIL: f64 = 1.95;
/// ∫ 2 + sin 3t.
const INTEGRAL: fn(f64) -> f64 = |t| 2.0 * t - (3.0 * t).cos() / 3.0;

#[test]
fn means_of_what_is_of_the_ends_of_windows_are_of_second_order_and_those_of_windows_exact() {
    let mean = |from: f64| (INTEGRAL(UNTIL) - INTEGRAL(from)) / (UNTIL - from);
    // ∫ (2 + sin 3t)².
    let squares = |t: f64| 4.5 * t - 4.0 / 3.0 * (3.0 * t).cos() - (6.0 * t).sin() / 12.0;
    let square = (squares(UNTIL) - squares(FROM)) / (UNTIL - FROM);
    let exact = [mean(0.0), mean(FROM), (square - mean(FROM).powi(2)).sqrt(), mean(0.0)];
    let off = |parts| {
        let found = in_uneven_windows(parts);
        std::array::from_fn::<f64, 4, _>(|k| (found[k] - exact[k]).abs())
    };
    let (coarse, fine) = (off(8), off(32));
    for k in 0..3 {
        let order = (coarse[k] / fine[k]).log(4.0);
        assert!((order - 2.0).abs() < 0.15, "{order} of {coarse:?} and {fine:?}");
    }
    assert!(coarse[3] < 1e-12 && fine[3] < 1e-12, "{coarse:?}, {fine:?}");
}

#[test]
fn an_unknown_column_is_refused_with_the_known_ones() {
    let scene = sphere(&COLUMNS.replace("hydrodynamic_force_z[0]", "flow_rate"));
    let columns = Columns::new(&scene, Sides::coupled());
    let error = Metrics::new(&scene, &columns, Sides::coupled()).err().expect("no such column");
    assert_eq!(error.key, "metrics[0].column");
    assert!(error.message.contains("flow_rate") && error.message.contains("kinetic_energy"), "{error}");
    // A DEM alone cannot know what the fluid adds: it goes on without.
    let metrics = Metrics::new(&scene, &Columns::new(&scene, Sides::dry()), Sides::dry()).expect("runs");
    assert_eq!(metrics.finish()["mean"].note.as_deref(), Some("this run has no column `flow_rate`"));
}

/// A heap has the surfaces of spheres and discs: it would be as high as circles about the bodies.
#[test]
fn a_heap_of_bodies_that_are_not_round_is_refused() {
    let text = |grain: &str, kind: &str| {
        format!(
            "until = 1.0\ngravity = [0.0, 0.0, -1.0]\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\n\
             upper = [9.0, 9.0]\nboundary = {{ x = \"no-slip\", z = \"no-slip\" }}\n[[grains]]\n{grain}\n\
             position = [4.0, 0.0, 2.0]\ndensity = 1.0\n[dem.contact]\nlaw = \"linear-spring-dashpot\"\n\
             restitution = 0.5\ncontact_time = 0.01\n[[metrics]]\nname = \"m\"\nkind = \"{kind}\"\ncentre = 4.0\n"
        )
    };
    for kind in ["heap-angle", "deposit-height\"\nhalf_length = 1.0\nend = \"contact"] {
        let found = ["radius = 0.5", "shape = \"rectangle\"\nsides = [1.0, 0.5]"].map(|grain| {
            let source = SceneSource { file: "s.toml".into(), text: text(grain, kind) };
            let scene = CheckedScene::new(source).expect("reads");
            Metrics::new(&scene, &Columns::new(&scene, Sides::dry()), Sides::dry()).map(|_| ())
        });
        let [Ok(()), Err(error)] = found else { panic!("{kind}: {found:?}") };
        assert!(error.key == "metrics[0].kind" && error.message.contains("grain 0 is not round"), "{error}");
    }
}

/// A column that still stands has left no deposit.
#[test]
fn a_run_that_ends_before_the_release_has_no_deposit() {
    let kinds = ["deposit-height", "deposit-run-out", "deposit-aspect-ratio", "column-solid-fraction"];
    let metric = |kind| {
        format!(
            "[[metrics]]\nname = \"{kind}\"\nkind = \"{kind}\"\ncentre = 0.0\nhalf_length = 1.0\nrelease = 5.0\n"
        )
    };
    let scene = sphere(&kinds.map(metric).concat());
    let notes = |windows: usize| {
        let mut watch = Watch::new(&scene, 1.0);
        feed(&mut watch, &WAY[..windows]);
        let values = watch.metrics.finish();
        kinds.map(|kind| values[kind].note.clone().unwrap_or_default())
    };
    for note in notes(4) {
        assert_eq!(note, "the run ended at t = 4 s, before `release`, 5 s");
    }
    for note in notes(5) {
        assert!(!note.contains("release"), "{note}");
    }
}

#[test]
fn a_resumed_run_measures_the_same_bits() {
    let scene = sphere(BOUNCE);
    let mut whole = Watch::new(&scene, 1.0);
    feed(&mut whole, &WAY);
    for cut in 0..WAY.len() {
        let mut first = Watch::new(&scene, 1.0);
        feed(&mut first, &WAY[..cut]);
        let json = serde_json::to_string(first.metrics.state()).expect("state to JSON");
        let state: MetricsState = serde_json::from_str(&json).expect("state from JSON");
        let mut second = Watch::new(&scene, 1.0);
        second.step = cut as u64;
        second.metrics.restore(state, 0.0).expect("the same metrics");
        feed(&mut second, &WAY[cut..]);
        assert_eq!(second.metrics.finish(), whole.metrics.finish(), "cut at {cut}");
    }
}

/// Of three windows it is there in the last two: its numbers before that are none.
#[test]
fn a_grain_that_is_inserted_counts_from_then_on() {
    let metric = |kind: &str| {
        format!("[[metrics]]\nname = \"{kind}\"\nkind = \"{kind}\"\ncolumn = \"position_z[2]\"\n")
    };
    let text = format!(
        "[observe]\ngrains = [2]\n[[insertions]]\ncount = 1\nlower = [0.0, 0.0, 4.0]\nupper = [9.0, 0.0, 8.0]\n\
         radius = 0.2\ndensity = 2.0\nseed = 1\nrate = 1.0\n{}{}{}",
        metric("mean"),
        metric("max"),
        metric("final")
    );
    let mut watch = Watch::new(&discs(&text), 0.25);
    let at = |z: f64, w: f64| Kinematics {
        position: [1.0, 0.0, z],
        orientation: [w, 0.0, 0.0, 0.0],
        ..Kinematics::default()
    };
    let feed = |watch: &mut Watch, last| {
        let grains = [at(1.0, 1.0), at(2.0, 1.0), last];
        let row = watch.feed_all(&[Loads::default(); 3], &Header::default(), &grains, &[]);
        let place = watch.columns.find("position_z[2]").expect("a column").0;
        row[place]
    };
    assert!(feed(&mut watch, at(9.0, 0.0)).is_nan());
    for kind in ["mean", "max", "final"] {
        assert!(watch.note(kind).contains("grain 2 is there once it is inserted"), "{}", watch.note(kind));
    }
    assert_eq!(feed(&mut watch, at(6.0, 1.0)), 6.0);
    assert_eq!(feed(&mut watch, at(4.0, 1.0)), 4.0);
    // The first window for the whole of it, the second by its ends.
    assert_eq!([watch.value("mean"), watch.value("max"), watch.value("final")], [5.5, 6.0, 4.0]);
}

/// Of a velocity that relaxes to −2 m/s and swings about it; cut anywhere it comes to the same bits.
#[test]
fn a_stationary_mean_has_its_standard_error_beside_it() {
    let text = "[[metrics]]\nname = \"v\"\nkind = \"mean\"\ncolumn = \"velocity_z[0]\"\n\
                from = \"stationary\"\n[[metrics]]\nname = \"all\"\nkind = \"mean\"\ncolumn = \"velocity_z[0]\"\n";
    let scene = sphere(text);
    let velocity =
        |step: i32| -2.0 - 5.0 * (-0.1 * f64::from(step)).exp() + 0.1 * (1.7 * f64::from(step)).sin();
    let mut whole = Watch::new(&scene, 0.1);
    let mut second = Watch::new(&scene, 0.1);
    for step in 0..2000 {
        whole.feed(falling(velocity(step), 1.0));
        second.feed(falling(velocity(step), 1.0));
        if step == 777 {
            let json = serde_json::to_string(second.metrics.state()).expect("state to JSON");
            let mut resumed = Watch::new(&scene, 0.1);
            resumed.step = second.step;
            resumed
                .metrics
                .restore(serde_json::from_str(&json).expect("state"), 0.0)
                .expect("the same metrics");
            second = resumed;
        }
    }
    let found = &whole.metrics.finish()["v"];
    assert_eq!(second.metrics.finish()["v"], *found);
    let (value, error) = (found.value.expect("a mean"), found.standard_error.expect("its error"));
    assert!((value + 2.0).abs() < 3.0 * error && error < 5e-3, "{value} ± {error}");
    assert!(found.note.as_ref().is_some_and(|note| note.contains("stationary")), "{found:?}");
    let all = &whole.metrics.finish()["all"];
    assert!(all.value.is_some_and(|all| all < -2.02) && all.standard_error.is_none(), "{all:?}");
}

/// A rebound that the run does not see to its top has no height.
#[test]
fn a_run_that_ends_on_the_way_up_knows_no_height() {
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    feed(&mut watch, &WAY[..6]);
    assert!(watch.note("height").contains("on the way up"), "{}", watch.note("height"));
    feed(&mut watch, &WAY[6..7]);
    assert_eq!(watch.value("height"), 0.5 / 2.0);
}

/// The last tenth of a run of 10 s, which is resumed at 9.5 s to end at 10.5 s, begins at 9.45 s: before what
/// is known. Resumed at 9 s it is known.
#[test]
fn the_last_part_of_a_run_that_was_made_longer_is_whole_or_not_there() {
    let longer = sphere(BOUNCE).source.text.replace("until = 10.0", "until = 10.5");
    let longer = crate::stage::scene(&longer);
    let go_on = |parts: usize| {
        let mut first = Watch::new(&sphere(BOUNCE), 0.5);
        (0..parts).for_each(|_| first.feed(falling(-3.0, 1.0)));
        let mut second = Watch::new(&longer, 0.5);
        second.step = first.step;
        second.metrics.restore(first.metrics.state().clone(), 0.5 * parts as f64).expect("the same");
        (parts..21).for_each(|_| second.feed(falling(-3.0, 1.0)));
        second
    };
    assert_eq!(go_on(18).value("terminal"), 3.0 * 2.0 / 0.5);
    assert!(go_on(19).note("terminal").contains("resumed with another end"));
}

#[test]
fn a_state_of_other_metrics_is_refused() {
    let other = Watch::new(&sphere(&COLUMNS.replace("flow_rate", "t")), 1.0);
    let mut watch = Watch::new(&sphere(BOUNCE), 1.0);
    assert!(watch.metrics.restore(other.metrics.state().clone(), 0.0).is_err());
}
