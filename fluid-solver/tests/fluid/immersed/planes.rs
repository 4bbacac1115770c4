//! Averages over planes against what is known of them.

use crate::immersed::newton::{Run, scene};
use crate::immersed::restart::folder;
use bedload_output::planes::{Plane, Planes};
use fluid_solver::participant::Fluid;
use fluid_solver::planes::averages;
use fluid_solver::ranks::Ranks;
use protocol::participant::Participant;
use std::f64::consts::PI;
use std::path::Path;

/// A sphere that moves and spins in fluid that streams along x: fraction, both velocities, across each axis.
#[test]
fn planes_hold_the_grain_and_both_velocities() {
    let scene = scene(
        r#"until = 1.0
        [domain]
        geometry = "space"
        lower = [0.0, 0.0, 0.0]
        upper = [2.0, 2.0, 2.5]
        cells = [32, 32, 40]
        boundary = { x = "periodic", y = "periodic", z = "free-slip" }
        [medium]
        density = 1.0
        viscosity = 0.1
        initial = { type = "uniform", velocity = [0.3, 0.0, 0.0] }
        [[grains]]
        position = [0.1, 1.0, 1.2]
        radius = 0.5
        density = 2.0
        motion = "prescribed"
        velocity = [0.2, -0.1, 0.05]
        spin = [0.0, 3.0, 0.0]"#,
    );
    let fluid = Fluid::new(&scene, Path::new("unused")).expect("a valid scene");
    let solver = fluid.three().expect("space");
    let volume = 4.0 / 3.0 * PI * 0.125;
    for (axis, section) in [(0, 5.0), (1, 5.0), (2, 4.0)] {
        let planes = averages(solver, axis);
        let solid: f64 = planes.iter().map(|p| p.solid_fraction * p.width * section).sum();
        assert!((solid / volume - 1.0).abs() < 1e-3, "axis {axis}: volume {solid} for {volume}");
        let mean: [f64; 3] = std::array::from_fn(|c| {
            let sum = planes.iter().map(|p| p.solid_fraction * p.width * section * p.grain_velocity[c]);
            sum.sum::<f64>() / solid
        });
        for (c, v) in [0.2, -0.1, 0.05].into_iter().enumerate() {
            assert!((mean[c] - v).abs() < 2e-3, "axis {axis}, component {c}: {} for {v}", mean[c]);
        }
    }
    // across z the spin about y shows: v_x = 0.2 + 3 (z − 1.2)
    for plane in averages(solver, 2).iter().filter(|p| (p.at - 1.2).abs() < 0.4) {
        let expected = 0.2 + 3.0 * (plane.at - 1.2);
        assert!((plane.grain_velocity[0] - expected).abs() < 1e-12, "{plane:?}");
    }
    let far = averages(solver, 2);
    let [low, high] = [far[0], far[39]];
    assert_eq!((low.solid_fraction, high.solid_fraction), (0.0, 0.0));
    // the fluid moves only where the grain pushes it aside: its mean far away is the stream's, nearly
    assert!((low.fluid_velocity[0] - 0.3).abs() < 0.05, "{low:?}");
}

/// A grain fills its own volume, coarse or fine, in the plane, in space and in r–z, of either method.
#[test]
fn the_solid_fraction_is_that_of_the_grain() {
    for (geometry, upper, lengths, whole) in [
        ("plane", "[2.0, 2.0]", &[2, 2][..], PI / 4.0),
        ("space", "[2.0, 2.0, 2.0]", &[2, 2, 2], PI / 6.0),
        ("axisymmetric", "[1.0, 2.0]", &[1, 2], PI / 6.0),
    ] {
        let (lower, section) =
            (vec![0.0; lengths.len()], [PI, 2.0, 4.0][lengths.iter().sum::<usize>() / 2 - 1]);
        let x = if geometry == "axisymmetric" { "r_upper = \"no-slip\"" } else { "x = \"periodic\"" };
        let y = if geometry == "space" { "y = \"periodic\"\n" } else { "" };
        for (resolution, method) in
            [6, 10, 16].into_iter().flat_map(|n| [(n, "calibrated"), (n, "izard-2014")])
        {
            let cells: Vec<usize> = lengths.iter().map(|length| length * resolution).collect();
            // A sharp edge on few cells swings with its place by 1 %: the mean of sixteen.
            let solid = |k: usize| {
                let [a, b, c] = [0.618, 0.755, 0.57].map(|part| 0.9 + (k as f64 * part).fract() / 6.0);
                let place = match geometry {
                    "plane" => [a, 0.0, c],
                    "space" => [a, b, c],
                    _ => [0.0, 0.0, c],
                };
                let scene = scene(&format!(
                    "until = 1.0\n[domain]\ngeometry = \"{geometry}\"\nlower = {lower:?}\nupper = {upper}\n\
                 cells = {cells:?}\n[domain.boundary]\n{x}\n{y}z = \"no-slip\"\n[medium]\ndensity = 1.0\n\
                 viscosity = 0.1\n[fluid]\nmethod = \"{method}\"\n[fluid.time]\ndt = 1e-3\n[[grains]]\n\
                 position = {place:?}\nradius = 0.5\ndensity = 2.0\nmotion = \"fixed\"\n",
                ));
                let fluid = Fluid::new(&scene, Path::new("unused")).expect("a valid scene");
                let planes = match fluid.three() {
                    Some(solver) => averages(solver, 2),
                    None => averages(fluid.two().expect("two axes"), 1),
                };
                planes.iter().map(|p| p.solid_fraction * p.width * section).sum::<f64>()
            };
            let error = (0..16).map(solid).sum::<f64>() / (16.0 * whole) - 1.0;
            let n = resolution as f64;
            // On the axis there is but one place across.
            let bar = if geometry == "axisymmetric" { 0.2 / n } else { 0.3 / (n * n) };
            assert!(error.abs() < bar, "{geometry}, {method}, {resolution} cells: {error}");
        }
    }
}

