//! Direct solution of `(σ − c ∇²) x = b` for velocity components and pressure.
//!
//! Fourier analysis along all axes but one and a tridiagonal sweep along that one (Buzbee, Golub &
//! Nielson 1970; Schumann & Sweet 1988). Eigenvalues and sweeps are those of the discrete
//! second-order operator, so the solution is exact to round-off: no iteration, no tolerance.
//!
//! The swept axis is the stretched or radial one; otherwise one with walls; a box that is periodic
//! along its candidate axis is transformed along all.

mod block_columns;
mod block_sweep;
mod block_tree;
mod blocks;
mod edges;
mod plane;
mod plane_columns;
mod shared;
pub(crate) mod space;
mod space_columns;
mod tiles;
mod unknown;

use crate::grid::Grid;

pub use crate::transform::Write;
pub use block_columns::most_edges;
pub use unknown::Unknown;

/// A direct solver for one unknown on one grid.
pub struct Helmholtz<const D: usize> {
    layout: Layout,
}

enum Layout {
    Plane(Box<plane::Plane>),
    Space(Box<space::Space>),
}

impl<const D: usize> Helmholtz<D> {
    /// Plans the solver; `grid` must be the one later given to [`Helmholtz::solve`].
    pub fn new(grid: &Grid<D>, unknown: Unknown) -> Self {
        let layout = if D == 2 {
            Layout::Plane(Box::new(plane::Plane::new(grid, unknown)))
        } else {
            Layout::Space(Box::new(space::Space::new(grid, unknown)))
        };
        Self { layout }
    }

    /// Solves `(σ − c ∇²) x = rhs`, `operator` being σ and c, and writes `x` to the unknowns of `out`.
    ///
    /// `rhs` is used as working memory. For pressure, σ = 0 and c = −1: the constant is fixed by a
    /// zero mean, and a right-hand side without zero mean is taken without its mean.
    pub fn solve(
        &mut self,
        grid: &Grid<D>,
        operator: [f64; 2],
        rhs: &mut [f64],
        out: &mut [f64],
        write: Write,
    ) {
        match &mut self.layout {
            Layout::Plane(plane) => plane.solve(grid, operator, rhs, out, write),
            Layout::Space(space) => space.solve(operator, rhs, out, write),
        }
    }
}
