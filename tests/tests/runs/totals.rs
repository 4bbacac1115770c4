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

/// The five parts add up to one stress on all planes; a resumed run has the same bits.
#[test]
fn parts_of_the_stress_add_up_and_totals_resume() {
    let folder = Folder::new("totals");
    let scene = folder.write("sheared.toml", SHEARED);
    let (whole, parted) = (folder.join("whole"), folder.join("parted"));
    run(&["run", path(&scene), "--out", path(&whole)]);
    run(&["run", path(&scene), "--out", path(&parted), "--until", "2.5", "--no-record"]);
    run(&["run", path(&scene), "--out", path(&parted), "--resume", "--no-record"]);
    for file in ["series.csv", "planes.csv"] {
        let read = |out: &Path| std::fs::read(out.join(file)).expect(file);
        assert!(read(&whole) == read(&parted), "{file} of a resumed run");
    }

    let series = Series::read(&whole.join("series.csv")).expect("a series");
    let mean = |name: &str| {
        let column = series.column(name).unwrap_or_else(|| panic!("{name} in {:?}", series.names()));
        column.iter().skip(column.len() / 6).sum::<f64>() / (column.len() - column.len() / 6) as f64
    };
    let planes = Planes::parse(&std::fs::read_to_string(whole.join("planes.csv")).expect("planes"));
    let planes = planes.expect("planes").planes;
    let parts: Vec<[f64; 5]> =
        planes.iter().map(|p| p.stresses.expect("stresses").parts.map(|part| part[0])).collect();
    let sums: Vec<f64> = parts.iter().map(|parts| parts.iter().sum()).collect();
    let total = sums.iter().sum::<f64>() / sums.len() as f64;
    let off = sums.iter().map(|sum| (sum / total - 1.0).abs()).fold(0.0, f64::max);
    for (p, q) in planes.iter().zip(&parts) {
        println!("{} {:.3} {:?} {}", p.at, p.solid_fraction, q, q.iter().sum::<f64>());
    }
    for name in &series.names()[1..] {
        println!("{name} {}", mean(name));
    }
    println!("total {total} off {off}");
    assert!(off < 0.02, "{off}: {sums:?}");
}
