//! Stress on planes of cells, as both phases transmit it: what `observe.planes.stress` adds.
//!
//! With z across the planes, ⟨ ⟩ the mean over a plane of the box, grains' places included, λ the force
//! of the immersed boundary per unit mass, F_i, C_i, L_i the forces of fluid, contacts and lubrication on
//! grain i, −m_f g the buoyancy in F_i, a_i its acceleration, H(z_i − z) one below the centre z_i of a
//! grain and zero above, A the area:
//! ```text
//! viscous        μ ∂⟨u⟩/∂z
//! turbulent      −ρ ⟨u w⟩                                    ⟨w⟩ = 0
//! hydrodynamic   −ρ ∫_z ⟨λ⟩ dz' − Σ H (F_i + m_f g − m_f a_i)/A   within grains alone
//! contact        −Σ H C_i/A,   lubrication  −Σ H L_i/A       (Irving & Kirkwood 1950: centre to centre)
//! ```
//! The momentum of the fluid in the box gives d(first three without F)/dz = ρ ∂⟨u⟩/∂t − ρ f, and that of each
//! grain cancels F_i + C_i + L_i against its inertia and weight: the sum is the stress of the mixture, whose
//! slope is the change of the momentum of both phases less the forces on them.

use crate::boundary::Boundary;
use crate::field::{for_each_unknown, for_each_value};
use crate::grain_forces::GrainForces;
use crate::grid::Grid;
use crate::immersed::body::laboratory;
use crate::solver::Solver;
use bedload_output::planes::Stresses;

/// Sums over one plane of cells and its lower face, by component.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Viscous and turbulent on the lower face; of the component across in the cells.
    fluxes: [[f64; 3]; 2],
    /// ρ λ: in the cells; of the component across at the lower face.
    force: [f64; 3],
    pressure: f64,
}

/// Pressure and stresses on the planes across grid axis `axis`, with the force `lambda` whole, if there is
/// one, and the halos filled. The granular temperature is left zero.
pub(crate) fn stresses<const D: usize>(
    solver: &Solver<D>,
    axis: usize,
    lambda: Option<&[Vec<f64>; D]>,
    forces: &GrainForces,
) -> Vec<Stresses> {
    let grid = solver.grid();
    let n = grid.cells[axis];
    let mut sums = vec![Sums::default(); n + 1];
    for d in 0..D {
        let lambda = lambda.map(|lambda| lambda[d].as_slice());
        if d == axis {
            add_across(solver, axis, lambda, &mut sums);
        } else {
            add_along(solver, axis, d, lambda, &mut sums);
        }
    }
    let area: f64 = (0..D).filter(|a| *a != axis).map(|a| grid.axes[a].length()).product();
    let across = laboratory(grid.geometry, axis);
    let mut planes = vec![Stresses::default(); n];
    let mut above = [0.0; 3];
    for (k, plane) in planes.iter_mut().enumerate().rev() {
        let (lower, upper) = (sums[k], sums[k + 1]);
        plane.pressure = lower.pressure / area;
        for (c, above) in above.iter_mut().enumerate() {
            for part in 0..2 {
                let ends = lower.fluxes[part][c] + upper.fluxes[part][c];
                plane.parts[part][c] = if c == across { lower.fluxes[part][c] } else { 0.5 * ends } / area;
            }
            let (half, whole) = match c == across {
                true => (upper.force[c], upper.force[c]),
                false => (0.5 * lower.force[c], lower.force[c]),
            };
            plane.parts[2][c] = -(*above + half) / area;
            *above += whole;
        }
    }
    add_grains(solver, axis, area, forces, &mut planes);
    planes
}

