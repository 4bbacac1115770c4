//! Dense cubic arrays of spheres, at rest and moving over the grid, against Zick & Homsy (1982).

use crate::newton::Run;
use fluid_solver::measure::momentum;
use std::f64::consts::PI;

/// A cubic array.
struct Array {
    fraction: f64,
    /// Cells per period.
    cells: usize,
    /// ν dt/Δx².
    number: f64,
    /// Motion over the grid, cells per step.
    speed: [f64; 3],
    /// Place of the centre in its cell.
    place: [f64; 3],
    /// Keys of `fluid.immersed`.
    immersed: &'static str,
    time: &'static str,
}

impl Array {
    /// Superficial velocity over Zick & Homsy's, less one.
    fn error(&self) -> f64 {
        let exact = [(0.064, 2.810), (0.125, 4.292), (0.216, 7.442), (0.343, 15.4), (0.45, 28.1), (0.5236, 42.1)];
        let k = exact.iter().find(|(c, _)| (c - self.fraction).abs() < 1e-6).expect("a value of the table").1;
        let (n, nu) = (self.cells, 1.0);
        let radius = (3.0 * self.fraction / (4.0 * PI)).cbrt().min(0.499_999);
        let dx = 1.0 / n as f64;
        let dt = self.number * dx * dx / nu;
        let velocity = self.speed.map(|v| v * dx / dt);
        let place = self.place.map(|p| 0.5 + p * dx);
        let moving = velocity != [0.0; 3];
        let motion = if moving { "prescribed" } else { "fixed" };
        let mut run = Run::new(&format!(
            "until = 1.5
            [domain]
            geometry = \"space\"
            lower = [0.0, 0.0, 0.0]
            upper = [1.0, 1.0, 1.0]
            cells = [{n}, {n}, {n}]
            boundary = {{ x = \"periodic\", y = \"periodic\", z = \"periodic\" }}
            [medium]
            density = 1.0
            viscosity = {nu}
            initial = {{ type = \"uniform\", velocity = {velocity:?} }}
            body_force = [0.0, 0.0, 2.0]
            [[grains]]
            position = {place:?}
            velocity = {velocity:?}
            radius = {radius}
            density = 8.0
            motion = \"{motion}\"
            [fluid]
            time = {{ dt = {dt}, {time} }}
            immersed = {{ {keys} }}
            ",
            time = self.time,
            keys = self.immersed,
        ));
        // The slowest mode of the pore dies in some R²/ν (1 − c)/K.
        let end = 0.4f64.min(30.0 * radius * radius / k).max(60.0 * dt);
        run.until(end);
        let (mut sum, mut count) = (0.0, 0.0);
        let steps = if moving { ((1.0 / dx / self.speed.iter().fold(0.0f64, |m, v| m.max(v.abs()))) / n as f64 * 10.0) as usize } else { 1 };
        for _ in 0..steps.max(1) {
            run.windows(1);
            let solver = run.fluid.three().expect("space");
            sum += momentum(solver.grid(), 2, &solver.stepper().state().velocity[2]) - velocity[2];
            count += 1.0;
        }
        let slip = sum / count;
        slip * 6.0 * PI * radius * nu * k / 2.0 - 1.0
    }
}

/// Eight places of a centre in its cell.
const PLACES: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.5, 0.5, 0.5],
    [0.25, 0.25, 0.25],
    [0.25, 0.0, 0.0],
    [0.25, 0.5, 0.1],
    [0.1, 0.3, 0.45],
];

#[test]
#[ignore = "a table"]
fn table() {
    let keys = std::env::var("KEYS").unwrap_or_default();
    let keys: &'static str = Box::leak(keys.into_boxed_str());
    for (fraction, cells) in [(0.064, 17), (0.125, 14), (0.216, 11), (0.343, 10), (0.45, 9), (0.5236, 8), (0.5236, 9)] {
        let radius = (3.0 * fraction / (4.0 * PI)).cbrt();
        let error = |number: f64, speed: [f64; 3], place: [f64; 3]| {
            let array = Array { fraction, cells, number, speed, place, immersed: keys, time: "" };
            100.0 * array.error()
        };
        let rest = PLACES.map(|place| error(1.7, [0.0; 3], place));
        if std::env::var("PLACES").is_ok() { println!("{rest:.2?}"); continue; }
        let fold = |f: fn(f64, f64) -> f64, v: &[f64]| v.iter().copied().reduce(f).unwrap();
        print!("{fraction} D/dx {:.1}: rest {:.2} .. {:.2}; moving", 2.0 * radius * cells as f64, fold(f64::min, &rest), fold(f64::max, &rest));
        for (number, speed) in [
            (1.7, [0.5, 0.14, 0.22]),
            (1.7, [0.5, 0.0, 0.0]),
            (1.7, [0.0, 0.0, 0.5]),
            (0.85, [0.5, 0.14, 0.22]),
            (0.85, [0.25, 0.07, 0.11]),
            (0.4, [0.12, 0.03, 0.05]),
        ] {
            print!(" {:.2}", error(number, speed, [0.0; 3]));
        }
        println!();
    }
}
