//! Coupling schemes from the fluid's side: what is sent when, and what repeated windows lead to.

use crate::immersed::newton::{Newton, Run, scene};
use fluid_solver::methods::calibrated::calibration::Calibration;
use protocol::participant::{Participant, Window};

/// A sphere in a small (r, z) box, D = g = ρ = ν = 1, released from rest.
fn sphere(density: f64, dt: f64, keys: &str) -> String {
    format!(
        "until = 100.0
        gravity = [0.0, 0.0, -1.0]
        [domain]
        geometry = \"axisymmetric\"
        lower = [0.0, 0.0]
        upper = [2.0, 4.0]
        cells = [16, 32]
        boundary = {{ r_upper = \"free-slip\", z = \"no-slip\" }}
        [medium]
        density = 1.0
        viscosity = 1.0
        [[grains]]
        position = [0.0, 0.0, 2.0]
        radius = 0.5
        density = {density}
        [fluid.time]
        dt = {dt}
        {keys}
        "
    )
}

fn iterated(more: &str) -> String {
    format!("[coupling]\nscheme = \"iterated\"\n{more}")
}

/// One window of `attempts` attempts; the velocity after each.
fn attempts(run: &mut Run, attempts: u64) -> Vec<f64> {
    let text = sphere(1.0, 1.0, "");
    let mut before = Newton::new(&scene(&text));
    before.take_over(&run.newton);
    run.fluid.save();
    let mut velocities = Vec::new();
    for attempt in 0..attempts {
        if attempt > 0 {
            run.fluid.restore();
            run.newton.take_over(&before);
        }
        let window =
            Window { step: run.step, attempt, time: run.time, dt: run.dt, substeps: 1, output: false };
        run.fluid.advance(&window, &mut run.newton).unwrap_or_else(|error| panic!("{error}"));
        velocities.push(run.fall());
    }
    run.time += run.dt;
    run.step += 1;
    velocities
}

/// Velocity at time `until` with windows repeated until nothing changes.
fn converged(density: f64, dt: f64, until: f64) -> f64 {
    repeated(Run::new(&sphere(density, dt, &iterated(""))), until)
}

fn repeated(mut run: Run, until: f64) -> f64 {
    while run.time < until * (1.0 - 1e-9) {
        attempts(&mut run, 25);
    }
    run.fall()
}

#[test]
fn the_first_attempt_is_the_semi_implicit_window_with_more_virtual_mass() {
    let (dt, volume) = (0.02, std::f64::consts::PI / 6.0);
    let mut plain = Run::new(&sphere(0.5, dt, ""));
    let mut first = Run::new(&sphere(0.5, dt, &iterated("")));
    plain.windows(1);
    first.windows(1);
    let (plain, first) = (plain.newton.loads[0], first.newton.loads[0]);
    assert_eq!((plain.force, plain.torque), (first.force, first.torque));
    // 2 ν dt/D² of the displaced mass, which drops out of what the attempts converge to.
    assert!((first.added_mass - plain.added_mass - 2.0 * dt * volume).abs() < 1e-15);
}

#[test]
fn attempts_converge_for_light_grains_in_long_windows() {
    for (number, density) in [(0.2, 0.01), (0.2, 4.0), (0.8, 0.01), (0.8, 0.5), (0.024, 0.5), (0.08, 0.5)] {
        let keys = iterated("");
        let mut run = Run::new(&sphere(density, number, &keys));
        let velocities = attempts(&mut run, 20);
        let changes: Vec<f64> = velocities.windows(2).map(|v| (v[1] - v[0]).abs()).collect();
        println!("ν dt/D² = {number}, ρ_r = {density}: changes {changes:?}");
        let least = changes[8..].iter().fold(f64::INFINITY, |least, change| least.min(*change));
        assert!(least < 1e-2 * changes[0], "{number}, {density}");
        // By the rule of the coupler, over a while.
        let found = release(density, number, 20, &keys);
        let mean = found.attempts as f64 / 20.0;
        println!("    {mean} attempts, {} unconverged", found.unconverged);
        // The first window, from rest, may take more than 20.
        assert!(!found.broken && found.unconverged <= 1 && mean < 14.0, "{number}, {density}");
    }
}

#[test]
fn what_it_converges_to_does_not_know_the_virtual_mass() {
    let (density, dt) = (0.5, 0.2);
    let with = converged(density, dt, 3.0 * dt);
    let text = sphere(density, dt, &iterated(""));
    let calibration = Calibration { without_virtual_mass: true, ..Calibration::default() };
    let without = repeated(Run::calibrated(&text, calibration), 3.0 * dt);
    println!("{without} without, {with} with it");
    assert!((without / with - 1.0).abs() < 1e-4, "{without} against {with}");
}

#[test]
fn what_it_converges_to_hardly_knows_the_length_of_the_windows() {
    // At t = 0.8, some 15 relaxation times: the same speed from 1, 4 and 16 windows.
    let speeds = [0.8, 0.2, 0.05].map(|dt| converged(0.1, dt, 0.8));
    println!("speeds {speeds:?}");
    assert!(
        (speeds[0] / speeds[2] - 1.0).abs() < 0.2 && (speeds[1] / speeds[2] - 1.0).abs() < 0.05,
        "{speeds:?}"
    );
}

#[test]
fn it_is_the_semi_implicit_scheme_in_the_limit_of_short_windows() {
    let until = 0.08;
    let differences: Vec<f64> = [0.02, 0.01, 0.005]
        .into_iter()
        .map(|dt| {
            let mut plain = Run::new(&sphere(2.0, dt, ""));
            plain.until(until);
            (converged(2.0, dt, until) / plain.fall() - 1.0).abs()
        })
        .collect();
    println!("differences {differences:?}");
    assert!(differences[2] < 0.6 * differences[0], "{differences:?}");
    assert!(differences[1] < differences[0], "{differences:?}");
}

/// What a scheme makes of a release from rest.
struct Release {
    /// Velocity after each window, m/s.
    velocities: Vec<f64>,
    /// Attempts at all windows, and windows without an end to them.
    attempts: u64,
    unconverged: u64,
    /// Did it end early?
    broken: bool,
}

/// `windows` windows of a release (a neutral sphere is pushed), by the rules of the coupler: an attempt
/// more while the velocity changes by 1e-4 of itself and 0.3 g dt, 20 at most.
fn release(density: f64, dt: f64, windows: usize, keys: &str) -> Release {
    let (place, push) =
        if density < 1.0 { (2.0, 0.0) } else { (6.0, if density == 1.0 { -0.05 } else { 0.0 }) };
    let text = sphere(density, dt, keys)
        .replace("upper = [2.0, 4.0]", "upper = [2.0, 8.0]")
        .replace("cells = [16, 32]", "cells = [16, 64]")
        .replace("[0.0, 0.0, 2.0]\n", &format!("[0.0, 0.0, {place}]\n velocity = [0.0, 0.0, {push}]\n"));
    let mut run = Run::new(&text);
    let mut before = Newton::new(&scene(&text));
    let mut result = Release { velocities: Vec::new(), attempts: 0, unconverged: 0, broken: false };
    let most = if keys.contains("iterated") { 20 } else { 1 };
    for step in 0..windows as u64 {
        before.take_over(&run.newton);
        run.fluid.save();
        let mut last = f64::INFINITY;
        for attempt in 0..most {
            if attempt > 0 {
                run.fluid.restore();
                run.newton.take_over(&before);
            }
            let window = Window { step, attempt, time: dt * step as f64, dt, substeps: 1, output: false };
            let done = run.fluid.advance(&window, &mut run.newton);
            result.attempts += 1;
            let (speed, z) = (run.fall(), run.newton.motions[0].position[2]);
            if done.is_err() || !(speed.abs() < 2.0 && (0.7..7.3).contains(&z)) {
                result.broken = done.is_err() || speed.abs() > 1.0 || (step as usize) < windows / 4;
                return result;
            }
            if (speed - last).abs() <= 1e-4 * (speed.abs() + 0.3 * dt) {
                break;
            }
            result.unconverged += u64::from(attempt + 1 == most && most > 1);
            last = speed;
        }
        result.velocities.push(run.fall());
    }
    result
}

/// The table of docs/coupling.md, *Schemes*.
#[test]
#[ignore = "a minute of measuring; prints the table of docs/coupling.md"]
fn table() {
    let schemes = [("semi-implicit", String::new()), ("iterated", iterated(""))];
    for number in [0.024, 0.08, 0.2, 0.8] {
        for density in [0.01, 0.1, 0.5, 1.0] {
            let splits = (number / 0.0016_f64).round() as usize;
            let count = if number > 0.5 { 3 } else { 6 };
            let reference = release(density, number / splits as f64, count * splits, "").velocities;
            let reference: Vec<f64> =
                reference.chunks(splits).filter_map(|part| part.last().copied()).collect();
            let scale = reference.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            for (name, keys) in &schemes {
                let found = release(density, number, 120, keys);
                let v = &found.velocities;
                let error = |k: usize| v.get(k).map_or(f64::NAN, |v| (v - reference[k]).abs() / scale);
                let tail = &v[v.len() / 2..];
                let jump =
                    tail.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).fold(0.0, f64::max) / scale;
                let verdict = match (found.broken, jump) {
                    (true, _) => "failed",
                    (_, jump) if jump > 0.02 => "oscillates",
                    _ => "stable",
                };
                println!(
                    "nu dt/D2 {number:<6} rho {density:<5} {name:30} {verdict:10} first {:8.4} last {:8.4} \
                     jump {jump:8.1e} windows {:3} attempts {:5.2} unconverged {}",
                    error(0),
                    error(count - 1),
                    v.len(),
                    found.attempts as f64 / v.len().max(1) as f64,
                    found.unconverged,
                );
            }
        }
    }
}