/// Component `d` along the planes.
fn add_along<const D: usize>(
    solver: &Solver<D>,
    axis: usize,
    d: usize,
    lambda: Option<&[f64]>,
    sums: &mut [Sums],
) {
    let grid: &Grid<D> = solver.grid();
    let velocity = &solver.stepper().state().velocity;
    let (u, w, c) = (&velocity[d], &velocity[axis], laboratory(grid.geometry, d));
    let (rho, viscosity) = (solver.density(), solver.density() * solver.stepper().options().viscosity);
    let (n, one, back) = (grid.cells[axis], grid.stride(axis), grid.stride(d));
    let widths = &grid.axes[axis].widths;
    let at_wall = |side: usize| matches!(grid.boundaries[axis][side], Boundary::NoSlip { .. });
    for_each_value(grid, d, |at, index| {
        let k = at[axis];
        let volume = grid.control_volume(d, at);
        let area = volume / widths[k];
        sums[k].force[c] += rho * lambda.map_or(0.0, |lambda| lambda[index]) * volume;
        if k > 0 {
            let rate = (u[index] - u[index - one]) / grid.axes[axis].distances[k];
            sums[k].fluxes[0][c] += viscosity * rate * area;
            let carried = 0.5 * (u[index] + u[index - one]) * 0.5 * (w[index] + w[index - back]);
            sums[k].fluxes[1][c] -= rho * carried * area;
        } else if at_wall(0) {
            let slip = u[index] - grid.boundaries[axis][0].velocity(d);
            sums[0].fluxes[0][c] += viscosity * slip / (0.5 * widths[0]) * area;
        }
        if k + 1 == n && at_wall(1) {
            let slip = grid.boundaries[axis][1].velocity(d) - u[index];
            sums[n].fluxes[0][c] += viscosity * slip / (0.5 * widths[k]) * area;
        }
    });
}

/// The component across the planes, and the pressure.
fn add_across<const D: usize>(solver: &Solver<D>, axis: usize, lambda: Option<&[f64]>, sums: &mut [Sums]) {
    let grid: &Grid<D> = solver.grid();
    let state = solver.stepper().state();
    let (w, c) = (&state.velocity[axis], laboratory(grid.geometry, axis));
    let (rho, viscosity) = (solver.density(), solver.density() * solver.stepper().options().viscosity);
    for_each_unknown(grid, axis, |at, index| {
        sums[at[axis]].force[c] +=
            rho * lambda.map_or(0.0, |lambda| lambda[index]) * grid.control_volume(axis, at);
    });
    for_each_unknown(grid, D, |at, index| {
        let k = at[axis];
        let width = grid.axes[axis].widths[k];
        let area = grid.cell_volume(at) / width;
        let (below, above) = (w[index], w[index + grid.stride(axis)]);
        sums[k].fluxes[0][c] += viscosity * (above - below) / width * area;
        sums[k].fluxes[1][c] -= rho * (0.5 * (below + above)).powi(2) * area;
        sums[k].pressure += rho * state.pressure[index] * area;
    });
}

/// What grains transmit: forces from their centres down, in the mean over the height of a cell.
fn add_grains<const D: usize>(
    solver: &Solver<D>,
    axis: usize,
    area: f64,
    forces: &GrainForces,
    planes: &mut [Stresses],
) {
    let (axis, across) = (&solver.grid().axes[axis], laboratory(solver.grid().geometry, axis));
    for (i, (motion, shape)) in solver.motions().iter().zip(solver.immersed().shapes()).enumerate() {
        let acceleration = solver.grains.memory.acceleration(i).force;
        let inertia = acceleration.map(|a| solver.density() * shape.volume * a);
        for (k, plane) in planes.iter_mut().enumerate() {
            let below = ((motion.centre[across] - axis.faces[k]) / axis.widths[k]).clamp(0.0, 1.0);
            if below == 0.0 {
                break;
            }
            for (of, part) in forces.of.iter().zip(&mut plane.parts[2..]) {
                (0..3).for_each(|c| part[c] -= below * of[i][c] / area);
            }
            (0..3).for_each(|c| plane.parts[2][c] += below * inertia[c] / area);
        }
    }
}
