//! Bodies of the plane that are not round: impacts, energy, rest, toppling, limits of discs, turned set-ups,
//! restore.
use crate::common::{add_body, contacts_after, dem, exact, floor, law, repeats, spec};
use bedload_scene::Outline;
use dem_solver::{
    ContactLaw, Dem, DemSpec, Freedom, Grain, Integrator, LinearSpringDashpot, Shape, Vec3, Wall,
};
use std::f64::consts::PI;

/// Quaternion of a turn by `angle` about y.
fn turned(angle: f64) -> [f64; 4] {
    [(0.5 * angle).cos(), 0.0, (0.5 * angle).sin(), 0.0]
}

/// No bodies yet.
fn empty(law: LinearSpringDashpot) -> DemSpec {
    spec(Vec::new(), law)
}

fn polygon(vertices: &[[f64; 2]]) -> Outline {
    Outline::polygon(vertices).expect("convex")
}

/// A regular polygon in a circle of `radius`.
fn regular(count: u32, radius: f64) -> Outline {
    let angles = (0..count).map(|k| 2.0 * PI * f64::from(k) / f64::from(count));
    polygon(&angles.map(|a| [radius * a.cos(), radius * a.sin()]).collect::<Vec<_>>())
}

/// Kinetic energy, momentum (x, z) and angular momentum about the origin.
fn motion(dem: &Dem) -> [f64; 4] {
    let g = &dem.grains;
    let mut sum = [0.0; 4];
    for i in 0..g.len() {
        let (m, v, x, w) = (g.mass[i], g.velocity[i], g.position[i], g.spin[i].y);
        sum[0] += 0.5 * m * v.norm_squared() + 0.5 * g.inertia[i] * w * w;
        sum[1] += m * v.x;
        sum[2] += m * v.z;
        sum[3] += m * (x.z * v.x - x.x * v.z) + g.inertia[i] * w;
    }
    sum
}

/// Velocity and spin after a rectangle, turned by 30° and spinning, fell on its corner; `t_c` is the contact
/// time.
fn corner_drop(e: f64, t_c: f64, integrator: Integrator) -> [f64; 3] {
    let mut set_up = empty(exact(law(e, t_c)));
    set_up.walls.push(floor());
    set_up.integrator = integrator;
    let body = add_body(&mut set_up, Outline::rectangle([2.0, 1.0]), [0.0; 3], 1.0);
    body.orientation = turned(PI / 6.0);
    body.velocity = [0.2, 0.0, -1.0];
    body.spin = [0.0, 0.3, 0.0];
    // The lowest corner stands on the floor.
    body.position[2] = 1.0 * 0.5 + 0.5 * 0.75f64.sqrt();
    let mut solver = dem(&set_up);
    solver.advance(1.2 * t_c, 6000, &[]).expect("advances");
    [solver.grains.velocity[0].x, solver.grains.velocity[0].z, solver.grains.spin[0].y]
}

#[test]
fn a_frictionless_fall_on_a_corner_is_the_impact_of_a_rigid_body() {
    let e = 0.6;
    // Corner from the centre: (x, z) of the body (1, −½) turned: x' = x c + z s, z' = −x s + z c.
    let (s, c) = (PI / 6.0).sin_cos();
    let r = [1.0 * c - 0.5 * s, -s - 0.5 * c];
    let (m, inertia) = (2.0, 2.0 * 5.0 / 12.0);
    // Normal z: velocity of the corner along it, and the arm (r × n)_y = −r_x.
    let v_n = -1.0 - 0.3 * r[0];
    let impulse = -(1.0 + e) * v_n / (1.0 / m + r[0] * r[0] / inertia);
    let expected = [0.2, -1.0 + impulse / m, 0.3 - r[0] * impulse / inertia];
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let errors: Vec<f64> = [1e-2, 1e-3, 1e-4]
            .iter()
            .map(|&t_c| {
                let found = corner_drop(e, t_c, integrator);
                (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max)
            })
            .collect();
        println!("{integrator:?}: errors {errors:?}");
        assert!(errors[0] < 3e-2 && errors[1] < 3e-3 && errors[2] < 1e-3, "{errors:?}");
        assert!(errors[1] < 0.3 * errors[0] && errors[2] < errors[1], "{errors:?}");
    }
}

