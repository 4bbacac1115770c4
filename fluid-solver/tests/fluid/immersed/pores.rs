//! The radius of masks depends on the distances of grains alone.

use crate::immersed::newton::Run;

/// Centres in a box of 4 diameters whose z axis has walls.
const CENTRES: [[f64; 3]; 6] = [
    [0.61, 0.72, 0.55],
    [1.75, 0.81, 0.62],
    [3.45, 3.31, 0.58],
    [2.21, 2.35, 1.81],
    [1.02, 2.94, 2.77],
    [3.37, 1.19, 3.38],
];

/// What of the scene is varied.
struct Case {
    /// Length of a diameter, m.
    unit: f64,
    /// Cells along x by which all is moved.
    cells: f64,
    /// Part by which the box is longer along z.
    longer: f64,
    diameters: f64,
}

const BASE: Case = Case { unit: 1.0, cells: 0.0, longer: 0.0, diameters: 4.0 };

impl Case {
    /// (mask radius − R)/D of every grain.
    fn radii(&self) -> Vec<f64> {
        let Self { unit, cells, longer, diameters } = self;
        let length = diameters * unit;
        let mut text = format!(
            "until = 1.0
            [domain]
            geometry = \"space\"
            lower = [0.0, 0.0, 0.0]
            upper = [{length:?}, {length:?}, {:?}]
            cells = [32, 32, 32]
            boundary = {{ x = \"periodic\", y = \"periodic\", z = \"no-slip\" }}
            [medium]
            density = 1.0
            viscosity = {:?}
            [fluid]
            time = {{ dt = 0.001 }}
            ",
            length * (1.0 + longer),
            unit * unit,
        );
        for [x, y, z] in CENTRES {
            let place = [(x + cells * diameters / 32.0).rem_euclid(*diameters), y, z].map(|x| x * unit);
            text += &format!("[[grains]]\nposition = {place:?}\nradius = {:?}\ndensity = 2.0\n", 0.5 * unit);
        }
        let mut run =
            Run::calibrated(&text, fluid_solver::methods::calibrated::calibration::Calibration::default());
        run.windows(1);
        let shapes = run.fluid.three().expect("space").immersed().shapes();
        shapes.iter().map(|shape| (shape.mask_radius - shape.radius) / unit).collect()
    }
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn neither_the_unit_nor_the_place_of_the_box_changes_the_radius_of_a_mask() {
    let base = BASE.radii();
    assert!(base.iter().all(|excess| *excess > 1e-4), "{base:?}");
    for unit in [1e-3, 1e-6, 3e5] {
        let other = Case { unit, ..BASE }.radii();
        assert!(largest_difference(&base, &other) < 1e-12, "{unit}: {base:?} {other:?}");
    }
    for cells in [1.0, 5.0, 16.0, 31.0] {
        let moved = Case { cells, ..BASE }.radii();
        assert!(largest_difference(&base, &moved) < 1e-12, "{cells}: {base:?} {moved:?}");
    }
}

#[test]
fn a_box_that_grows_makes_no_jump() {
    // About 4.5 diameters there were once three coarse cells along an axis in place of two.
    let [below, above] = [4.5 * (1.0 - 1e-7), 4.5 * (1.0 + 1e-7)];
    let radii = [below, above].map(|diameters| Case { diameters, ..BASE }.radii());
    assert!(largest_difference(&radii[0], &radii[1]) < 1e-8, "{radii:?}");
    let longer =
        [4.5 / 4.0 - 1.0 - 1e-7, 4.5 / 4.0 - 1.0 + 1e-7].map(|longer| Case { longer, ..BASE }.radii());
    assert!(largest_difference(&longer[0], &longer[1]) < 1e-8, "{longer:?}");
}
