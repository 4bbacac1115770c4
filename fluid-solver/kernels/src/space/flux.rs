//! Momentum fluxes through the faces of the control volumes, row by row.
//!
//! Convection is the plain mean of the velocity times the mean of the mass fluxes
//! (Verstappen & Veldman 2003), viscosity −ν ∂u/∂x. A flux serves the control volumes
//! on both its sides. Fluxes along x and y are divided by the cell width, those along z are not.
//!
//! Row `j` of plane `k` has the fluxes of u along x, y (above the row) and z (above the plane), of w
//! likewise, and of v along x and z on the face above the row, along y through the centre. So each is
//! computed once, from left to right and upwards.

use super::shape::Shape;
use crate::factors::Factors;
use crate::vector::Real;
use pulp::Simd;

/// Factors of one stage and plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// ¼, or 0 without convection.
    quarter: f64,
    /// ¼/Δx, ¼/Δy.
    convection: [f64; 2],
    /// ν/Δx², ν/Δy².
    viscosity: [f64; 2],
    /// ν/distance of the centres beside the upper face.
    upper: f64,
    /// ν/Δz of the cell.
    cell: f64,
    /// Weights of the cells below and above the upper face in the mass flux: ½/Δx times
    /// [`Shape::cell_weights`], the same for Δy.
    mass: [[f64; 2]; 2],
    /// 1/Δz of the cell.
    inverse: f64,
    /// 1/height of the control volume of w on the lower and the upper face.
    height: [f64; 2],
}

impl Weights {
    /// For the fluxes from cell `cell` through `face` above it.
    pub(super) fn new(shape: &Shape, f: &Factors, cell: usize, face: usize) -> Self {
        let (quarter, nu) = (if f.convection { 0.25 } else { 0.0 }, f.explicit);
        let ([x, y], [low, high]) = (shape.inverse, shape.cell_weights[face]);
        Self {
            quarter,
            convection: [quarter * x, quarter * y],
            viscosity: [nu * x * x, nu * y * y],
            upper: nu * shape.slope[face],
            cell: nu * shape.cell[cell],
            mass: [
                [2.0 * quarter * x * low, 2.0 * quarter * x * high],
                [2.0 * quarter * y * low, 2.0 * quarter * y * high],
            ],
            inverse: shape.cell[cell],
            height: [shape.face[cell], shape.face[face]],
        }
    }
}

/// The rows of velocity, as vectors, from which the fluxes of a row are computed; rows of v and w reach
/// beyond it: `next` is the row above, `above` the plane above.
#[derive(Clone, Copy)]
pub(super) struct Velocity<'a, S: Simd> {
    pub(super) u: &'a [S::f64s],
    /// One place to the left.
    pub(super) u_left: &'a [S::f64s],
    pub(super) u_next: &'a [S::f64s],
    pub(super) u_above: &'a [S::f64s],
    pub(super) v: &'a [S::f64s],
    pub(super) v_next: &'a [S::f64s],
    /// `v_next` one place to the left.
    pub(super) v_left: &'a [S::f64s],
    /// The next row of the plane above.
    pub(super) v_above: &'a [S::f64s],
    pub(super) w: &'a [S::f64s],
    pub(super) w_above: &'a [S::f64s],
    /// `w_above` one place to the left.
    pub(super) w_left: &'a [S::f64s],
    /// The next row of the plane above.
    pub(super) w_next: &'a [S::f64s],
}

/// Fluxes carried from row to row, a vector of each: u along y, v along y, w along y, and what N of v has
/// from its fluxes along z.
pub(super) type Carried<S> = [<S as Simd>::f64s; 4];

/// What a row keeps for its own N, a vector of each: the share of y and z in that of u, and all of w.
pub(super) type Own<S> = [<S as Simd>::f64s; 2];