/// Two bodies that meet off centre without friction and loss: relative change of the energy, changes of the
/// momenta.
fn collide(outlines: [Outline; 2], (steps, phase): (u32, f64), integrator: Integrator) -> [f64; 4] {
    let mut set_up = empty(law(1.0, 1e-2));
    set_up.integrator = integrator;
    let [one, other] = outlines;
    // The touch comes anywhere in a sub-step.
    let body = add_body(&mut set_up, one, [-1.6 + 1.8e-2 * phase / f64::from(steps), 0.0, 0.1], 1.0);
    (body.velocity, body.spin, body.orientation) = ([1.0, 0.0, 0.0], [0.0, 0.4, 0.0], turned(0.35));
    let body = add_body(&mut set_up, other, [1.4, 0.0, -0.2], 2.0);
    (body.velocity, body.spin, body.orientation) = ([-0.8, 0.0, 0.1], [0.0, -0.5, 0.0], turned(-0.5));
    let mut solver = dem(&set_up);
    let before = motion(&solver);
    let (mut touched, mut window) = (false, 0);
    while window < 250 {
        touched |= contacts_after(&mut solver, 1e-2, steps) > 0;
        window += 1;
    }
    assert!(touched && solver.save().body_contacts.is_empty(), "they met and parted");
    let after = motion(&solver);
    let size = before[0];
    std::array::from_fn(|k| ((after[k] - before[k]) / if k == 0 { size } else { 1.0 }).abs())
}

#[test]
fn an_elastic_collision_keeps_energy_and_momenta() {
    let pairs: [[Outline; 2]; 5] = [
        [Outline::rectangle([2.0, 1.0]), Outline::rectangle([1.0, 1.6])],
        [Outline::Ellipse { semi_axes: [1.0, 0.5] }, Outline::Ellipse { semi_axes: [0.4, 0.9] }],
        [Outline::rectangle([2.0, 1.0]), Outline::Ellipse { semi_axes: [0.4, 0.9] }],
        [Outline::Ellipse { semi_axes: [1.0, 0.3] }, regular(5, 0.8)],
        [regular(3, 1.0), regular(7, 0.7)],
    ];
    for pair in pairs {
        for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
            let worst = |steps: u32| {
                (0..8).fold([0.0; 4], |worst: [f64; 4], phase| {
                    let found = collide(pair.clone(), (steps, f64::from(phase) / 8.0), integrator);
                    std::array::from_fn(|k| worst[k].max(found[k]))
                })
            };
            let [coarse, middle, fine] = [25, 50, 100].map(worst);
            println!(
                "{integrator:?}: {:.2e} {:.2e} {:.2e}, momenta {:.1e}",
                coarse[0], middle[0], fine[0], fine[3]
            );
            assert!(
                middle[0] < 1e-3 && fine[0] < 0.4 * coarse[0],
                "{pair:?}: {} {} {}",
                coarse[0],
                middle[0],
                fine[0]
            );
            assert!(fine[1..].iter().all(|change| *change < 2e-12), "{fine:?}");
        }
    }
}

/// Two rectangles that meet off centre with friction and loss, at any place and in any period along x.
fn rub(shift: f64, period: Option<(f64, f64)>) -> Dem {
    let mut law = law(0.7, 1e-2);
    law.friction = 0.5;
    let mut set_up = empty(law);
    set_up.periods[0] = period;
    let body = add_body(&mut set_up, Outline::rectangle([2.0, 1.0]), [-1.6 + shift, 0.0, 0.1], 1.0);
    (body.velocity, body.spin, body.orientation) = ([1.0, 0.0, 0.3], [0.0, 0.4, 0.0], turned(0.35));
    let body =
        add_body(&mut set_up, Outline::Ellipse { semi_axes: [0.6, 0.9] }, [1.4 + shift, 0.0, -0.2], 2.0);
    (body.velocity, body.spin, body.orientation) = ([-0.8, 0.0, 0.1], [0.0, -0.5, 0.0], turned(-0.5));
    dem(&set_up)
}

