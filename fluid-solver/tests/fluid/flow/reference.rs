//! The equations of the step, node by node as they are printed, and a step made of them.

use fluid_solver::field::{State, for_each_unknown};
use fluid_solver::grid::Grid;
use fluid_solver::halo::{fill_scalar, fill_velocity};
use fluid_solver::helmholtz::{Helmholtz, Unknown, Write};
use fluid_solver::scheme::{Options, Stage, Viscous};

/// Calls `visit` with the indices of every cell and its place in memory.
pub(crate) fn for_each_cell<const D: usize>(grid: &Grid<D>, mut visit: impl FnMut([usize; D], usize)) {
    for row in 0..grid.rows() {
        let rest = [0, row % grid.cells[1], row / grid.cells[1]];
        for i in 0..grid.cells[0] {
            visit(std::array::from_fn(|a| if a == 0 { i } else { rest[a] }), grid.row(row) + i);
        }
    }
}

/// −∇·(u u_d) at every unknown of component `d`: the flux through a face is the mean of the two mass
/// fluxes beside it, times the plain mean of the two velocities (Verstappen & Veldman 2003).
pub(crate) fn convection<const D: usize>(grid: &Grid<D>, d: usize, velocity: &[Vec<f64>; D]) -> Vec<f64> {
    let mut out = grid.new_field();
    let (own, s, u) = (&grid.axes[d], grid.stride(d), &velocity[d]);
    for_each_unknown(grid, d, |at, index| {
        let face = at[d];
        let below = if face > 0 { face - 1 } else { own.cells() - 1 };
        let along = |face: usize, i: usize| own.face_area[face] * u[i];
        let low = 0.25 * (along(below, index - s) + along(face, index)) * (u[index - s] + u[index]);
        let high = 0.25 * (along(face, index) + along(face + 1, index + s)) * (u[index] + u[index + s]);
        let mut sum = (high - low) / own.face_volume[face];
        for a in (0..D).filter(|a| *a != d) {
            let (axis, t, w) = (&grid.axes[a], grid.stride(a), &velocity[a]);
            let flux = |side: usize| {
                let here = index + side * t;
                let mass = own.cell_volume[below] * w[here - s] + own.cell_volume[face] * w[here];
                0.25 * axis.face_area[at[a] + side] * mass * (u[here - t] + u[here])
            };
            sum += (flux(1) - flux(0)) / (own.face_volume[face] * axis.cell_volume[at[a]]);
        }
        out[index] = -sum;
    });
    out
}

/// ∇²u at every unknown of component `d`; in the radial component it includes −u_r/r².
pub(crate) fn laplacian<const D: usize>(grid: &Grid<D>, d: usize, u: &[f64]) -> Vec<f64> {
    let mut out = grid.new_field();
    for_each_unknown(grid, d, |at, index| {
        for (a, k) in at.into_iter().enumerate() {
            let (axis, s) = (&grid.axes[a], grid.stride(a));
            let [lower, upper] = if a == d {
                let below = if k > 0 { k - 1 } else { axis.cells() - 1 };
                [below, k].map(|c| axis.centre_area[c] / (axis.face_volume[k] * axis.widths[c]))
            } else {
                [k, k + 1].map(|f| axis.face_area[f] / (axis.cell_volume[k] * axis.distances[f]))
            };
            out[index] += lower * (u[index - s] - u[index]) + upper * (u[index + s] - u[index]);
            if axis.radial && a == d {
                // u_r/r² in the form that leaves u_r ∝ r free of force
                out[index] -= axis.distances[k] / (axis.face_volume[k] * axis.faces[k]) * u[index];
            }
        }
    });
    out
}

/// ∂p/∂x_d at every unknown of component `d`.
pub(crate) fn gradient<const D: usize>(grid: &Grid<D>, d: usize, p: &[f64]) -> Vec<f64> {
    let mut out = grid.new_field();
    for_each_unknown(grid, d, |at, index| {
        out[index] = (p[index] - p[index - grid.stride(d)]) / grid.axes[d].distances[at[d]];
    });
    out
}

/// ∇·u in every cell.
pub(crate) fn divergence<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> Vec<f64> {
    let mut out = grid.new_field();
    for_each_cell(grid, |at, index| {
        out[index] = (0..D)
            .map(|a| {
                let (axis, k, u) = (&grid.axes[a], at[a], &velocity[a]);
                (axis.face_area[k + 1] * u[index + grid.stride(a)] - axis.face_area[k] * u[index])
                    / axis.cell_volume[k]
            })
            .sum();
    });
    out
}

