//! What is kept of grains that have not moved is what would be found anew, bit for bit.

use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::field::set_component;
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::immersed::body::{Motion, Shape};
use fluid_solver::immersed::mask_model::{Mask, MaskModel};
use fluid_solver::immersed::{Immersed, Wrench};

const RADIUS: f64 = 0.2;

fn grid() -> Grid<3> {
    let axis = AxisSpec::Uniform { start: 0.0, end: 1.0, cells: 24 };
    let boundaries = [[Boundary::Periodic; 2], [Boundary::Periodic; 2], [Boundary::WALL; 2]];
    let spec = GridSpec { geometry: Geometry::Space, axes: [axis.clone(), axis.clone(), axis], boundaries };
    Grid::new(&spec).expect("the grid is valid")
}

fn motion(centre: [f64; 3]) -> Motion {
    Motion { centre, velocity: [0.3, -0.2, 0.1], spin: [1.0, 2.0, 3.0], angle: 0.0 }
}

/// Forces on grains at each of `places` in turn.
fn forces(caches: bool, places: &[[[f64; 3]; 4]]) -> Vec<Vec<Wrench>> {
    let grid = grid();
    let model = MaskModel { mask: Mask::ParameterFree, width: 1.0, wave: 1.0, viscosity: 0.01, dt: 0.01 };
    let volume = 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let shape = Shape {
        radius: RADIUS,
        mask_radius: RADIUS,
        wave: 1.0,
        patches: Vec::new(),
        outline: None,
        density: 2.0,
        volume,
        gyration: 0.4 * RADIUS * RADIUS,
    };
    let mut velocity = grid.new_vector();
    for (d, u) in velocity.iter_mut().enumerate() {
        set_component(&grid, d, u, |x| (5.0 * x[0] + d as f64).sin() * (3.0 * x[1]).cos() + x[2]);
    }
    let mut immersed = Immersed::new(&grid, vec![shape; 4], caches);
    let at = |centres: &[[f64; 3]; 4]| centres.map(motion);
    places
        .iter()
        .map(|places| immersed.forces((&grid, &model, &at(places)), &velocity, None).to_vec())
        .collect()
}

/// Grains that touch, overlap, cross faces; some move, a little or far, one leaves a layer, all move, none.
#[test]
fn forces_are_those_of_masks_found_anew() {
    let first = [[0.3, 0.3, 0.3], [0.7, 0.3, 0.3], [0.95, 0.02, 0.5], [0.5, 0.6, 0.75]];
    let mut second = first;
    second[1] = [0.69, 0.31, 0.33];
    let mut third = second;
    (third[0], third[3]) = ([0.3, 0.3, 0.55], [0.1, 0.6, 0.75]);
    let fourth = third.map(|centre| centre.map(|x| x + 1e-9));
    let places = [first, second, second, third, first, fourth];
    assert_eq!(forces(true, &places), forces(false, &places));
    assert_ne!(forces(true, &[first]), forces(true, &[second]));
}
