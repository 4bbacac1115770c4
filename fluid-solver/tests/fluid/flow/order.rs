//! Order in space and time on periodic exact solutions.

use crate::flow::common::{SCHEMES, distance, error, grid, observed_order, stepper, uniform};
use fluid_solver::boundary::Boundary;
use fluid_solver::field::set_component;
use fluid_solver::scheme::{Scheme, Viscous};
use fluid_solver::step::Stepper;
use std::f64::consts::TAU;

const NU: f64 = 0.05;

/// Taylor & Green (1937) in the plane: u = cos x sin z, w = −sin x cos z, times e^{−2νt}.
fn taylor_green(n: usize, scheme: Scheme) -> Stepper<2> {
    let p = [Boundary::Periodic; 2];
    let mut s = stepper(grid([uniform(TAU, n), uniform(TAU, n)], [p, p]), NU, scheme);
    let g = s.grid().clone();
    let state = s.state_mut();
    set_component(&g, 0, &mut state.velocity[0], |[x, z]| x.cos() * z.sin());
    set_component(&g, 1, &mut state.velocity[1], |[x, z]| -x.sin() * z.cos());
    s
}

/// Second order in space: dt = 0.005 makes the error in time (1e-6) negligible.
#[test]
fn taylor_green_converges_in_space() {
    for scheme in SCHEMES {
        let errors = [16, 32, 64].map(|n| {
            let mut s = taylor_green(n, scheme);
            (0..200).for_each(|_| s.step(0.005, None));
            let decay = (-2.0 * NU * s.state().time).exp();
            let exact = |[x, z]: [f64; 2]| decay * x.cos() * z.sin();
            error(s.grid(), 0, &s.state().velocity[0], exact)
        });
        assert!(observed_order("Taylor-Green, space", &errors) > 1.9);
    }
}

/// A flow with all nonlinear terms alive (a Taylor–Green vortex plus a shear) against itself with a
/// 16 times smaller step, on one grid: order in time of velocity and pressure.
#[test]
fn order_in_time_is_two_with_pressure() {
    for scheme in SCHEMES {
        for viscous in [Viscous::Implicit, Viscous::Explicit] {
            let run = |steps: usize| {
                let mut s = perturbed(scheme, viscous);
                (0..steps).for_each(|_| s.step(0.8 / steps as f64, None));
                s
            };
            let reference = run(640);
            let errors = |f: &dyn Fn(&Stepper<2>) -> Vec<f64>| {
                [10, 20, 40].map(|n| distance(reference.grid(), 0, &f(&run(n)), &f(&reference)))
            };
            let u = errors(&|s| s.state().velocity[0].clone());
            let p = errors(&|s| s.state().pressure.clone());
            let label = format!("{scheme:?} {viscous:?}");
            assert!(observed_order(&format!("{label}: velocity"), &u) > 1.9);
            // The pressure belongs to the middle of the last stage: first order in the distance of
            // that instant from the end, second once both runs are compared at their own instants.
            assert!(observed_order(&format!("{label}: pressure"), &p) > 0.9);
        }
    }
}

/// Taylor–Green plus a second vortex, so that convection does not reduce to a gradient.
fn perturbed(scheme: Scheme, viscous: Viscous) -> Stepper<2> {
    let base = taylor_green(32, scheme);
    let options = fluid_solver::scheme::Options { viscous, ..base.options().clone() };
    let mut s = Stepper::new(base.grid().clone(), options);
    let g = s.grid().clone();
    let state = s.state_mut();
    set_component(&g, 0, &mut state.velocity[0], |[x, z]| x.cos() * z.sin() + 0.5 * (2.0 * z).sin());
    set_component(&g, 1, &mut state.velocity[1], |[x, z]| -x.sin() * z.cos() + 0.5 * x.cos());
    s.project_velocity();
    s
}

/// Arnold–Beltrami–Childress flow, exact in space: u = (sin z + cos y, sin x + cos z,
/// sin y + cos x) e^{−νt}. Second order.
#[test]
fn beltrami_flow_converges_in_space() {
    let errors = [12, 24].map(|n| {
        let p = [Boundary::Periodic; 2];
        let g = grid([uniform(TAU, n), uniform(TAU, n), uniform(TAU, n)], [p; 3]);
        let mut s = stepper(g.clone(), NU, SCHEMES[0]);
        let exact = |d: usize, x: [f64; 3]| x[(d + 2) % 3].sin() + x[(d + 1) % 3].cos();
        for d in 0..3 {
            set_component(&g, d, &mut s.state_mut().velocity[d], |x| exact(d, x));
        }
        (0..20).for_each(|_| s.step(0.025, None));
        let decay = (-NU * s.state().time).exp();
        (0..3).map(|d| error(&g, d, &s.state().velocity[d], |x| decay * exact(d, x))).sum()
    });
    assert!(observed_order("Beltrami, space", &errors) > 1.9);
}

/// Adams–Bashforth keeps its order when the step changes all the time (ratio 2 up and down).
#[test]
fn variable_steps_keep_second_order() {
    let run = |pairs: usize| {
        let mut s = perturbed(Scheme::AdamsBashforth2, Viscous::Implicit);
        let dt = 0.8 / (3 * pairs) as f64;
        for _ in 0..pairs {
            s.step(dt, None);
            s.step(2.0 * dt, None);
        }
        s
    };
    let reference = run(400);
    let errors = [8, 16, 32].map(|n| {
        let (a, b) = (run(n), &reference);
        distance(b.grid(), 0, &a.state().velocity[0], &b.state().velocity[0])
    });
    assert!(observed_order("variable step", &errors) > 1.9);
}
