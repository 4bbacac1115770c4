//! Grains in accelerated flow: body force, mean pressure gradient, gravity along a periodic axis.

use crate::newton::Run;

/// The grain's true volume is counted unless `exact` asks for its volume on the grid; the two
/// differ by the smooth edge, whence the tolerance below.
fn box_with(density: f64, drive: &str, gravity: f64, exact: bool) -> Run {
    Run::new(&format!(
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
        viscosity = 0.02
        {drive}
        [[grains]]
        position = [1.97, 0.0, 0.4]
        radius = 0.2
        density = {density}
        [fluid]
        time = {{ dt = 0.01 }}
        loads = {{ displaced_mass = {exact} }}
        "
    ))
}

/// Share of the velocity by which a grain may run ahead of the fluid at the end.
const TOLERANCES: [(bool, f64); 2] = [(false, 3e-3), (true, 1e-5)];

#[test]
fn a_neutral_grain_moves_with_the_accelerated_fluid() {
    // u = a t everywhere is the exact solution, the grain included.
    for drive in ["body_force = [0.7, 0.0, 0.0]", "pressure_gradient = [-1.4, 0.0, 0.0]"] {
        for (exact, tolerance) in TOLERANCES {
            let mut run = box_with(2.0, drive, 0.0, exact);
            for step in 1..=100 {
                run.windows(1);
                let velocity = run.newton.motions[0].velocity;
                let drift = velocity[0] / (0.007 * f64::from(step)) - 1.0;
                assert!(drift.abs() < 30.0 * tolerance, "step {step}: {drift}");
                if step == 100 {
                    println!("{drive}, displaced mass {exact}: drift {drift:.2e}");
                    assert!(drift.abs() < tolerance && velocity[2].abs() < tolerance, "{velocity:?}");
                }
            }
        }
    }
}

#[test]
fn all_grains_fall_with_a_fluid_that_nothing_holds() {
    // Gravity along a periodic axis accelerates fluid and grains alike, whatever their density:
    // m_p g + F = m_p g needs F = 0.
    for density in [0.5, 2.0, 16.0] {
        for (exact, tolerance) in TOLERANCES {
            let mut run = box_with(density, "", 0.7, exact);
            run.windows(100);
            let drift = run.newton.motions[0].velocity[0] / 0.7 - 1.0;
            println!("density {density}, displaced mass {exact}: drift {drift:.2e}");
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
