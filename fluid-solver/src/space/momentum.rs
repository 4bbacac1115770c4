//! The momentum equation on one plane, in place.
//!
//! Planes are taken upwards and rows in order, so a flux is computed while both its sides are still
//! old, and is stored for its second use: along y in a row, along z in three planes ([`FluxesAcross`]). After
//! that nothing old is needed, and the increment can go to the velocity itself.

use super::flux::{
    Use, Weights, begin_w, between_planes_x, between_planes_y, between_rows, gather, gather_w, u_along_x,
};
use super::shape::Shape;
use crate::lanes::{Aligned, Kernel};
use pulp::Simd;

/// What multiplies each term in one stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    /// Viscosity within N, m²/s.
    pub(super) explicit: f64,
    /// Viscosity of the increment, times 2 α dt, m².
    pub(super) implicit: f64,
    /// Whether there is convection.
    pub(super) convection: bool,
    /// dt γ, s.
    pub(super) now: f64,
    /// dt ζ, s; zero: N_old is not read.
    pub(super) old: f64,
    /// Whether N is kept for a later stage.
    pub(super) keep: bool,
    /// 2 α dt, s.
    pub(super) length: f64,
    /// Body force, m/s².
    pub(super) body: [f64; 3],
}

/// Fluxes through the lower side of a plane, from the plane below: u and v along z, and all of N_w but what
/// leaves upwards.
#[derive(Debug)]
pub(super) struct FluxesAcross {
    u: Aligned,
    v: Aligned,
    w: Aligned,
}

/// Fluxes of one row; pairs are those below and above the row.
#[derive(Debug)]
pub(super) struct Lines {
    ux: Aligned,
    uz: Aligned,
    wx: Aligned,
    wz: Aligned,
    uy: [Aligned; 2],
    vx: [Aligned; 2],
    vy: [Aligned; 2],
    vz: [Aligned; 2],
    wy: [Aligned; 2],
}

impl FluxesAcross {
    /// Room for one plane.
    pub(super) fn new(shape: &Shape) -> Self {
        let plane = || Aligned::zeros(shape.n[1] * shape.row);
        Self { u: plane(), v: plane(), w: plane() }
    }
}

impl Lines {
    /// Room for one row.
    pub(super) fn new(shape: &Shape) -> Self {
        let row = || Aligned::zeros(shape.wide + 8);
        let pair = || [row(), row()];
        Self {
            ux: row(),
            uz: row(),
            wx: row(),
            wz: row(),
            uy: pair(),
            vx: pair(),
            vy: pair(),
            vz: pair(),
            wy: pair(),
        }
    }
}

