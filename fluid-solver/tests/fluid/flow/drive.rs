//! Walls, forces and flow rates that change over time, against exact solutions.

use crate::flow::common::{SCHEMES, distance, error, grid, observed_order, put_back, uniform};
use bedload_scene::{OverTime, Sine};
use fluid_solver::boundary::{Boundary, Profile};
use fluid_solver::drive::Drive;
use fluid_solver::engines::HasEngine;
use fluid_solver::field::set_component;
use fluid_solver::grid::Grid;
use fluid_solver::measure::{mean_velocity, momentum};
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;
use std::f64::consts::{PI, TAU};

const BOTH: [Viscous; 2] = [Viscous::Implicit, Viscous::Explicit];

fn stepper<const D: usize>(g: Grid<D>, nu: f64, scheme: Scheme, viscous: Viscous, drive: Drive) -> Stepper<D>
where
    Grid<D>: HasEngine<D>,
{
    let options = Options { viscosity: nu, scheme, viscous, convection: true, body_force: [0.0; D] };
    let mut s = Stepper::new(g, options);
    s.set_drive(drive);
    s
}

/// A layer between walls, periodic along x, whose wall on `side` of z moves.
fn layer(n: usize) -> Grid<2> {
    grid([uniform(1.0, 4), uniform(1.0, n)], [[Boundary::Periodic; 2], [Boundary::WALL; 2]])
}

fn wall(side: usize, velocity: OverTime<[f64; 3]>) -> Drive {
    Drive { faces: vec![(1, side, velocity)], force: Vec::new() }
}

fn swing(frequency: f64) -> OverTime<[f64; 3]> {
    OverTime::sine(Sine { amplitude: [1.0, 0.0, 0.0], frequency, phase: 0.0, offset: [0.0; 3] })
}

/// Complex sinh of a + ib.
fn sinh(a: f64, b: f64) -> [f64; 2] {
    [a.sinh() * b.cos(), a.cosh() * b.sin()]
}

/// Stokes' second problem below a wall at rest at z = 1: Im[sinh(λ(1 − z))/sinh(λ) e^{iωt}], λ = √(iω/ν).
fn stokes(z: f64, t: f64, omega: f64, nu: f64) -> f64 {
    let l = (0.5 * omega / nu).sqrt();
    let (c, d) = (sinh(l * (1.0 - z), l * (1.0 - z)), sinh(l, l));
    let norm = d[0] * d[0] + d[1] * d[1];
    let ratio = [(c[0] * d[0] + c[1] * d[1]) / norm, (c[1] * d[0] - c[0] * d[1]) / norm];
    let (sin, cos) = (omega * t).sin_cos();
    ratio[0] * sin + ratio[1] * cos
}

/// A plate that swings, from the exact solution on: Δz and dt halved together, second order.
#[test]
fn an_oscillating_plate_converges() {
    let (nu, frequency) = (0.05, 0.5);
    let omega = TAU * frequency;
    for scheme in SCHEMES {
        let errors = [16, 32, 64].map(|n| {
            let mut s = stepper(layer(n), nu, scheme, Viscous::Implicit, wall(0, swing(frequency)));
            let g = s.grid().clone();
            set_component(&g, 0, &mut s.state_mut().velocity[0], |[_, z]| stokes(z, 0.0, omega, nu));
            let steps = 5 * n;
            (0..steps).for_each(|_| s.step(2.25 / steps as f64, None));
            error(&g, 0, &s.state().velocity[0], |[_, z]| stokes(z, 2.25, omega, nu))
        });
        println!("{scheme:?}: {errors:?}");
        assert!(observed_order("Stokes' second problem", &errors) > 1.9);
    }
}

/// The same in time alone, on one grid against a run of short steps, both treatments of viscosity.
#[test]
fn it_is_of_second_order_in_time() {
    for (scheme, viscous) in SCHEMES.into_iter().flat_map(|scheme| BOTH.map(|viscous| (scheme, viscous))) {
        let run = |steps: usize| {
            let mut s = stepper(layer(8), 0.05, scheme, viscous, wall(0, swing(0.5)));
            (0..steps).for_each(|_| s.step(1.25 / steps as f64, None));
            s.state().velocity.clone()
        };
        let (grid, exact) = (layer(8), run(4000));
        let errors = [40, 80, 160].map(|steps| distance(&grid, 0, &run(steps)[0], &exact[0]));
        println!("{scheme:?} {viscous:?}: {errors:?}");
        assert!(observed_order("Stokes' second problem in time", &errors) > 1.9);
    }
}

