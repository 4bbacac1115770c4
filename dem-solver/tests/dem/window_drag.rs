//! A fluid's force of one window makes grains that contacts shake vibrate the more; the drag that changes
//! within the window takes that away, and acts nowhere else.

use crate::common::{dem, exact, floor, law, spec};
use dem_solver::{Dem, DemSpec, Grain, GrainLoad, Vec3, Wall};
use std::f64::consts::PI;

/// Windows.
const WINDOWS: usize = 60;
/// m_f of a sphere of diameter 1.
const DISPLACED: f64 = PI / 6.0;
const DENSITY: f64 = 2.1;

/// One sphere; `held`: between two planes that both press it, or else on one of them. ρ = D = 1.
fn sphere(held: bool, restitution: f64, contact_time: f64) -> DemSpec {
    let mut set_up =
        spec(vec![Grain::new([0.0, 0.0, 0.4995], 0.5, DENSITY)], exact(law(restitution, contact_time)));
    set_up.walls = vec![floor()];
    if held {
        set_up.walls.push(Wall::new([0.0, 0.0, 0.999], [0.0, 0.0, -1.0]));
    }
    (set_up.viscosity, set_up.fluid_density) = (1.0, 1.0);
    set_up
}

/// Impulse of a fluid on a sphere that moves at 1 for a window of length `dt`, over m_f: steady drag and
/// sudden motion.
fn answer(dt: f64) -> f64 {
    18.0 * dt + 10.2 * dt.sqrt()
}

/// Energy of the vibration after the windows over that before, under the force of a fluid that knows how
/// each window began.
fn energy(set_up: &DemSpec, dt: f64, frequency: f64) -> f64 {
    let mut solver = dem(set_up);
    solver.grains.velocity[0].z = 1e-6;
    let of = |solver: &Dem| {
        let (x, v) = (solver.grains.position[0].z - 0.4995, solver.grains.velocity[0].z);
        v * v + (frequency * x).powi(2)
    };
    let before = of(&solver);
    for _ in 0..WINDOWS {
        let drag = -answer(dt) * DISPLACED / dt * solver.grains.velocity[0];
        solver.advance(dt, 400, &[GrainLoad { force: drag, ..GrainLoad::default() }]).expect("advances");
    }
    of(&solver) / before
}

/// Of a sphere between two springs of angular frequency ω the map of a window has the determinant 1 − κ sin
/// θ/θ, θ = ω dt, κ the fluid's answer over its mass: from half a period a window on it grows.
#[test]
fn a_force_of_one_window_feeds_a_vibration_and_the_drag_within_it_takes_that_away() {
    for windows in [0.75, 1.0, 1.2, 2.5] {
        let contact_time = 0.04;
        let dt = windows * contact_time;
        let mut set_up = sphere(true, 1.0, contact_time);
        let frequency = 2f64.sqrt() * PI / contact_time;
        let theta = frequency * dt;
        let feeds = 1.0 - answer(dt) / DENSITY * theta.sin() / theta;
        let damped = energy(&set_up, dt, frequency);
        assert!(damped < 1e-3, "{windows}: {damped:e}");
        set_up.fluid_density = 0.0;
        // Where it stands in its period at the start and at the end: a factor of ten at most, in 60 windows.
        let (room, grown) = (10f64.powf(1.0 / WINDOWS as f64), energy(&set_up, dt, frequency));
        let grown = grown.powf(1.0 / WINDOWS as f64);
        assert!(
            feeds > 1.05 && (1.0 / room..room).contains(&(grown / feeds)),
            "{windows}: {grown} for {feeds}"
        );
    }
}

/// A grain with one contact, one whose contacts take the vibration away, one in short windows, one in a fluid
/// that hardly answers, and one without loads keep every bit.
#[test]
fn the_drag_within_a_window_acts_in_beds_that_need_it_alone() {
    let load = GrainLoad { force: Vec3::new(0.01, 0.0, -0.2), ..GrainLoad::default() };
    let bits = |mut set_up: DemSpec, loads: &[GrainLoad], drag: bool| {
        if !drag {
            set_up.fluid_density = 0.0;
        }
        let mut solver = dem(&set_up);
        solver.grains.velocity[0] = Vec3::new(0.01, 0.0, -0.02);
        for _ in 0..20 {
            solver.advance(0.04, 40, loads).expect("advances");
        }
        solver.save()
    };
    let thin = DemSpec { viscosity: 1e-3, ..sphere(true, 0.97, 0.04) };
    for (what, set_up, loads) in [
        ("one contact", sphere(false, 0.97, 0.04), &[load][..]),
        ("damped", sphere(true, 0.6, 0.04), &[load]),
        ("short windows", sphere(true, 0.97, 0.41), &[load]),
        ("thin", thin, &[load]),
        ("no fluid", sphere(true, 0.97, 0.04), &[]),
    ] {
        assert!(bits(set_up.clone(), loads, true) == bits(set_up, loads, false), "{what}");
    }
    let bed = sphere(true, 0.97, 0.04);
    assert!(bits(bed.clone(), &[load], true) != bits(bed, &[load], false));
}
