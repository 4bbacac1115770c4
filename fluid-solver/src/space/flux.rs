//! Momentum fluxes through the faces of the control volumes, row by row.
//!
//! Convection is the plain mean of the velocity times the mean of the mass fluxes
//! (Verstappen & Veldman 2003), viscosity −ν ∂u/∂x. A flux serves the control volumes
//! on both its sides. Fluxes along x and y are divided by the cell width, those along z are not.
//!
//! Every row is an argument of its own: that alone tells the compiler that results overlap nothing.
#![allow(clippy::too_many_arguments, reason = "see above")]

/// Factors of one stage and plane: `convection` is ¼, or 0 without convection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// ¼.
    pub(super) quarter: f64,
    /// ¼/Δx, ¼/Δy.
    pub(super) convection: [f64; 2],
    /// ν/Δx², ν/Δy².
    pub(super) viscosity: [f64; 2],
    /// ν/distance of the centres beside the upper face.
    pub(super) upper: f64,
    /// ν/Δz of the cell.
    pub(super) cell: f64,
    /// Weights of the cells below and above the upper face in the mass flux: ½/Δx times
    /// [`super::shape::Shape::cell_weights`], the same for Δy.
    pub(super) mass: [[f64; 2]; 2],
}

/// Flux of u along x through the centre left of each face.
#[inline(always)]
pub(super) fn u_along_x(w: &Weights, left: &[f64], u: &[f64], flux: &mut [f64]) {
    let n = flux.len();
    let (left, u) = (&left[..n], &u[..n]);
    let (q, nu) = (w.convection[0], w.viscosity[0]);
    for i in 0..n {
        let sum = left[i] + u[i];
        flux[i] = q * (sum * sum) - nu * (u[i] - left[i]);
    }
}

/// Between two rows: u along y, v along x (both at the edge), v along y (at the centre).
#[inline(always)]
pub(super) fn between_rows(
    w: &Weights,
    u: &[f64],
    u_next: &[f64],
    v: &[f64],
    v_next: &[f64],
    v_left: &[f64],
    uy: &mut [f64],
    vx: &mut [f64],
    vy: &mut [f64],
) {
    let n = uy.len();
    let (u, u_next, v, v_next, v_left) = (&u[..n], &u_next[..n], &v[..n], &v_next[..n], &v_left[..n]);
    let (vx, vy) = (&mut vx[..n], &mut vy[..n]);
    let ([qx, qy], [nx, ny]) = (w.convection, w.viscosity);
    for i in 0..n {
        let product = (v_left[i] + v_next[i]) * (u[i] + u_next[i]);
        uy[i] = qy * product - ny * (u_next[i] - u[i]);
        vx[i] = qx * product - nx * (v_next[i] - v_left[i]);
        let sum = v[i] + v_next[i];
        vy[i] = qy * (sum * sum) - ny * (v_next[i] - v[i]);
    }
}

/// Between two planes: u along z and w along x, at the edge; w along z, at the centre.
#[inline(always)]
pub(super) fn between_planes_x(
    k: &Weights,
    u: &[f64],
    u_next: &[f64],
    w: &[f64],
    w_next: &[f64],
    w_left: &[f64],
    uz: &mut [f64],
    wx: &mut [f64],
    wz: &mut [f64],
) {
    let n = uz.len();
    let (u, u_next, w, w_next, w_left) = (&u[..n], &u_next[..n], &w[..n], &w_next[..n], &w_left[..n]);
    let (wx, wz) = (&mut wx[..n], &mut wz[..n]);
    let (q, nu, nw, nx, [a, b]) = (k.quarter, k.upper, k.cell, k.viscosity[0], k.mass[0]);
    for i in 0..n {
        let sum = w_left[i] + w_next[i];
        uz[i] = q * (sum * (u[i] + u_next[i])) - nu * (u_next[i] - u[i]);
        wx[i] = sum * (a * u[i] + b * u_next[i]) - nx * (w_next[i] - w_left[i]);
        let sum = w[i] + w_next[i];
        wz[i] = q * (sum * sum) - nw * (w_next[i] - w[i]);
    }
}

