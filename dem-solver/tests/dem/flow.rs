//! Ratio of stresses, inertial number and exponent of a flow down an incline that is exact.

use dem_solver::Shape;
use dem_solver::output::coarse_grain::Cell;
use dem_solver::output::flow::{exponent, inertial_number, stress_ratio};
use dem_solver::output::profile::Profile;

/// tan θ = 0.45 and I = 0.2, of grains of density 2 and diameter 1 at a solid fraction of 0.6: with the
/// depth y below h = 16 it is σ = 1.2 g y, γ̇ = I √(σ/2), so that v falls by (2/3) I √(0.6 g) y^(3/2).
fn exact() -> Profile {
    let mut profile = Profile {
        axis: 2,
        first: 0.05,
        width: 0.1,
        area: 100.0,
        perimeter: 40.0,
        shape: Shape::Sphere,
        cells: vec![Cell::default(); 200],
        walls: vec![[0.0; 2]; 200],
    };
    for slab in 0..160 {
        let depth = 16.0 - profile.middle(slab);
        let normal = 1.2 * 9.0 * depth;
        let cell = &mut profile.cells[slab];
        (cell.solid, cell.density) = (0.6, 1.2);
        cell.contact[(2, 2)] = 0.75 * normal;
        cell.kinetic[(2, 2)] = 0.25 * normal;
        cell.contact[(0, 2)] = -0.45 * normal;
        cell.velocity.x = 30.0 - 2.0 / 3.0 * 0.2 * (0.6 * 9.0 * depth.powi(3)).sqrt();
    }
    profile
}

#[test]
fn an_exact_flow_has_its_own_numbers() {
    let (profile, range) = (exact(), [2.0, 14.0]);
    let ratio = stress_ratio(&profile, range).expect("slabs");
    assert!((ratio.value - 0.45).abs() < 1e-12 && ratio.spread < 1e-12 && ratio.slabs == 120, "{ratio:?}");
    let inertia = inertial_number(&profile, range, 1.0).expect("slabs");
    assert!((inertia.value - 0.2).abs() < 1e-5, "{inertia:?}");
    let power = exponent(&profile, range, -9.0).expect("slabs");
    assert!((power.value - 1.5).abs() < 1e-6 && power.spread < 1e-6, "{power:?}");
}

#[test]
fn where_nothing_flows_there_is_no_number() {
    let profile = exact();
    let empty = [17.0, 19.0];
    assert!(stress_ratio(&profile, empty).is_none());
    assert!(inertial_number(&profile, empty, 1.0).is_none());
    assert!(exponent(&profile, empty, -9.0).is_none());
    assert!(exponent(&profile, [2.0, 2.3], -9.0).is_none(), "three slabs are no curve");
    assert!(inertial_number(&profile, [0.0, 0.1], 1.0).is_none(), "nothing below the lowest slab");
}
