//! A suspension that is sheared between walls, with the real programs: totals of the bed and stresses.

use std::f64::consts::PI;
use std::path::Path;

use bedload_output::planes::Planes;
use bedload_output::{Series, Summary};
use tests::harness::{Folder, bedload, said};

/// Sixteen neutral discs, some of which touch, in plane Couette flow.
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
dt = 0.0078125
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 0.01
friction = 0.5
[observe]
grains = []
planes = { every = 0.015625, from = 1.0, stress = true }
totals = { columns = ["grain-flux", "fluid-flux", "bed-height", "moving-grains", "shields", "coordination-number", "wall-force", "wall-stress"], surface = 0.05, speed = 0.5 }
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
    let (first, last) = (planes("fields/planes_00000127.csv"), planes("fields/planes_00000767.csv"));
    let (mean, between) = (planes("planes.csv"), last.time() - first.time());
    assert!((between - 5.0).abs() < 1e-9, "{between}");
    let ends = stress_and_momentum(&last).into_iter().zip(stress_and_momentum(&first));
    let balanced: Vec<f64> = stress_and_momentum(&mean)
        .into_iter()
        .zip(ends)
        .map(|([sum, _], ([_, now], [_, before]))| sum - (now - before) / between)
        .collect();
    let total = balanced.iter().sum::<f64>() / balanced.len() as f64;
    let off = balanced.iter().map(|sum| (sum / total - 1.0).abs()).fold(0.0, f64::max);
    let series = Series::read(&whole.join("series.csv")).expect("a series");
    let mean_of = |name: &str| {
        let column = series.column(name).unwrap_or_else(|| panic!("{name} in {:?}", series.names()));
        column.iter().sum::<f64>() / column.len() as f64
    };
    assert!(off < 0.005, "{off}: {balanced:?}");
    let carried = |part: usize| {
        let of = mean.planes.iter().map(|p| p.stresses.expect("stresses").parts[part][0].abs());
        of.fold(0.0, f64::max) / total
    };
    assert!(carried(4) > 0.2, "films carry {}", carried(4));
    // Fluid, contacts and films on both walls are in balance, and are the stress of the mixture.
    let walls = [mean_of("wall_stress_z_lower_x"), -mean_of("wall_stress_z_upper_x")];
    assert!((walls[0] / walls[1] - 1.0).abs() < 0.05, "{walls:?}: the discs are set in motion at first");
    assert!((walls[1] / total - 1.0).abs() < 0.01, "{walls:?} for {total}");
    assert!(mean_of("moving_grains") > 0.0);
    let flux = mean_of("grain_flux_x") + mean_of("fluid_flux_x");
    assert!(flux.abs() < 0.1, "{flux}");
}

/// Heavy grains without films: they touch. From top to bottom the normal stress gains their submerged weight,
/// and contacts carry to the floor what they transmit in the lowest plane.
#[test]
fn contacts_carry_the_weight_of_a_bed_to_the_floor() {
    let folder = Folder::new("totals-heavy");
    let (scene, out) = (folder.write("bed.toml", SHEARED), folder.join("out"));
    let mut arguments = vec!["run", path(&scene), "--out", path(&out), "--until", "5.0", "--no-record"];
    let keys = ["groups[0].density=3.0", "gravity=[0.0,0.0,-20.0]", "dem.lubrication.form=\"none\""];
    keys.iter().for_each(|key| arguments.extend(["--set", key]));
    run(&arguments);
    let text = std::fs::read_to_string(out.join("planes.csv")).expect("planes");
    let planes = Planes::parse(&text).expect("planes").planes;
    let normal = |p: &bedload_output::planes::Plane| {
        let stresses = p.stresses.expect("stresses");
        stresses.parts.iter().map(|part| part[2]).sum::<f64>() - stresses.pressure
    };
    let weight = 16.0 * std::f64::consts::PI * 0.25 * 0.25 * 2.0 * 20.0 / 4.0;
    let gained = normal(&planes[31]) - normal(&planes[0]);
    assert!((gained / weight - 1.0).abs() < 0.01, "{gained} for {weight}");

    let series = Series::read(&out.join("series.csv")).expect("a series");
    let mean = |name: &str| {
        let column = &series.column(name).unwrap_or_else(|| panic!("{name}"))[128..];
        column.iter().sum::<f64>() / column.len() as f64
    };
    let (floor, lowest) =
        (mean("wall_contact_force_z_lower_z"), planes[0].stresses.expect("stresses").parts[3][2]);
    assert!((floor / 4.0 / lowest - 1.0).abs() < 0.05, "{floor} on the floor, {lowest} in the lowest plane");
    let walls = mean("wall_force_z_lower_z") + mean("wall_force_z_upper_z") + floor;
    assert!((walls / 4.0 / weight + 1.0).abs() < 0.02, "{walls} on the walls for {weight}");
    assert!(mean("coordination_number") > 0.3 && mean("shields") > 0.0);
}

