//! Grains in accelerated flow: body force, mean pressure gradient, gravity along a periodic axis.

use crate::immersed::newton::Run;
use fluid_solver::methods::calibrated::calibration::Calibration;

/// With or without the mass by which the mask differs from the grain.
fn box_with(density: f64, drive: &str, gravity: f64, displaced: bool) -> Run {
    coupled(density, drive, gravity, displaced, "semi-implicit")
}

fn coupled(density: f64, drive: &str, gravity: f64, displaced: bool, scheme: &str) -> Run {
    let text = format!(
        "until = 1.0
        gravity = [{gravity}, 0.0, 0.0]
        [domain]
        geometry = \"plane\"
        lower = [0.0, 0.0]
        upper = [2.0, 1.0]
        cells = [48, 24]
        boundary = {{ x = \"periodic\", z = \"periodic\" }}
        [medium]
        density = 2.0
        viscosity = 0.033 # the mask is as large as the grain, not smaller: light ones neglect that
        {drive}
        [[grains]]
        position = [1.97, 0.0, 0.4]
        radius = 0.2
        density = {density}
        [coupling]
        scheme = \"{scheme}\"
        [fluid]
        time = {{ dt = 0.01 }}
        "
    );
    Run::calibrated(&text, with(displaced))
}

fn with(displaced: bool) -> Calibration {
    Calibration { without_displaced_mass: !displaced, ..Calibration::default() }
}

/// Share of the velocity by which a grain may run ahead of the fluid at the end.
const TOLERANCES: [(bool, f64); 2] = [(false, 3e-3), (true, 1e-5)];

#[test]
fn a_neutral_grain_moves_with_the_accelerated_fluid() {
    // u = a t everywhere is the exact solution, the grain included.
    for drive in ["body_force = [0.7, 0.0, 0.0]", "pressure_gradient = [-1.4, 0.0, 0.0]"] {
        for (displaced, tolerance) in TOLERANCES {
            let mut run = box_with(2.0, drive, 0.0, displaced);
            for step in 1..=100 {
                run.windows(1);
                let velocity = run.newton.motions[0].velocity;
                let drift = velocity[0] / (0.007 * f64::from(step)) - 1.0;
                assert!(drift.abs() < 30.0 * tolerance, "step {step}: {drift}");
                if step == 100 {
                    println!("{drive}, displaced mass {displaced}: drift {drift:.2e}");
                    assert!(drift.abs() < tolerance && velocity[2].abs() < tolerance, "{velocity:?}");
                }
            }
        }
    }
}

/// However what drives the fluid changes: from rest in one window, by ramps, in and against the direction of
/// motion. The fluid's velocity is the exact solution, the grain included.
#[test]
fn a_neutral_grain_follows_a_drive_that_changes() {
    fn ramp(from: f64, t: f64) -> f64 {
        ((t - from) / 0.05).clamp(0.0, 1.0)
    }
    type Velocity = fn(f64) -> f64;
    let cases: [(&str, Velocity); 3] = [
        ("flow_rate = { axis = \"x\", mean_velocity = 1.0 }", |_| 1.0),
        (
            "flow_rate = { axis = \"x\", mean_velocity = [[0.1, 0.5], [0.15, 1.0], [0.3, 1.0], [0.35, 0.2]] }",
            |t| 0.5 + 0.5 * ramp(0.1, t) - 0.8 * ramp(0.3, t),
        ),
        ("body_force = { amplitude = [0.7, 0.0, 0.0], frequency = 2.0 }", |t| {
            let rate = 4.0 * std::f64::consts::PI;
            0.7 * (1.0 - (rate * t).cos()) / rate
        }),
    ];
    // Of repeated windows the first attempt: some are not repeated.
    let cases = cases.into_iter().flat_map(|case| ["semi-implicit", "iterated"].map(|scheme| (scheme, case)));
    for (scheme, (drive, exact)) in cases {
        let mut run = coupled(2.0, drive, 0.0, true, scheme);
        for step in 1..=50 {
            run.windows(1);
            let (velocity, t) = (run.newton.motions[0].velocity, 0.01 * f64::from(step));
            let drift = velocity[0] - exact(t);
            // Across, the grain sees the grid.
            assert!(
                drift.abs() < 1e-5 && velocity[2].abs() < 1e-4,
                "{scheme}, {drive}, {t} s: {drift:.2e} {velocity:?}"
            );
        }
    }
}

#[test]
fn all_grains_fall_with_a_fluid_that_nothing_holds() {
    // Gravity along a periodic axis accelerates fluid and grains alike, whatever their density:
    // m_p g + F = m_p g needs F = 0.
    for density in [0.5, 2.0, 16.0] {
        for (displaced, tolerance) in TOLERANCES {
            let mut run = box_with(density, "", 0.7, displaced);
            run.windows(100);
            let drift = run.newton.motions[0].velocity[0] / 0.7 - 1.0;
            println!("density {density}, displaced mass {displaced}: drift {drift:.2e}");
            assert!(drift.abs() < tolerance, "{density}: {drift}");
        }
    }
}

#[test]
fn a_heavy_grain_lags_and_a_light_one_leads_in_an_accelerated_fluid() {
    // First step: (ρ_r + C_v) dU/dt = (1 + C_v) a, so the light one is faster at once.
    let speed = |density: f64, windows: usize| {
        let mut run = box_with(density, "body_force = [0.7, 0.0, 0.0]", 0.0, true);
        run.windows(windows);
        run.newton.motions[0].velocity[0]
    };
    let (light, neutral, heavy) = (speed(1.0, 10), speed(2.0, 10), speed(8.0, 10));
    assert!(light > 1.05 * neutral && heavy < 0.8 * neutral, "{light} {neutral} {heavy}");
}

/// Speed at t = 1 of a sphere, ρ_r = 8, that falls from rest at Ar = 20,000, in units of D and (D/(ρ_r − 1)
/// g)^½.
fn start(displaced: bool, dt: f64) -> f64 {
    let text = format!(
        "until = 1.0
        gravity = [0.0, 0.0, -0.142857142857]
        [domain]
        geometry = \"axisymmetric\"
        lower = [0.0, 0.0]
        upper = [2.0, 4.0]
        cells = [16, 32]
        boundary = {{ r_upper = \"free-slip\", z = \"free-slip\" }}
        [medium]
        density = 1.0
        viscosity = 0.00707107
        [[grains]]
        position = [0.0, 0.0, 2.5]
        radius = 0.5
        density = 8.0
        [fluid]
        time = {{ dt = {dt} }}
        "
    );
    let mut run = Run::calibrated(&text, with(displaced));
    run.windows((1.0 / dt).round() as usize);
    -run.newton.motions[0].velocity[2]
}

/// ν dt/Δx² is 0.002 and 0.02 here: the mask's edge lies 0.3 cells further inside with the short step.
#[test]
fn a_sphere_starts_alike_with_short_steps_and_long_ones() {
    let spread = |displaced: bool| {
        let [short, long] = [0.005, 0.04].map(|dt| start(displaced, dt));
        println!("{displaced}: {short:.5} and {long:.5}");
        (short / long - 1.0).abs()
    };
    let (with, without) = (spread(true), spread(false));
    assert!(with < 4e-3 && without > 1e-2, "{with} {without}");
}

/// A stream enters, carries a neutral disc along, and takes it out of the box: it is nowhere disturbed.
#[test]
fn a_neutral_grain_goes_out_with_the_stream() {
    for method in ["calibrated", "fictitious-domain"] {
        for start in [0.2, 1.0] {
            let mut run = Run::new(&format!(
                "until = 3.0
                [domain]
                geometry = \"plane\"
                lower = [0.0, 0.0]
                upper = [2.0, 2.0]
                cells = [16, 16]
                [domain.boundary]
                x_lower = {{ type = \"inflow\", velocity = [1.0, 0.0, 0.0] }}
                x_upper = \"outflow\"
                z = \"free-slip\"
                [medium]
                density = 1.0
                viscosity = 0.1
                initial = {{ type = \"uniform\", velocity = [1.0, 0.0, 0.0] }}
                [[grains]]
                position = [{start}, 0.0, 1.0]
                radius = 0.5
                density = 1.0
                velocity = [1.0, 0.0, 0.0]
                [fluid]
                method = \"{method}\"
                time = {{ dt = 0.02 }}
                "
            ));
            for window in 1..=120 {
                run.windows(1);
                let velocity = run.newton.motions[0].velocity;
                let off = velocity.iter().zip([1.0, 0.0, 0.0]).map(|(u, stream)| (u - stream).abs());
                let off = off.fold(0.0, f64::max);
                assert!(off < 1e-10, "{method} from {start}, window {window}: {velocity:?}");
            }
            assert!(run.newton.motions[0].position[0] > 2.5);
        }
    }
}

/// A heavy disc that a channel's flow takes along and out, with both methods: as its points leave one after
/// the other, no window pushes it hard. At this step the points that had left pushed on the last cells until
/// the run ended.
#[test]
fn nothing_pushes_a_heavy_disc_that_goes_out() {
    for method in ["calibrated", "fictitious-domain"] {
        let mut run = Run::new(&format!(
            "until = 3.0
            [domain]
            geometry = \"plane\"
            lower = [0.0, 0.0]
            upper = [6.0, 3.0]
            cells = [72, 36]
            [domain.boundary]
            x_lower = {{ type = \"inflow\", velocity = [1.0, 0.0, 0.0], profile = \"parabolic\" }}
            x_upper = \"outflow\"
            z = \"no-slip\"
            [medium]
            density = 1.0
            viscosity = 0.05
            initial = {{ type = \"uniform\", velocity = [1.0, 0.0, 0.0] }}
            [[grains]]
            position = [5.0, 0.0, 1.5]
            radius = 0.4
            density = 1.5
            [fluid]
            method = \"{method}\"
            time = {{ dt = 0.0078125 }}
            "
        ));
        // The stream meets it at once.
        run.windows(20);
        let mut largest = 0.0_f64;
        for _ in 20..256 {
            let before = run.newton.motions[0].velocity[0];
            run.windows(1);
            largest = largest.max((run.newton.motions[0].velocity[0] - before).abs());
        }
        let motion = run.newton.motions[0];
        println!("{method}: {largest:.4} m/s in a window, {:.4} m/s at last", motion.velocity[0]);
        assert!(motion.position[0] > 6.4 && (motion.velocity[0] - 0.9).abs() < 0.1, "{method}: {motion:?}");
        assert!(largest < 0.03, "{method}: {largest}");
    }
}