/// A lid that speeds up evenly from rest, after Duhamel from the start-up of Couette flow:
/// u/a = t z + Σ 2(−1)ⁿ/(nπ) sin(nπz) (1 − e^{−n²π²νt})/(n²π²ν).
fn ramp(z: f64, t: f64, nu: f64) -> f64 {
    let series = (1..60).map(|n| {
        let k = PI * f64::from(n);
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        2.0 * sign / k * (k * z).sin() * (1.0 - (-k * k * nu * t).exp()) / (k * k * nu)
    });
    t * z + series.sum::<f64>()
}

/// The lid goes on evenly once the table ends: the difference of two ramps. The corner lies within a step.
#[test]
fn a_ramped_lid_converges() {
    let (nu, until) = (0.1, 0.5171);
    for scheme in SCHEMES {
        let errors = [8, 16, 32].map(|n| {
            let lid = OverTime::table(vec![(0.0, [0.0; 3]), (until, [until, 0.0, 0.0])]);
            let mut s = stepper(layer(n), nu, scheme, Viscous::Implicit, wall(1, lid));
            let g = s.grid().clone();
            let steps = 4 * n;
            (0..steps).for_each(|_| s.step(1.0 / steps as f64, None));
            error(&g, 0, &s.state().velocity[0], |[_, z]| ramp(z, 1.0, nu) - ramp(z, 1.0 - until, nu))
        });
        println!("{scheme:?}: {errors:?}");
        assert!(observed_order("ramped lid", &errors) > 1.9);
    }
}

/// In space, with walls across y and z: what both engines do is the same where nothing depends on y.
#[test]
fn a_swinging_wall_in_space_is_that_of_the_plane() {
    let p = [Boundary::Periodic; 2];
    for (scheme, viscous) in SCHEMES.into_iter().flat_map(|scheme| BOTH.map(|viscous| (scheme, viscous))) {
        let mut plane = stepper(layer(16), 0.05, scheme, viscous, wall(1, swing(0.5)));
        for axis in [1, 2] {
            let mut axes = [uniform(1.0, 4), uniform(1.0, 16), uniform(1.0, 16)];
            axes[3 - axis] = uniform(1.0, 4);
            let mut boundaries = [p; 3];
            boundaries[axis] = [Boundary::WALL; 2];
            let drive = Drive { faces: vec![(axis, 1, swing(0.5))], force: Vec::new() };
            let mut space = stepper(grid(axes, boundaries), 0.05, scheme, viscous, drive);
            (0..50).for_each(|_| space.step(0.01, None));
            if axis == 1 {
                (0..50).for_each(|_| plane.step(0.01, None));
            }
            for k in 0..16_isize {
                let (u, v) = (&plane.state().velocity[0], &space.state().velocity[0]);
                let at = if axis == 1 { [1, k, 2] } else { [1, 2, k] };
                let wrong = u[plane.grid().index([1, k])] - v[space.grid().index(at)];
                assert!(wrong.abs() < 1e-13, "{scheme:?} {viscous:?}, axis {axis}, {k}: {wrong:e}");
            }
        }
    }
}

