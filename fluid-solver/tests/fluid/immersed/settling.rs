//! The seed's falling sphere (Izard et al. 2014, §3.1): Ar = 800, ρ_p/ρ = 4, D = g = ρ = 1.

use crate::immersed::newton::Run;
use fluid_solver::methods::calibrated::calibration::{Calibration, ForceTransport};

/// The falling sphere in an (r, z) box of `width` × `height` D with `across` cells over D.
pub(crate) fn sphere(across: usize, size: [f64; 2], density: f64, dt: f64, fluid: &str) -> Run {
    let [width, height] = size;
    let nu = (3.0_f64 / 800.0).sqrt();
    let n = across as f64;
    // The seed's radial grid: 30 of 128 cells of width D/20 up to 1.5 D for 20 D.
    let cells = [(1.5 * n + (width - 1.5) * n * 98.0 / (18.5 * 20.0)) as usize, (height * n) as usize];
    let z = height - 2.5;
    let time = if dt > 0.0 { format!("dt = {dt}") } else { "cfl = 0.5".into() };
    Run::new(&format!(
        "until = 100.0
        gravity = [0.0, 0.0, -1.0]
        [domain]
        geometry = \"axisymmetric\"
        lower = [0.0, 0.0]
        upper = [{width}, {height}]
        cells = {cells:?}
        stretching = {{ axis = \"r\", uniform_to = {core}, spacing = {spacing} }}
        boundary = {{ r_upper = \"free-slip\", z = \"free-slip\" }}
        [medium]
        density = 1.0
        viscosity = {nu}
        [[grains]]
        position = [0.0, 0.0, {z}]
        radius = 0.5
        density = {density}
        [fluid]
        time = {{ {time} }}
        {fluid}
        ",
        core = (1.5 * n).ceil() / n,
        spacing = 1.0 / n,
    ))
}

/// Re = V D/ν averaged over the last diameter of fall before `until`.
pub(crate) fn reynolds(run: &mut Run, until: f64) -> f64 {
    run.until(until - 1.0);
    let (z, t) = (run.newton.motions[0].position[2], run.time);
    run.until(until);
    (z - run.newton.motions[0].position[2]) / (run.time - t) / (3.0_f64 / 800.0).sqrt()
}

/// Mean over two places of the equator among the nodes: on one of them and in the middle between two.
#[test]
fn terminal_reynolds_number_in_a_reduced_box() {
    let of = |cells: usize| reynolds(&mut sphere(cells, [8.0, 28.0], 4.0, 0.04, ""), 16.0);
    let (on, between) = (of(8), of(9));
    let re = 0.5 * (on + between);
    println!("D/dx = 8, 9, dt = .04, 8D x 28D: Re = {on:.3}, {between:.3}");
    // Clift, Grace & Weber (1978), table 5.2, infinite fluid: 19.63.
    assert!((re / 19.63 - 1.0).abs() < 0.01, "{re}");
}

#[test]
fn first_step_has_the_acceleration_of_equation_20_and_the_fall_is_stable() {
    for density in [0.1, 0.5, 1.0, 4.0, 8.0] {
        let mut run = sphere(8, [4.0, 12.0], density, 0.04, "");
        run.windows(1);
        let found = run.fall() / 0.04;
        let exact = -(density - 1.0) / (density + 0.5);
        assert!((found - exact).abs() < 1e-12, "{density}: {found} against {exact}");
        let mut fastest = 0.0_f64;
        // No more than free fall against C_D = 0.9 can reach.
        let limit = 1.2 * ((density - 1.0_f64).abs() + 1e-9).sqrt();
        for step in 0..200 {
            let before = run.fall();
            run.windows(1);
            // Instability shows as a velocity that jumps back and forth.
            let change = run.fall() - before;
            assert!(step > 20 || change * exact >= 0.0, "{density}: {change} in step {step}");
            let z = run.newton.motions[0].position[2];
            if !(1.0..11.0).contains(&z) {
                break;
            }
            fastest = fastest.max(run.fall().abs());
            assert!(fastest < limit, "{density}: speed {fastest} after {} steps", run.step);
        }
        println!("density {density}: largest speed {fastest:.4} in {} steps", run.step);
        if density == 1.0 {
            assert!(fastest < 1e-12);
        }
    }
}

#[test]
fn the_printed_method_settles_as_fast() {
    let mut run = sphere(8, [5.0, 20.0], 4.0, 0.02, "method = \"izard-2014\"");
    let re = reynolds(&mut run, 11.0);
    println!("izard-2014: Re = {re:.3}");
    assert!((re / 19.63 - 1.0).abs() < 0.15, "{re}");
}

#[test]
fn adaptive_steps_reach_the_same_speed() {
    let mut run = sphere(8, [5.0, 20.0], 4.0, 0.0, "");
    let re = reynolds(&mut run, 11.0);
    println!("adaptive: Re = {re:.3} in {} steps", run.step);
    assert!((re / 19.63 - 1.0).abs() < 0.015, "{re}");
}

/// Speed of a sphere at Re = 2 after a fall of 1.7 D, on eight cells.
fn slow_fall(domain: &str, dt: f64, force_transport: ForceTransport) -> f64 {
    let text = format!(
        "until = 8.0
        gravity = [0.0, 0.0, -2.0]
        [domain]
        {domain}
        [medium]
        density = 1.0
        viscosity = 0.141421
        [[grains]]
        position = [0.0, 0.0, 0.0]
        radius = 0.5
        density = 1.5
        [fluid]
        time = {{ dt = {dt} }}
        "
    );
    let mut run = Run::calibrated(&text, Calibration { force_transport, ..Calibration::default() });
    run.until(8.0);
    run.fall()
}

/// A force that stays in its cells lets the fluid slip by some U dt/Δx ν dt/Δx² of the velocity.
#[test]
fn a_slow_sphere_does_not_gain_from_long_steps() {
    let axis = "geometry = \"axisymmetric\"\nlower = [0.0, -4.0]\nupper = [2.0, 2.0]\ncells = [16, 48]\n\
        boundary = { r_upper = \"free-slip\", z = \"no-slip\" }";
    let space = "geometry = \"space\"\nlower = [-2.0, -2.0, -4.0]\nupper = [2.0, 2.0, 2.0]\n\
        cells = [32, 32, 48]\nboundary = { x = \"free-slip\", y = \"free-slip\", z = \"no-slip\" }";
    for domain in [axis, space] {
        let short = slow_fall(domain, 0.01, ForceTransport::Auto);
        // ν dt/Δx² = 1.45
        let [with_grain, in_place] = [ForceTransport::Auto, ForceTransport::Eulerian]
            .map(|transport| slow_fall(domain, 0.16, transport) / short - 1.0);
        println!("speed {short:.4}, long steps {with_grain:.4} more, {in_place:.4} with the force in place");
        assert!(with_grain.abs() < 0.007 && in_place > 0.015, "{with_grain} and {in_place}");
    }
}

/// The whole scene of the seed; minutes, so run by name: `-- --ignored full_scene --nocapture`.
#[test]
#[ignore = "minutes: a measurement, not a check"]
fn full_scene() {
    let cases = std::env::var("ACROSS").unwrap_or_else(|_| "8,10".into());
    let fluid = std::env::var("FLUID").unwrap_or_default();
    let steps = std::env::var("STEPS").unwrap_or_else(|_| "0.04,0.01".into());
    for across in cases.split(',').map(|n| n.parse().expect("a number")) {
        for dt in steps.split(',').map(|dt| dt.parse().expect("a number")) {
            let begin = std::time::Instant::now();
            let mut run = sphere(across, [20.0, 40.0], 4.0, dt, &fluid);
            let history: Vec<String> =
                [10.0, 14.0, 18.0, 22.0].map(|t| format!("{:.3}", reynolds(&mut run, t))).into();
            let re = reynolds(&mut run, 26.0);
            println!("Re at t = 10, 14, 18, 22: {}", history.join(", "));
            println!(
                "20D x 40D, D/dx = {across}, dt = {dt} {fluid}: Re = {re:.3}, {} steps, {:.1} s, {:.0} ns \
                 per cell and step",
                run.step,
                begin.elapsed().as_secs_f64(),
                1e9 * begin.elapsed().as_secs_f64()
                    / (run.step as f64 * run.fluid.two().expect("r, z").grid().cell_count() as f64)
            );
        }
    }
}
