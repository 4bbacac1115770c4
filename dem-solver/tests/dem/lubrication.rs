//! The film: exact solutions of m dU/dt = −κ(h) U, stability, tunnelling, many films.
use crate::common::{angular_momentum, dem, effective, floor, law, momentum, spec};
use dem_solver::lubrication::law::{LubricationLaw, LubricationModel};
use dem_solver::lubrication::settings::LubricationSettings;
use dem_solver::{Dem, DemSpec, Grain, Lubrication, Motion, Shape, Vec3, Wall};
use std::f64::consts::PI;

const R: f64 = 0.5;

fn model(roughness: f64, shape: Shape) -> LubricationModel {
    LubricationModel {
        shape,
        roughness,
        cut_off: 0.5,
        longest: f64::INFINITY,
        resolved_length: f64::INFINITY,
        line: dem_solver::LineResolution::MASK,
        tangential: false,
        viscosity: 1.0,
    }
}

/// One sphere of radius ½ above the floor: gap `gap`, velocity `v`, St_R = m |v|/(6πμR²) = `stokes`.
fn approach(gap: f64, v: f64, stokes: f64, settings: LubricationSettings, t_c: f64) -> DemSpec {
    let mut grain = Grain::new([0.0, 0.0, R + gap], R, 1.0);
    grain.velocity = [0.0, 0.0, v];
    let mass = 4.0 / 3.0 * PI * R.powi(3);
    let mut set_up = spec(vec![grain], law(0.97, t_c));
    set_up.walls.push(floor());
    set_up.viscosity = mass * v.abs() / (6.0 * PI * R * R * stokes);
    set_up.lubrication = Lubrication::AsPrinted(settings);
    set_up
}

/// U(h) = U₀ + K ln((h + η)/(h₀ + η)), whatever the sub-step: on the way in, stopped by the film.
#[test]
fn approach_keeps_the_logarithm_to_four_digits() {
    for eta in [1e-3, 4e-4, 1e-4, 1e-5, 1e-6] {
        for dt in [1e-5, 1e-4, 1e-3, 1e-2] {
            for stokes in [1.0, 3.0, 10.0, 100.0] {
                let mut solver = dem(&approach(0.2, -1.0, stokes, LubricationSettings::new(eta), 1e-3));
                let k = 1.0 / stokes;
                let mut worst = 0.0f64;
                let n = (0.4 / dt) as u32;
                for _ in 0..n {
                    solver.advance(dt, 1, &[]).expect("advances");
                    let h = solver.grains.position[0].z - R;
                    if h < 0.0 {
                        break;
                    }
                    let exact = -1.0 - k * ((h + eta * R) / (0.2 + eta * R)).ln();
                    worst = worst.max((solver.grains.velocity[0].z - exact).abs());
                }
                assert!(worst < 1e-4, "eta/R {eta}, dt {dt}, St_R {stokes}: {worst:.2e}");
            }
        }
    }
}

/// Below St_R ln((h₀ + η)/η) = 1 the film stops the grain, however long the sub-step.
#[test]
fn stopped_grain_never_touches() {
    for eta in [1e-3, 1e-6] {
        for dt in [1e-5, 1e-3, 1e-2, 1.0, 100.0] {
            let mut solver = dem(&approach(0.2, -1.0, 0.1, LubricationSettings::new(eta), 1e-3));
            let report = solver.advance(2000.0 * dt, 2000, &[]).expect("advances");
            assert!(
                report.smallest_gap > 0.0 && report.largest_overlap == 0.0,
                "eta/R {eta}, dt {dt}: {report:?}"
            );
        }
    }
}

