//! The step in space against the same step written term by term, field by field.

use crate::common::{Random, SCHEMES, grid, space_grids, uniform};
use fluid_solver::advect::Advection;
use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::{Boundary, fill_scalar, fill_velocity};
use fluid_solver::diffuse::Diffusion;
use fluid_solver::field::{State, for_each_unknown};
use fluid_solver::grid::Grid;
use fluid_solver::helmholtz::{Helmholtz, Unknown, Write};
use fluid_solver::project::Projection;
use fluid_solver::scheme::{Stage, Viscous};
use fluid_solver::step::{Options, Stepper};

/// The step as its equations say, with the pressure gradient in every predictor.
struct Reference {
    grid: Grid<3>,
    options: Options<3>,
    state: State<3>,
    advection: Advection<3>,
    diffusion: [Diffusion<3>; 3],
    projection: Projection<3>,
    viscous: [Helmholtz<3>; 3],
    pressure: Helmholtz<3>,
}

impl Reference {
    fn new(grid: &Grid<3>, options: &Options<3>) -> Self {
        Self {
            state: State::at_rest(grid),
            advection: Advection::new(grid),
            diffusion: [0, 1, 2].map(|d| Diffusion::new(grid, d)),
            projection: Projection::new(grid),
            viscous: [0, 1, 2].map(|d| Helmholtz::new(grid, Unknown::Component(d))),
            pressure: Helmholtz::new(grid, Unknown::Pressure),
            grid: grid.clone(),
            options: options.clone(),
        }
    }

    fn fill(&mut self) {
        for (d, u) in self.state.velocity.iter_mut().enumerate() {
            fill_velocity(&self.grid, d, u);
        }
    }

    /// Every row of `field`, with its number.
    fn rows(grid: &Grid<3>, field: &mut [f64], mut task: impl FnMut(usize, &mut [f64])) {
        for row in 0..grid.rows() {
            task(row, &mut field[grid.row(row)..][..grid.cells[0]]);
        }
    }

    fn step(&mut self, dt: f64, force: Option<&[Vec<f64>; 3]>, between: impl Fn(&mut [Vec<f64>; 3])) {
        let scheme = self.options.scheme;
        let every = scheme.projects_every_stage();
        self.fill();
        for k in 0..scheme.stages() {
            let stage = scheme.stage(k, dt, self.state.previous_dt);
            self.predict(stage, dt, force);
            if k + 1 == scheme.stages() {
                between(&mut self.state.velocity);
            }
            self.fill();
            if every {
                self.project(2.0 * stage.alpha * dt, stage.alpha / (2.0 * stage.alpha));
            } else if k + 1 == scheme.stages() {
                self.project(dt, stage.alpha);
            }
        }
        self.state.previous_dt = dt;
    }

    fn predict(&mut self, stage: Stage, dt: f64, force: Option<&[Vec<f64>; 3]>) {
        let Self { grid, options, state, advection, diffusion, projection, viscous, .. } = self;
        let nu = options.viscosity;
        let share = 2.0 * stage.alpha * dt;
        let implicit = options.viscous == Viscous::Implicit;
        let mut rhs = grid.new_vector();
        for d in 0..3 {
            let u = &state.velocity;
            let history = &mut state.history[d];
            Self::rows(grid, &mut rhs[d], |row, rhs| {
                let old = &mut history[grid.row(row)..][..rhs.len()];
                let mut new = vec![0.0; rhs.len()];
                if options.convection {
                    advection.add_row(grid, d, u, row, &mut new);
                }
                if !implicit {
                    diffusion[d].add_row(grid, nu, &u[d], row, &mut new);
                }
                for i in 0..rhs.len() {
                    let f = force.map_or(0.0, |f| f[d][grid.row(row) + i]);
                    rhs[i] = dt * (stage.gamma * new[i] + stage.zeta * old[i]);
                    rhs[i] += share * (options.body_force[d] + f);
                }
                old.copy_from_slice(&new);
                if implicit {
                    diffusion[d].add_row(grid, share * nu, &u[d], row, rhs);
                }
                projection.add_gradient_row(grid, d, -share, &state.pressure, row, rhs);
            });
        }
        for d in 0..3 {
            let u = &mut state.velocity[d];
            if implicit {
                viscous[d].solve(grid, 1.0, stage.alpha * nu * dt, &mut rhs[d], u, Write::Add);
            } else {
                for_each_unknown(grid, d, |_, index| u[index] += rhs[d][index]);
            }
        }
    }

    /// `half`: what multiplies ν ∇·u* in the pressure with implicit viscosity.
    fn project(&mut self, weight: f64, half: f64) {
        let Self { grid, options, state, projection, pressure, .. } = self;
        let (mut rhs, mut phi) = (grid.new_field(), grid.new_field());
        let implicit = options.viscous == Viscous::Implicit;
        let correction = if implicit { half * options.viscosity } else { 0.0 };
        Self::rows(grid, &mut rhs, |row, rhs| {
            projection.divergence_row(grid, &state.velocity, row, rhs);
            for (i, r) in rhs.iter_mut().enumerate() {
                state.pressure[grid.row(row) + i] -= correction * *r;
                *r /= weight;
            }
        });
        pressure.solve(grid, 0.0, -1.0, &mut rhs, &mut phi, Write::Set);
        fill_scalar(grid, &mut phi);
        for d in 0..3 {
            Self::rows(grid, &mut state.velocity[d], |row, u| {
                projection.add_gradient_row(grid, d, -weight, &phi, row, u);
            });
        }
        state.pressure.iter_mut().zip(&phi).for_each(|(p, phi)| *p += phi);
        fill_scalar(grid, &mut state.pressure);
        self.fill();
    }
}