#[test]
fn friction_keeps_the_momenta_and_images_meet_like_neighbours() {
    let mut open = rub(0.0, None);
    let mut periodic = rub(4.0, Some((-4.0, 8.0)));
    let before = motion(&open);
    for _ in 0..200 {
        assert_eq!(contacts_after(&mut periodic, 1e-2, 50), contacts_after(&mut open, 1e-2, 50));
    }
    let after = motion(&open);
    assert!(after[0] < 0.95 * before[0], "they met: {before:?} {after:?}");
    (1..4).for_each(|k| assert!((after[k] - before[k]).abs() < 2e-12, "{before:?} {after:?}"));
    for i in 0..2 {
        let apart = (open.grains.velocity[i] - periodic.grains.velocity[i]).norm();
        assert!(apart < 1e-10 && (open.grains.spin[i] - periodic.grains.spin[i]).norm() < 1e-10, "{apart}");
    }
}

/// A floor that falls towards +x by `slope` radians: as gravity that is turned.
fn incline(outline: Outline, slope: f64, friction: f64) -> Dem {
    let mut law = law(0.5, 2e-3);
    law.friction = friction;
    let mut set_up = empty(law);
    set_up.walls.push(floor());
    set_up.gravity = [9.81 * slope.sin(), 0.0, -9.81 * slope.cos()].into();
    let height = outline.support([0.0, 1.0])[1];
    add_body(&mut set_up, outline, [0.0, 0.0, height], 1000.0);
    dem(&set_up)
}

#[test]
fn a_square_slides_above_the_angle_of_friction_only() {
    let friction: f64 = 0.5;
    let angle = friction.atan();
    for (slope, slides) in [(0.97 * angle, false), (1.03 * angle, true)] {
        let mut solver = incline(Outline::rectangle([0.1, 0.1]), slope, friction);
        solver.advance(0.5, 12_500, &[]).expect("advances");
        let (before, speed) = (solver.grains.position[0].x, solver.grains.velocity[0].x);
        solver.advance(0.5, 12_500, &[]).expect("advances");
        let (x, v) = (solver.grains.position[0].x - before, solver.grains.velocity[0].x - speed);
        let expected = 0.5 * 9.81 * (slope.sin() - friction * slope.cos());
        println!(
            "slope {slope:.4}: moved {x:.3e} m and won {v:.3e} m/s in half a second, expected {expected:.4e}"
        );
        if slides {
            assert!((v / expected - 1.0).abs() < 1e-3, "{v} beside {expected}");
        } else {
            assert!(x.abs() < 1e-8 && v.abs() < 1e-8 && solver.grains.spin[0].y.abs() < 1e-8, "{x} {v}");
        }
    }
}

#[test]
fn a_standing_rectangle_topples_beyond_its_aspect_ratio_only() {
    let angle: f64 = 0.25f64.atan();
    for (slope, topples) in [(0.97 * angle, false), (1.03 * angle, true)] {
        let mut solver = incline(Outline::rectangle([0.05, 0.2]), slope, 1.0);
        solver.advance(2.0, 50_000, &[]).expect("advances");
        let q = solver.grains.orientation[0];
        let turn = 2.0 * q.j.atan2(q.w);
        println!("slope {slope:.4}: turned by {turn:.4}");
        if topples {
            assert!(turn > 1.0, "{turn}");
        } else {
            assert!(turn.abs() < 1e-3 && solver.grains.velocity[0].norm() < 1e-6, "{turn}");
        }
    }
}