/// A load that presses the grain on: the film yields slowly, but no sub-step, however long, tunnels.
#[test]
fn pressed_grain_never_tunnels() {
    for dt in [1e-3, 1e-1, 1e1] {
        let mut set_up = approach(0.1, -1e-9, 1e-9, LubricationSettings::new(1e-4), 1e-3);
        set_up.gravity = [0.0, 0.0, -1e-3].into();
        let mut solver = dem(&set_up);
        let mut last = 0.1;
        for _ in 0..200 {
            let report = solver.advance(dt, 1, &[]).expect("advances");
            let h = solver.grains.position[0].z - R;
            assert!(
                report.largest_overlap < 1e-12 && h < last && h > -1e-9,
                "dt {dt}: h {h:.3e} after {last:.3e}"
            );
            last = h;
        }
    }
}

/// e = e_dry − (1 + e_dry) ln((x₀ + η)/η)/St_R (Davis; Barnocky & Davis): in, dry contact, out to x₀.
#[test]
fn bounce_through_the_film() {
    println!("  eta/R     dt     St_R   found     exact");
    for eta in [1e-3, 1e-4, 1e-6] {
        for n in [100, 1000] {
            for stokes in [30.0, 100.0] {
                // a contact so short that the film's path during it does not count
                let t_c = 1e-5;
                let mut set_up = approach(0.1, -1.0, stokes, LubricationSettings::new(eta), t_c);
                set_up.contact = dem_solver::ContactLaw::LinearSpringDashpot(law(0.97, t_c));
                let mut solver = dem(&set_up);
                let dt = t_c / f64::from(n);
                let dry = effective(&law(0.97, t_c)).0;
                let exact = dry - (1.0 + dry) * ((0.1 + eta * R) / (eta * R)).ln() / stokes;
                let height = |solver: &Dem| solver.grains.position[0].z - R;
                // long sub-steps through the film, short ones near the wall and in contact
                while height(&solver) > 1e-3 {
                    solver.advance(1e-4, 1, &[]).expect("advances");
                }
                while height(&solver) < 1e-3 {
                    solver.advance(10.0 * dt, 10, &[]).expect("advances");
                }
                while height(&solver) < 0.1 {
                    solver.advance(1e-4, 1, &[]).expect("advances");
                }
                let beyond = ((height(&solver) + eta * R) / (0.1 + eta * R)).ln() / stokes;
                let found = solver.grains.velocity[0].z + beyond;
                println!("{eta:7.0e} {dt:7.0e} {stokes:6.0} {found:9.6} {exact:9.6}");
                assert!(
                    (found - exact).abs() < 1.5 / f64::from(n),
                    "eta/R {eta}, n {n}, St_R {stokes}: {found} instead of {exact}"
                );
            }
        }
    }
}

/// A sub-step far above 2(η + δ)m/(6πμR²), where an explicit film would grow, only decays.
#[test]
fn a_long_sub_step_only_decays() {
    let (eta, gap) = (1e-3, 0.01);
    let set_up = approach(gap, -1e-9, 1e-9, LubricationSettings::new(eta), 1e-3);
    let mass = 4.0 / 3.0 * PI * R.powi(3);
    let limit = 2.0 * (eta * R + gap) * mass / (6.0 * PI * set_up.viscosity * R * R);
    assert!(limit < 0.1, "{limit}");
    let mut solver = dem(&set_up);
    solver.advance(1.0, 1, &[]).expect("advances");
    assert!(solver.grains.velocity[0].z.abs() < 1e-9);
}

