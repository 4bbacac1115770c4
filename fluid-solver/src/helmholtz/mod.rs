//! Direct solution of `(σ − c ∇²) x = b` for velocity components and pressure.
//!
//! Fourier analysis along all axes but one and a tridiagonal sweep along that one (Buzbee, Golub &
//! Nielson 1970; Schumann & Sweet 1988). Eigenvalues and sweeps are those of the discrete
//! second-order operator, so the solution is exact to round-off: no iteration, no tolerance.
//!
//! The swept axis is the stretched or radial one; otherwise one with walls; a box that is periodic
//! along its candidate axis is transformed along all.

mod columns;
mod pillars;
mod plane;
pub(crate) mod space;
mod tiles;

use crate::grid::Grid;
use crate::lanes::{Lanes, ZERO};
use crate::stencil::Stencil;
use crate::transform::{Kind, Transform};
use crate::tridiagonal::Sweep;
use columns::Across;
use std::sync::Mutex;

pub use crate::transform::Write;

/// What is solved for: it decides positions and wall conditions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Velocity component on its faces, homogeneous wall conditions.
    Component(usize),
    /// Pressure at the centres, zero slope at walls.
    Pressure,
}

impl Unknown {
    /// Boundary type and staggering along `axis`.
    fn kind<const D: usize>(self, grid: &Grid<D>, axis: usize) -> Kind {
        match self {
            Self::Component(d) => Kind::of_component(grid, d, axis),
            Self::Pressure => Kind::of_pressure(grid, axis),
        }
    }

    /// Index of the first unknown along `axis`.
    fn first<const D: usize>(self, grid: &Grid<D>, axis: usize) -> usize {
        usize::from(self.kind(grid, axis) == Kind::Fixed)
    }

    /// Tridiagonal operator along `axis`, walls folded in.
    fn sweep<const D: usize>(self, grid: &Grid<D>, axis: usize) -> Sweep {
        let own = self == Self::Component(axis);
        let stencil = if own { Stencil::staggered(grid, axis) } else { Stencil::centred(grid, axis) };
        let range = self.first(grid, axis)..grid.cells[axis];
        let mut sweep = Sweep {
            last: range.len() - 1,
            lower: stencil.lower[range.clone()].to_vec(),
            upper: stencil.upper[range.clone()].to_vec(),
            diagonal: range
                .clone()
                .map(|i| -stencil.lower[i] - stencil.upper[i] - stencil.extra[i])
                .collect(),
            volume: if own {
                grid.axes[axis].face_volume[range].to_vec()
            } else {
                grid.axes[axis].cell_volume[range].to_vec()
            },
        };
        let last = sweep.last;
        let (low, high) = match self.kind(grid, axis) {
            // The neighbour is the wall itself.
            Kind::Fixed => (0.0, 0.0),
            Kind::EvenEven => (1.0, 1.0),
            Kind::OddOdd => (-1.0, -1.0),
            Kind::EvenOdd => (1.0, -1.0),
            Kind::OddEven => (-1.0, 1.0),
            Kind::Periodic => unreachable!("periodic axes are transformed"),
        };
        sweep.diagonal[0] += low * sweep.lower[0];
        sweep.diagonal[last] += high * sweep.upper[last];
        sweep.lower[0] = 0.0;
        sweep.upper[last] = 0.0;
        sweep
    }

    /// How the last axis of the solve, `axis`, is treated.
    fn across<const D: usize>(self, grid: &Grid<D>, axis: usize) -> Across {
        if grid.periodic(axis) {
            let width = grid.axes[axis].length() / grid.cells[axis] as f64;
            let transform = Transform::new(self.kind(grid, axis), grid.cells[axis]);
            Across::Transform(Box::new(transform), width * width)
        } else {
            Across::Sweep(self.sweep(grid, axis))
        }
    }

    /// Eigenvalues along a transformed axis, 1/m².
    fn eigenvalues<const D: usize>(self, grid: &Grid<D>, axis: usize) -> Vec<f64> {
        let (kind, cells) = (self.kind(grid, axis), grid.cells[axis]);
        let width = grid.axes[axis].length() / cells as f64;
        (0..kind.values(cells)).map(|q| kind.eigenvalue(q, cells) / (width * width)).collect()
    }
}

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

    /// Solves `(σ − c ∇²) x = rhs` and writes `x` to the unknowns of `out`.
    ///
    /// `rhs` is used as working memory. For pressure, σ = 0 and c = −1: the constant is fixed by a
    /// zero mean, and a right-hand side without zero mean is taken without its mean.
    pub fn solve(
        &mut self,
        grid: &Grid<D>,
        sigma: f64,
        c: f64,
        rhs: &mut [f64],
        out: &mut [f64],
        write: Write,
    ) {
        match &mut self.layout {
            Layout::Plane(plane) => plane.solve(grid, [sigma, c], rhs, out, write),
            Layout::Space(space) => space.solve([sigma, c], rhs, out, write),
        }
    }
}

/// Packs values into lanes; lanes beyond the end get −1, a harmless eigenvalue.
fn pack(values: &[f64]) -> Vec<Lanes> {
    let pad = |c: &[f64]| std::array::from_fn(|l| c.get(l).copied().unwrap_or(-1.0));
    values.chunks(8).map(pad).collect()
}

/// Working memory, one per thread; a lock that nobody else wants costs nothing measurable.
struct Pool<T>(Vec<Mutex<T>>);

impl<T> Pool<T> {
    /// One piece of memory for each thread of the current pool, and one for the caller.
    fn new(make: impl Fn() -> T) -> Self {
        let threads = rayon::current_num_threads() + 1;
        Self((0..threads).map(|_| Mutex::new(make())).collect())
    }

    /// Lends a piece of memory to `task`.
    fn with<R>(&self, task: impl FnOnce(&mut T) -> R) -> R {
        let me = rayon::current_thread_index().map_or(0, |i| i + 1);
        let mut memory = self.0[me % self.0.len()].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        task(&mut memory)
    }
}

/// `out = x` or `out += x`.
#[inline(always)]
fn store(out: &mut [f64], x: &[f64], write: Write) {
    // A length known beforehand spares a call of memcpy per cache line.
    if let (Ok(out), Some(x)) = (<&mut Lanes>::try_from(&mut *out), x.first_chunk::<8>()) {
        for l in 0..8 {
            out[l] = if write == Write::Add { out[l] + x[l] } else { x[l] };
        }
    } else if write == Write::Add {
        out.iter_mut().zip(x).for_each(|(o, x)| *o += x);
    } else {
        out.iter_mut().zip(x).for_each(|(o, x)| *o = *x);
    }
}

/// Length of a block of `rows` rows: an odd number of tiles, so that the same row of many blocks
/// does not fall on the same few places of the cache.
fn block_length(rows: usize) -> usize {
    (rows.div_ceil(8) | 1) * 8
}

/// `count` blocks of zeros for `rows` rows each, and one row to [`crate::lanes::aligned`] them.
fn blocks(count: usize, rows: usize) -> Vec<Lanes> {
    vec![ZERO; count * block_length(rows) + 1]
}