/// A sphere, or a disc, falls in a closed box and bounces: the forces on its walls give the mixture its
/// weight and change of momentum at every time, what contacts do to the pressure included. In a closed box
/// that is the momentum of the grain above that of the fluid in its place.
#[test]
fn walls_of_a_closed_box_bear_a_bounce() {
    let folder = Folder::new("totals-bounce");
    for (geometry, film) in [("space", "none"), ("space", "complement"), ("plane", "none")] {
        let axes = if geometry == "space" { 3 } else { 2 };
        let list = |across: f64, up: f64| {
            let along = vec![across.to_string(); axes - 1];
            format!("[{}, {up}]", along.join(", "))
        };
        let y = if axes == 3 { "y = \"no-slip\"\n" } else { "" };
        let roughness = if film == "none" { "" } else { "roughness = 1e-3\n" };
        let text = format!(
            "title = \"Drop\"\nuntil = 5.0\ngravity = [0.0, 0.0, -1.0]\n\
             [domain]\ngeometry = \"{geometry}\"\nlower = {}\nupper = {}\ncells = {}\n\
             [domain.boundary]\nx = \"no-slip\"\n{y}z = \"no-slip\"\n\
             [medium]\ndensity = 1.0\nviscosity = 0.01\n\
             [[grains]]\nposition = [1.5, {}, 2.5]\nradius = 0.5\ndensity = 4.0\n\
             [fluid.time]\ncfl = 0.5\n\
             [dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.97\ncontact_time = 5e-3\n\
             [dem.lubrication]\nform = \"{film}\"\n{roughness}\
             [observe]\nevery = 0.0\ntotals = {{ columns = [\"wall-force\", \"wall-stress\"] }}\n\
             [[metrics]]\nname = \"on-grain\"\nkind = \"mean\"\ncolumn = \"contact_force_z[0]\"\n\
             [[metrics]]\nname = \"on-floor\"\nkind = \"mean\"\ncolumn = \"wall_contact_force_z_lower_z\"\n",
            list(0.0, 0.0),
            list(3.0, 3.5),
            list(24.0, 28.0).replace(".0", ""),
            if axes == 3 { 1.5 } else { 0.0 },
        );
        let (scene, out) = (folder.write("drop.toml", &text), folder.join(&format!("{geometry}-{film}")));
        run(&["run", path(&scene), "--out", path(&out), "--no-record"]);
        let series = Series::read(&out.join("series.csv")).expect("a series");
        let column = |name: &str| series.column(name).unwrap_or_else(|| panic!("{name}"));
        let [time, dt, u] = ["t", "dt", "velocity_z[0]"].map(column);
        let walls = ["lower", "upper"].map(|side| column(&format!("wall_stress_z_{side}_z")));
        let sides = |k: usize| -> f64 {
            let names =
                series.names().iter().filter(|name| name.starts_with("wall_force_") && name.ends_with("_z"));
            names.filter(|name| !name.contains("_z_")).map(|name| column(name)[k]).sum()
        };
        let (area, volume) =
            if axes == 3 { (9.0, std::f64::consts::PI / 6.0) } else { (3.0, std::f64::consts::PI / 4.0) };
        let submerged = 3.0 * volume;
        let (mut given, mut worst, mut fastest) = (0.0, 0.0f64, 0.0f64);
        for k in 0..time.len() {
            given += dt[k] * ((walls[0][k] + walls[1][k]) * area + sides(k));
            let off = -submerged * (time[k] + u[k]) - given;
            if time[k] > 1.0 {
                worst = worst.max((off / (submerged * time[k])).abs());
            }
            fastest = fastest.max(u[k]);
        }
        println!("{geometry}, {film}: {worst}");
        // Both are means over windows, in metrics too.
        let metrics = Summary::read(&out.join("summary.json")).expect("a summary").metrics;
        let [on_grain, on_floor] = ["on-grain", "on-floor"].map(|name| metrics[name].value.expect(name));
        assert!((on_floor / on_grain + 1.0).abs() < 1e-9, "{on_grain} on the grain, {on_floor} on the floor");
        assert!(fastest > 0.5, "it bounces: {fastest}");
        assert!(worst < 0.01, "{geometry}, {film}: {worst}");
    }
}