/// All film laws: the implicit rate satisfies m(U′ − U) + ∫κ = 0 by quadrature, for random input.
#[test]
fn implicit_rate_solves_its_equation() {
    let mut random = crate::common::Random(7);
    let laws = [
        (Shape::Sphere, f64::INFINITY),
        (Shape::Disc, f64::INFINITY),
        (Shape::Sphere, 0.1),
        (Shape::Sphere, 1e-3),
        (Shape::Disc, 0.1),
        (Shape::Disc, 1e-3),
    ];
    for (shape, resolved_length) in laws {
        {
            for _ in 0..2000 {
                let eta = 10f64.powf(-6.0 + 4.0 * random.next());
                let film = LubricationModel { resolved_length, ..model(eta, shape) }.law(0.5, 0.7);
                let gap = if random.next() < 0.2 {
                    -1e-3
                } else {
                    0.5 * random.next() * 10f64.powf(-4.0 * random.next())
                };
                let (rate, dt) = (4.0 * random.next() - 2.0, 10f64.powf(-5.0 + 4.0 * random.next()));
                let inverse_mass = 10f64.powf(-2.0 + 4.0 * random.next());
                let impulse = film.impulse(gap, rate, dt, inverse_mass);
                let after = rate + inverse_mass * impulse;
                let residual = impulse + quadrature(&film, gap, gap + dt * after);
                let scale = rate.abs() / inverse_mass;
                assert!(
                    residual.abs() < 1e-6 * scale,
                    "{film:?} gap {gap} rate {rate} dt {dt}: residual {residual:.2e} of {scale:.2e}"
                );
                assert!(impulse * rate <= 0.0 && after * rate >= 0.0, "a film only brakes");
            }
        }
    }
}

/// ∫κ dδ from `a` to `b` by Simpson's rule in ln(δ + η), κ = 0 outside [0, δ_c].
fn quadrature(film: &LubricationLaw, a: f64, b: f64) -> f64 {
    let (a, b) = (a.clamp(0.0, film.cut_off), b.clamp(0.0, film.cut_off));
    let (low, high) = ((a + film.roughness).ln(), (b + film.roughness).ln());
    let n = 400;
    let value = |k: usize| {
        let y = low + (high - low) * k as f64 / n as f64;
        film.resistance(y.exp() - film.roughness) * y.exp()
    };
    let sum: f64 = (0..=n)
        .map(|k| {
            value(k)
                * if k == 0 || k == n {
                    1.0
                } else if k % 2 == 1 {
                    4.0
                } else {
                    2.0
                }
        })
        .sum();
    sum * (high - low) / (3.0 * n as f64)
}

/// Printed coefficients: eq. 19 for two spheres and a wall, 3√2 πμ (R/h)^{3/2} for a disc at a wall.
#[test]
fn coefficients_are_the_printed_ones() {
    let point = model(1e-3, Shape::Sphere);
    let pair = point.law(0.5, 0.5).resistance(0.01);
    assert!((pair - 6.0 * PI * 0.0625 / (0.01 + 0.5e-3)).abs() < 1e-12 * pair);
    let wall = point.law(0.5, f64::INFINITY).resistance(0.01);
    assert!((wall - 6.0 * PI * 0.25 / (0.01 + 0.5e-3)).abs() < 1e-12 * wall);
    let disc = model(1e-9, Shape::Disc).law(0.5, f64::INFINITY).resistance(0.01);
    assert!((disc / (3.0 * 2f64.sqrt() * PI * 50f64.powf(1.5)) - 1.0).abs() < 1e-6, "{disc}");
    // what the flow lacks at a line ends at the cut-off
    let line = LubricationModel { resolved_length: 0.01, ..model(1e-3, Shape::Disc) }.law(0.5, 0.5);
    assert!(line.resistance(line.cut_off).abs() < 1e-12);
    let complement = LubricationModel { resolved_length: 0.01, ..model(1e-9, Shape::Sphere) };
    let film = complement.law(0.5, f64::INFINITY);
    // a fifth of eq. 19 one cell away, all of it far within a cell
    assert!((film.resistance(0.01) / (6.0 * PI * 0.25 / 0.01) - 0.2).abs() < 1e-6);
    assert!((film.resistance(1e-6) / (6.0 * PI * 0.25 / 1e-6) - 1.0).abs() < 1e-3);
}

