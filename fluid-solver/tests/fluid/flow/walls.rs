//! Flows driven or held by walls, against exact solutions.

use crate::flow::common::{SCHEMES, error, grid, observed_order, stepper, uniform};
use crate::flow::reference::largest_divergence;
use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::scheme::Scheme;
use std::f64::consts::PI;

/// Couette start-up: u/U = z/h + Σ 2(−1)ⁿ/(nπ) sin(nπz/h) e^{−n²π²νt/h²}.
fn couette(z: f64, nu_t: f64) -> f64 {
    let series: f64 = (1..60)
        .map(|n| {
            let k = PI * f64::from(n);
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            2.0 * sign / k * (k * z).sin() * (-k * k * nu_t).exp()
        })
        .sum();
    z + series
}

/// Start-up of a sheared layer, equal cells, second order. dt ∝ Δz² keeps Crank–Nicolson's ringing
/// from the impulsive start damped, so that the error is that of space.
#[test]
fn couette_start_up_follows_the_series() {
    for scheme in SCHEMES {
        let errors = [8, 16, 32].map(|n| {
            let lid = Boundary::NoSlip { velocity: [1.0, 0.0] };
            let p = Boundary::Periodic;
            let g = grid([uniform(1.0, 4), uniform(1.0, n)], [[p, p], [Boundary::WALL, lid]]);
            let mut s = stepper(g.clone(), 0.1, scheme);
            let steps = n * n;
            (0..steps).for_each(|_| s.step(1.0 / steps as f64, None));
            error(&g, 0, &s.state().velocity[0], |[_, z]| couette(z, 0.1))
        });
        assert!(observed_order("Couette start-up", &errors) > 1.9);
    }
}

/// Shear between walls that move both ways, along x and (in space) along y, is linear exactly;
/// stretched cells do not matter. Round-off.
#[test]
fn steady_shear_is_exact_on_any_grid() {
    let stretched = AxisSpec::Faces(vec![0.0, 0.1, 0.25, 0.45, 0.7, 1.0]);
    let p = [Boundary::Periodic; 2];
    let walls = [-1.0, 1.0].map(|u| Boundary::NoSlip { velocity: [u, 0.5 * u, 0.0] });
    let g = grid([uniform(1.0, 4), uniform(1.0, 6), stretched], [p, p, walls]);
    for scheme in SCHEMES {
        let mut s = stepper(g.clone(), 1.0, scheme);
        (0..400).for_each(|_| s.step(0.05, None));
        for (d, share) in [(0, 1.0), (1, 0.5)] {
            let exact = |[_, _, z]: [f64; 3]| share * (2.0 * z - 1.0);
            // The mirrored ghost cell makes a linear profile exact at the wall as well.
            assert!(error(&g, d, &s.state().velocity[d], exact) < 1e-12);
        }
    }
}

/// Channel in space with free-slip top: film u = (G/ν)(z − z²/2), discrete excess G Δz²/8ν at the
/// no-slip wall only (linear extrapolation over half a cell).
#[test]
fn film_flow_in_space_is_the_discrete_parabola() {
    let n = 12;
    let p = [Boundary::Periodic; 2];
    let z = [Boundary::WALL, Boundary::FreeSlip];
    let g = grid([uniform(1.0, 6), uniform(1.0, 4), uniform(1.0, n)], [p, p, z]);
    let mut s = stepper(g.clone(), 0.5, SCHEMES[0]);
    s.set_body_force([1.0, 0.0, 0.0]);
    (0..400).for_each(|_| s.step(0.5, None));
    let excess = 1.0 / (8.0 * 0.5 * (n * n) as f64);
    let exact = |[_, _, z]: [f64; 3]| (z - 0.5 * z * z) / 0.5 + excess;
    let wrong = error(&g, 0, &s.state().velocity[0], exact);
    assert!(wrong < 1e-12, "{wrong:e}");
}

/// Complex hyperbolic cosine of a + ib.
fn cosh(a: f64, b: f64) -> [f64; 2] {
    [a.cosh() * b.cos(), a.sinh() * b.sin()]
}

