//! What the grains receive, the fluid loses.

use crate::immersed::newton::{Drift, Run};
use fluid_solver::measure::momentum;
use fluid_solver::methods::calibrated::calibration::Calibration;
use fluid_solver::solver::Solver;

/// ∫ b dV of the first grain, on the nodes of z.
fn filled<const D: usize>(solver: &Solver<D>) -> f64 {
    let mut immersed = solver.immersed().clone();
    let velocity = &solver.stepper().state().velocity;
    immersed.contents((solver.grid(), solver.mask_model(), solver.motions()), velocity);
    let mut out = [[0.0; 3]];
    immersed.volumes(solver.grid().geometry, &mut out);
    out[0][2]
}

/// Two discs that overlap, moving apart and spinning in a periodic box at rest.
const PAIR: &str = "until = 1.0
    [domain]
    geometry = \"plane\"
    lower = [0.0, 0.0]
    upper = [2.0, 2.0]
    cells = [48, 48]
    boundary = { x = \"periodic\", z = \"periodic\" }
    [medium]
    density = 1.0
    viscosity = 0.05
    [[grains]]
    position = [0.1, 0.0, 1.0]
    velocity = [0.5, 0.0, 0.2]
    spin = [0.0, 1.0, 0.0]
    radius = 0.25
    density = 3.0
    [[grains]]
    position = [0.598, 0.0, 1.0]
    velocity = [-0.3, 0.0, 0.1]
    radius = 0.25
    density = 1.5
    [fluid]
    time = { dt = 0.01 }
    ";

/// Without what the loads add to the momentum that the fluid gives.
fn pair() -> Run {
    let calibration =
        Calibration { without_virtual_mass: true, without_displaced_mass: true, ..Calibration::default() };
    Run::calibrated(PAIR, calibration)
}

#[test]
fn fluid_momentum_change_is_minus_the_impulse_on_the_grains() {
    let mut run = pair();
    run.newton.drift = Drift::Old;
    let grid = run.fluid.two().expect("plane").grid().clone();
    let ones = [vec![1.0; grid.len()], vec![1.0; grid.len()]];
    for step in 0..20 {
        let before = run.newton.motions.clone();
        let total = |run: &Run, d: usize| {
            momentum(&grid, d, &run.fluid.two().expect("plane").stepper().state().velocity[d])
        };
        let start = [total(&run, 0), total(&run, 1)];
        run.windows(1);
        // Fluid in the grains' place is taken along by them: ∫ b dV ΔU, with the masks of now.
        let solver = run.fluid.two().expect("plane");
        let mut immersed = solver.immersed().clone();
        let volumes: Vec<_> =
            immersed.contents((&grid, solver.mask_model(), solver.motions()), &ones).to_vec();
        for (d, c) in [(0, 0), (1, 2)] {
            let mut expected = 0.0;
            for (grain, volume) in volumes.iter().enumerate() {
                let change = run.newton.motions[grain].velocity[c] - before[grain].velocity[c];
                expected += volume.force[c] * change - 0.01 * run.newton.loads[grain].force[c];
                // ∫ b (Δω × r)_c dV: the masks of two grains are not symmetric about their centres.
                let spin = run.newton.motions[grain].spin[1] - before[grain].spin[1];
                expected += arm(&volumes_moments(solver, &ones), grain, c) * spin;
            }
            let found = total(&run, d) - start[d];
            assert!((found - expected).abs() < 1e-12, "step {step}, axis {c}: {found} {expected}");
        }
    }
}

/// ∫ b r dV by axis pairs: (ω × r)_x = ω r_z, (ω × r)_z = −ω r_x.
fn arm(moments: &[[f64; 2]], grain: usize, c: usize) -> f64 {
    if c == 0 { moments[grain][0] } else { -moments[grain][1] }
}

/// For every grain ∫ b r_z dV on the x nodes and ∫ b r_x dV on the z nodes.
fn volumes_moments(solver: &fluid_solver::solver::Solver<2>, ones: &[Vec<f64>; 2]) -> Vec<[f64; 2]> {
    let grid = solver.grid();
    let zeros = [grid.new_field(), grid.new_field()];
    let mut immersed = solver.immersed().clone();
    let mut part = |fields: [&Vec<f64>; 2]| -> Vec<f64> {
        let fields = [fields[0].clone(), fields[1].clone()];
        let wrenches = immersed.contents((grid, solver.mask_model(), solver.motions()), &fields);
        wrenches.iter().map(|w| w.torque[1]).collect()
    };
    // Torque about y: ∫ f_x r_z − f_z r_x.
    let x = part([&ones[0], &zeros[1]]);
    let z = part([&zeros[0], &ones[1]]);
    x.into_iter().zip(z).map(|(x, z)| [x, -z]).collect()
}

#[test]
fn overlapping_grains_stay_bounded() {
    let mut run = pair();
    run.windows(60);
    let solver = run.fluid.two().expect("plane");
    let fastest = solver.stepper().state().velocity.iter().flatten().fold(0.0_f64, |m, u| m.max(u.abs()));
    assert!(fastest < 3.0, "{fastest}");
}

#[test]
fn mask_volume_tends_to_the_grains_volume() {
    // The edge of the seed's mask holds as much outside as it lacks inside, so its volume is true to
    // second order in w/R.
    let volume = |geometry: &str, n: usize| {
        let (lower, upper, cells, faces, at) = match geometry {
            "plane" => ("[0.0, 0.0]", "[1.0, 1.0]", format!("[{n}, {n}]"), "x", "[0.5, 0.0, 0.5]"),
            "axisymmetric" => {
                ("[0.0, 0.0]", "[0.5, 1.0]", format!("[{}, {n}]", n / 2), "r", "[0.0, 0.0, 0.5]")
            }
            _ => ("[0.0, 0.0, 0.0]", "[1.0, 1.0, 1.0]", format!("[{n}, {n}, {n}]"), "y", "[0.5, 0.5, 0.5]"),
        };
        let faces = match faces {
            "x" => "x = \"periodic\", z = \"periodic\"",
            "r" => "r_upper = \"free-slip\", z = \"periodic\"",
            _ => "x = \"periodic\", y = \"periodic\", z = \"periodic\"",
        };
        let run = Run::new(&format!(
            "until = 1.0
            [domain]
            geometry = \"{geometry}\"
            lower = {lower}
            upper = {upper}
            cells = {cells}
            boundary = {{ {faces} }}
            [medium]
            density = 1.0
            viscosity = 1.0
            [[grains]]
            position = {at}
            radius = 0.3
            density = 2.0
            motion = \"fixed\"
            [fluid]
            time = {{ dt = 1e-4 }}
            method = \"izard-2014\"
            "
        ));
        run.fluid.two().map(filled).or_else(|| run.fluid.three().map(filled)).expect("two or three axes")
    };
    let pi = std::f64::consts::PI;
    for (geometry, exact, n) in [
        ("plane", pi * 0.09, 64),
        ("axisymmetric", 4.0 / 3.0 * pi * 0.027, 64),
        ("space", 4.0 / 3.0 * pi * 0.027, 24),
    ] {
        let [coarse, fine] = [n, 2 * n].map(|n| volume(geometry, n) / exact - 1.0);
        println!("{geometry}: volume error {coarse:.2e}, {fine:.2e}");
        assert!(fine.abs() < 0.4 * coarse.abs() && fine.abs() < 0.01, "{geometry}: {coarse} {fine}");
    }
}
