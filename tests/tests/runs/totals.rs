//! A suspension that is sheared between walls, with the real programs: totals of the bed and stresses.

use std::path::Path;

use bedload_output::Series;
use bedload_output::planes::Planes;
use tests::harness::{Folder, bedload, said};

/// Twelve neutral discs, some of which touch, in plane Couette flow.
const SHEARED: &str = r#"
title = "Sheared suspension"
until = 6.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [4.0, 2.0]
cells = [64, 32]
[domain.boundary]
x = "periodic"
z_lower = { type = "no-slip", velocity = [-1.0, 0.0, 0.0] }
z_upper = { type = "no-slip", velocity = [1.0, 0.0, 0.0] }
[medium]
density = 1.0
viscosity = 0.5
initial = { type = "shear", direction = "x", gradient = "z", rate = 1.0, origin = 1.0 }
[[groups]]
count = 16
lower = [0.0, 0.0, 0.05]
upper = [4.0, 0.0, 1.95]
radius = 0.25
density = 1.0
seed = 3
with_fluid = true
[fluid.time]
dt = 0.01
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 0.01
friction = 0.5
[observe]
grains = []
planes = { every = 0.02, from = 1.0, stress = true }
totals = { columns = ["grain-flux", "fluid-flux", "bed-height", "moving-grains", "shields", "coordination-number", "wall-force"], surface = 0.05, speed = 0.5 }
"#;

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn run(arguments: &[&str]) {
    let output = bedload(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

/// Sum over the parts, and momentum of both phases (of density 1) below the middle, on each plane along x.
fn stress_and_momentum(planes: &Planes) -> Vec<[f64; 2]> {
    let mut below = 0.0;
    let plane = |p: &bedload_output::planes::Plane| {
        let (phi, parts) = (p.solid_fraction, p.stresses.expect("stresses").parts);
        let here = p.width * ((1.0 - phi) * p.fluid_velocity[0] + phi * p.grain_velocity[0]);
        below += here;
        [parts.iter().map(|part| part[0]).sum(), below - 0.5 * here]
    };
    planes.planes.iter().map(plane).collect()
}

/// Contacts and films among them, the parts of the stress add up to one on all planes, less the momentum that
/// the planes gain. A resumed run has the same bits. The totals are those of a suspension without a drive.
#[test]
fn parts_of_the_stress_add_up_and_totals_resume() {
    let folder = Folder::new("totals");
    let scene = folder.write("sheared.toml", SHEARED);
    let (whole, parted) = (folder.join("whole"), folder.join("parted"));
    run(&["run", path(&scene), "--out", path(&whole)]);
    run(&["run", path(&scene), "--out", path(&parted), "--until", "2.5", "--no-record"]);
    run(&["run", path(&scene), "--out", path(&parted), "--resume", "--until", "6.0", "--no-record"]);
    let read = |out: &Path, file: &str| std::fs::read_to_string(out.join(file)).expect(file);
    for file in ["series.csv", "planes.csv"] {
        assert!(read(&whole, file) == read(&parted, file), "{file} of a resumed run");
    }

    let planes = |file: &str| Planes::parse(&read(&whole, file)).expect(file);
    let (first, last) = (planes("fields/planes_00000099.csv"), planes("fields/planes_00000599.csv"));
    let (mean, between) = (planes("planes.csv"), last.time - first.time);
    assert!((between - 5.0).abs() < 1e-9, "{between}");
    let ends = stress_and_momentum(&last).into_iter().zip(stress_and_momentum(&first));
    let balanced: Vec<f64> = stress_and_momentum(&mean)
        .into_iter()
        .zip(ends)
        .map(|([sum, _], ([_, now], [_, before]))| sum - (now - before) / between)
        .collect();
    let total = balanced.iter().sum::<f64>() / balanced.len() as f64;
    let off = balanced.iter().map(|sum| (sum / total - 1.0).abs()).fold(0.0, f64::max);
    for p in &mean.planes {
        println!(
            "{} {:.3} {:?}",
            p.at,
            p.solid_fraction,
            p.stresses.expect("stresses").parts.map(|part| part[0])
        );
    }
    let series = Series::read(&whole.join("series.csv")).expect("a series");
    let mean_of = |name: &str| {
        let column = series.column(name).unwrap_or_else(|| panic!("{name} in {:?}", series.names()));
        column.iter().sum::<f64>() / column.len() as f64
    };
    for name in &series.names()[1..] {
        println!("{name} {}", mean_of(name));
    }
    println!("total {total} off {off}");
    assert!(off < 0.02, "{off}: {balanced:?}");
    let carried = |part: usize| {
        let of = mean.planes.iter().map(|p| p.stresses.expect("stresses").parts[part][0].abs());
        of.fold(0.0, f64::max) / total
    };
    assert!(carried(3) + carried(4) > 0.05, "contacts {}, films {}", carried(3), carried(4));
    assert!(mean_of("coordination_number") > 0.0 && mean_of("moving_grains") > 0.0);
    let flux = mean_of("grain_flux_x") + mean_of("fluid_flux_x");
    assert!(flux.abs() < 0.1, "{flux}");
}