/// A disc of the fictitious-domain method turns within half a cell of a wall: what its points give to the
/// mirror image, the wall bears. In a steady flow disc and walls then have the whole body force.
#[test]
fn walls_bear_what_points_beside_them_give_to_the_image() {
    let folder = Folder::new("totals-points");
    let text = "until = 6.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [4.0, 1.5]\n\
        cells = [64, 24]\nboundary = { x = \"periodic\", z = \"no-slip\" }\n[medium]\ndensity = 1.0\n\
        viscosity = 1.0\nbody_force = [0.4, 0.0, 0.0]\n[[grains]]\nposition = [2.03, 0.0, 0.31]\n\
        radius = 0.3\ndensity = 2.0\nmotion = \"prescribed\"\nspin = [0.0, 1.0, 0.0]\n[fluid]\n\
        method = \"fictitious-domain\"\n[observe]\ntotals = { columns = [\"wall-force\"] }\n";
    let (scene, out) = (folder.write("turns.toml", text), folder.join("out"));
    run(&["run", path(&scene), "--out", path(&out), "--no-record"]);
    let series = Series::read(&out.join("series.csv")).expect("a series");
    let last = |name: &str| *series.column(name).unwrap_or_else(|| panic!("{name}")).last().expect("rows");
    let names = ["hydrodynamic_force_x[0]", "wall_force_z_lower_x", "wall_force_z_upper_x"];
    let sum: f64 = names.map(last).iter().sum();
    assert!((sum - 0.4 * 4.0 * 1.5).abs() < 2e-3, "{sum}");
}

/// Discs of both methods off the middle of a channel: walls, disc and drive balance across, too.
#[test]
fn pressure_on_walls_is_that_of_the_whole_window() {
    let folder = Folder::new("totals-lift");
    for method in ["izard-2014", "calibrated"] {
        let text = format!(
            "until = 3.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [3.0, 2.0]\n\
             cells = [48, 32]\nboundary = {{ x = \"periodic\", z = \"no-slip\" }}\n[medium]\n\
             density = 1.0\nviscosity = 0.2\nbody_force = [2.0, 0.0, 0.0]\n[[grains]]\n\
             position = [1.03, 0.0, 1.2]\nradius = 0.5\ndensity = 2.0\nmotion = \"fixed\"\n[fluid]\n\
             method = \"{method}\"\n[fluid.time]\ndt = 0.005\n[observe]\n\
             totals = {{ columns = [\"wall-force\"] }}\n"
        );
        let (scene, out) = (folder.write(&format!("{method}.toml"), &text), folder.join(method));
        run(&["run", path(&scene), "--out", path(&out), "--no-record"]);
        let series = Series::read(&out.join("series.csv")).expect("a series");
        let last =
            |name: &str| *series.column(name).unwrap_or_else(|| panic!("{name}")).last().expect("rows");
        let lift = last("hydrodynamic_force_z[0]");
        let walls = last("wall_force_z_lower_z") + last("wall_force_z_upper_z");
        assert!(
            lift.abs() > 0.02 && (lift + walls).abs() < 0.02 * lift.abs(),
            "{method}: {lift} and {walls}"
        );
    }
}