/// A force gives its whole impulse, whatever the steps; a flow rate is held at each end of a step.
#[test]
fn an_impulse_is_complete_and_a_mean_is_kept() {
    let force = OverTime::table(vec![(0.1, [1.0, 0.0, 0.0]), (0.33, [-2.0, 0.0, 3.0]), (0.7, [0.0; 3])]);
    for scheme in SCHEMES {
        let periodic = grid([uniform(1.0, 6), uniform(1.0, 8)], [[Boundary::Periodic; 2]; 2]);
        let constant = OverTime::from([0.5, 0.0, 0.0]);
        let drive = Drive { faces: Vec::new(), force: vec![constant, force.clone()] };
        let mut s = stepper(periodic, 0.1, scheme, Viscous::Implicit, drive);
        (0..9).for_each(|_| s.step(0.1, None));
        for (d, c) in [(0, 0), (1, 2)] {
            let given = force.integral(0.9)[c] + if c == 0 { 0.45 } else { 0.0 };
            let has = momentum(s.grid(), d, &s.state().velocity[d]);
            assert!((has - given).abs() < 1e-13, "{scheme:?}: {has} of {given}");
        }
        for viscous in BOTH {
            let mut s = stepper(layer(8), 0.1, scheme, viscous, Drive::default());
            let mean = OverTime::table(vec![(0.0, 0.0), (0.5, 2.0)]);
            s.prescribe_flow_rate(0, mean.clone());
            for k in 1..=20 {
                s.step(0.04, None);
                let wrong = momentum(s.grid(), 0, &s.state().velocity[0]) - mean.at(0.04 * f64::from(k));
                assert!(wrong.abs() < 1e-12, "{scheme:?} {viscous:?}, step {k}: {wrong:e}");
            }
        }
    }
}

/// A stream that pulses between slip walls is uniform at any time; between walls every cross-section lets
/// through what enters.
#[test]
fn an_inflow_that_pulses_goes_through_every_section() {
    let pulse = |axis: usize, sign: f64| {
        let mut of = [[0.0; 3]; 2];
        (of[0][2 * axis], of[1][2 * axis]) = (0.5 * sign, sign);
        OverTime::sine(Sine { amplitude: of[0], frequency: 0.5, phase: 0.3, offset: of[1] })
    };
    for (scheme, viscous) in SCHEMES.into_iter().flat_map(|scheme| BOTH.map(|viscous| (scheme, viscous))) {
        for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let velocity = pulse(axis, sign);
            let start = velocity.at(0.0);
            for (profile, wall) in
                [(Profile::Uniform, Boundary::FreeSlip), (Profile::Parabolic, Boundary::WALL)]
            {
                let inflow = Boundary::Inflow { velocity: [start[0], start[2]], profile };
                let mut boundaries = [[wall; 2]; 2];
                boundaries[axis] = [Boundary::Outflow; 2];
                boundaries[axis][side] = inflow;
                let mut axes = [uniform(1.0, 8), uniform(1.0, 8)];
                axes[axis] = uniform(2.0, 16);
                let drive = Drive { faces: vec![(axis, side, velocity.clone())], force: Vec::new() };
                let mut s = stepper(grid(axes, boundaries), 0.05, scheme, viscous, drive);
                set_component(&s.grid().clone(), axis, &mut s.state_mut().velocity[axis], |_| {
                    start[2 * axis]
                });
                s.project_velocity();
                for _ in 0..40 {
                    s.step(0.02, None);
                    let now = velocity.at(s.state().time)[2 * axis];
                    let (g, u) = (s.grid(), &s.state().velocity[axis]);
                    let mean = mean_velocity(g, axis, u);
                    assert!(
                        (mean - now).abs() < 1e-11,
                        "{scheme:?} {viscous:?} {axis} {side}: {mean} for {now}"
                    );
                    if profile == Profile::Uniform {
                        let wrong = error(g, axis, u, |_| now);
                        assert!(wrong < 1e-11, "{scheme:?} {viscous:?} {axis} {side}: {wrong:e}");
                    }
                }
            }
        }
    }
}

/// What is put back goes on in the same bits: the walls follow the time of the state.
#[test]
fn a_restored_state_goes_on() {
    for (scheme, viscous) in SCHEMES.into_iter().flat_map(|scheme| BOTH.map(|viscous| (scheme, viscous))) {
        let mut s = stepper(layer(8), 0.05, scheme, viscous, wall(1, swing(0.5)));
        (0..5).for_each(|_| s.step(0.02, None));
        let saved = s.state().clone();
        (0..5).for_each(|_| s.step(0.02, None));
        let end = s.state().velocity.clone();
        let mut other = stepper(layer(8), 0.05, scheme, viscous, wall(1, swing(0.5)));
        for s in [&mut s, &mut other] {
            put_back(s, &saved);
            (0..5).for_each(|_| s.step(0.02, None));
            assert!(s.state().velocity == end, "{scheme:?} {viscous:?}");
        }
    }
}
