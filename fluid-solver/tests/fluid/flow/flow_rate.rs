//! A flow rate that is held: the mean is kept to round-off, the gradient is that of the exact flow.

use crate::flow::common::{SCHEMES, distance, error, grid, observed_order, pipe, put_back, uniform};
use crate::flow::reference::largest_divergence;
use fluid_solver::boundary::Boundary;
use fluid_solver::engines::HasEngine;
use fluid_solver::field::set_component;
use fluid_solver::grid::Grid;
use fluid_solver::measure::momentum;
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;
use std::f64::consts::PI;

/// A stepper that holds the mean velocity 2 along `axis`, from rest.
fn held<const D: usize>(g: Grid<D>, nu: f64, scheme: Scheme, viscous: Viscous, axis: usize) -> Stepper<D>
where
    Grid<D>: HasEngine<D>,
{
    let options = Options { viscosity: nu, scheme, viscous, convection: true, body_force: [0.0; D] };
    let mut s = Stepper::new(g, options);
    s.prescribe_flow_rate(axis, 2.0);
    s
}

/// Steps, each of which keeps the mean and continuity.
fn run<const D: usize>(s: &mut Stepper<D>, axis: usize, volume: f64, steps: usize, dt: f64) {
    for _ in 0..steps {
        s.step(dt, None);
        let mean = momentum(s.grid(), axis, &s.state().velocity[axis]) / volume;
        assert!((mean - 2.0).abs() < 1e-12, "mean {mean}");
    }
    assert!(largest_divergence(s.grid(), &s.state().velocity) < 1e-11);
}

/// Plane channel, either axis: in the end the parabola, and −∂p/∂x/ρ = 12 ν U/H², second order.
#[test]
fn channel_flow_of_given_mean_has_its_gradient() {
    for (axis, scheme) in [(0, SCHEMES[0]), (1, SCHEMES[0]), (0, SCHEMES[1])] {
        let mut gradients = Vec::new();
        let errors = [8, 16, 32].map(|n| {
            let mut axes = [uniform(1.0, n), uniform(1.0, n)];
            axes[axis] = uniform(1.0, 4);
            let mut boundaries = [[Boundary::WALL; 2]; 2];
            boundaries[axis] = [Boundary::Periodic; 2];
            let mut s = held(grid(axes, boundaries), 0.5, scheme, Viscous::Implicit, axis);
            // The slowest mode decays like e^{−4π²νt} = e^{−79}.
            run(&mut s, axis, 1.0, 400, 0.01);
            let force = s.flow_rate().expect("it is held").acceleration();
            gradients.push((force / (12.0 * 0.5 * 2.0) - 1.0).abs());
            error(s.grid(), axis, &s.state().velocity[axis], |x| 12.0 * x[1 - axis] * (1.0 - x[1 - axis]))
        });
        assert!(observed_order("held channel", &errors) > 1.9);
        assert!(observed_order("its gradient", &gradients) > 1.9);
    }
}

/// Tube: 8 ν U/R².
#[test]
fn tube_flow_of_given_mean_has_its_gradient() {
    for viscous in [Viscous::Implicit, Viscous::Explicit] {
        let errors = [8, 16, 32].map(|n| {
            let mut s = held(pipe(uniform(1.0, n), uniform(1.0, 4)), 1.0, SCHEMES[0], viscous, 1);
            run(&mut s, 1, PI, 8 * n * n, 0.25 / (n * n) as f64);
            (s.flow_rate().expect("it is held").acceleration() / 16.0 - 1.0).abs()
        });
        assert!(observed_order(&format!("held tube, {viscous:?}"), &errors) > 1.9);
    }
}

/// In space, disturbed, with both treatments of viscosity: kept whatever else happens; and the force
/// that has been at work is what makes the same flow with the gradient given.
#[test]
fn force_that_holds_is_the_force_that_drives() {
    let p = [Boundary::Periodic; 2];
    let g: Grid<3> = grid(
        [uniform(2.0, 12), uniform(1.0, 10), uniform(1.0, 8)],
        [p, [Boundary::WALL, Boundary::FreeSlip], p],
    );
    for scheme in SCHEMES {
        for viscous in [Viscous::Implicit, Viscous::Explicit] {
            let disturb = |s: &mut Stepper<3>| {
                for d in 0..3 {
                    let shape = |x: [f64; 3]| (PI * (x[0] + 2.0 * x[2] + d as f64)).sin() * x[1];
                    set_component(&g, d, &mut s.state_mut().velocity[d], shape);
                }
                s.project_velocity();
            };
            let mut s = held(g.clone(), 0.05, scheme, viscous, 0);
            let mut given = Stepper::new(g.clone(), s.options().clone());
            disturb(&mut s);
            disturb(&mut given);
            run(&mut s, 0, 2.0, 1, 0.01);
            // From the second step on it is smooth: one force over all stages of Adams–Bashforth.
            if scheme == Scheme::AdamsBashforth2 {
                put_back(&mut given, s.state());
                s.step(0.01, None);
                given.set_body_force([s.flow_rate().expect("it is held").acceleration(), 0.0, 0.0]);
                given.step(0.01, None);
                for d in 0..3 {
                    let (a, b) = (&s.state().velocity[d], &given.state().velocity[d]);
                    let apart = distance(&g, d, a, b);
                    assert!(apart < 1e-13, "{viscous:?} component {d}: {apart:e}");
                }
            }
            run(&mut s, 0, 2.0, 10, 0.01);
        }
    }
}

/// The number of threads changes no bit.
#[test]
fn threads_do_not_change_a_held_flow() {
    let g: Grid<2> =
        grid([uniform(1.0, 256), uniform(1.0, 256)], [[Boundary::Periodic; 2], [Boundary::WALL; 2]]);
    let state = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of threads").install(|| {
            let mut s = held(g.clone(), 0.01, SCHEMES[0], Viscous::Implicit, 0);
            (0..3).for_each(|_| s.step(1e-3, None));
            s.state().clone()
        })
    };
    let one = state(1);
    crate::flow::common::assert_same(&state(2), &one);
    crate::flow::common::assert_same(&state(4), &one);
}
