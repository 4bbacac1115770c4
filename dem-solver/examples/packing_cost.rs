//! What a grain and sub-step cost in bulk:
//! `cargo run --release -p bedload-dem --example packing_cost -- N [STEPS [THREADS [MODE [FILE]]]]`.
//!
//! `scenes/bench/packing.csv` (1,000 settled spheres, D = 2 mm ± 10 %, walls 10 D apart) stacked up to N
//! grains; e_n = 0.3, μ = 0.25, t_c = 1e-4 s, dt = t_c/50. After RELAX sub-steps (from the environment,
//! else 300) STEPS are timed by the CPU clock of the process. Modes:
//!
//! - `settle FILE`: stacks the layers too closely, lets them come to rest and writes what lies there
//!   (`x y z r` per line) to FILE. With START=FILE in the environment all modes but rain begin with it, or
//!   with copies of it one upon the other.
//! - `rain`: the stack four times as high, with 0.5 m/s.
//! - `write FILE`: writes only the start, for LAMMPS (see `tests/peers/lammps.sh`); `write-rain FILE` that of
//!   rain.
//! - `general`, `general-rain`: the other engine.
//!
//! SKIN, m, and DEPTH in the environment set the width of the lists and the depth of the wavefront.

use cpu_time::ProcessTime;
use dem_solver::{ContactLaw, Dem, DemSpec, Engine, Grain, LinearSpringDashpot, Wall};
use std::error::Error;
use std::fmt::Write as _;
use std::time::Instant;

const SIDE: f64 = 0.02;
const SHIFT: f64 = 0.02042;
/// Distance of the layers that are to settle: they overlap a little, else they fall for long.
const CLOSE: f64 = 0.0192;
const DT: f64 = 2e-6;

/// A packing that came to rest before; more grains than it has are taken from copies of it, one upon the
/// other.
fn settled(path: &str, n: usize) -> Result<Vec<Grain>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let mut one: Vec<[f64; 4]> = Vec::new();
    for line in text.lines() {
        let value: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let [x, y, z, r] = value[..] else { return Err(format!("{path}: not x y z r: {line}").into()) };
        one.push([x, y, z, r]);
    }
    // from below, so that a part of a copy is its lower part
    one.sort_by(|a, b| a[2].total_cmp(&b[2]));
    let end = |side: f64| one.iter().map(|[_, _, z, r]| side * z + r).fold(f64::NEG_INFINITY, f64::max);
    let (top, bottom) = (end(1.0), end(-1.0));
    let grains = (0..n).map(|k| {
        let [x, y, z, r] = one[k % one.len()];
        Grain::new([x, y, z + (top + bottom) * (k / one.len()) as f64], r, 2500.0)
    });
    Ok(grains.collect())
}

/// The stacked packing.
fn stacked(n: usize, rain: bool, shift: f64) -> Result<Vec<Grain>, Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/bench/packing.csv");
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}; run in a checkout"))?;
    let mut layer = Vec::new();
    for line in text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())) {
        let value: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
        layer.push((value[0], value[1], value[2], value[3]));
    }
    layer.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut seed = 7u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let stacked = (0..n).map(|k| {
        let (x, y, z, r) = layer[k % layer.len()];
        let z = z + shift * (k / layer.len()) as f64;
        let mut grain = Grain::new([x, y, if rain { 4.0 * z } else { z }], r, 2500.0);
        if rain {
            grain.velocity = [random(), random(), random()];
        }
        grain
    });
    Ok(stacked.collect())
}

