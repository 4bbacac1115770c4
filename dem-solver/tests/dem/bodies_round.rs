//! Limits in which bodies that are not round are discs: ellipses of equal semi-axes, polygons of many
//! vertices.
use crate::common::{add_body, dem, floor, law, spec};
use bedload_scene::Outline;
use dem_solver::{Freedom, Grain, Shape};
use std::f64::consts::PI;

/// Quaternion of a turn by `angle` about y.
fn turned(angle: f64) -> [f64; 4] {
    [(0.5 * angle).cos(), 0.0, (0.5 * angle).sin(), 0.0]
}

/// A regular polygon in a circle of `radius`.
fn regular(count: u32, radius: f64) -> Outline {
    let angles = (0..count).map(|k| 2.0 * PI * f64::from(k) / f64::from(count));
    let vertices: Vec<[f64; 2]> = angles.map(|a| [radius * a.cos(), radius * a.sin()]).collect();
    Outline::polygon(&vertices).expect("convex")
}

/// A grain with spin that bounces from the floor with friction: velocity and spin.
fn bounce(outline: Option<Outline>, t_c: f64) -> [f64; 3] {
    let mut law = law(0.8, t_c);
    law.friction = 0.3;
    let mut set_up = spec(Vec::new(), law);
    set_up.shape = Shape::Disc;
    set_up.walls.push(floor());
    let grain = match outline {
        Some(outline) => add_body(&mut set_up, outline, [0.0; 3], 1.0),
        None => {
            set_up.grains.push(Grain { free: Freedom::PLANE, ..Grain::new([0.0; 3], 0.5, 1.0) });
            &mut set_up.grains[0]
        }
    };
    (grain.position, grain.velocity, grain.spin) =
        ([0.0, 0.0, 0.5 + 0.5 * t_c], [0.3, 0.0, -1.0], [0.0, 2.0, 0.0]);
    let mut solver = dem(&set_up);
    solver.advance(3.0 * t_c, 3000, &[]).expect("advances");
    [solver.grains.velocity[0].x, solver.grains.velocity[0].z, solver.grains.spin[0].y]
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_round_ellipse_is_a_disc_and_a_polygon_of_many_vertices_nearly() {
    let disc = bounce(None, 1e-3);
    let ellipse = bounce(Some(Outline::Ellipse { semi_axes: [0.5; 2] }), 1e-3);
    assert!(difference(&disc, &ellipse) < 1e-9, "{disc:?} {ellipse:?}");
    // A vertex below the centre, in a contact so short that it stays there: what is left is the radius of
    // gyration, which differs by 1/n².
    let disc = bounce(None, 1e-6);
    let errors = [16, 32, 64].map(|count| difference(&disc, &bounce(Some(regular(count, 0.5)), 1e-6)));
    println!("16, 32, 64 vertices: {errors:?}");
    assert!(errors[2] < 5e-3, "{errors:?}");
    for k in 0..2 {
        let order = (errors[k] / errors[k + 1]).log2();
        assert!((order - 2.0).abs() < 0.1, "{errors:?}: order {order}");
    }
}

/// Two round grains that meet obliquely with friction, each a disc or an ellipse.
fn meet(round: [bool; 2]) -> Vec<f64> {
    let mut law = law(0.8, 1e-3);
    law.friction = 0.3;
    let mut set_up = spec(Vec::new(), law);
    set_up.shape = Shape::Disc;
    for (k, round) in round.into_iter().enumerate() {
        let (radius, sign) = ([0.5, 0.3][k], [1.0, -1.0][k]);
        if round {
            set_up.grains.push(Grain { free: Freedom::PLANE, ..Grain::new([0.0; 3], radius, 1.0) });
        } else {
            add_body(&mut set_up, Outline::Ellipse { semi_axes: [radius; 2] }, [0.0; 3], 1.0);
        }
        let grain = &mut set_up.grains[k];
        grain.position = [-0.3 * sign, 0.0, -0.2645 * sign];
        (grain.velocity, grain.spin) = ([sign, 0.0, 0.1], [0.0, 2.0 * sign, 0.0]);
        grain.orientation = turned(0.3 * sign);
    }
    let mut solver = dem(&set_up);
    solver.advance(3e-3, 3000, &[]).expect("advances");
    let g = &solver.grains;
    (0..2).flat_map(|i| [g.velocity[i].x, g.velocity[i].z, g.spin[i].y]).collect()
}

#[test]
fn round_ellipses_and_discs_meet_alike() {
    let discs = meet([true, true]);
    for round in [[false, true], [true, false], [false, false]] {
        let found = meet(round);
        assert!(difference(&discs, &found) < 1e-9, "{round:?}: {discs:?} {found:?}");
    }
}