/// Largest |∇·u| over all cells, 1/s. Halo and wall faces must be up to date.
pub(crate) fn largest_divergence<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> f64 {
    divergence(grid, velocity).iter().fold(0.0, |largest, x| largest.max(x.abs()))
}

/// The step as its equations say, with the pressure gradient in every predictor.
pub(crate) struct Reference<const D: usize> {
    grid: Grid<D>,
    options: Options<D>,
    pub(crate) state: State<D>,
    viscous: [Helmholtz<D>; D],
    pressure: Helmholtz<D>,
}

impl<const D: usize> Reference<D> {
    pub(crate) fn new(grid: &Grid<D>, options: &Options<D>) -> Self {
        Self {
            state: State::at_rest(grid),
            viscous: std::array::from_fn(|d| Helmholtz::new(grid, Unknown::Component(d))),
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

    /// One step; `between` is what the caller does before the last projection.
    pub(crate) fn step(
        &mut self,
        dt: f64,
        force: Option<&[Vec<f64>; D]>,
        between: impl Fn(&mut [Vec<f64>; D]),
    ) {
        let scheme = self.options.scheme;
        self.fill();
        for k in 0..scheme.stages() {
            let stage = scheme.stage(k, dt, self.state.previous_dt);
            self.predict(stage, dt, force);
            if k + 1 == scheme.stages() {
                between(&mut self.state.velocity);
            }
            self.fill();
            self.project(2.0 * stage.alpha * dt, 0.5);
        }
        self.state.previous_dt = dt;
    }

    fn predict(&mut self, stage: Stage, dt: f64, force: Option<&[Vec<f64>; D]>) {
        let Self { grid, options, state, viscous, .. } = self;
        let (nu, length) = (options.viscosity, 2.0 * stage.alpha * dt);
        let implicit = options.viscous == Viscous::Implicit;
        let mut increments = grid.new_vector();
        for (d, increment) in increments.iter_mut().enumerate() {
            let diffusion = laplacian(grid, d, &state.velocity[d]);
            let slope = gradient(grid, d, &state.pressure);
            let mut n =
                if options.convection { convection(grid, d, &state.velocity) } else { grid.new_field() };
            for_each_unknown(grid, d, |_, i| {
                let f = options.body_force[d] + force.map_or(0.0, |f| f[d][i]) - slope[i];
                n[i] += if implicit { 0.0 } else { nu * diffusion[i] };
                increment[i] = dt * (stage.gamma * n[i] + stage.zeta * state.history[d][i])
                    + length * (f + if implicit { nu * diffusion[i] } else { 0.0 });
            });
            state.history[d] = n;
        }
        for (d, increment) in increments.iter_mut().enumerate() {
            let u = &mut state.velocity[d];
            if implicit {
                viscous[d].solve(grid, [1.0, stage.alpha * nu * dt], increment, u, Write::Add);
            } else {
                for_each_unknown(grid, d, |_, i| u[i] += increment[i]);
            }
        }
    }

    /// `half`: what multiplies ν ∇·u* in the pressure with implicit viscosity.
    fn project(&mut self, duration: f64, half: f64) {
        let Self { grid, options, state, pressure, .. } = self;
        let implicit = options.viscous == Viscous::Implicit;
        let correction = if implicit { half * options.viscosity } else { 0.0 };
        let (mut rhs, mut phi) = (divergence(grid, &state.velocity), grid.new_field());
        for_each_cell(grid, |_, i| {
            state.pressure[i] -= correction * rhs[i];
            rhs[i] /= duration;
        });
        pressure.solve(grid, [0.0, -1.0], &mut rhs, &mut phi, Write::Set);
        fill_scalar(grid, &mut phi);
        for (d, u) in state.velocity.iter_mut().enumerate() {
            let slope = gradient(grid, d, &phi);
            for_each_unknown(grid, d, |_, i| u[i] -= duration * slope[i]);
        }
        for_each_cell(grid, |_, i| state.pressure[i] += phi[i]);
        fill_scalar(grid, &mut state.pressure);
        self.fill();
    }
}
