//! Drag of fixed periodic arrays in Stokes flow.

use crate::immersed::newton::Run;
use fluid_solver::measure::momentum;
use std::f64::consts::PI;

/// Square array of cylinders in a unit cell, driven along x: ν = ρ = 1, `n` cells per side.
pub(crate) fn cylinders(fraction: f64, n: usize, number: f64, shift: f64, loads: &str) -> Run {
    array([fraction, number, shift, 2.0], n, loads)
}

/// The same, of cylinders that have a density.
fn array([fraction, number, shift, density]: [f64; 4], n: usize, loads: &str) -> Run {
    let radius = (fraction / PI).sqrt();
    let dt = number / (n * n) as f64;
    let mut run = Run::new(&format!(
        "until = 1.0
        [domain]
        geometry = \"plane\"
        lower = [0.0, 0.0]
        upper = [1.0, 1.0]
        cells = [{n}, {n}]
        boundary = {{ x = \"periodic\", z = \"periodic\" }}
        [medium]
        density = 1.0
        viscosity = 1.0
        body_force = [1.0, 0.0, 0.0]
        [[grains]]
        position = [{x}, 0.0, {z}]
        radius = {radius}
        density = {density}
        motion = \"fixed\"
        [fluid]
        time = {{ scheme = \"ab2\", dt = {dt}, convection = false, viscosity = \"implicit\" }}
        {loads}
        ",
        x = 0.5 + shift,
        z = 0.5 + 0.7 * shift,
    ));
    // In time for the flow, in steps for the force.
    run.until(0.8).windows(200);
    run
}

/// F/(μU) with F the body force on the cell and U the mean velocity over it.
pub(crate) fn drag(run: &Run) -> f64 {
    let solver = run.fluid.two().expect("plane");
    1.0 / momentum(solver.grid(), 0, &solver.stepper().state().velocity[0])
}

/// Dilute square array (Sangani & Acrivos 1982): within 0.3 % of their table up to c = 0.1, 1.5 %
/// low at 0.2.
pub(crate) fn sangani_acrivos(c: f64) -> f64 {
    4.0 * PI / (-0.5 * c.ln() - 0.738 + c - 0.887 * c * c + 2.038 * c.powi(3))
}

#[test]
fn cylinder_drag_approaches_sangani_and_acrivos() {
    // c = 0.3 from their Table 1; the others by the formula.
    for (c, exact, limits) in [
        (0.05, sangani_acrivos(0.05), [0.03, 0.006]),
        (0.1, sangani_acrivos(0.1), [0.015, 0.006]),
        (0.3, 102.90, [0.08, 0.02]),
    ] {
        for (n, limit) in [(24, limits[0]), (64, limits[1])] {
            let error = drag(&cylinders(c, n, 1.0, 0.0, "")) / exact - 1.0;
            let across = 2.0 * (c / PI).sqrt() * n as f64;
            println!("c = {c}, D/dx = {across:.1}: drag error {:.3} %", 100.0 * error);
            assert!(error.abs() < limit, "c = {c}, n = {n}: {error}");
        }
    }
}

#[test]
fn f5b_drag_does_not_depend_on_dt() {
    // What the force lacks after 200 windows is gone after 800.
    let steady = |number| drag(cylinders(0.1, 24, number, 0.13, "").windows(600));
    let reference = steady(1.0);
    for number in [0.25, 4.0] {
        let change = steady(number) / reference - 1.0;
        println!("nu dt/dx^2 = {number}: drag changes by {change:.2e}");
        assert!(change.abs() < 1e-4, "{number}: {change}");
    }
}

#[test]
fn eq_7_drag_depends_on_dt() {
    // What docs/numerics.md, Mask, says of direct forcing; were it not so, a carried force would have no
    // point.
    let izard = "method = \"izard-2014\"";
    let [a, b] = [0.25, 4.0].map(|number| drag(&cylinders(0.1, 24, number, 0.0, izard)));
    println!("eq. 7: drag {a:.3} and {b:.3} at nu dt/dx^2 = 0.25 and 4; exact {:.3}", sangani_acrivos(0.1));
    assert!((a / b - 1.0).abs() > 0.05);
}

#[test]
fn fixed_grain_load_is_the_body_force_on_the_cell() {
    let force = cylinders(0.15, 24, 1.0, 0.21, "").newton.loads[0].force;
    assert!((force[0] - 1.0).abs() < 1e-6 && force[2].abs() < 1e-6, "{force:?}");
    // Equations 5 and 6 put Newton's law in, which a held grain does not obey: its density has no part.
    let forces = [0.5, 1.0, 2.0, 8.0].map(|density| {
        array([0.15, 1.0, 0.21, density], 24, "method = \"izard-2014\"").newton.loads[0].force
    });
    assert!((forces[0][0] - 1.0).abs() < 1e-6 && forces[0][2].abs() < 1e-6, "{forces:?}");
    assert!(forces.iter().all(|force| *force == forces[0]), "{forces:?}");
}

/// In the first window, too, in which the mask's own mass is not carried along either: what holds the fluid
/// within the mask, ρ ∫β dV a, and the virtual mass that the grain sees in a fluid with the acceleration a.
#[test]
fn the_first_load_of_a_held_grain_does_not_hang_on_its_density() {
    for motion in ["motion = \"fixed\"", "motion = \"prescribed\"", "locked = [\"x\", \"y\", \"z\"]"] {
        let load = |density: f64, dt: f64| {
            let mut run = Run::new(&format!(
                "until = 1.0
                [domain]
                geometry = \"space\"
                lower = [0.0, 0.0, 0.0]
                upper = [2.0, 2.0, 2.0]
                cells = [16, 16, 16]
                boundary = {{ x = \"periodic\", y = \"periodic\", z = \"periodic\" }}
                [medium]
                density = 1.0
                viscosity = 1.0
                body_force = [1.0, 0.0, 0.0]
                [[grains]]
                position = [1.03, 1.0, 0.97]
                radius = 0.5
                density = {density}
                {motion}
                [fluid]
                time = {{ dt = {dt}, convection = false }}
                "
            ));
            run.windows(1);
            run.newton.loads[0].force[0]
        };
        let forces = [0.1, 1.0, 2.65, 1000.0].map(|density| load(density, 0.01));
        assert!(forces.iter().all(|force| *force == forces[0]), "{motion}: {forces:?}");
        // 3/2 of the displaced mass, and what viscosity adds until the end of a short window.
        let exact = 1.5 * PI / 6.0;
        assert!((1.0..1.1).contains(&(load(2.0, 1e-3) / exact)), "{motion}: {}", load(2.0, 1e-3) / exact);
    }
}

/// Simple cubic array: K = 2.810 at φ = 0.064 (Zick & Homsy 1982).
#[test]
fn sphere_array_drag_approaches_zick_and_homsy() {
    let (fraction, k) = (0.064_f64, 2.810);
    let radius = (3.0 * fraction / (4.0 * PI)).cbrt();
    let mut errors = Vec::new();
    for n in [16, 32] {
        let dt = 2.0 / (n * n) as f64;
        let mut run = Run::new(&format!(
            "until = 1.0
            [domain]
            geometry = \"space\"
            lower = [0.0, 0.0, 0.0]
            upper = [1.0, 1.0, 1.0]
            cells = [{n}, {n}, {n}]
            boundary = {{ x = \"periodic\", y = \"periodic\", z = \"periodic\" }}
            [medium]
            density = 1.0
            viscosity = 1.0
            pressure_gradient = [0.0, 0.0, -1.0]
            [[grains]]
            position = [0.5, 0.5, 0.5]
            radius = {radius}
            density = 2.0
            motion = \"fixed\"
            [fluid]
            time = {{ scheme = \"ab2\", dt = {dt}, convection = false, viscosity = \"implicit\" }}
            "
        ));
        run.until(1.1);
        let solver = run.fluid.three().expect("space");
        let mean = momentum(solver.grid(), 2, &solver.stepper().state().velocity[2]);
        let error = 1.0 / (6.0 * PI * radius * mean) / k - 1.0;
        println!("phi = .064, D/dx = {:.1}: K error {:.3} %", 2.0 * radius * n as f64, 100.0 * error);
        assert!((run.newton.loads[0].force[2] - 1.0).abs() < 1e-4);
        errors.push(error.abs());
    }
    assert!(errors[0] < 0.025 && errors[1] < 0.008, "{errors:?}");
}
