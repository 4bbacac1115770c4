//! Light and neutral grains, and a grain at rest: where the printed loads fail.

use tests::harness::{Folder, bedload, metric, said};

/// A sphere released from rest in a quiet fluid; D = g = ρ = 1.
fn release(density: f64, extra: &str) -> String {
    format!(
        r#"
until = 2.0
gravity = [0.0, 0.0, -1.0]

[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [4.0, 10.0]
cells = [20, 80]
stretching = {{ axis = "r", uniform_to = 1.5, spacing = 0.125 }}

[domain.boundary]
r_upper = "free-slip"
z = "free-slip"

[medium]
density = 1.0
viscosity = 0.05

[[grains]]
position = [0.0, 0.0, 5.0]
radius = 0.5
density = {density:?}

[fluid.time]
dt = 0.02

{extra}

[[metrics]]
name = "initial_acceleration_over_g"
kind = "initial-acceleration"

[[metrics]]
name = "fastest"
kind = "max"
column = "kinetic_energy"
"#
    )
}

#[test]
fn neutral_and_light_spheres_start_as_their_virtual_mass_says_and_stay_bounded() {
    let folder = Folder::new("light");
    for density in [1.0, 0.5, 0.1] {
        let scene = folder.write("light.toml", &release(density, ""));
        let out = folder.join(&format!("density-{density}"));
        let arguments =
            ["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8"), "--no-record"];
        let output = bedload(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        // (ρ_r − 1)/(ρ_r + ½) g downwards; the sign is that of the settling direction.
        let expected = (density - 1.0) / (density + 0.5);
        let start = metric(&out, "initial_acceleration_over_g");
        assert!(
            (start.abs() - f64::abs(expected)).abs() < 1e-6,
            "ρ_r = {density}: {start}, expected {expected}"
        );
        // Rising at most with the buoyancy and no drag over 2 s: (1 − ρ_r)/(ρ_r + ½) t.
        let bound = 0.5 * density * std::f64::consts::PI / 6.0 * (2.0 * expected).powi(2);
        let energy = metric(&out, "fastest");
        assert!(energy <= bound + 1e-12, "ρ_r = {density}: energy {energy} above the inviscid bound {bound}");
    }
}

#[test]
fn the_printed_force_of_2014_is_refused_for_light_grains_by_name_and_can_be_forced() {
    let folder = Folder::new("light-f1");
    let izard = "[fluid]\nmethod = \"izard-2014\"";
    for density in [1.0, 0.5, 0.1] {
        let scene = folder.write("f1.toml", &release(density, izard));
        let output = bedload(&["check", scene.to_str().expect("UTF-8")]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        let words = said(&output);
        let name = if density == 1.0 { "fluid.method" } else { "density-ratio" };
        assert!(words.contains(name), "ρ_r = {density}: no {name:?} in {words}");
    }
    let scene = folder.write("f1.toml", &release(0.5, izard));
    let forced = ["check", scene.to_str().expect("UTF-8"), "--set", "coupling.force=[\"density-ratio\"]"];
    let output = bedload(&forced);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

#[test]
fn a_sphere_at_rest_on_the_wall_presses_with_its_submerged_weight() {
    let folder = Folder::new("resting");
    let contact = "[dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.97\ncontact_time = 1e-2\n\
        friction = 0.25\n\n[[metrics]]\nname = \"resting_force_ratio\"\nkind = \"resting-force-ratio\"";
    let text = release(8.0, contact)
        .replace("position = [0.0, 0.0, 5.0]", "position = [0.0, 0.0, 0.5]")
        .replace("z = \"free-slip\"", "z_lower = \"no-slip\"\nz_upper = \"free-slip\"");
    let (scene, out) = (folder.write("rest.toml", &text), folder.join("out"));
    let arguments =
        ["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8"), "--no-record"];
    let output = bedload(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let ratio = metric(&out, "resting_force_ratio");
    assert!((ratio - 1.0).abs() < 1e-3, "contact force over submerged weight is {ratio}");
}
