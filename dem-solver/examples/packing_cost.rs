//! What a grain and sub-step cost in bulk:
//! `cargo run --release -p dem-solver --example packing_cost -- N [STEPS [THREADS [general|rain|write FILE]]]`.
//! With RELAX=n in the environment, n sub-steps before the timed ones (300).
//!
//! `scenes/bench/packing.csv` (1,000 settled spheres, D = 2 mm ± 10 %, walls 10 D apart) stacked up to N
//! grains; e_n = 0.3, μ = 0.25, t_c = 1e-4 s, dt = t_c/50. After RELAX sub-steps STEPS are timed by the
//! CPU clock of the process. `rain` spreads them fourfold in height with 0.5 m/s; `general` takes the other
//! engine; `write` only writes the start for LAMMPS (see `tests/peers/lammps.sh`).

use cpu_time::ProcessTime;
use dem_solver::{ContactLaw, Dem, DemSpec, Engine, Grain, LinearSpringDashpot, Wall};
use std::error::Error;
use std::fmt::Write as _;
use std::time::Instant;

const SIDE: f64 = 0.02;
const SHIFT: f64 = 0.02042;
const DT: f64 = 2e-6;

/// The stacked packing.
fn grains(n: usize, rain: bool) -> Result<Vec<Grain>, Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/bench/packing.csv");
    let text = std::fs::read_to_string(path)?;
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
        let z = z + SHIFT * (k / layer.len()) as f64;
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
    spec.gravity = [0.0, 0.0, -9.81];
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

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, or: usize| words.get(k).map_or(Ok(or), |word| word.parse());
    let (n, steps, threads) = (number(0, 8000)?, number(1, 1000)?, number(2, 1)?);
    let mode = words.get(3).map_or("", String::as_str);
    let start = grains(n, mode == "rain" || words.get(5).is_some_and(|word| word == "rain"))?;
    if let ("write", Some(path)) = (mode, words.get(4)) {
        return Ok(std::fs::write(path, lammps(&start)?)?);
    }
    let mut spec = spec(start);
    spec.bulk.threads = threads;
    spec.engine = if mode == "general" { Engine::General } else { Engine::Bulk };
    let mut dem = Dem::new(&spec)?;
    drop(spec);
    let relax: u32 = std::env::var("RELAX").map_or(Ok(300), |word| word.parse())?;
    for _ in 0..relax / 100 {
        dem.advance(100.0 * DT, 100, &[])?;
    }
    let (builds, cpu, wall) = (dem.list_builds(), ProcessTime::now(), Instant::now());
    let mut contacts = 0;
    for first in (0..steps).step_by(100) {
        let part = (steps - first).min(100) as u32;
        contacts = dem.advance(f64::from(part) * DT, part, &[])?.contacts;
    }
    let per = 1e9 / (n * steps) as f64;
    println!(
        "{n} grains, {threads} threads: {:.1} ns CPU, {:.1} ns wall per grain-step; {:.2} contacts per grain; \
         {} builds in {steps} steps; peak {:.0} B per grain; KE {:.6e} J",
        cpu.elapsed().as_secs_f64() * per,
        wall.elapsed().as_secs_f64() * per,
        2.0 * contacts as f64 / n as f64,
        dem.list_builds() - builds,
        peak() / n as f64,
        dem.kinetic_energy(),
    );
    Ok(())
}
