//! The second-order Laplacian along one axis, in metric form.

use crate::grid::Grid;

/// `(L u)_i = lower_i (u_{i−1} − u_i) + upper_i (u_{i+1} − u_i) − extra_i u_i`, 1/m².
///
/// Finite volumes: `lower = A_{i−½} / (V_i h_{i−½})`, `upper = A_{i+½} / (V_i h_{i+½})`, with the
/// metric in A and V. `extra` is the −u_r/r² of the radial momentum, in the form that keeps
/// u_r ∝ r exactly free of viscous force on any grid. Entries belong to the node indices of
/// [`Grid::nodes`]; entries of wall faces are zero.
#[derive(Clone, Debug)]
pub struct Stencil {
    /// Weight of the lower neighbour.
    pub lower: Vec<f64>,
    /// Weight of the upper neighbour.
    pub upper: Vec<f64>,
    /// Extra damping, positive.
    pub extra: Vec<f64>,
}

impl Stencil {
    /// Stencil along `axis` for values at the cell centres of that axis.
    pub fn centred<const D: usize>(grid: &Grid<D>, axis: usize) -> Self {
        let a = &grid.axes[axis];
        let side = |i: usize, f: usize| a.face_area[f] / (a.cell_volume[i] * a.distances[f]);
        Self {
            lower: (0..a.cells()).map(|i| side(i, i)).collect(),
            upper: (0..a.cells()).map(|i| side(i, i + 1)).collect(),
            extra: vec![0.0; a.cells()],
        }
    }

    /// Stencil along `axis` for values at the faces of that axis, that is component `axis`.
    pub fn staggered<const D: usize>(grid: &Grid<D>, axis: usize) -> Self {
        let a = &grid.axes[axis];
        let n = a.cells();
        let mut stencil = Self { lower: vec![0.0; n + 1], upper: vec![0.0; n + 1], extra: vec![0.0; n + 1] };
        let first = usize::from(!grid.periodic(axis));
        for f in first..n {
            let below = if f == 0 { n - 1 } else { f - 1 };
            let side = |c: usize| a.centre_area[c] / (a.face_volume[f] * a.widths[c]);
            stencil.lower[f] = side(below);
            stencil.upper[f] = side(f);
            if a.radial {
                stencil.extra[f] = a.distances[f] / (a.face_volume[f] * a.faces[f]);
            }
        }
        stencil
    }

    /// Stencil along `axis` for velocity component `d`.
    pub fn of_component<const D: usize>(grid: &Grid<D>, d: usize, axis: usize) -> Self {
        if d == axis { Self::staggered(grid, axis) } else { Self::centred(grid, axis) }
    }
}