/// What the fluxes of a row are written to.
pub(super) struct Out<'a, S: Simd> {
    /// Along x: of u, of w, and of v in the next row.
    pub(super) x: [&'a mut [S::f64s]; 3],
    /// Of the row below.
    pub(super) below: &'a [Carried<S>],
    pub(super) carried: &'a mut [Carried<S>],
    pub(super) own: &'a mut [Own<S>],
    /// On entry what comes through the lower face, on return what goes through the upper one: flux of u, flux
    /// of v in the next row, N of w on that face but its share along x.
    pub(super) across: [&'a mut [S::f64s]; 3],
}

/// Flux through a centre: of a component along its own axis.
#[inline(always)]
fn through_centre<S: Simd>(quarter: f64, nu: f64, low: Real<S>, high: Real<S>) -> Real<S> {
    let sum = low + high;
    sum * sum * quarter - (high - low) * nu
}

/// Fluxes over the edge above a row: of u and w along y, of v along x and z; and of v along y, through the
/// centre below the edge.
struct Edge<S: Simd> {
    uy: Real<S>,
    wy: Real<S>,
    vx: Real<S>,
    vy: Real<S>,
    vz: Real<S>,
}

impl<S: Simd> Velocity<'_, S> {
    /// Vector `t` of the fluxes over the edge above the row.
    #[inline(always)]
    fn edge(&self, simd: S, k: &Weights, t: usize) -> Edge<S> {
        let (u, u_next) = (Real::new(simd, self.u[t]), Real::new(simd, self.u_next[t]));
        let (v, v_next) = (Real::new(simd, self.v[t]), Real::new(simd, self.v_next[t]));
        let (v_left, v_above) = (Real::new(simd, self.v_left[t]), Real::new(simd, self.v_above[t]));
        let (w, w_next) = (Real::new(simd, self.w_above[t]), Real::new(simd, self.w_next[t]));
        let ([qx, qy], [nx, ny], [a, b]) = (k.convection, k.viscosity, k.mass[1]);
        let product = (v_left + v_next) * (u + u_next);
        let sum = w + w_next;
        Edge {
            uy: product * qy - (u_next - u) * ny,
            vx: product * qx - (v_next - v_left) * nx,
            vy: through_centre(qy, ny, v, v_next),
            vz: sum * (v_next + v_above) * k.quarter - (v_above - v_next) * k.upper,
            wy: sum * (v_next * a + v_above * b) - (w_next - w) * ny,
        }
    }

    /// The same rows, cut to `m` vectors: one check of their lengths for a whole loop.
    #[inline(always)]
    fn cut(self, m: usize) -> Self {
        Self {
            u: &self.u[..m],
            u_left: &self.u_left[..m],
            u_next: &self.u_next[..m],
            u_above: &self.u_above[..m],
            v: &self.v[..m],
            v_next: &self.v_next[..m],
            v_left: &self.v_left[..m],
            v_above: &self.v_above[..m],
            w: &self.w[..m],
            w_above: &self.w_above[..m],
            w_left: &self.w_left[..m],
            w_next: &self.w_next[..m],
        }
    }
}

/// Fluxes over the edge below row 0: those that the row finds carried.
#[inline(always)]
pub(super) fn first_edge<S: Simd>(simd: S, k: &Weights, from: Velocity<'_, S>, out: Out<'_, S>) {
    let Out { x: [.., vx], carried, across: [_, across, _], .. } = out;
    let m = carried.len();
    let (from, vx, across) = (from.cut(m), &mut vx[..m], &mut across[..m]);
    for t in 0..m {
        let edge = from.edge(simd, k, t);
        let vz = (Real::new(simd, across[t]) - edge.vz) * k.inverse;
        (across[t], vx[t]) = (edge.vz.get(), edge.vx.get());
        carried[t] = [edge.uy.get(), edge.vy.get(), edge.wy.get(), vz.get()];
    }
}

/// All fluxes of a row that are not carried to it.
#[inline(always)]
pub(super) fn row<S: Simd>(simd: S, k: &Weights, from: Velocity<'_, S>, out: Out<'_, S>) {
    let Out { x: [ux, wx, vx], below, carried, own, across: [across_u, across_v, across_w] } = out;
    let m = carried.len();
    let (from, below, own) = (from.cut(m), &below[..m], &mut own[..m]);
    let (ux, wx, vx) = (&mut ux[..m], &mut wx[..m], &mut vx[..m]);
    let (across_u, across_v) = (&mut across_u[..m], &mut across_v[..m]);
    let across_w = &mut across_w[..m];
    let ([qx, _], [nx, _], [a, b]) = (k.convection, k.viscosity, k.mass[0]);
    let [lower, upper] = k.height;
    for t in 0..m {
        let edge = from.edge(simd, k, t);
        let (left, u, above) =
            (Real::new(simd, from.u_left[t]), Real::new(simd, from.u[t]), Real::new(simd, from.u_above[t]));
        let (w_left, w, w_above) =
            (Real::new(simd, from.w_left[t]), Real::new(simd, from.w[t]), Real::new(simd, from.w_above[t]));
        let (low_u, low_v) = (Real::new(simd, across_u[t]), Real::new(simd, across_v[t]));
        let low_w = Real::new(simd, across_w[t]);
        let (uy, wy) = (Real::new(simd, below[t][0]), Real::new(simd, below[t][2]));
        let sum = w_left + w_above;
        let uz = sum * (u + above) * k.quarter - (above - u) * k.upper;
        let wz = through_centre(k.quarter, k.cell, w, w_above);
        let own_u = (uy - edge.uy) + (low_u - uz) * k.inverse;
        let own_w = low_w - wz * lower;
        let vz = (low_v - edge.vz) * k.inverse;
        let next_w = (wy - edge.wy) + wz * upper;
        ux[t] = through_centre(qx, nx, left, u).get();
        wx[t] = (sum * (u * a + above * b) - (w_above - w_left) * nx).get();
        vx[t] = edge.vx.get();
        own[t] = [own_u.get(), own_w.get()];
        carried[t] = [edge.uy.get(), edge.vy.get(), edge.wy.get(), vz.get()];
        (across_u[t], across_v[t], across_w[t]) = (uz.get(), edge.vz.get(), next_w.get());
    }
}