/// Plane Womersley flow between walls at z = ±h for the force K cos ωt, K = h = 1:
/// u = Re[(1/iω)(1 − cosh(λz)/cosh(λh)) e^{iωt}], λ = √(iω/ν) (Womersley 1955).
fn womersley(z: f64, t: f64, omega: f64, nu: f64) -> f64 {
    let l = (0.5 * omega / nu).sqrt();
    let (c, d) = (cosh(l * z, l * z), cosh(l, l));
    let norm = d[0] * d[0] + d[1] * d[1];
    let ratio = [(c[0] * d[0] + c[1] * d[1]) / norm, (c[1] * d[0] - c[0] * d[1]) / norm];
    let (sin, cos) = (omega * t).sin_cos();
    ((1.0 - ratio[0]) * sin - ratio[1] * cos) / omega
}

/// Oscillating channel after the transient (νt = 4 leaves e^{−10}; the run starts on the exact
/// solution): Δz and dt halved together, second order, force taken at the middle of the step.
#[test]
fn womersley_flow_converges() {
    let (nu, omega) = (0.2, 2.0);
    for scheme in SCHEMES {
        let errors = [8, 16, 32].map(|n| {
            let p = [Boundary::Periodic; 2];
            let z = AxisSpec::Uniform { start: -1.0, end: 1.0, cells: n };
            let g = grid([uniform(1.0, 4), z], [p, [Boundary::WALL; 2]]);
            let mut s = stepper(g.clone(), nu, scheme);
            let u = &mut s.state_mut().velocity[0];
            fluid_solver::field::set_component(&g, 0, u, |[_, z]| womersley(z, 0.0, omega, nu));
            let steps = 20 * n;
            let dt = 20.0 / steps as f64;
            for k in 0..steps {
                s.set_body_force([(omega * (k as f64 + 0.5) * dt).cos(), 0.0]);
                s.step(dt, None);
            }
            error(&g, 0, &s.state().velocity[0], |[_, z]| womersley(z, 20.0, omega, nu))
        });
        assert!(observed_order("Womersley", &errors) > 1.9);
    }
}

/// A uniform force in a closed box is balanced by pressure: the fluid comes to rest. The impulsive
/// start leaves a slip layer that decays like e^{−ν π² (1 + 1/4) t}, here e^{−49}; then round-off.
#[test]
fn closed_box_comes_to_rest_under_gravity() {
    for scheme in SCHEMES {
        let g = grid([uniform(1.0, 10), uniform(2.0, 16)], [[Boundary::WALL; 2]; 2]);
        let mut s = stepper(g.clone(), 0.2, scheme);
        s.set_body_force([1.0, -9.81]);
        (0..400).for_each(|_| s.step(0.05, None));
        for d in 0..2 {
            let speed = error(&g, d, &s.state().velocity[d], |_| 0.0);
            assert!(speed < 1e-13, "{scheme:?} component {d}: {speed:e}");
        }
    }
}

/// Lid-driven cavity at Re = 100: smallest u on the vertical mid-line −0.21090 at y = 0.4531
/// (Ghia, Ghia & Shin 1982, table I). 64² cells, second order: within 1 %.
#[test]
fn lid_driven_cavity_agrees_with_ghia() {
    let lid = Boundary::NoSlip { velocity: [1.0, 0.0] };
    let g = grid([uniform(1.0, 64), uniform(1.0, 64)], [[Boundary::WALL; 2], [Boundary::WALL, lid]]);
    let mut s = stepper(g.clone(), 0.01, Scheme::AdamsBashforth2);
    (0..2500).for_each(|_| s.step(0.01, None));
    let u = &s.state().velocity[0];
    let lowest = (0..64).map(|j| u[g.index([32, j])]).fold(0.0_f64, f64::min);
    assert!((lowest / -0.21090 - 1.0).abs() < 0.01, "lowest u = {lowest}");
    assert!(largest_divergence(&g, &s.state().velocity) < 1e-12);
}
