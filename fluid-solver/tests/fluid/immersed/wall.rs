//! Sphere approaching a wall in Stokes flow: Brenner (1961).

use crate::immersed::newton::Run;
use std::f64::consts::PI;

/// F/(6πμRU) at gap `gap` R, `across` cells over D, in an (r, z) box of 8 D × 8 D.
fn correction(gap: f64, across: usize) -> f64 {
    let (n, dt) = (8 * across, 2.0 / (across * across) as f64);
    let z = 0.5 * (1.0 + gap);
    // So slow that the gap does not change: the equations are linear.
    let speed = 1e-6;
    let mut run = Run::new(&format!(
        "until = 100.0
        [domain]
        geometry = \"axisymmetric\"
        lower = [0.0, 0.0]
        upper = [8.0, 8.0]
        cells = [{n}, {n}]
        boundary = {{ r_upper = \"free-slip\", z_lower = \"no-slip\", z_upper = \"free-slip\" }}
        [medium]
        density = 1.0
        viscosity = 1.0
        [[grains]]
        position = [0.0, 0.0, {z}]
        velocity = [0.0, 0.0, -{speed}]
        radius = 0.5
        density = 2.0
        motion = \"prescribed\"
        [fluid]
        time = {{ scheme = \"ab2\", dt = {dt}, convection = false, viscosity = \"implicit\" }}
        "
    ));
    run.until(6.0);
    run.newton.loads[0].force[2] / (6.0 * PI * 0.5 * speed)
}

#[test]
fn brenners_correction_is_approached() {
    for (gap, exact, limits) in [(1.0, 2.12554, [0.04, 0.02]), (0.5, 3.20539, [0.08, 0.03])] {
        for (across, limit) in [(8, limits[0]), (16, limits[1])] {
            let error = correction(gap, across) / exact - 1.0;
            println!("gap {gap} R, D/dx = {across}: error {:.2} %", 100.0 * error);
            assert!(error.abs() < limit, "gap {gap}, D/dx {across}: {error}");
        }
    }
}
