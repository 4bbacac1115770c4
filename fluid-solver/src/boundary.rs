//! What holds on each face of the box, and the halo values that express it.
//!
//! A wall is met by the halo alone: kernels never ask where they are. With `u₁` the first value
//! inside and `u₀` its mirror image outside, at the same distance from the wall,
//! no-slip sets `u₀ = 2 V − u₁` and free-slip `u₀ = u₁`. Both are what the transforms of
//! [`crate::helmholtz`] assume (odd and even continuation), so the direct solves are exact.
//! A face that fluid passes through is a no-slip wall in this sense, whose velocity, the normal one
//! too, differs from place to place: see [`crate::open`].

use crate::grid::Grid;
use crate::open::OpenFaces;

/// How the normal velocity of an inflow is spread over its face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// The same everywhere.
    Uniform,
    /// Laminar: a parabola along every axis with a no-slip wall, their product where there are two.
    Parabolic,
}

/// Condition on one face of the box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Boundary<const D: usize> {
    /// The field goes on at the opposite face; both faces of the axis must say so.
    Periodic,
    /// Fluid sticks to a wall that moves in its own plane.
    NoSlip {
        /// Velocity of the wall, m/s, one entry per axis of the grid; its normal entry must be zero.
        velocity: [f64; D],
    },
    /// Impermeable, without shear stress (also a plane of symmetry).
    FreeSlip,
    /// The line r = 0 of an axisymmetric grid: lower face of axis 0 only.
    Axis,
    /// Fluid enters with a given velocity, see [`crate::open`].
    Inflow {
        /// Mean velocity over the face, m/s, one entry per axis of the grid.
        velocity: [f64; D],
        /// How its normal component is spread.
        profile: Profile,
    },
    /// Fluid leaves as it comes, see [`crate::open`].
    Outflow,
}

impl<const D: usize> Boundary<D> {
    /// A no-slip wall at rest.
    pub const WALL: Self = Self::NoSlip { velocity: [0.0; D] };

    /// Whether the field goes on at the opposite face.
    pub fn is_periodic(&self) -> bool {
        matches!(self, Self::Periodic)
    }

    /// Whether a tangential component is given here (relative to the wall), instead of its slope.
    pub fn is_odd(&self) -> bool {
        matches!(self, Self::NoSlip { .. }) || self.is_open()
    }

    /// Whether fluid passes through.
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Inflow { .. } | Self::Outflow)
    }

    /// Velocity that the fluid takes on the face along `component`, m/s (zero where it is free).
    pub fn velocity(&self, component: usize) -> f64 {
        match self {
            Self::NoSlip { velocity } => velocity[component],
            _ => 0.0,
        }
    }
}

/// Fills the halo and the wall faces of velocity component `d` from its unknowns (m/s).
///
/// Axes are filled in order, each over the halo of the former ones, so edges and corners hold too.
pub fn fill_velocity<const D: usize>(grid: &Grid<D>, d: usize, u: &mut [f64]) {
    (0..D).for_each(|axis| fill_velocity_across(grid, d, axis, u));
}

/// [`fill_velocity`] on a grid with open faces: those first, so that walls complete their layers.
pub fn fill_velocity_and_open<const D: usize>(grid: &Grid<D>, open: &OpenFaces<D>, d: usize, u: &mut [f64]) {
    let is_open = |axis: &usize| open.faces().iter().any(|face| face.axis == *axis);
    for axis in (0..D).filter(is_open) {
        fill_velocity_across(grid, d, axis, u);
        open.fill_across(grid, d, axis, u);
    }
    (0..D).filter(|axis| !is_open(axis)).for_each(|axis| fill_velocity_across(grid, d, axis, u));
}

/// The part of [`fill_velocity`] that belongs to `axis`.
pub(crate) fn fill_velocity_across<const D: usize>(grid: &Grid<D>, d: usize, axis: usize, u: &mut [f64]) {
    let n = grid.cells[axis] as isize;
    let [low, high] = grid.boundaries[axis];
    if low.is_periodic() {
        copy_layer(grid, axis, -1, n - 1, u, |x| x);
        copy_layer(grid, axis, n, 0, u, |x| x);
    } else if axis == d {
        // Walls do not move along their normal (checked when the grid is made).
        copy_layer(grid, axis, 0, 0, u, |_| 0.0);
        copy_layer(grid, axis, n, n, u, |_| 0.0);
        copy_layer(grid, axis, -1, 1, u, |x| -x);
    } else {
        ghost(grid, axis, -1, 0, low, d, u);
        ghost(grid, axis, n, n - 1, high, d, u);
    }
}

/// Fills the halo of a cell-centred scalar: periodic images, else zero slope at every wall.
pub fn fill_scalar<const D: usize>(grid: &Grid<D>, p: &mut [f64]) {
    (0..D).for_each(|axis| fill_scalar_across(grid, axis, p));
}

/// The part of [`fill_scalar`] that belongs to `axis`.
pub(crate) fn fill_scalar_across<const D: usize>(grid: &Grid<D>, axis: usize, p: &mut [f64]) {
    let n = grid.cells[axis] as isize;
    let (below, above) = if grid.periodic(axis) { (n - 1, 0) } else { (0, n - 1) };
    copy_layer(grid, axis, -1, below, p, |x| x);
    copy_layer(grid, axis, n, above, p, |x| x);
}

/// Sets the image `to` of layer `from` in a wall for a component tangential to that wall.
fn ghost<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    to: isize,
    from: isize,
    wall: Boundary<D>,
    d: usize,
    u: &mut [f64],
) {
    if wall.is_odd() {
        let twice = 2.0 * wall.velocity(d);
        copy_layer(grid, axis, to, from, u, |x| twice - x);
    } else {
        copy_layer(grid, axis, to, from, u, |x| x);
    }
}

/// `u(to) = map(u(from))` over a whole layer across `axis`, halo of the other axes included.
fn copy_layer<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    to: isize,
    from: isize,
    u: &mut [f64],
    map: impl Fn(f64) -> f64,
) {
    let mut at = [-1_isize; D];
    at[axis] = to;
    let shift = (from - to) * grid.stride(axis) as isize;
    // The first axis that is not `axis` runs innermost.
    let inner = usize::from(axis == 0);
    let outer = 3 - axis - inner;
    let layers = if D == 3 { grid.cells[outer] + 2 } else { 1 };
    for k in 0..layers {
        if D == 3 {
            at[outer] = k as isize - 1;
        }
        let start = grid.index(at);
        let values = grid.cells[inner] + 2;
        let from = start.wrapping_add_signed(shift);
        if inner > 0 {
            let stride = grid.stride(inner);
            for j in 0..values {
                u[start + j * stride] = map(u[from + j * stride]);
            }
        } else if shift >= values as isize {
            let (to, source) = u[start..].split_at_mut(shift as usize);
            to[..values].iter_mut().zip(source).for_each(|(to, from)| *to = map(*from));
        } else if shift <= -(values as isize) {
            let (source, to) = u[from..].split_at_mut(start - from);
            to[..values].iter_mut().zip(source).for_each(|(to, from)| *to = map(*from));
        } else {
            u[start..start + values].iter_mut().for_each(|u| *u = map(*u));
        }
    }
}