/// Where the increment goes.
pub(super) enum Target<'a> {
    /// To the velocity itself.
    Velocity,
    /// To fields of its own, of which these are the planes.
    Increment([&'a mut [f64]; 3]),
}

/// One plane of the momentum equation.
pub(super) struct MomentumPlane<'a> {
    pub(super) shape: &'a Shape,
    pub(super) factors: &'a Factors,
    /// Number of the plane.
    pub(super) k: usize,
    /// The plane: old velocity on entry.
    pub(super) here: [&'a mut [f64]; 3],
    /// The plane above, old.
    pub(super) above: [&'a [f64]; 3],
    /// The plane below, old; only asked for by implicit viscosity.
    pub(super) below: [&'a [f64]; 3],
    pub(super) target: Target<'a>,
    /// N_old on entry, N on return.
    pub(super) history: [&'a mut [f64]; 3],
    /// Force of the caller.
    pub(super) force: Option<[&'a [f64]; 3]>,
    /// Pressure of this plane and the one below.
    pub(super) pressure: Option<[&'a [f64]; 2]>,
    pub(super) fluxes: &'a mut FluxesAcross,
    pub(super) lines: &'a mut Lines,
}

/// Factors of the fluxes from cell `cell` through `face` above it.
fn weights(shape: &Shape, f: &Factors, cell: usize, face: usize) -> Weights {
    let (quarter, nu) = (if f.convection { 0.25 } else { 0.0 }, f.explicit);
    let ([x, y], [low, high]) = (shape.inverse, shape.cell_weights[face]);
    Weights {
        quarter,
        convection: [quarter * x, quarter * y],
        viscosity: [nu * x * x, nu * y * y],
        upper: nu * shape.slope[face],
        cell: nu * shape.cell[cell],
        mass: [
            [2.0 * quarter * x * low, 2.0 * quarter * x * high],
            [2.0 * quarter * y * low, 2.0 * quarter * y * high],
        ],
    }
}

/// Fills `fluxes` with what goes from the plane below to the first plane of a slab.
pub(super) struct FirstFluxes<'a> {
    pub(super) shape: &'a Shape,
    pub(super) factors: &'a Factors,
    /// Number of the first plane.
    pub(super) k: usize,
    pub(super) below: [&'a [f64]; 3],
    pub(super) first: [&'a [f64]; 3],
    pub(super) fluxes: &'a mut FluxesAcross,
    pub(super) lines: &'a mut Lines,
}

impl Kernel for FirstFluxes<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { shape, factors, k, below, first, fluxes, lines } = self;
        let under = if k > 0 { k - 1 } else { shape.n[2] - 1 };
        let weights = weights(shape, factors, under, k);
        let n = shape.n[0];
        vertical_edge(shape, &weights, -1, below, first, lines);
        for j in 0..shape.n[1] as isize {
            lines.turn();
            vertical(shape, &weights, j, below, first, lines);
            vertical_edge(shape, &weights, j, below, first, lines);
            let at = j as usize * shape.row;
            let Lines { uz, wx, wz, vz, wy, .. } = &mut *lines;
            fluxes.u[at..at + n].copy_from_slice(&uz[..n]);
            fluxes.v[at..at + n].copy_from_slice(&vz[0][..n]);
            let part = &mut fluxes.w[at..at + n];
            begin_w(shape.face[k], wx, &wx[1..], &wy[0], &wy[1], wz, part);
        }
    }
}

impl Lines {
    /// What was above the last row is below the next.
    #[inline(always)]
    fn turn(&mut self) {
        self.uy.swap(0, 1);
        self.vx.swap(0, 1);
        self.vy.swap(0, 1);
        self.vz.swap(0, 1);
        self.wy.swap(0, 1);
    }
}

/// Fluxes between two planes over row `j`.
#[inline(always)]
fn vertical(
    shape: &Shape,
    weights: &Weights,
    j: isize,
    here: [&[f64]; 3],
    above: [&[f64]; 3],
    lines: &mut Lines,
) {
    let (at, wide) = (shape.at(j), shape.wide);
    let Lines { uz, wx, wz, .. } = lines;
    let (u, u_next) = (&here[0][at..][..wide], &above[0][at..][..wide]);
    let (w, w_next, w_left) = (&here[2][at..][..wide], &above[2][at..][..wide], &above[2][at - 1..][..wide]);
    let (uz, wx, wz) = (&mut uz[..wide], &mut wx[..wide], &mut wz[..wide]);
    between_planes_x(weights, u, u_next, w, w_next, w_left, uz, wx, wz);
}

/// Fluxes between two planes over the edge above row `j`.
#[inline(always)]
fn vertical_edge(
    shape: &Shape,
    weights: &Weights,
    j: isize,
    here: [&[f64]; 3],
    above: [&[f64]; 3],
    lines: &mut Lines,
) {
    let (at, up, n) = (shape.at(j), shape.at(j + 1), shape.n[0]);
    let Lines { vz, wy, .. } = lines;
    let (v, v_next) = (&here[1][up..][..n], &above[1][up..][..n]);
    let (w, w_next) = (&above[2][at..][..n], &above[2][up..][..n]);
    between_planes_y(weights, v, v_next, w, w_next, &mut vz[1][..n], &mut wy[1][..n]);
}

/// Fluxes of a plane over the edge above row `j`.
#[inline(always)]
fn edge(shape: &Shape, weights: &Weights, j: isize, here: [&[f64]; 3], lines: &mut Lines) {
    let (at, up, wide) = (shape.at(j), shape.at(j + 1), shape.wide);
    let Lines { uy, vx, vy, .. } = lines;
    let (u, u_next) = (&here[0][at..][..wide], &here[0][up..][..wide]);
    let (v, v_next, v_left) = (&here[1][at..][..wide], &here[1][up..][..wide], &here[1][up - 1..][..wide]);
    let (uy, vx, vy) = (&mut uy[1][..wide], &mut vx[1][..wide], &mut vy[1][..wide]);
    between_rows(weights, u, u_next, v, v_next, v_left, uy, vx, vy);
}

impl Kernel for MomentumPlane<'_> {
    #[inline(always)]
    fn run<S: Simd>(mut self, _: S) {
        let weights = weights(self.shape, self.factors, self.k, self.k + 1);
        let [u, v, w] = &self.here;
        let here = [&**u, &**v, &**w];
        edge(self.shape, &weights, -1, here, self.lines);
        vertical_edge(self.shape, &weights, -1, here, self.above, self.lines);
        for j in 0..self.shape.n[1] {
            self.row_fluxes(&weights, j as isize);
            for d in 0..3 {
                self.explicit(d, j);
                self.gather(d, j);
                self.forces(d, j);
            }
        }
    }
}

impl MomentumPlane<'_> {
    /// All fluxes of row `j` that are not there yet.
    #[inline(always)]
    fn row_fluxes(&mut self, weights: &Weights, j: isize) {
        let Self { shape, here: [u, v, w], above, lines, .. } = self;
        let here = [&**u, &**v, &**w];
        lines.turn();
        let (at, wide) = (shape.at(j), shape.wide);
        u_along_x(weights, &here[0][at - 1..][..wide], &here[0][at..][..wide], &mut lines.ux[..wide]);
        edge(shape, weights, j, here, lines);
        vertical(shape, weights, j, here, *above, lines);
        vertical_edge(shape, weights, j, here, *above, lines);
    }

    /// 2 α dt ν ∇²u on row `j` of component `d`, where viscosity is implicit.
    #[inline(always)]
    fn explicit(&mut self, d: usize, j: usize) {
        let Self { shape, factors, k, here, above, below, target, .. } = self;
        let Target::Increment(rhs) = target else { return };
        let (at, n) = (shape.at(j as isize), shape.n[0]);
        let weights = laplacian_weights(shape, factors.implicit, d, *k);
        let [low, mid, high] = [below[d], &*here[d], above[d]];
        let rhs = &mut rhs[d][at..][..shape.wide];
        rhs[n..].fill(0.0);
        laplacian(weights, low, mid, high, at, shape.row, &mut rhs[..n]);
    }

    /// dt (γ N + ζ N_old) + 2 α dt f (uniform) on row `j` of component `d`.
    #[inline(always)]
    fn gather(&mut self, d: usize, j: usize) {
        match (self.factors.old != 0.0, self.factors.keep) {
            (false, true) => self.gather_as::<false, true>(d, j),
            (false, false) => self.gather_as::<false, false>(d, j),
            (true, true) => self.gather_as::<true, true>(d, j),
            (true, false) => self.gather_as::<true, false>(d, j),
        }
    }

    #[inline(always)]
    fn gather_as<const OLD: bool, const KEEP: bool>(&mut self, d: usize, j: usize) {
        let Self { shape, factors: f, k, here, target, history, fluxes, lines, .. } = self;
        let (n, k) = (shape.n[0], *k);
        let at = shape.at(j as isize);
        let out = match target {
            Target::Velocity => &mut here[d][at..][..n],
            Target::Increment(rhs) => &mut rhs[d][at..][..n],
        };
        let history = &mut history[d][at..][..n];
        let usage = Use { now: f.now, old: f.old, body: f.length * f.body[d] };
        let row = j * shape.row..j * shape.row + n;
        let Lines { ux, uz, wx, wz, uy, vx, vy, vz, wy } = &mut **lines;
        let cell = shape.cell[k];
        match d {
            0 => {
                let below = &mut fluxes.u[row];
                gather::<OLD, KEEP>(cell, usage, ux, &ux[1..], &uy[0], &uy[1], uz, below, out, history);
            }
            1 => {
                let (x, y, below) = (&vx[0], &vy, &mut fluxes.v[row]);
                gather::<OLD, KEEP>(cell, usage, x, &x[1..], &y[0], &y[1], &vz[0], below, out, history);
            }
            _ => {
                let (here, next) = (shape.face[k], shape.face[k + 1]);
                let (x, y, part) = (&wx, &wy, &mut fluxes.w[row]);
                gather_w::<OLD, KEEP>(here, next, usage, x, &x[1..], &y[0], &y[1], wz, part, out, history);
            }
        }
    }

    /// 2 α dt (f − ∇p) of caller and pressure on row `j` of component `d`.
    #[inline(always)]
    fn forces(&mut self, d: usize, j: usize) {
        let Self { shape, factors: f, k, here, target, force, pressure, .. } = self;
        let (n, at) = (shape.n[0], shape.at(j as isize));
        let (out, in_place) = match target {
            Target::Velocity => (&mut here[d][at..][..n], true),
            Target::Increment(rhs) => (&mut rhs[d][at..][..n], false),
        };
        if let Some(force) = force {
            add_scaled(f.length, &force[d][at..][..n], out);
        }
        if let Some([p, p_below]) = pressure {
            let here = &p[at..][..n];
            let (before, inverse) = match d {
                0 => (&p[at - 1..][..n], shape.inverse[0]),
                1 => (&p[shape.at(j as isize - 1)..][..n], shape.inverse[1]),
                _ => (&p_below[at..][..n], shape.slope[*k]),
            };
            subtract_slope(f.length * inverse, before, here, out);
        }
        if in_place {
            reset_wall_faces(shape, d, [j, *k], out);
        }
    }
}

/// No increment on wall faces.
#[inline(always)]
pub(super) fn reset_wall_faces(shape: &Shape, d: usize, [j, k]: [usize; 2], row: &mut [f64]) {
    if shape.periodic(d) {
        return;
    }
    if d == 0 {
        row[0] = 0.0;
    } else if (d == 1 && j == 0) || (d == 2 && k == 0) {
        row.fill(0.0);
    }
}

/// u += weight f.
#[inline(always)]
fn add_scaled(weight: f64, force: &[f64], u: &mut [f64]) {
    for (u, force) in u.iter_mut().zip(force) {
        *u += weight * force;
    }
}

/// u −= weight (here − before).
#[inline(always)]
pub(super) fn subtract_slope(weight: f64, before: &[f64], here: &[f64], u: &mut [f64]) {
    let n = u.len();
    let (before, here) = (&before[..n], &here[..n]);
    for i in 0..n {
        u[i] -= weight * (here[i] - before[i]);
    }
}

/// Weights of the neighbours: along x, along y, below, above.
fn laplacian_weights(shape: &Shape, nu: f64, d: usize, k: usize) -> [f64; 4] {
    let [x, y] = shape.inverse;
    let (x, y) = (nu * x * x, nu * y * y);
    if d < 2 {
        return [x, y, nu * shape.cell[k] * shape.slope[k], nu * shape.cell[k] * shape.slope[k + 1]];
    }
    let under = if k > 0 { k - 1 } else { shape.n[2] - 1 };
    [x, y, nu * shape.face[k] * shape.cell[under], nu * shape.face[k] * shape.cell[k]]
}

/// out = Σ weight (neighbour − u).
#[inline(always)]
fn laplacian(
    [x, y, lower, upper]: [f64; 4],
    low: &[f64],
    mid: &[f64],
    high: &[f64],
    at: usize,
    row: usize,
    out: &mut [f64],
) {
    let n = out.len();
    let (left, right) = (&mid[at - 1..][..n], &mid[at + 1..][..n]);
    let (under, over) = (&mid[at - row..][..n], &mid[at + row..][..n]);
    let (low, mid, high) = (&low[at..][..n], &mid[at..][..n], &high[at..][..n]);
    for i in 0..n {
        let m = mid[i];
        out[i] = x * ((left[i] - m) + (right[i] - m))
            + y * ((under[i] - m) + (over[i] - m))
            + (lower * (low[i] - m) + upper * (high[i] - m));
    }
}