/// Neutral discs in plane Couette flow, each on a height of its own; more observed things.
fn couette(observe: &str) -> String {
    let disc = |x: f64, z: f64| {
        format!("[[grains]]\nposition = [{x}, 0.0, {z}]\nradius = 0.25\ndensity = 1.0\nwith_fluid = true\n")
    };
    let discs: String = [(0.4, 0.5), (1.2, 0.8), (2.0, 1.2), (2.7, 1.6)].map(|(x, z)| disc(x, z)).concat();
    format!(
        r#"until = 8.0
        [domain]
        geometry = "plane"
        lower = [0.0, 0.0]
        upper = [3.0, 2.0]
        cells = [48, 32]
        [domain.boundary]
        x = "periodic"
        z_lower = {{ type = "no-slip", velocity = [-1.0, 0.0, 0.0] }}
        z_upper = {{ type = "no-slip", velocity = [1.0, 0.0, 0.0] }}
        [medium]
        density = 1.0
        viscosity = 0.5
        initial = {{ type = "shear", direction = "x", gradient = "z", rate = 1.0, origin = 1.0 }}
        [fluid.time]
        dt = 0.01
        [observe]
        totals = {{ columns = ["wall-force", "fluid-flux"] }}
        planes = {{ every = 0.02, from = 5.0, stress = true{observe} }}
        {discs}"#
    )
}

/// Sum of the parts of the shear stress on each plane.
fn shear(planes: &Planes) -> Vec<f64> {
    let sum = |p: &Plane| p.stresses.expect("stresses").parts.iter().map(|part| part[0]).sum();
    planes.planes.iter().map(sum).collect()
}

/// Momentum along x of both phases, which have density 1, below the middle of each plane, per area.
fn momentum_below(planes: &Planes) -> Vec<f64> {
    let mut below = 0.0;
    let momentum = planes.planes.iter().map(|p| {
        let phi = p.solid_fraction;
        let here = p.width * ((1.0 - phi) * p.fluid_velocity[0] + phi * p.grain_velocity[0]);
        below += here;
        below - 0.5 * here
    });
    momentum.collect()
}

/// The parts of the shear stress change by their whole from plane to plane; their sum changes by the momentum
/// that the planes gain, and is that of the walls. The tolerance is what the mean over samples leaves of it.
#[test]
fn the_sum_of_the_stresses_balances_momentum_on_every_plane() {
    let folder = folder("stress");
    let mut run = Run::with_ranks(&couette(""), &Ranks::alone(), &folder);
    let first = run.newton.motions[3];
    assert!((first.velocity[0] - 0.6).abs() < 1e-15 && (first.spin[1] - 0.5).abs() < 1e-15, "{first:?}");
    run.until(8.0);
    let mut found = Vec::new();
    run.fluid.totals(&mut found);
    let entries = std::fs::read_dir(folder.join("fields")).expect("samples").flatten();
    let read = |entry: std::fs::DirEntry| std::fs::read_to_string(entry.path()).expect("a sample");
    let mut samples: Vec<Planes> = entries.map(|e| Planes::parse(&read(e)).expect("planes")).collect();
    std::fs::remove_dir_all(&folder).expect("a folder");
    samples.retain(|sample| sample.time() > 4.99);
    samples.sort_by(|a, b| a.time().total_cmp(&b.time()));
    let (first, last) = (&samples[0], &samples[samples.len() - 1]);
    let mean = Planes::mean(&samples, first.time()).expect("a mean");
    let gained = momentum_below(last).into_iter().zip(momentum_below(first));
    let rate = gained.map(|(now, before)| (now - before) / (last.time() - first.time()));
    let balanced: Vec<f64> = shear(&mean).iter().zip(rate).map(|(sum, rate)| sum - rate).collect();
    let total = balanced.iter().sum::<f64>() / balanced.len() as f64;
    let off = balanced.iter().map(|sum| (sum / total - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < 0.005, "{off}: {balanced:?}");
    // mean velocity, then the floor and the lid, along x and z: each drags the other way
    let now = shear(last);
    for (wall, side, near) in [(found[1], 1.0, now[0]), (found[3], -1.0, now[31])] {
        assert!((side * wall / 3.0 / near - 1.0).abs() < 0.01, "{wall} for {near}");
    }
    assert!(found[0].abs() < 0.05 && found.len() == 5, "{found:?}");
    let grains = |p: &Plane| p.stresses.expect("stresses").parts[2][0];
    let most = mean.planes.iter().map(grains).fold(0.0, f64::max);
    assert!(most > 0.5 * total, "what grains carry: {most} of {total}");
    println!("balance {off}, grains {most} of {total}");
    for p in mean.planes.iter().filter(|p| p.solid_fraction == 0.0) {
        assert!(grains(p).abs() < 1e-3 * total, "no grain at {}: {}", p.at, grains(p));
    }
}