/// Between two planes and two rows: v along z and w along y, at the edge.
#[inline(always)]
pub(super) fn between_planes_y(
    k: &Weights,
    v: &[f64],
    v_next: &[f64],
    w: &[f64],
    w_next: &[f64],
    vz: &mut [f64],
    wy: &mut [f64],
) {
    let n = vz.len();
    let (v, v_next, w, w_next) = (&v[..n], &v_next[..n], &w[..n], &w_next[..n]);
    let wy = &mut wy[..n];
    let (q, nu, ny, [a, b]) = (k.quarter, k.upper, k.viscosity[1], k.mass[1]);
    for i in 0..n {
        let sum = w[i] + w_next[i];
        vz[i] = q * (sum * (v[i] + v_next[i])) - nu * (v_next[i] - v[i]);
        wy[i] = sum * (a * v[i] + b * v_next[i]) - ny * (w_next[i] - w[i]);
    }
}

/// What becomes of N: `out += now N + old N_old + body`, `history = N`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Use {
    pub(super) now: f64,
    pub(super) old: f64,
    pub(super) body: f64,
}

/// N of u or v from what flows in: along x, along y, and along z with `below`, the flux through the
/// lower face, which the one through the upper face replaces. `inverse` is 1/Δz.
#[inline(always)]
pub(super) fn gather<const OLD: bool, const KEEP: bool>(
    inverse: f64,
    usage: Use,
    x: &[f64],
    x_next: &[f64],
    y: &[f64],
    y_next: &[f64],
    above: &[f64],
    below: &mut [f64],
    out: &mut [f64],
    history: &mut [f64],
) {
    let n = out.len();
    let (x, x_next, y, y_next) = (&x[..n], &x_next[..n], &y[..n], &y_next[..n]);
    let (above, below, history) = (&above[..n], &mut below[..n], &mut history[..n]);
    let Use { now, old, body } = usage;
    for i in 0..n {
        let new = (x[i] - x_next[i]) + (y[i] - y_next[i]) + inverse * (below[i] - above[i]);
        below[i] = above[i];
        let mut sum = now * new + body;
        if OLD {
            sum += old * history[i];
        }
        if KEEP {
            history[i] = new;
        }
        out[i] += sum;
    }
}

/// N of w on the lower face from what was gathered for it, `part`, and the flux along z through the
/// centre; `part` becomes what is known of the next face. `inverse` are 1/height of both.
#[inline(always)]
pub(super) fn gather_w<const OLD: bool, const KEEP: bool>(
    here: f64,
    next: f64,
    usage: Use,
    x: &[f64],
    x_next: &[f64],
    y: &[f64],
    y_next: &[f64],
    z: &[f64],
    part: &mut [f64],
    out: &mut [f64],
    history: &mut [f64],
) {
    let n = out.len();
    let (x, x_next, y, y_next) = (&x[..n], &x_next[..n], &y[..n], &y_next[..n]);
    let (z, part, history) = (&z[..n], &mut part[..n], &mut history[..n]);
    let Use { now, old, body } = usage;
    for i in 0..n {
        let new = part[i] - here * z[i];
        part[i] = (x[i] - x_next[i]) + (y[i] - y_next[i]) + next * z[i];
        let mut sum = now * new + body;
        if OLD {
            sum += old * history[i];
        }
        if KEEP {
            history[i] = new;
        }
        out[i] += sum;
    }
}

/// What is known of N of w on a face from below it alone, see [`gather_w`].
#[inline(always)]
pub(super) fn begin_w(
    inverse: f64,
    x: &[f64],
    x_next: &[f64],
    y: &[f64],
    y_next: &[f64],
    z: &[f64],
    part: &mut [f64],
) {
    let n = part.len();
    let (x, x_next, y, y_next, z) = (&x[..n], &x_next[..n], &y[..n], &y_next[..n], &z[..n]);
    for i in 0..n {
        part[i] = (x[i] - x_next[i]) + (y[i] - y_next[i]) + inverse * z[i];
    }
}