/// The force on a sphere that swings in windows far shorter than viscosity needs for a cell follows its
/// acceleration from window to window.
#[test]
fn the_force_on_a_swinging_sphere_has_no_jumps() {
    let folder = Folder::new("totals-swing");
    let text = "until = 0.5\n[domain]\ngeometry = \"axisymmetric\"\nlower = [0.0, 0.0]\nupper = [2.0, 4.0]\n\
        cells = [20, 40]\nboundary = { r_upper = \"free-slip\", z = \"free-slip\" }\n[medium]\ndensity = 1.7\n\
        viscosity = 0.01\n[[grains]]\nposition = [0.0, 0.0, 1.97]\nradius = 0.5\ndensity = 2.0\n\
        motion = \"prescribed\"\nvelocity = { amplitude = [0.0, 0.0, 0.3], frequency = 2.0, phase = 0.6 }\n\
        [fluid.time]\ndt = 0.00125\n[observe]\nevery = 0.0\n";
    let (scene, out) = (folder.write("swings.toml", text), folder.join("out"));
    run(&["run", path(&scene), "--out", path(&out), "--no-record"]);
    let series = Series::read(&out.join("series.csv")).expect("a series");
    let force = &series.column("hydrodynamic_force_z[0]").expect("a force")[100..];
    let amplitude = force.iter().fold(0.0, |largest: f64, force| largest.max(force.abs()));
    let jump = force.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    // ω dt is 0.016.
    assert!(jump < 0.03 * amplitude, "{jump} of {amplitude}");
}

/// Laminar flow that enters and leaves: each wall has 6 μ U L/h, and the stress on every plane is that of the
/// velocities of the planes beside it.
#[test]
fn open_faces_have_their_part_of_walls_and_planes() {
    let folder = Folder::new("totals-open");
    let text = "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [2.0, 1.0]\n\
        cells = [16, 16]\n[domain.boundary]\nx_lower = { type = \"inflow\", velocity = [1.0, 0.0, 0.0], \
        profile = \"parabolic\" }\nx_upper = \"outflow\"\nz = \"no-slip\"\n[medium]\ndensity = 1.0\n\
        viscosity = 1.0\n[observe]\ntotals = { columns = [\"wall-force\"] }\n\
        planes = { every = 1.0, stress = true }\n";
    let (scene, out) = (folder.write("open.toml", text), folder.join("out"));
    run(&["run", path(&scene), "--out", path(&out), "--no-record"]);
    let series = Series::read(&out.join("series.csv")).expect("a series");
    for name in ["wall_force_z_lower_x", "wall_force_z_upper_x"] {
        let force = *series.column(name).expect(name).last().expect("rows");
        // 16 cells: the parabola between the wall and half a cell off it, 1 − 1/32 and a half of that again.
        assert!((force / 12.0 - 1.0).abs() < 0.02, "{name}: {force}");
    }
    let planes = Planes::parse(&std::fs::read_to_string(out.join("planes.csv")).expect("planes"));
    let planes = planes.expect("planes").planes;
    for three in planes.windows(3) {
        let slope = (three[2].fluid_velocity[0] - three[0].fluid_velocity[0]) / (2.0 / 16.0);
        let stress = three[1].stresses.expect("stresses").parts[0][0];
        assert!((stress - slope).abs() < 1e-3 * 6.0, "{stress} for {slope}");
    }
}