/// A column of grains, each in the film of the next, pressed together: momentum of the grains changes
/// by gravity and the wall's film alone; nothing tunnels; more sweeps converge.
#[test]
fn many_films_conserve_momentum_and_converge() {
    let column = |sweeps: u32| {
        let grains: Vec<Grain> = (0..6)
            .map(|k| {
                let mut grain = Grain::new([0.0, 0.0, R + 0.02 + 1.02 * f64::from(k)], R, 1.0 + f64::from(k));
                grain.velocity = [0.0, 0.0, -0.1 * f64::from(k)];
                grain
            })
            .collect();
        let mut set_up = spec(grains, law(0.97, 1e-2));
        set_up.viscosity = 0.05;
        set_up.lubrication =
            Lubrication::AsPrinted(LubricationSettings { sweeps, ..LubricationSettings::new(1e-4) });
        set_up
    };
    let run = |set_up: &DemSpec| -> Dem {
        let mut solver = dem(set_up);
        solver.advance(1e-2, 1, &[]).expect("advances");
        solver
    };
    let free = column(8);
    let before = momentum(&dem(&free));
    let after = run(&free);
    assert!((momentum(&after) - before).norm() < 1e-14 * before.norm());
    assert!((after.observations().mean_lubrication.iter().sum::<Vec3>()).norm() < 1e-12);
    let speed = |sweeps| run(&column(sweeps)).grains.velocity.iter().map(|v| v.z).collect::<Vec<_>>();
    let exact = speed(10_000);
    let errors = [1, 2, 3, 4]
        .map(|sweeps| speed(sweeps).iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
    println!("error of one stiff sub-step by sweeps 1 to 4: {errors:?}");
    assert!(errors[0] > errors[1] && errors[1] >= errors[2] && errors[3] < 1e-6, "{errors:?}");
}

/// Eight spheres in the film of one floor, or of one fixed sphere each side of which two stand: what is held
/// bears the films of all, not of one of a pack.
#[test]
fn what_is_held_bears_all_films_that_share_it() {
    let film = |set_up: &mut DemSpec| {
        set_up.viscosity = 0.05;
        set_up.lubrication = Lubrication::AsPrinted(LubricationSettings::new(1e-3));
    };
    let falling = (0..8).map(|k| {
        let mut grain = Grain::new([3.0 * f64::from(k), 0.0, R + 0.02], R, 1.0);
        grain.velocity = [0.0, 0.0, -0.1];
        grain
    });
    let mut row = spec(falling.collect(), law(0.97, 1e-2));
    row.walls.push(floor());
    film(&mut row);
    let mut solver = dem(&row);
    solver.advance(1e-3, 1, &[]).expect("advances");
    let (one, all) =
        (solver.observations().mean_lubrication[3].z, solver.observations().wall_lubrication[0].z);
    assert!(one > 0.0 && (all + 8.0 * one).abs() < 1e-12 * all.abs(), "{all} of eight times {one}");

    let mut held = Grain::new([0.0; 3], R, 1.0);
    held.motion = Motion::Fixed;
    let sides = [[1.02, 0.0, 0.0], [-1.02, 0.0, 0.0], [0.0, 1.02, 0.0]].map(|site| {
        let mut grain = Grain::new(site, R, 1.0);
        grain.velocity = site.map(|x| -0.1 * x);
        grain
    });
    let mut cross = spec([vec![held], sides.to_vec()].concat(), law(0.97, 1e-2));
    film(&mut cross);
    let mut solver = dem(&cross);
    solver.advance(1e-3, 1, &[]).expect("advances");
    let films = &solver.observations().mean_lubrication;
    let sum: Vec3 = films.iter().sum();
    assert!(films[3].norm() > 0.0 && sum.norm() < 1e-12 * films[3].norm(), "{films:?}");
    assert!((films[0] + films[3]).norm() < 1e-9 * films[3].norm(), "{films:?}");
}

/// A sub-step that begins with the impulses of the one before ends where one from nothing ends.
#[test]
fn sub_steps_within_a_window_agree_with_windows_of_one_sub_step() {
    let grains = (0..27).map(|k| {
        let site = [k % 3, k / 3 % 3, k / 9].map(f64::from);
        let mut grain = Grain::new(site.map(|s| 1.02 * s + R + 0.01), R, 2.0);
        grain.velocity = [0.1 * (site[1] - 1.0), 0.05 * (1.0 - site[2]), -0.1 * site[2]];
        grain
    });
    let mut set_up = spec(grains.collect(), law(0.97, 1e-2));
    set_up.gravity = [0.0, 0.0, -1.0].into();
    set_up.viscosity = 0.05;
    set_up.lubrication =
        Lubrication::AsPrinted(LubricationSettings { sweeps: 100, ..LubricationSettings::new(1e-4) });
    let (mut whole, mut apart) = (dem(&set_up), dem(&set_up));
    whole.advance(0.02, 40, &[]).expect("advances");
    for _ in 0..40 {
        apart.advance(0.02 / 40.0, 1, &[]).expect("advances");
    }
    let largest = apart.grains.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let off = whole.grains.velocity.iter().zip(&apart.grains.velocity).map(|(a, b)| (a - b).norm());
    let off = off.fold(0.0, f64::max) / largest;
    println!("largest difference of a velocity: {off:e}");
    // forty sub-steps, each converged to 1e-6 of the largest gap rate
    assert!(off > 0.0 && off < 1e-5, "{off}");
}

/// A wall that moves towards a resting grain pushes it through the film.
#[test]
fn moving_wall_carries_the_grain() {
    let mut set_up = approach(0.01, -1e-12, 1e-12, LubricationSettings::new(1e-3), 1e-3);
    set_up.walls = vec![Wall { velocity: [0.0, 0.0, 0.3].into(), ..floor() }];
    let mut solver = dem(&set_up);
    solver.advance(1.0, 100, &[]).expect("advances");
    assert!((solver.grains.velocity[0].z - 0.3).abs() < 1e-6);
    // K = 1 here: ln((h + η)/(h₀ + η)) = −0.3
    let exact = (0.01 + 1e-3 * R) * (-0.3f64).exp() - 1e-3 * R;
    assert!(
        (solver.observations().gap_end[0] - exact).abs() < 1e-6,
        "{}",
        solver.observations().gap_end[0] - exact
    );
}

/// The film of two grains over one sub-step gives the impulse of the law, be the path so short that the
/// solver has a series for it, or longer.
#[test]
fn one_film_gives_the_impulse_of_the_law() {
    let (mut short, mut long) = (0, 0);
    for (shape, resolved_length) in [
        (Shape::Sphere, f64::INFINITY),
        (Shape::Sphere, 0.1),
        (Shape::Disc, f64::INFINITY),
        (Shape::Disc, 0.1),
    ] {
        let law = LubricationModel { resolved_length, ..model(4e-4, shape) }.law(R, R);
        let size = if shape == Shape::Sphere { 4.0 / 3.0 * PI * R.powi(3) } else { PI * R * R };
        for gap in [0.0, 1e-4, 1e-3, 0.01, 0.1, 0.2] {
            for rate in [-3.0, -0.1, -1e-3, 1e-6, 0.02, 1.0] {
                for (dt, inverse_mass) in [(1e-4, 0.5), (1e-2, 0.5), (1e-4, 50.0), (1e-6, 1e-3)] {
                    let places = [[0.5 + R + gap, 0.0, 0.0], [0.5 - R, 0.0, 0.0]];
                    let mut grains = places.map(|at| Grain::new(at, R, 2.0 / (inverse_mass * size)));
                    (grains[0].velocity, grains[1].velocity) =
                        ([0.5 * rate, 0.0, 0.0], [-0.5 * rate, 0.0, 0.0]);
                    let mut set_up = spec(grains.to_vec(), self::law(0.97, 1.0));
                    (set_up.shape, set_up.viscosity) = (shape, 1.0);
                    let settings = LubricationSettings::new(4e-4);
                    set_up.lubrication = match resolved_length {
                        f64::INFINITY => Lubrication::AsPrinted(settings),
                        length => Lubrication::Complement(LubricationSettings {
                            resolved_length: Some(length),
                            ..settings
                        }),
                    };
                    let mut solver = dem(&set_up);
                    solver.advance(dt, 1, &[]).expect("advances");
                    let near = solver.observations().mean_lubrication[0].x * dt;
                    let at = (places[0][0] - places[1][0]) - 2.0 * R;
                    let exact = law.impulse(at, rate, dt, inverse_mass);
                    let path = dt * (rate + inverse_mass * exact) / (at + law.roughness);
                    *if path.abs() < 1.0 / 512.0 { &mut short } else { &mut long } += 1;
                    // the logarithms' impulse is a difference of momenta
                    let rounding = 1e-14 * rate.abs() / inverse_mass;
                    assert!(
                        (near - exact).abs() <= 2e-10 * exact.abs() + rounding,
                        "{shape:?} gap {gap}, rate {rate}, dt {dt}: {near:e} against {exact:e}"
                    );
                }
            }
        }
    }
    assert!(short > 200 && long > 100, "{short} short, {long} long");
}

/// A sphere beside a wall at constant gap: its velocity and spin decay as with the resistances of Goldman,
/// Cox & Brenner (1967), force −6πμR(8/15 U − 2/15 ωR)ℓ and torque 8πμR²(1/10 U − 2/5 ωR)ℓ.
#[test]
fn a_sphere_beside_a_wall_slides_and_rolls_as_published() {
    let (gap, length, roughness) = (0.004, 0.1, 1e-3);
    let mut grain = Grain::new([0.0, 0.0, R + gap], R, 2.0);
    grain.velocity = [0.3, 0.0, 0.0];
    grain.free.translation = [true, true, false];
    let mass = 2.0 * 4.0 / 3.0 * PI * R.powi(3);
    let mut set_up = spec(vec![grain], law(0.97, 1e-2));
    set_up.walls.push(floor());
    set_up.viscosity = 0.2;
    let settings =
        LubricationSettings { resolved_length: Some(length), ..LubricationSettings::new(roughness) };
    set_up.lubrication = Lubrication::Complement(settings);
    let (time, steps) = (0.5, 4000);
    let mut solver = dem(&set_up);
    solver.advance(time, steps, &[]).expect("advances");
    let log = 0.5 * (0.25 * length / (gap + roughness * R)).powi(2).ln_1p();
    let c = PI * set_up.viscosity * R * log;
    // Heun's method, w = ωR.
    let (mut u, mut w) = (0.3, 0.0);
    let dt = time / f64::from(steps);
    let rates = |u: f64, w: f64| (-c * (3.2 * u - 0.8 * w) / mass, c * (0.8 * u - 3.2 * w) / (0.4 * mass));
    for _ in 0..steps {
        let (a, b) = rates(u, w);
        let (a2, b2) = rates(u + dt * a, w + dt * b);
        (u, w) = (u + 0.5 * dt * (a + a2), w + 0.5 * dt * (b + b2));
    }
    let (ours, spin) = (solver.grains.velocity[0].x, solver.grains.spin[0].y * R);
    println!("velocity {ours} for {u}, spin times radius {spin} for {w}");
    assert!(u < 0.2 && w > 0.02, "the film acts");
    assert!((ours / u - 1.0).abs() < 1e-3 && (spin / w - 1.0).abs() < 1e-3);
    // It drags the wall along as much.
    let seen = solver.observations();
    let (drag, on_wall) = (seen.mean_lubrication[0].x, seen.wall_lubrication[0].x);
    assert!(drag < 0.0 && on_wall == -drag, "{on_wall} for {drag}");
    // Without it nothing brakes.
    let settings = LubricationSettings { tangential: Some(false), ..settings };
    set_up.lubrication = Lubrication::Complement(settings);
    let mut solver = dem(&set_up);
    solver.advance(time, steps, &[]).expect("advances");
    assert_eq!(solver.grains.velocity[0].x, 0.3);
}

/// Two spheres that pass and turn: whatever the sub-step, the film keeps momentum and angular momentum, and
/// takes energy.
#[test]
fn tangential_films_keep_momentum_and_take_energy() {
    for viscosity in [1e-3, 1.0, 1e4] {
        let (a, b) = (R, 0.3);
        let mut grains = vec![Grain::new([0.0; 3], a, 2.0), Grain::new([0.0, 0.48, 0.65], b, 5.0)];
        grains[1].position = grains[1].position.map(|x: f64| x * (a + b + 0.003) / 0.65f64.hypot(0.48));
        (grains[0].velocity, grains[0].spin) = ([0.3, 0.2, -0.1], [1.0, -2.0, 0.5]);
        (grains[1].velocity, grains[1].spin) = ([-0.2, 0.1, 0.0], [3.0, 1.0, -1.0]);
        let mut set_up = spec(grains, law(0.97, 1e-2));
        set_up.viscosity = viscosity;
        let settings = LubricationSettings { resolved_length: Some(0.1), ..LubricationSettings::new(1e-3) };
        set_up.lubrication = Lubrication::Complement(settings);
        let mut solver = dem(&set_up);
        let mut energy = solver.kinetic_energy();
        let (before, angular) = (momentum(&solver), angular_momentum(&solver));
        for _ in 0..20 {
            solver.advance(1e-3, 1, &[]).expect("advances");
            let now = solver.kinetic_energy();
            assert!(now < energy, "{viscosity}: {now} after {energy}");
            energy = now;
        }
        assert!((momentum(&solver) - before).norm() < 1e-13 * before.norm());
        // The drift of the centres between two sub-steps takes no part: each moves along its momentum.
        let off = (angular_momentum(&solver) - angular).norm();
        assert!(off < 1e-13 * angular.norm(), "{viscosity}: {off:e} of {}", angular.norm());
    }
}

#[test]
fn a_tangential_film_is_that_of_the_complement_alone() {
    let mut set_up = spec(vec![Grain::new([0.0; 3], R, 1.0)], law(0.97, 1e-2));
    set_up.viscosity = 1.0;
    let settings = LubricationSettings { tangential: Some(true), ..LubricationSettings::new(1e-3) };
    set_up.lubrication = Lubrication::AsPrinted(settings);
    let error = Dem::new(&set_up).expect_err("is refused").to_string();
    assert!(error.contains("tangential") && error.contains("complement"), "{error}");
}

/// Discs that overlap by more than their roughness: no film, and no root of a negative number.
#[test]
fn discs_that_overlap_further_than_their_roughness_stay_finite() {
    let settings = LubricationSettings::new(1e-4);
    let complement = LubricationSettings { resolved_length: Some(0.1), ..settings };
    for film in [Lubrication::AsPrinted(settings), Lubrication::Complement(complement)] {
        let mut grains = vec![Grain::new([0.0; 3], 0.5, 2.0), Grain::new([0.999, 0.0, 0.0], 0.5, 2.0)];
        grains.iter_mut().for_each(|grain| grain.free = dem_solver::Freedom::PLANE);
        let mut set_up = spec(grains, law(0.9, 1e-2));
        (set_up.shape, set_up.lubrication, set_up.viscosity) = (dem_solver::Shape::Disc, film, 0.01);
        let mut solver = dem(&set_up);
        for _ in 0..20 {
            let report = solver.advance(1e-3, 4, &[]).expect("advances");
            assert_eq!(report.first_non_finite, None, "{film:?}");
        }
        assert!(solver.grains.velocity[1].x > 0.0, "{film:?}: they push each other apart");
    }
}
