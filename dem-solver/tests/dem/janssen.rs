//! Janssen's k, fitted and from stresses.

use bedload_scene::{Axis, Profile as Asked};
use dem_solver::contacts::Contact;
use dem_solver::output::coarse_grain::Cell;
use dem_solver::output::janssen::{Silo, direct};
use dem_solver::output::profile::Profile;
use dem_solver::{ContactLaw, Dem, DemSpec, Grain, LinearSpringDashpot, Motion, Shape, Vec3, Wall};

/// A profile that is Janssen's curve with k = 0.3, as far as the fit can see.
fn exact(k: f64) -> (Profile, Silo) {
    let silo = Silo { density: 800.0, gravity: 10.0, section: 0.025, top: 1.0 };
    let mut profile = Profile {
        axis: 2,
        first: 0.01,
        width: 0.02,
        area: 0.01,
        perimeter: 0.4,
        shape: Shape::Sphere,
        cells: vec![Cell::default(); 60],
        walls: vec![[0.0; 2]; 60],
    };
    for slab in 0..60 {
        let z = profile.middle(slab);
        let p = silo.pressure(z, k);
        let cell = &mut profile.cells[slab];
        cell.density = if z < 1.0 { 800.0 } else { 0.0 };
        cell.contact = nalgebra::Matrix3::identity() * p;
        profile.walls[slab][1] = k * p * 0.4 * 0.02;
    }
    (profile, silo)
}

#[test]
fn the_fit_finds_the_curve_it_was_given_and_the_balance_agrees() {
    let (profile, silo) = exact(0.3);
    let found = Silo::new(&profile, [0.1, 0.9], -10.0).expect("filled");
    assert!((found.top - 1.0).abs() < 1e-12 && (found.density - 800.0).abs() < 1e-9, "{found:?}");
    assert!((found.section - silo.section).abs() < 1e-15);
    let fit = found.fit(&profile, [0.1, 2.0]).expect("fits");
    assert!((fit.value - 0.3).abs() < 1e-6 && fit.spread < 1e-6, "{fit:?}");
    let direct = direct(&profile, [0.1, 0.9]).expect("slabs");
    assert!((direct.value - 0.3).abs() < 1e-12 && direct.spread < 1e-12 && direct.slabs == 40);
    // far down ρ g S/(k P), near the top hydrostatic
    assert!((found.pressure(-10.0, 0.3) / (800.0 * 10.0 * 0.025 / 0.3) - 1.0).abs() < 1e-12);
    assert!((found.pressure(0.9999, 0.3) / found.hydrostatic(0.9999) - 1.0).abs() < 1e-3);
    assert!(Silo::new(&profile, [1.1, 1.2], 10.0).is_none(), "empty");
}

/// Over a part of the section only the sides along which a wall stands count: planes, or held grains behind.
#[test]
fn sides_without_a_wall_bear_nothing() {
    let law = ContactLaw::LinearSpringDashpot(LinearSpringDashpot::new(0.9, 1e-3, 0.3));
    let free = Grain::new([0.1, 0.0, 0.5], 0.1, 1000.0);
    let held = |k: i32| Grain {
        motion: Motion::Fixed,
        ..Grain::new([-0.05, 0.0, 0.05 + 0.1 * f64::from(k)], 0.05, 1000.0)
    };
    let (point, force) = (Vec3::new(0.0, 0.0, 0.5), Vec3::new(2.0, 0.0, 0.6));
    let end = Vec3::new(0.1, 0.0, 0.5);
    let contact = Contact { grain: 0, force, end, start: point, point, held: true, wall: Some(0) };
    let stress = |planes: &[Wall], held: &[Grain], x: [f64; 2]| {
        let grains = std::iter::once(&free).chain(held).cloned().collect();
        let spec = DemSpec { shape: Shape::Disc, walls: planes.to_vec(), ..DemSpec::new(grains, law) };
        let grains = Dem::new(&spec).expect("a DEM").grains;
        let asked = Asked { axis: Axis::Z, lower: [x[0], 0.0, 0.0], upper: [x[1], 1.0, 1.0], slabs: 4 };
        let profile = Profile::new(&asked, &spec, &grains, &[contact]);
        (profile.perimeter, profile.wall_stress(2), direct(&profile, [0.0, 1.0]).is_some())
    };
    let planes = [Wall::new([0.0; 3], [1.0, 0.0, 0.0]), Wall::new([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0])];
    assert_eq!(stress(&planes, &[], [0.0, 1.0]), (2.0, [4.0, 1.2], true));
    assert_eq!(stress(&planes, &[], [0.0, 0.5]), (1.0, [8.0, 2.4], true));
    assert_eq!(stress(&planes, &[], [0.3, 0.7]), (0.0, [0.0; 2], false));
    let column: Vec<Grain> = (0..10).map(held).collect();
    assert_eq!(stress(&[], &column, [0.0, 1.0]), (1.0, [8.0, 2.4], true));
    assert_eq!(stress(&[], &column[..2], [0.0, 1.0]), (0.0, [0.0; 2], false));
}