fn spec(grains: Vec<Grain>) -> DemSpec {
    let mut law = LinearSpringDashpot::new(0.3, 1e-4, 0.25);
    law.stiffness_ratio = 2.0 / 7.0;
    law.damping_ratio = 0.5;
    let mut spec = DemSpec::new(grains, ContactLaw::LinearSpringDashpot(law));
    spec.gravity = [0.0, 0.0, -9.81].into();
    spec.walls = vec![
        Wall::new([0.0; 3], [0.0, 0.0, 1.0]),
        Wall::new([0.0; 3], [1.0, 0.0, 0.0]),
        Wall::new([SIDE, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        Wall::new([0.0; 3], [0.0, 1.0, 0.0]),
        Wall::new([0.0, SIDE, 0.0], [0.0, -1.0, 0.0]),
    ];
    (spec.observations, spec.orientation) = (false, false);
    spec
}

/// A LAMMPS data file of the start.
fn lammps(grains: &[Grain]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let top = grains.iter().map(|grain| grain.position[2]).fold(0.0, f64::max) + 0.008;
    writeln!(text, "packing\n\n{} atoms\n1 atom types\n0 {SIDE} xlo xhi\n0 {SIDE} ylo yhi", grains.len())?;
    writeln!(text, "-0.002 {top} zlo zhi\n\nAtoms # sphere\n")?;
    for (k, grain) in grains.iter().enumerate() {
        let [x, y, z] = grain.position;
        writeln!(text, "{} 1 {} {} {x} {y} {z}", k + 1, 2.0 * grain.radius, grain.density)?;
    }
    writeln!(text, "\nVelocities\n")?;
    for (k, grain) in grains.iter().enumerate() {
        let [x, y, z] = grain.velocity;
        writeln!(text, "{} {x} {y} {z} 0 0 0", k + 1)?;
    }
    Ok(text)
}

/// Peak resident memory, bytes; 0 where the system does not tell.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).unwrap_or(0.0) * 1024.0
}

/// Lets closely stacked layers come to rest: first nothing may be faster than 0.1 m/s, then speeds are
/// damped, then they are left alone until the mean grain has less than 1e-11 J (1.4 mm/s).
fn settle(dem: &mut Dem, n: usize) -> Result<(), Box<dyn Error>> {
    for _ in 0..1000 {
        dem.advance(10.0 * DT, 10, &[])?;
        for v in &mut dem.grains.velocity {
            *v *= (0.1 / v.norm()).min(1.0);
        }
    }
    for _ in 0..200 {
        dem.advance(100.0 * DT, 100, &[])?;
        dem.grains.velocity.iter_mut().for_each(|v| *v *= 0.9);
    }
    for window in 0..500 {
        dem.advance(200.0 * DT, 200, &[])?;
        if window % 25 == 0 {
            let (energy, pairs) = (dem.kinetic_energy() / n as f64, dem.save().contacts.len());
            protocol::say!(
                "{window}: {energy:.1e} J, {:.2} contacts per grain",
                2.0 * pairs as f64 / n as f64
            );
            if energy < 1e-11 {
                return Ok(());
            }
        }
    }
    Err("the packing did not come to rest in 100,000 sub-steps".into())
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, or: usize| words.get(k).map_or(Ok(or), |word| word.parse());
    let (n, steps, threads) = (number(0, 8000)?, number(1, 1000)?, number(2, 1)?);
    let (mode, path) = (words.get(3).map_or("", String::as_str), words.get(4));
    let start = match std::env::var("START") {
        Ok(path) if !mode.ends_with("rain") => settled(&path, n)?,
        _ => stacked(n, mode.ends_with("rain"), if mode == "settle" { CLOSE } else { SHIFT })?,
    };
    if let ("write" | "write-rain", Some(path)) = (mode, path) {
        return Ok(std::fs::write(path, lammps(&start)?)?);
    }
    let mut spec = spec(start);
    spec.bulk.threads = threads;
    spec.bulk.skin = std::env::var("SKIN").ok().map(|word| word.parse()).transpose()?;
    spec.bulk.depth = std::env::var("DEPTH").map_or(Ok(0), |word| word.parse())?;
    spec.engine = if mode.starts_with("general") { Engine::General } else { Engine::Bulk };
    let mut dem = Dem::new(&spec)?;
    drop(spec);
    if let ("settle", Some(path)) = (mode, path) {
        settle(&mut dem, n)?;
        let mut text = String::new();
        for (x, r) in dem.grains.position.iter().zip(&dem.grains.radius) {
            writeln!(text, "{} {} {} {r}", x.x, x.y, x.z)?;
        }
        return Ok(std::fs::write(path, text)?);
    }
    let relax: u32 = std::env::var("RELAX").map_or(Ok(300), |word| word.parse())?;
    for _ in 0..relax / 100 {
        dem.advance(100.0 * DT, 100, &[])?;
    }
    let (builds, cpu, wall) = (dem.list_builds(), ProcessTime::now(), Instant::now());
    for first in (0..steps).step_by(100) {
        let part = (steps - first).min(100) as u32;
        dem.advance(f64::from(part) * DT, part, &[])?;
    }
    let (cpu, wall) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    let (per, memory, builds) = (1e9 / (n * steps) as f64, peak() / n as f64, dem.list_builds() - builds);
    println!(
        "{n} grains, {threads} threads: {:.1} ns CPU, {:.1} ns wall per grain-step; {:.2} contacts per grain; \
         {builds} builds in {steps} steps; peak {memory:.0} B per grain; KE {:.6e} J",
        cpu * per,
        wall * per,
        2.0 * dem.save().contacts.len() as f64 / n as f64,
        dem.kinetic_energy(),
    );
    Ok(())
}