/// Largest difference of velocity and of pressure, each relative to its largest value.
fn differences(grid: &Grid<3>, a: &State<3>, b: &State<3>) -> [f64; 2] {
    let mut u = [0.0_f64; 2];
    for d in 0..3 {
        for_each_unknown(grid, d, |_, at| {
            u[0] = u[0].max((a.velocity[d][at] - b.velocity[d][at]).abs());
            u[1] = u[1].max(b.velocity[d][at].abs());
        });
    }
    let mut p = [0.0_f64; 2];
    for row in 0..grid.rows() {
        for at in grid.row(row)..grid.row(row) + grid.cells[0] {
            p[0] = p[0].max((a.pressure[at] - b.pressure[at]).abs());
            p[1] = p[1].max(b.pressure[at].abs());
        }
    }
    assert!(u[1] > 0.1 && p[1] > 0.0, "the flow must be alive: {u:?} {p:?}");
    [u[0] / u[1], p[0] / p[1]]
}

/// Options of the comparison.
fn options(scheme: fluid_solver::scheme::Scheme, viscous: Viscous) -> Options<3> {
    Options { viscosity: 0.02, scheme, viscous, convection: true, body_force: [0.3, -0.2, 0.1] }
}

/// Both codes from the same divergence-free random velocity.
fn pair(grid: &Grid<3>, options: &Options<3>) -> (Stepper<3>, Reference) {
    let mut stepper = Stepper::new(grid.clone(), options.clone());
    for d in 0..3 {
        Random(5 + d as u64).fill(grid, d, &mut stepper.state_mut().velocity[d]);
    }
    stepper.project_velocity();
    let mut reference = Reference::new(grid, options);
    reference.state.velocity.clone_from(&stepper.state().velocity);
    (stepper, reference)
}

/// A random force.
fn random_force(grid: &Grid<3>) -> [Vec<f64>; 3] {
    let mut force = grid.new_vector();
    for (d, f) in force.iter_mut().enumerate() {
        Random(50 + d as u64).fill(grid, d, f);
    }
    force
}

/// Grids of [`space_grids`], and one with moving walls, stretched, cut into several slabs.
fn grids() -> Vec<Grid<3>> {
    let mut grids = space_grids();
    let move_along = |velocity| Boundary::NoSlip { velocity };
    let faces = (0..=20).map(|k: i32| f64::from(k) * 0.05 + 0.002 * f64::from(k * k)).collect();
    grids.push(grid(
        [uniform(1.0, 15), uniform(1.2, 10), AxisSpec::Faces(faces)],
        [
            [move_along([0.0, 0.5, -0.3]), Boundary::FreeSlip],
            [Boundary::WALL, move_along([0.2, 0.0, 0.4])],
            [move_along([0.7, -0.6, 0.0]), Boundary::WALL],
        ],
    ));
    grids
}

/// Three steps of different length agree for every combination of boundaries, scheme and treatment
/// of viscosity, with and without a force. Sums in another order: round-off of some 20 operations.
#[test]
fn every_combination_agrees_with_the_equations() {
    for grid in grids() {
        let force = random_force(&grid);
        for scheme in SCHEMES {
            for viscous in [Viscous::Implicit, Viscous::Explicit] {
                for force in [None, Some(&force)] {
                    let (mut fast, mut slow) = pair(&grid, &options(scheme, viscous));
                    for dt in [2e-3, 3e-3, 1e-3] {
                        fast.step(dt, force);
                        slow.step(dt, force, |_| ());
                    }
                    let [u, p] = differences(&grid, fast.state(), &slow.state);
                    let forced = force.is_some();
                    let label = format!("{scheme:?} {viscous:?} forced {forced} {:?}", grid.boundaries);
                    assert!(u < 1e-13, "{label}: velocity {u:e}");
                    assert!(p < 1e-12, "{label}: pressure {p:e}");
                }
            }
        }
    }
}

/// What a caller does between predictor and projection sees the predictor with the pressure.
#[test]
fn forcing_before_the_projection_agrees() {
    let damp = |velocity: &mut [Vec<f64>; 3]| {
        velocity[0].iter_mut().step_by(3).for_each(|u| *u *= 0.5);
    };
    for grid in [&grids()[0], &grids()[124]] {
        for scheme in SCHEMES {
            for viscous in [Viscous::Implicit, Viscous::Explicit] {
                let (mut fast, mut slow) = pair(grid, &options(scheme, viscous));
                for dt in [2e-3, 3e-3] {
                    fast.step(dt, None);
                    slow.step(dt, None, |_| ());
                    fast.advance_without_projection(dt, None);
                    damp(&mut fast.state_mut().velocity);
                    fast.project();
                    slow.step(dt, None, damp);
                }
                let [u, p] = differences(grid, fast.state(), &slow.state);
                assert!(u < 1e-13, "{scheme:?} {viscous:?}: velocity {u:e}");
                assert!(p < 1e-12, "{scheme:?} {viscous:?}: pressure {p:e}");
            }
        }
    }
}
