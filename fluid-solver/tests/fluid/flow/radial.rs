//! Axisymmetric flow against exact solutions.

use crate::flow::common::{
    SCHEMES, error, kinetic_energy, laplacian_of, observed_order, pipe, stepper, uniform,
};
use fluid_solver::axis::AxisSpec;
use fluid_solver::field::set_component;
use fluid_solver::grid::Grid;
use fluid_solver::measure::momentum;

/// Bessel function J₀ by its power series; x ≤ 3 needs 15 terms.
fn bessel_j0(x: f64) -> f64 {
    let mut term = 1.0;
    (1..16).fold(1.0, |sum, k| {
        term *= -0.25 * x * x / f64::from(k * k);
        sum + term
    })
}

/// First zero of J₀ (Abramowitz & Stegun 1964, table 9.5).
const J01: f64 = 2.404_825_557_695_773;

/// The kind of grid of Izard et al. (2014) on 0..1: equal cells up to 0.25, then growing.
fn growing(cells: usize) -> AxisSpec {
    AxisSpec::Growing { start: 0.0, core_end: 0.25, width: 0.5 / cells as f64, end: 1.0, cells }
}

/// Hagen–Poiseuille u = G (R² − r²)/4ν. The finite volumes reproduce the parabola exactly but for
/// the wall, met half a cell away: a constant excess G Δr²/16ν (linear extrapolation over half a
/// cell). Round-off, since ν t/R² = 8 leaves e^{−46} of the start.
#[test]
fn hagen_poiseuille_is_the_discrete_parabola() {
    for n in [8, 16] {
        for scheme in SCHEMES {
            let mut s = stepper(pipe(uniform(1.0, n), uniform(0.5, 4)), 0.1, scheme);
            s.set_body_force([0.0, 1.0]);
            (0..400).for_each(|_| s.step(0.2, None));
            let excess = 1.0 / (16.0 * 0.1 * (n * n) as f64);
            let exact = |[r, _]: [f64; 2]| (1.0 - r * r) / 0.4 + excess;
            let wrong = error(s.grid(), 1, &s.state().velocity[1], exact);
            assert!(wrong < 1e-11, "{n} cells: {wrong:e}");
        }
    }
}

/// Error of u_z = J₀(j₀₁ r) exp(−ν j₀₁² t) at ν t = 0.1.
fn bessel_error(grid: Grid<2>, scheme: fluid_solver::scheme::Scheme) -> f64 {
    let mut s = stepper(grid.clone(), 0.1, scheme);
    set_component(&grid, 1, &mut s.state_mut().velocity[1], |[r, _]| bessel_j0(J01 * r));
    (0..100).for_each(|_| s.step(0.01, None));
    let decay = (-0.1 * J01 * J01 * s.state().time).exp();
    error(&grid, 1, &s.state().velocity[1], |[r, _]| decay * bessel_j0(J01 * r))
}

/// Second order on equal cells and on growing cells.
#[test]
fn bessel_mode_decays_at_second_order() {
    for scheme in SCHEMES {
        let equal = [8, 16, 32].map(|n| bessel_error(pipe(uniform(1.0, n), uniform(1.0, 4)), scheme));
        assert!(observed_order("Bessel mode, equal", &equal) > 1.9);
        let grown = [16, 32, 64].map(|n| bessel_error(pipe(growing(n), uniform(1.0, 4)), scheme));
        assert!(observed_order("Bessel mode, growing", &grown) > 1.9);
    }
}

/// Stokes flow in the pipe that uses every term: stream function ψ = r² (1 − r²)² sin(kz)
/// gives u_r = −∂ψ/∂z / r, u_z = ∂ψ/∂r / r; the discrete ν ∇²u, with −u_r/r², against the exact one.
#[test]
fn vector_laplacian_is_second_order() {
    let k = std::f64::consts::TAU;
    // u_r = −k (r − 2r³ + r⁵) cos kz; ∇²u_r − u_r/r² from r^m → (m² − 1) r^{m−2}, −k² u_r.
    let radial = |r: f64| r - 2.0 * r.powi(3) + r.powi(5);
    let radial_laplacian = |r: f64| -16.0 * r + 24.0 * r.powi(3) - k * k * radial(r);
    for spec in [uniform as fn(f64, usize) -> AxisSpec, |_, n| growing(n)] {
        let errors = [16, 32, 64].map(|n| {
            let grid = pipe(spec(1.0, n), uniform(1.0, n));
            let mut u = grid.new_field();
            set_component(&grid, 0, &mut u, |[r, z]| -k * radial(r) * (k * z).cos());
            let out = laplacian_of(&grid, 0, &u);
            error(&grid, 0, &out, |[r, z]| -k * radial_laplacian(r) * (k * z).cos())
        });
        assert!(observed_order("radial Laplacian", &errors) > 1.9);
    }
}

/// A jet around r = 0 in a closed box loses momentum only through the walls and the pressure, and
/// the energy only falls: checks signs of the axisymmetric convection in a strongly nonlinear flow.
#[test]
fn energy_only_falls_without_forcing() {
    let mut s = stepper(pipe(growing(32), uniform(1.0, 48)), 1e-3, SCHEMES[0]);
    let grid = s.grid().clone();
    set_component(&grid, 1, &mut s.state_mut().velocity[1], |[r, z]| {
        (-20.0 * r * r).exp() * (1.0 + 0.3 * (std::f64::consts::TAU * z).sin())
    });
    s.project_velocity();
    let mut energy = kinetic_energy(&grid, &s.state().velocity);
    let start = momentum(&grid, 1, &s.state().velocity[1]);
    for _ in 0..200 {
        s.step(0.01, None);
        let now = kinetic_energy(&grid, &s.state().velocity);
        assert!(now < energy, "energy rose from {energy} to {now}");
        energy = now;
    }
    let end = momentum(&grid, 1, &s.state().velocity[1]);
    // The wall, at r = 1, has hardly been felt: e^{−20} at the start, ν t = 0.002.
    assert!((end / start - 1.0).abs() < 0.02, "momentum {start} → {end}");
}

/// The grid of Izard, Bonometti & Lacaze (2014, §3.1): 128 cells over 20 D, D/20 up to 1.5 D.
#[test]
fn seed_grid_has_its_cells_and_impossible_ones_are_refused() {
    let izard = |cells| AxisSpec::Growing { start: 0.0, core_end: 1.5, width: 0.05, end: 20.0, cells };
    let grid = pipe(izard(128), uniform(40.0, 800));
    let widths = &grid.axes[0].widths;
    assert_eq!(widths.len(), 128);
    assert!(widths[..30].iter().all(|w| (w - 0.05).abs() < 1e-12));
    let growth = widths[31] - widths[30];
    assert!(growth > 0.0);
    assert!(widths[30..].windows(2).all(|w| (w[1] - w[0] - growth).abs() < 1e-12));
    assert!((grid.axes[0].faces[128] - 20.0).abs() < 1e-12);
    let make = |cells| fluid_solver::axis::Axis::new(0, &izard(cells), false, true);
    let refused = |cells| make(cells).expect_err("no such axis").to_string();
    assert!(refused(500).contains("too many for widths that grow outwards: give at most 400"));
    assert!(refused(30).contains("must hold a whole number of cells of width 0.05"));
}