/// Some bodies that fall on an inclined floor with friction, the whole turned by `angle` about y.
fn heap(angle: f64) -> DemSpec {
    let mut law = law(0.6, 5e-3);
    law.friction = 0.4;
    let mut set_up = empty(law);
    let (s, c) = angle.sin_cos();
    let out = |[x, z]: [f64; 2]| [x * c + z * s, 0.0, z * c - x * s];
    set_up.gravity = out([0.0, -9.81]).into();
    set_up.walls.push(Wall::new([0.0; 3], out([0.0, 1.0])));
    set_up.walls.push(Wall::new(out([-0.7, 0.0]), out([1.0, 0.0])));
    set_up.walls.push(Wall::new(out([0.7, 0.0]), out([-1.0, 0.0])));
    let outlines = [
        Outline::rectangle([0.4, 0.2]),
        Outline::Ellipse { semi_axes: [0.25, 0.12] },
        regular(5, 0.2),
        polygon(&[[0.0, 0.0], [0.4, 0.0], [0.1, 0.3]]),
        Outline::Ellipse { semi_axes: [0.1, 0.2] },
        Outline::rectangle([0.2, 0.5]),
        regular(8, 0.15),
    ];
    for (k, outline) in outlines.into_iter().enumerate() {
        let k = k as f64;
        let body = add_body(&mut set_up, outline, out([0.35 * (1.3 * k).sin(), 0.3 + 0.45 * k]), 1.0);
        body.orientation = turned(angle + 0.7 * k);
    }
    set_up.grains.push(Grain {
        free: Freedom::PLANE,
        orientation: turned(angle),
        ..Grain::new(out([0.05, 3.4]), 0.12, 1.0)
    });
    set_up
}

#[test]
fn a_turned_set_up_moves_alike() {
    let angle: f64 = 0.83;
    let (s, c) = angle.sin_cos();
    let (mut straight, mut tilted) = (dem(&heap(0.0)), dem(&heap(angle)));
    let mut touched = 0;
    for window in 0..420 {
        for solver in [&mut straight, &mut tilted] {
            touched += contacts_after(solver, 1e-3, 20);
        }
        for i in 0..straight.grains.len() {
            let (x, y) = (straight.grains.position[i], tilted.grains.position[i]);
            let x = Vec3::new(x.x * c + x.z * s, 0.0, x.z * c - x.x * s);
            let spins = straight.grains.spin[i].y - tilted.grains.spin[i].y;
            // Round-off grows from one collision to the next.
            assert!(
                (x - y).norm() < 1e-8 && spins.abs() < 1e-5,
                "window {window}, body {i}: {:e} {spins:e}",
                (x - y).norm()
            );
        }
    }
    assert!(touched > 20, "{touched}");
}

#[test]
fn restored_in_the_middle_of_contacts_it_repeats_bit_for_bit() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let set_up = DemSpec { integrator, ..heap(0.0) };
        let mut solver = dem(&set_up);
        let mut windows = 0;
        let busy = |solver: &Dem| {
            let state = solver.save();
            state.body_contacts.len() >= 3 && state.body_wall_contacts.len() >= 2
        };
        while !busy(&solver) && windows < 1000 {
            solver.advance(2e-3, 40, &[]).expect("advances");
            windows += 1;
        }
        let saved =
            repeats("heap", &set_up, &mut solver, |solver| solver.advance(2e-3, 40, &[]).expect("advances"));
        assert!(saved.body_contacts.len() >= 3 && saved.body_wall_contacts.len() >= 2, "{saved:?}");
        assert!(saved.body_contacts.iter().any(|point| point.spring != 0.0), "springs are part of it");
    }
}

/// The skin changes the cost and no bit.
#[test]
fn the_skin_changes_no_bit() {
    let run = |skin: f64| {
        let mut solver = dem(&DemSpec { skin: Some(skin), ..heap(0.0) });
        for _ in 0..200 {
            solver.advance(5e-3, 100, &[]).expect("advances");
        }
        (solver.save(), solver.list_builds())
    };
    let (a, many) = run(0.005);
    let (b, few) = run(0.3);
    assert!(many > 2 * few && a == b, "{many} and {few} builds");
}

#[test]
fn a_heap_comes_to_rest() {
    let mut solver = dem(&heap(0.0));
    let largest = (0..1200).map(|_| solver.advance(5e-3, 100, &[]).expect("advances").largest_overlap);
    let largest = largest.fold(0.0, f64::max);
    let energy = motion(&solver)[0];
    println!("energy left {energy:.2e}, largest overlap {largest:.2e}");
    assert!(energy < 1e-18, "{energy}");
    assert!(solver.contact_list(&[]).len() >= solver.grains.len());
    // What the contacts carry is the weight.
    let weight: f64 = solver.grains.mass.iter().sum::<f64>() * 9.81;
    let carried: f64 = solver.contact_list(&[]).iter().filter(|c| c.held).map(|c| c.force.z).sum();
    assert!((carried / weight - 1.0).abs() < 1e-4, "{carried} {weight}");
}