/// What becomes of N: `out += now N + old N_old + body`, `history = N`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Use {
    pub(super) now: f64,
    pub(super) old: f64,
    pub(super) body: [f64; 3],
}

/// The fluxes of a row, for its N.
#[derive(Clone, Copy)]
pub(super) struct Fluxes<'a, S: Simd> {
    /// Along x, of u, v and w; each with its neighbour to the right.
    pub(super) x: [[&'a [S::f64s]; 2]; 3],
    pub(super) below: &'a [Carried<S>],
    pub(super) carried: &'a [Carried<S>],
    pub(super) own: &'a [Own<S>],
}

impl<S: Simd> Fluxes<'_, S> {
    /// The first `m` vectors.
    #[inline(always)]
    fn cut(self, m: usize) -> Self {
        let [[u, u_right], [v, v_right], [w, w_right]] = self.x;
        let x = [[&u[..m], &u_right[..m]], [&v[..m], &v_right[..m]], [&w[..m], &w_right[..m]]];
        Self { x, below: &self.below[..m], carried: &self.carried[..m], own: &self.own[..m] }
    }

    /// What flows in along x for component `d`.
    #[inline(always)]
    fn along_x(&self, simd: S, d: usize, t: usize) -> Real<S> {
        let [left, right] = self.x[d];
        Real::new(simd, left[t]) - Real::new(simd, right[t])
    }

    /// Vector `t` of N of u, v and w.
    #[inline(always)]
    fn sum(&self, simd: S, t: usize) -> [Real<S>; 3] {
        let (own_u, own_w) = (Real::new(simd, self.own[t][0]), Real::new(simd, self.own[t][1]));
        let (vy, vz) = (Real::new(simd, self.below[t][1]), Real::new(simd, self.below[t][3]));
        let vy = vy - Real::new(simd, self.carried[t][1]);
        [self.along_x(simd, 0, t) + own_u, self.along_x(simd, 1, t) + (vy + vz), own_w]
    }
}

/// `out += now N + old N_old + body`, `history = N` on a row, for the component `d` of `fluxes`.
#[inline(always)]
pub(super) fn gather<S: Simd, const OLD: bool, const KEEP: bool>(
    simd: S,
    usage: Use,
    fluxes: Fluxes<'_, S>,
    out: [&mut [f64]; 3],
    history: [&mut [f64]; 3],
) {
    let [mut u, mut v, mut w] = out.map(S::as_mut_simd_f64s);
    let [mut old_u, mut old_v, mut old_w] = history.map(S::as_mut_simd_f64s);
    let m = u.0.len();
    let fluxes = fluxes.cut(fluxes.own.len());
    {
        let (u, v, w) = (&mut u.0[..m], &mut v.0[..m], &mut w.0[..m]);
        let (old_u, old_v, old_w) = (&mut old_u.0[..m], &mut old_v.0[..m], &mut old_w.0[..m]);
        let whole = fluxes.cut(m);
        for t in 0..m {
            // All is read before anything is written: the fields lie alike in their pages, and a value read
            // waits for one written to the same place of another page.
            let [new_u, new_v, new_w] = whole.sum(simd, t);
            let next_u = usage.apply::<S, OLD>(0, new_u, u[t], old_u[t]);
            let next_v = usage.apply::<S, OLD>(1, new_v, v[t], old_v[t]);
            let next_w = usage.apply::<S, OLD>(2, new_w, w[t], old_w[t]);
            (u[t], v[t], w[t]) = (next_u, next_v, next_w);
            if KEEP {
                (old_u[t], old_v[t], old_w[t]) = (new_u.get(), new_v.get(), new_w.get());
            }
        }
    }
    if !u.1.is_empty() {
        let new = fluxes.sum(simd, m);
        let pairs = [(&mut u.1, &mut old_u.1), (&mut v.1, &mut old_v.1), (&mut w.1, &mut old_w.1)];
        for (d, (out, history)) in pairs.into_iter().enumerate() {
            let (x, old) = (simd.partial_load_f64s(out), simd.partial_load_f64s(history));
            simd.partial_store_f64s(out, usage.apply::<S, OLD>(d, new[d], x, old));
            if KEEP {
                simd.partial_store_f64s(history, new[d].get());
            }
        }
    }
}

impl Use {
    /// One vector of component `d`.
    #[inline(always)]
    fn apply<S: Simd, const OLD: bool>(
        &self,
        d: usize,
        new: Real<S>,
        out: S::f64s,
        history: S::f64s,
    ) -> S::f64s {
        let mut sum = new * self.now + new.splat(self.body[d]);
        if OLD {
            sum = sum + new.with(history) * self.old;
        }
        sum.plus(out)
    }
}

/// The share along x of N of w on the upper face.
#[inline(always)]
pub(super) fn share_of_w<S: Simd>(simd: S, [left, right]: [&[S::f64s]; 2], across: &mut [S::f64s]) {
    let m = across.len();
    let (left, right) = (&left[..m], &right[..m]);
    for t in 0..m {
        let share = Real::new(simd, left[t]) - Real::new(simd, right[t]);
        across[t] = share.plus(across[t]);
    }
}
