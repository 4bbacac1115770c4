//! Averages over planes against what is known of them.

use crate::immersed::newton::scene;
use fluid_solver::participant::Fluid;
use fluid_solver::planes::averages;
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
        assert!((solid / volume - 1.0).abs() < 0.02, "axis {axis}: volume {solid} for {volume}");
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