#[test]
fn a_stack_of_five_squares_stands() {
    let mut law = law(0.5, 2e-3);
    law.friction = 0.5;
    let mut set_up = empty(law);
    set_up.walls.push(floor());
    set_up.gravity = [0.0, 0.0, -9.81].into();
    for k in 0..5 {
        // One has slipped a little.
        let x = if k == 2 { 1e-3 } else { 0.0 };
        add_body(&mut set_up, Outline::rectangle([0.1, 0.1]), [x, 0.0, 0.05 + 0.1 * f64::from(k)], 1000.0);
    }
    let mut solver = dem(&set_up);
    // Its slowest swaying dies down with 1.2 s.
    solver.advance(15.0, 375_000, &[]).expect("advances");
    let before = solver.grains.position.clone();
    solver.advance(5.0, 125_000, &[]).expect("advances");
    for (k, x) in before.iter().enumerate() {
        let moved = (solver.grains.position[k] - x).norm();
        let speed = solver.grains.velocity[k].norm();

        println!("square {k}: at {x:?}, moved {moved:.2e} in five seconds, {speed:.2e} m/s");
        assert!(moved < 1e-7 && speed < 1e-8, "square {k}: {moved} {speed}");
    }
}

#[test]
fn gaps_are_those_of_the_surfaces() {
    let mut set_up = empty(law(0.5, 1e-3));
    set_up.walls.push(floor());
    add_body(&mut set_up, Outline::rectangle([1.0, 0.4]), [0.0, 0.0, 1.0], 1.0);
    let body = add_body(&mut set_up, Outline::rectangle([1.0, 0.4]), [1.5, 0.0, 1.0], 1.0);
    body.orientation = turned(PI / 4.0);
    let mut solver = dem(&set_up);
    let report = solver.advance(1e-6, 1, &[]).expect("advances");
    // The corner of the second reaches 0.7/√2 towards the first, and stands 0.3/√2 above its middle, which
    // ends at 0.2.
    let between = (1.5 - 0.5 - 0.7 / 2f64.sqrt()).hypot(0.3 / 2f64.sqrt() - 0.2);
    let seen = &solver.observations().gap_end;
    let to_floor = 1.0 - 0.7 / 2f64.sqrt();
    println!("{seen:?}, {between} {to_floor}");
    assert!((seen[0] - between.min(0.8)).abs() < 1e-9 && (seen[1] - between.min(to_floor)).abs() < 1e-9);
    assert_eq!(report.largest_overlap, 0.0);
}

#[test]
fn what_bodies_do_not_allow_is_refused() {
    let good = heap(0.0);
    good.validate().expect("as it is");
    let refused = |set_up: &DemSpec| set_up.validate().expect_err("refused").to_string();
    let with = |contact: LinearSpringDashpot| DemSpec {
        contact: ContactLaw::LinearSpringDashpot(contact),
        ..heap(0.0)
    };
    assert!(refused(&DemSpec { integrator: Integrator::Rk3, ..heap(0.0) }).contains("rk3"));
    assert!(refused(&DemSpec { energy: true, ..heap(0.0) }).contains("energy"));
    assert!(refused(&DemSpec { shape: Shape::Sphere, ..heap(0.0) }).contains("plane"));
    assert!(refused(&DemSpec { engine: dem_solver::Engine::Bulk, ..heap(0.0) }).contains("not round"));
    let rolling = Some(dem_solver::laws::rolling::Rolling { friction: 0.1, damping: 0.3 });
    assert!(refused(&with(LinearSpringDashpot { rolling, ..law(0.5, 1e-3) })).contains("corners"));
    let mut film = heap(0.0);
    film.viscosity = 1e-3;
    film.lubrication =
        dem_solver::Lubrication::AsPrinted(dem_solver::lubrication::settings::LubricationSettings::new(1e-3));
    assert!(refused(&film).contains("not modelled"));
    let mut leaning = heap(0.0);
    leaning.grains[0].orientation = [0.8, 0.6, 0.0, 0.0];
    assert!(refused(&leaning).contains("about y"));
    let mut free = heap(0.0);
    free.grains[1].free = Freedom::SPACE;
    assert!(refused(&free).contains("across the plane"));
}
