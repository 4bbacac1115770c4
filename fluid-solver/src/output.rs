//! Field files for ParaView: VTK rectilinear grids (`.vtr`).
//!
//! Cell data: velocity at the centres, pressure without its hydrostatic part and mean gradient,
//! vorticity, solid fraction. A plane or (r, z) grid lies in the plane y = 0, r along x.

use crate::grid::{Geometry, Grid};
use crate::immersed::body::laboratory;
use crate::immersed::layer_sums::{first, for_each_layer};
use crate::solver::Solver;
use bedload_output::vtk::{Array, rectilinear};
use protocol::participant::{SolverError, Window};
use std::path::Path;

/// Writes the fields after `window` to `folder`/`fluid_<step>.vtr`.
///
/// # Errors
/// [`SolverError::File`].
pub fn write<const D: usize>(
    solver: &mut Solver<D>,
    window: &Window,
    folder: &Path,
) -> Result<(), SolverError> {
    if !solver.show() {
        return Ok(());
    }
    let data = [velocity(solver), pressure(solver), vorticity(solver), solid(solver)];
    let path = folder.join(format!("fluid_{:08}.vtr", window.step));
    let save = || -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(&path, rectilinear(window.time + window.dt, &faces(solver.grid()), &data))
    };
    save().map_err(|source| SolverError::File { path: path.display().to_string(), source })
}

/// Faces along x, y and z, m; 0 alone along an axis that the grid has not.
fn faces<const D: usize>(grid: &Grid<D>) -> [Vec<f64>; 3] {
    std::array::from_fn(|c| {
        let axis = (0..D).find(|a| laboratory(grid.geometry, *a) == c);
        axis.map_or_else(|| vec![0.0], |a| grid.axes[a].faces.clone())
    })
}

/// Visits every cell in VTK's order (x fastest): its indices and its place in a field.
fn for_each_cell<const D: usize>(grid: &Grid<D>, mut visit: impl FnMut([usize; D], usize)) {
    for row in 0..grid.rows() {
        let start = grid.row(row);
        let rest = [0, row % grid.cells[1], row / grid.cells[1]];
        for i in 0..grid.cells[0] {
            visit(std::array::from_fn(|a| if a == 0 { i } else { rest[a] }), start + i);
        }
    }
}

fn velocity<const D: usize>(solver: &Solver<D>) -> Array {
    let grid = solver.grid();
    let mut values = Vec::with_capacity(3 * grid.cell_count());
    for_each_cell(grid, |_, index| {
        let mut v = [0.0; 3];
        for (a, u) in solver.stepper().state().velocity.iter().enumerate() {
            v[laboratory(grid.geometry, a)] = 0.5 * (u[index] + u[index + grid.stride(a)]);
        }
        values.extend(v);
    });
    Array::real("velocity", 3, values)
}

fn pressure<const D: usize>(solver: &Solver<D>) -> Array {
    let grid = solver.grid();
    let mut values = Vec::with_capacity(grid.cell_count());
    let p = &solver.stepper().state().pressure;
    for_each_cell(grid, |_, index| values.push(solver.density() * p[index]));
    Array::scalar("pressure", values)
}

/// ∇ × u at the centres: central differences of the centred velocity, walls through the halo.
fn vorticity<const D: usize>(solver: &Solver<D>) -> Array {
    let grid = solver.grid();
    let velocity = &solver.stepper().state().velocity;
    let mut values = Vec::with_capacity(3 * grid.cell_count());
    // ∂u_d/∂x_a at a centre, a ≠ d.
    let slope = |at: [usize; D], index: usize, d: usize, a: usize| {
        let u = &velocity[d];
        let centred = |i: usize| 0.5 * (u[i] + u[i + grid.stride(d)]);
        let distances = &grid.axes[a].distances;
        let width = distances[at[a]] + distances[at[a] + 1];
        (centred(index + grid.stride(a)) - centred(index - grid.stride(a))) / width
    };
    for_each_cell(grid, |at, index| {
        let mut curl = [0.0; 3];
        for d in 0..D {
            for a in (0..D).filter(|a| *a != d) {
                let (c, k) = (laboratory(grid.geometry, d), laboratory(grid.geometry, a));
                let normal = 3 - c - k;
                // ε_{normal, k, c} ∂u_c/∂x_k
                let sign = if (k + 1) % 3 == c { 1.0 } else { -1.0 };
                curl[normal] += sign * slope(at, index, d, a);
            }
        }
        if grid.geometry == Geometry::Axisymmetric {
            curl[0] = 0.0;
            curl[2] = 0.0;
        }
        values.extend(curl);
    });
    Array::real("vorticity", 3, values)
}

fn solid<const D: usize>(solver: &Solver<D>) -> Array {
    let grid = solver.grid();
    let mut ratio = grid.new_field();
    for_each_layer(
        grid,
        solver.mask_model(),
        solver.immersed().shapes(),
        solver.motions(),
        |k, layer_sums, _, _| {
            let layer = &mut ratio[first(grid, k)..];
            layer.iter_mut().zip(layer_sums.totals()).for_each(|(sum, total)| *sum += total);
        },
    );
    let mut values = Vec::with_capacity(grid.cell_count());
    for_each_cell(grid, |_, index| values.push(ratio[index] / (1.0 + ratio[index])));
    Array::scalar("solid", values)
}
