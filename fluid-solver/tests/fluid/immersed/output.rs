//! Field files: what VTK's reader relies on.

use crate::immersed::newton::{Run, scene};
use fluid_solver::participant::Fluid;
use protocol::participant::{Participant, Window};

/// Reads array `name` of an appended raw file the way VTK does: offset, length word, values.
fn array(bytes: &[u8], name: &str) -> Vec<f64> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let data = bytes.windows(mark.len()).position(|w| w == mark).expect("appended data") + mark.len();
    let head = std::str::from_utf8(&bytes[..data]).expect("the head is text");
    let tag = head.split(&format!("Name=\"{name}\"")).nth(1).expect(name);
    let offset = tag.split("offset=\"").nth(1).and_then(|t| t.split('"').next()).expect("offset");
    let at = data + offset.parse::<usize>().expect("a number");
    let word = |at: usize| <[u8; 8]>::try_from(&bytes[at..at + 8]).expect("eight bytes");
    let count = u64::from_le_bytes(word(at)) as usize / 8;
    (0..count).map(|k| f64::from_le_bytes(word(at + 8 + 8 * k))).collect()
}

#[test]
fn fields_hold_a_shear_flow_and_a_grain() {
    let text = "until = 1.0
        [domain]
        geometry = \"space\"
        lower = [0.0, 0.0, 0.0]
        upper = [2.0, 1.0, 2.0]
        cells = [20, 10, 20]
        boundary = { x = \"periodic\", y = \"periodic\", z_lower = \"no-slip\", z_upper = { type \
        = \"no-slip\", velocity = [3.0, 0.0, 0.0] } }
        [medium]
        density = 1.0
        viscosity = 0.1
        initial = { type = \"shear\", direction = \"x\", gradient = \"z\", rate = 1.5, origin = 0.0 }
        [[grains]]
        position = [0.05, 0.5, 1.0]
        radius = 0.3
        density = 2.0
        motion = \"fixed\"
        ";
    let folder = std::env::temp_dir().join(format!("bedload-fields-{}", std::process::id()));
    let mut fluid = Fluid::new(&scene(text), &folder).expect("a scene");
    let window = Window { step: 3, attempt: 0, time: 0.0, dt: 0.5, substeps: 1, output: true };
    fluid.write_fields(&window).expect("writes");
    let bytes = std::fs::read(folder.join("fields/fluid_00000003.vtr")).expect("there");
    std::fs::remove_dir_all(&folder).expect("removes");
    let (velocity, vorticity, solid) =
        (array(&bytes, "velocity"), array(&bytes, "vorticity"), array(&bytes, "solid"));
    assert_eq!((velocity.len(), solid.len(), array(&bytes, "pressure").len()), (12_000, 4000, 4000));
    assert_eq!(array(&bytes, "z").len(), 21);
    // Far from the grain, half a box away: u = 1.5 z, curl (0, 1.5, 0); at its centre at rest.
    let cell = |i: usize, j: usize, k: usize| i + 20 * (j + 10 * k);
    let far = cell(10, 5, 17);
    assert!((velocity[3 * far] - 1.5 * 1.75).abs() < 0.2, "{}", velocity[3 * far]);
    assert!((vorticity[3 * far + 1] - 1.5).abs() < 0.2, "{}", vorticity[3 * far + 1]);
    assert!(solid[cell(0, 5, 10)] > 0.99 && solid[far] == 0.0);
    let sum: f64 = solid.iter().sum::<f64>() * 1e-3;
    assert!((sum / (4.0 / 3.0 * std::f64::consts::PI * 0.027) - 1.0).abs() < 0.5, "{sum}");
}

#[test]
fn a_velocity_that_is_not_finite_is_named_by_its_cell() {
    let mut run = Run::new(
        "until = 1.0
        [domain]
        geometry = \"plane\"
        lower = [0.0, 0.0]
        upper = [1.0, 1.0]
        cells = [8, 8]
        boundary = { x = \"periodic\", z = \"no-slip\" }
        [medium]
        density = 1.0
        viscosity = 1.0
        body_force = [1e308, 0.0, 0.0]
        [fluid]
        time = { dt = 1e3, scheme = \"ab2\" }
        ",
    );
    let error = run.window().and_then(|_| run.window()).expect_err("overflows").to_string();
    assert!(error.contains("not finite") && error.contains("cell ["), "{error}");
}
