//! The fictitious-domain method: drag of fixed arrays, what the grains receive and the fluid loses, neutral
//! discs.

use crate::immersed::arrays::{cylinders, drag, sangani_acrivos};
use crate::immersed::newton::{Drift, Run, try_scene};
use fluid_solver::facts::facts;
use fluid_solver::measure::momentum;
use fluid_solver::methods::calibrated::calibration::Calibration;

const METHOD: &str = "method = \"fictitious-domain\"";

/// Places on the grid change the drag by less than two thousandths; the error falls by more than the width of
/// the cells.
#[test]
fn drag_of_an_array_approaches_sangani_and_acrivos() {
    let error =
        |n: usize, shift: f64| drag(&cylinders(0.05, n, 1.0, shift, METHOD)) / sangani_acrivos(0.05) - 1.0;
    let (coarse, fine) = (error(24, 0.0), error(48, 0.0));
    let moved = error(24, 0.013);
    println!("D/dx = 6.1: {coarse:.4}, {moved:.4} elsewhere, 12.1: {fine:.4}");
    assert!(coarse.abs() < 0.03 && fine.abs() < 0.011 && fine.abs() < 0.45 * coarse.abs());
    assert!((moved - coarse).abs() < 2e-3);
}

#[test]
fn drag_does_not_depend_on_dt() {
    let reference = drag(&cylinders(0.1, 24, 1.0, 0.13, METHOD));
    for number in [0.25, 4.0] {
        let mut run = cylinders(0.1, 24, number, 0.13, METHOD);
        // What the points disagree about fades by a hundredth a step here.
        run.windows(800);
        let change = drag(&run) / reference - 1.0;
        println!("nu dt/dx^2 = {number}: drag changes by {change:.2e}");
        assert!(change.abs() < 1e-4, "{number}: {change}");
    }
}

/// Two discs apart and spinning in a periodic box at rest.
fn pair(density: f64, more: &str) -> String {
    format!(
        "until = 1.0
        [domain]
        geometry = \"plane\"
        lower = [0.0, 0.0]
        upper = [2.0, 2.0]
        cells = [48, 48]
        boundary = {{ x = \"periodic\", z = \"periodic\" }}
        [medium]
        density = 1.0
        viscosity = 0.05
        [[grains]]
        position = [0.1, 0.0, 1.0]
        velocity = [0.5, 0.0, 0.2]
        spin = [0.0, 1.0, 0.0]
        radius = 0.25
        density = {density}
        [[grains]]
        position = [0.61, 0.0, 1.0]
        velocity = [-0.3, 0.0, 0.1]
        radius = 0.25
        density = {density}
        [fluid]
        time = {{ dt = 0.01 }}
        {METHOD}
        {more}
        "
    )
}

/// The points have the area of their discs, so the fluid in them gains V ΔU, and all else goes to the discs.
#[test]
fn what_the_discs_receive_the_fluid_loses() {
    for density in [1.0, 3.0] {
        let calibration = Calibration { without_virtual_mass: true, ..Calibration::default() };
        let mut run = Run::calibrated(&pair(density, ""), calibration);
        run.newton.drift = Drift::Old;
        let grid = run.fluid.two().expect("plane").grid().clone();
        let total = |run: &Run, d: usize| {
            momentum(&grid, d, &run.fluid.two().expect("plane").stepper().state().velocity[d])
        };
        let area = std::f64::consts::PI * 0.25 * 0.25;
        for step in 0..20 {
            let before = run.newton.motions.clone();
            let start = [total(&run, 0), total(&run, 1)];
            run.windows(1);
            for (d, c) in [(0, 0), (1, 2)] {
                let expected: f64 = (0..2)
                    .map(|i| {
                        let change = run.newton.motions[i].velocity[c] - before[i].velocity[c];
                        area * change - 0.01 * run.newton.loads[i].force[c]
                    })
                    .sum();
                let found = total(&run, d) - start[d];
                assert!((found - expected).abs() < 1e-12, "step {step}, axis {c}: {found} {expected}");
            }
        }
    }
}

/// A disc as dense as the fluid, in a shear that it lies in the middle of, turns at half the rate and stays.
#[test]
fn a_neutral_disc_turns_with_the_shear_and_stays_in_its_middle() {
    let mut run = Run::new(
        "until = 8.0
        [domain]
        geometry = \"plane\"
        lower = [0.0, 0.0]
        upper = [2.0, 1.0]
        cells = [64, 32]
        [domain.boundary]
        x = \"periodic\"
        z_lower = { type = \"no-slip\", velocity = [-0.5, 0.0, 0.0] }
        z_upper = { type = \"no-slip\", velocity = [0.5, 0.0, 0.0] }
        [medium]
        density = 1.0
        viscosity = 1.0
        initial = { type = \"shear\", direction = \"x\", gradient = \"z\", rate = 1.0, origin = 0.5 }
        [[grains]]
        position = [1.0, 0.0, 0.5]
        radius = 0.125
        density = 1.0
        [fluid]
        time = { dt = 0.005, viscosity = \"implicit\" }
        method = \"fictitious-domain\"
        ",
    );
    run.until(4.0);
    let motion = &run.newton.motions[0];
    assert!((motion.position[2] - 0.5).abs() < 1e-9, "{:?}", motion.position);
    // Half the rate of shear, less what walls at two diameters take.
    assert!((motion.spin[1] - 0.5).abs() < 0.04, "{:?}", motion.spin);
}

/// Positions are not wrapped: a disc that has gone around is where it began.
#[test]
fn a_disc_several_periods_away_is_the_same_disc() {
    let loads = |shift: f64| {
        let mut run = Run::new(&pair(1.5, ""));
        run.newton.motions[0].position[0] += shift;
        run.windows(5);
        run.newton.loads[0].force
    };
    let (here, left, right) = (loads(0.0), loads(-6.0), loads(8.0));
    for c in 0..3 {
        assert!(
            (left[c] - here[c]).abs() < 1e-12 && (right[c] - here[c]).abs() < 1e-12,
            "{here:?} {left:?} {right:?}"
        );
    }
}

#[test]
fn what_it_cannot_do_is_refused_by_key() {
    let refusal = |change: [&str; 2]| {
        let text = pair(1.5, "").replace(change[0], change[1]);
        facts(&try_scene(&text).expect("the shared part is right")).expect_err(change[1])
    };
    for (change, key, part) in [
        (["cells = [48, 48]", "cells = [48, 40]"], "domain.cells", "square"),
        (["cells = [48, 48]", "cells = [12, 12]"], "domain.cells", "3.0 cells across"),
    ] {
        let error = refusal(change);
        assert_eq!(error.key, key, "{}", error.message);
        assert!(error.message.contains(part) && !error.remedy.is_empty(), "{}", error.message);
    }
    // A face cuts the first one.
    for face in ["no-slip", "free-slip"] {
        let text = pair(1.5, "").replacen("radius = 0.25", "radius = 0.25\nmotion = \"prescribed\"", 1);
        let text = text.replace("x = \"periodic\"", &format!("x = \"{face}\""));
        let error = facts(&try_scene(&text).expect("the shared part is right")).expect_err(face);
        assert!(error.key == "grains[0].position" && error.message.contains(face), "{}", error.message);
    }
    let told = facts(&try_scene(&pair(1.5, "")).expect("a scene")).expect("facts");
    assert_eq!(told.schemes, [protocol::scheme::Scheme::SemiImplicit], "windows are not repeated");
}