/// Over a part of a period of a wall that swings in deep fluid the mean friction on it is that of Stokes
/// (1851), −μ A k L ⟨sin ωt + cos ωt⟩, k² = ω/2ν: a window's is its mean, whatever its length. A run in two
/// parts has the same.
#[test]
fn the_friction_of_a_window_is_its_mean() {
    let folder = Folder::new("totals-friction");
    let text = "until = 2.5\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [0.4, 2.0]\n\
        cells = [8, 40]\n[domain.boundary]\nx = \"periodic\"\nz_lower = { type = \"no-slip\", velocity = { \
        amplitude = [0.1, 0.0, 0.0], frequency = 1.0 } }\nz_upper = \"free-slip\"\n[medium]\ndensity = 1.0\n\
        viscosity = 0.25\n[fluid]\ntime = { dt = 0.03125, viscosity = \"implicit\" }\n[observe]\n\
        totals = { columns = [\"wall-force\"] }\n[[metrics]]\nname = \"mean\"\nkind = \"mean\"\n\
        column = \"wall_force_z_lower_x\"\nfrom = 2.125\n";
    let scene = folder.write("friction.toml", text);
    let [whole, parts] = ["whole", "parts"].map(|name| folder.join(name));
    run(&["run", path(&scene), "--out", path(&whole), "--no-record"]);
    let mean = Summary::read(&whole.join("summary.json")).expect("a summary").metrics["mean"].value;
    let (omega, k) = (2.0 * PI, (PI / 0.25).sqrt());
    let phases = ((PI / 4.0).cos() + 1.0 - (PI / 4.0).sin()) / omega / 0.375;
    let exact = -0.25 * 0.1 * k * 0.4 * phases;
    assert!((mean.expect("a mean") / exact - 1.0).abs() < 0.03, "{mean:?} for {exact}");
    run(&["run", path(&scene), "--out", path(&parts), "--no-record", "--until", "1.25"]);
    run(&["run", path(&scene), "--out", path(&parts), "--no-record", "--resume"]);
    let force = |out: &Path| {
        let series = Series::read(&out.join("series.csv")).expect("a series");
        series.column("wall_force_z_lower_x").expect("a force").to_vec()
    };
    assert_eq!(force(&whole), force(&parts));
}

/// What is asked of grains, or of an exchange, and cannot come is told.
#[test]
fn what_a_solver_alone_does_not_do_is_told() {
    let folder = Folder::new("totals-alone");
    let fluid = "until = 0.1\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [1.0, 1.0]\n\
        cells = [16, 16]\nboundary = { x = \"periodic\", z = \"no-slip\" }\n[medium]\ndensity = 1.0\n\
        viscosity = 1.0\ninitial = { type = \"uniform\", velocity = [1.0, 0.0, 0.5] }\n[coupling]\n\
        scheme = \"iterated\"\n[observe]\ntotals = { columns = \
        [\"fluid-flux\", \"coordination-number\"] }\n";
    let dry = "until = 0.1\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [1.0, 1.0]\n\
        boundary = { x = \"periodic\", z = \"no-slip\" }\n[[grains]]\nposition = [0.5, 0.0, 0.5]\n\
        radius = 0.1\ndensity = 1.0\n[fluid.time]\ncfl = 0.4\n[dem.contact]\nlaw = \
        \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 1e-3\n";
    for (name, text, told) in [
        (
            "fluid",
            fluid,
            &[
                "coordination-number\": nothing comes of it",
                "coupling.scheme: no effect",
                "the flow along z does not",
            ][..],
        ),
        ("dry", dry, &["fluid.time: no effect, as there is no [medium]"]),
    ] {
        let output = bedload(&["check", path(&folder.write(&format!("{name}.toml"), text))]);
        let words = said(&output);
        assert!(told.iter().all(|told| words.contains(told)) && !words.contains("fluid-flux"), "{words}");
    }
}
