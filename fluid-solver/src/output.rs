//! Field files for ParaView: VTK rectilinear grids (`.vtr`). Of several ranks each writes its planes to a
//! file of its own, and the first one the list of them (`.pvtr`), which opens as one grid. `fluid.pvd` lists
//! them over time.
//!
//! Cell data: velocity at the centres, pressure without its hydrostatic part and mean gradient,
//! vorticity, and β of the mask, which is wider than the grains, as `solid`. A plane or (r, z) grid lies in
//! the plane y = 0, r along x.

use crate::field::for_each_own_unknown;
use crate::grid::{Geometry, Grid};
use crate::immersed::body::laboratory;
use crate::immersed::by_layer::Placed;
use crate::immersed::layer_sums::{first, for_each_layer};
use crate::solver::Solver;
use bedload_output::atomic_write;
use bedload_output::vtk::{Array, Part, list, parts, rectilinear_part};
use protocol::new_file::write_new;
use protocol::participant::{SolverError, Window};
use std::path::Path;

/// Writes the fields after `window` to `folder`/`fluid_<step>.vtr`, or `.pvtr` and `-<rank>-of-<ranks>.vtr`.
///
/// # Errors
/// [`SolverError::File`], and what kept another rank from writing its file.
pub fn write<const D: usize>(
    solver: &mut Solver<D>,
    window: &Window,
    folder: &Path,
) -> Result<(), SolverError> {
    solver.stepper_mut().fill_halos();
    let data = [velocity(solver), pressure(solver), vorticity(solver), solid(solver)];
    let grid = solver.grid();
    let (division, own) = (&grid.division, grid.division.own());
    let (ranks, stem) = (division.ranks(), format!("fluid_{:08}", window.step));
    let part = |rank: usize| {
        let layers = division.of(rank);
        let file = format!("{stem}-{rank}-of-{}.vtr", ranks.size());
        Part { file, layers: [layers.start, layers.end] }
    };
    let name = if ranks.is_alone() { format!("{stem}.vtr") } else { part(ranks.rank()).file };
    let (path, time) = (folder.join(&name), window.time + window.dt);
    let first = if D == 3 { own.start } else { 0 };
    let save = || -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        write_new(&path, &rectilinear_part(time, &faces(grid), first, &data))
    };
    let saved = save().map_err(|source| SolverError::File { path: path.display().to_string(), source });
    ranks.report(saved.map(|()| Vec::new()))?;
    if !ranks.is_first() {
        return Ok(());
    }
    let whole = || {
        if ranks.is_alone() {
            return list(&folder.join("fluid.pvd"), time, &name);
        }
        let all: Vec<Part> = (0..ranks.size()).map(part).collect();
        let (name, text) = (format!("{stem}.pvtr"), parts([grid.cells[0], grid.cells[1]], &data, &all));
        atomic_write(&folder.join(&name), text.as_bytes())?;
        list(&folder.join("fluid.pvd"), time, &name)
    };
    Ok(whole()?)
}

/// Faces along x, y and z of the planes of this process, m; 0 alone along an axis that the grid has not.
fn faces<const D: usize>(grid: &Grid<D>) -> [Vec<f64>; 3] {
    let own = grid.division.own();
    std::array::from_fn(|c| {
        let axis = (0..D).find(|a| laboratory(grid.geometry, *a) == c);
        axis.map_or_else(
            || vec![0.0],
            |a| {
                let faces = &grid.axes[a].faces;
                if a == D - 1 { faces[own.start..=own.end].to_vec() } else { faces.clone() }
            },
        )
    })
}

/// `value` at every cell of this process, given its indices and its place in a field.
fn cells<const D: usize, const N: usize>(
    grid: &Grid<D>,
    value: impl Fn([usize; D], usize) -> [f64; N],
) -> Vec<f64> {
    let mut values = Vec::with_capacity(N * grid.own_rows().len() * grid.cells[0]);
    for_each_own_unknown(grid, D, |at, index| values.extend(value(at, index)));
    values
}

fn velocity<const D: usize>(solver: &Solver<D>) -> Array {
    let grid = solver.grid();
    let values = cells(grid, |_, index| {
        let mut v = [0.0; 3];
        for (a, u) in solver.stepper().state().velocity.iter().enumerate() {
            v[laboratory(grid.geometry, a)] = 0.5 * (u[index] + u[index + grid.stride(a)]);
        }
        v
    });
    Array::real("velocity", 3, values)
}

fn pressure<const D: usize>(solver: &Solver<D>) -> Array {
    let p = solver.pressure();
    Array::scalar("pressure", cells(solver.grid(), |_, index| [solver.density() * p[index]]))
}

/// ∇ × u at the centres: central differences of the centred velocity, walls through the halo.
fn vorticity<const D: usize>(solver: &Solver<D>) -> Array {
    let grid = solver.grid();
    let velocity = &solver.stepper().state().velocity;
    // ∂u_d/∂x_a at a centre, a ≠ d.
    let slope = |at: [usize; D], index: usize, d: usize, a: usize| {
        let u = &velocity[d];
        let centred = |i: usize| 0.5 * (u[i] + u[i + grid.stride(d)]);
        let distances = &grid.axes[a].distances;
        let width = distances[at[a]] + distances[at[a] + 1];
        (centred(index + grid.stride(a)) - centred(index - grid.stride(a))) / width
    };
    let values = cells(grid, |at, index| {
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
        curl
    });
    Array::real("vorticity", 3, values)
}

fn solid<const D: usize>(solver: &Solver<D>) -> Array {
    let grid = solver.grid();
    let mut ratio = grid.new_field();
    let (shapes, motions) = (solver.immersed().shapes(), solver.motions());
    let placed = Placed { grid, model: solver.mask_model(), shapes, motions };
    for_each_layer(placed, grid.division.own(), |k, layer_sums, _, _| {
        let layer = &mut ratio[first(grid, k)..];
        layer.iter_mut().zip(&layer_sums.totals).for_each(|(sum, total)| *sum += total);
    });
    Array::scalar("solid", cells(grid, |_, index| [ratio[index] / (1.0 + ratio[index])]))
}
