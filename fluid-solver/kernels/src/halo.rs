//! The halo values that express the conditions on the faces of the box ([`crate::boundary`]).

use crate::grid::Grid;
use crate::open::OpenFaces;

/// Fills the halo and the wall faces of velocity component `d` from its unknowns (m/s).
///
/// Axes are filled in order, each over the halo of the former ones, so edges and corners hold too.
pub fn fill_velocity<const D: usize>(grid: &Grid<D>, d: usize, u: &mut [f64]) {
    (0..D).for_each(|axis| fill_velocity_across(grid, d, axis, u));
}

/// [`fill_velocity`] on a grid with open faces, if there are any: those first, so that walls complete their
/// layers.
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
        // The images of a tangential component in the walls.
        for (to, from, wall) in [(-1, 0, low), (n, n - 1, high)] {
            let twice = 2.0 * wall.velocity(d);
            if wall.is_odd() {
                copy_layer(grid, axis, to, from, u, |x| twice - x);
            } else {
                copy_layer(grid, axis, to, from, u, |x| x);
            }
        }
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

/// `u(to) = map(u(from))` over a whole layer across `axis`, halo of the other axes included; across axes
/// other than the last on the planes of this process and those beside them.
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
    let layers = match outer {
        _ if D < 3 => 0..1,
        2 => grid.division.own().start..grid.division.own().end + 2,
        _ => 0..grid.cells[outer] + 2,
    };
    for k in layers {
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
