//! The momentum equation on one plane, in place.
//!
//! Planes are taken upwards and rows in order, so a flux is computed while both its sides are still
//! old, and is stored for its second use: along y in a row, along z in three planes ([`FluxesAcross`]). After
//! that nothing old is needed, and the increment can go to the velocity itself.

use super::flux::{self, Use, Weights};
use super::shape::Shape;
use crate::factors::Factors;
use crate::lanes::{Aligned, Kernel};
use crate::near_convection::NearConvection;
use pulp::Simd;

/// What goes through the lower side of a plane, from the plane below: fluxes of u and v along z, and all of
/// N of w but what leaves upwards. That of v has a row more, which nobody reads.
#[derive(Debug)]
pub(super) struct FluxesAcross {
    u: Aligned,
    v: Aligned,
    w: Aligned,
}

/// Fluxes of one row. Pairs: those carried to it, and those that it carries on.
#[derive(Debug)]
pub(super) struct Lines {
    /// Along x of u and w.
    x: [Aligned; 2],
    /// Along x of v: of this row and of the next.
    vx: [Aligned; 2],
    carried: [Aligned; 2],
    own: Aligned,
}

impl FluxesAcross {
    pub(super) fn new(shape: &Shape) -> Self {
        let rows = |count: usize| Aligned::zeros(count * shape.row);
        Self { u: rows(shape.n[1]), v: rows(shape.n[1] + 1), w: rows(shape.n[1]) }
    }
}

impl Lines {
    pub(super) fn new(shape: &Shape) -> Self {
        let wide = |count: usize| Aligned::zeros(count * shape.wide);
        // A line of x is read one place to the right, too.
        let x = || Aligned::zeros(shape.wide + 8);
        Self { x: [x(), x()], vx: [x(), x()], carried: [wide(4), wide(4)], own: wide(2) }
    }

    /// What was carried on is carried to the next row.
    #[inline(always)]
    fn turn(&mut self) {
        self.vx.swap(0, 1);
        self.carried.swap(0, 1);
    }
}

/// Where the increment goes.
pub(super) enum Target<'a> {
    /// To the velocity itself.
    Velocity,
    /// To fields of its own, of which these are the planes.
    Increment([&'a mut [f64]; 3]),
}

/// What is added to the momentum equation.
#[derive(Clone, Copy)]
pub(super) struct Given<'a, const D: usize> {
    /// Force of the caller, m/s².
    pub(super) force: Option<[&'a [f64]; 3]>,
    /// Terms of convection near grains.
    pub(super) near: Option<&'a NearConvection<D>>,
}

/// One plane of the momentum equation.
pub(super) struct MomentumPlane<'a, const D: usize> {
    pub(super) shape: &'a Shape,
    pub(super) factors: &'a Factors,
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
    /// Terms of convection near grains.
    pub(super) near: Option<&'a NearConvection<D>>,
    /// Pressure of this plane and the one below.
    pub(super) pressure: Option<[&'a [f64]; 2]>,
    pub(super) fluxes: &'a mut FluxesAcross,
    pub(super) lines: &'a mut Lines,
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
    fn run<S: Simd>(self, simd: S) {
        let Self { shape, factors, k, below, first, fluxes, lines } = self;
        let under = if k > 0 { k - 1 } else { shape.n[2] - 1 };
        let weights = Weights::new(shape, factors, under, k);
        let planes = [below, first];
        flux::first_edge(
            simd,
            &weights,
            velocity::<S>(shape, -1, planes),
            out::<S>(shape, 0, 0, fluxes, lines),
        );
        for j in 0..shape.n[1] {
            row_fluxes(simd, shape, &weights, j, planes, fluxes, lines);
            let across = vectors_mut::<S>(&mut fluxes.w[j * shape.row..][..shape.wide]);
            flux::share_of_w(simd, beside::<S>(&lines.x[1], shape.wide), across);
        }
    }
}

#[inline(always)]
fn vectors<S: Simd>(row: &[f64]) -> &[S::f64s] {
    S::as_simd_f64s(row).0
}

/// A row as vectors, to be changed.
#[inline(always)]
fn vectors_mut<S: Simd>(row: &mut [f64]) -> &mut [S::f64s] {
    S::as_mut_simd_f64s(row).0
}

/// A line and its neighbours to the right.
#[inline(always)]
fn beside<S: Simd>(line: &[f64], wide: usize) -> [&[S::f64s]; 2] {
    [vectors::<S>(&line[..wide]), vectors::<S>(&line[1..][..wide])]
}

/// The rows of a plane and the one above it that are needed for the fluxes of row `j`.
#[inline(always)]
fn velocity<'a, S: Simd>(
    shape: &Shape,
    j: isize,
    [here, above]: [[&'a [f64]; 3]; 2],
) -> flux::Velocity<'a, S> {
    let (at, up, wide) = (shape.at(j), shape.at(j + 1), shape.wide);
    let row = |plane: &'a [f64], at: usize| vectors::<S>(&plane[at..][..wide]);
    flux::Velocity {
        u: row(here[0], at),
        // Left of row −1 is another plane; nothing asks for it.
        u_left: row(here[0], at.saturating_sub(1)),
        u_next: row(here[0], up),
        u_above: row(above[0], at),
        v: row(here[1], at),
        v_next: row(here[1], up),
        v_left: row(here[1], up - 1),
        v_above: row(above[1], up),
        w: row(here[2], at),
        w_above: row(above[2], at),
        w_left: row(above[2], at.saturating_sub(1)),
        w_next: row(above[2], up),
    }
}

/// Where the fluxes of row `j` go; `fluxes.v` are those of the row above it.
#[inline(always)]
fn out<'a, S: Simd>(
    shape: &Shape,
    j: usize,
    next: usize,
    fluxes: &'a mut FluxesAcross,
    lines: &'a mut Lines,
) -> flux::Out<'a, S> {
    let (at, wide) = (j * shape.row, shape.wide);
    let Lines { x: [ux, wx], vx: [_, vx], carried: [below, carried], own } = lines;
    let x = [&mut ux[..wide], &mut wx[..wide], &mut vx[..wide]];
    let [ux, wx, vx] = x;
    flux::Out {
        x: [vectors_mut::<S>(ux), vectors_mut::<S>(wx), vectors_mut::<S>(vx)],
        below: vectors::<S>(&below[..4 * wide]).as_chunks().0,
        carried: vectors_mut::<S>(&mut carried[..4 * wide]).as_chunks_mut().0,
        own: vectors_mut::<S>(&mut own[..2 * wide]).as_chunks_mut().0,
        across: [
            vectors_mut::<S>(&mut fluxes.u[at..][..wide]),
            vectors_mut::<S>(&mut fluxes.v[next * shape.row..][..wide]),
            vectors_mut::<S>(&mut fluxes.w[at..][..wide]),
        ],
    }
}

/// All fluxes of row `j` that are not carried to it.
#[inline(always)]
fn row_fluxes<S: Simd>(
    simd: S,
    shape: &Shape,
    weights: &Weights,
    j: usize,
    planes: [[&[f64]; 3]; 2],
    fluxes: &mut FluxesAcross,
    lines: &mut Lines,
) {
    lines.turn();
    let velocity = velocity::<S>(shape, j as isize, planes);
    flux::row(simd, weights, velocity, out::<S>(shape, j, j + 1, fluxes, lines));
}

impl<const D: usize> Kernel for MomentumPlane<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let weights = Weights::new(self.shape, self.factors, self.k, self.k + 1);
        let Self { shape, here: [u, v, w], above, fluxes, lines, .. } = &mut self;
        let velocity = velocity::<S>(shape, -1, [[&**u, &**v, &**w], *above]);
        flux::first_edge(simd, &weights, velocity, out::<S>(shape, 0, 0, fluxes, lines));
        for j in 0..self.shape.n[1] {
            let Self { shape, here: [u, v, w], above, fluxes, lines, .. } = &mut self;
            row_fluxes(simd, shape, &weights, j, [[&**u, &**v, &**w], *above], fluxes, lines);
            for d in 0..3 {
                self.explicit(d, j);
            }
            self.gather(simd, j);
            for d in 0..3 {
                self.near(d, j);
                self.forces(d, j);
            }
        }
    }
}

impl<const D: usize> MomentumPlane<'_, D> {
    /// 2 α dt ν ∇²u on row `j` of component `d`, where viscosity is implicit.
    #[inline(always)]
    fn explicit(&mut self, d: usize, j: usize) {
        let Self { shape, factors, k, here, above, below, target, .. } = self;
        let Target::Increment(rhs) = target else { return };
        let (at, n) = (shape.at(j as isize), shape.n[0]);
        let weights = laplacian_weights(shape, factors.implicit, d, *k);
        let planes = [below[d], &*here[d], above[d]];
        let rhs = &mut rhs[d][at..][..shape.wide];
        rhs[n..].fill(0.0);
        laplacian(weights, planes, at, shape.row, &mut rhs[..n]);
    }

    /// dt (γ N + ζ N_old) + 2 α dt f (uniform) on row `j`.
    #[inline(always)]
    fn gather<S: Simd>(&mut self, simd: S, j: usize) {
        match (self.factors.old != 0.0, self.factors.keep) {
            (false, true) => self.gather_as::<S, false, true>(simd, j),
            (false, false) => self.gather_as::<S, false, false>(simd, j),
            (true, true) => self.gather_as::<S, true, true>(simd, j),
            (true, false) => self.gather_as::<S, true, false>(simd, j),
        }
    }

    #[inline(always)]
    fn gather_as<S: Simd, const OLD: bool, const KEEP: bool>(&mut self, simd: S, j: usize) {
        let Self { shape, factors: f, here, target, history, fluxes, lines, .. } = self;
        let (n, wide, at) = (shape.n[0], shape.wide, shape.at(j as isize));
        let out = match target {
            Target::Velocity => here,
            Target::Increment(rhs) => rhs,
        };
        let x =
            [beside::<S>(&lines.x[0], wide), beside::<S>(&lines.vx[0], wide), beside::<S>(&lines.x[1], wide)];
        let across = vectors_mut::<S>(&mut fluxes.w[j * shape.row..][..wide]);
        flux::share_of_w(simd, x[2], across);
        let fluxes = flux::Fluxes {
            x,
            below: vectors::<S>(&lines.carried[0][..4 * wide]).as_chunks().0,
            carried: vectors::<S>(&lines.carried[1][..4 * wide]).as_chunks().0,
            own: vectors::<S>(&lines.own[..2 * wide]).as_chunks().0,
        };
        flux::gather::<S, OLD, KEEP>(
            simd,
            Use { now: f.now, old: f.old, body: f.body },
            fluxes,
            out.each_mut().map(|u| &mut u[at..][..n]),
            history.each_mut().map(|x| &mut x[at..][..n]),
        );
    }

    /// The terms of convection near grains on row `j` of component `d`.
    #[inline(always)]
    fn near(&mut self, d: usize, j: usize) {
        let Self { shape, factors: f, k, here, target, near: Some(near), history, .. } = self else { return };
        let out = match target {
            Target::Velocity => &mut *here[d],
            Target::Increment(rhs) => &mut *rhs[d],
        };
        for (first, terms) in near.terms(d, j + *k * shape.n[1]) {
            let place = shape.at(j as isize) + first..;
            out[place.clone()].iter_mut().zip(terms).for_each(|(out, term)| *out += f.now * term);
            if f.keep {
                history[d][place].iter_mut().zip(terms).for_each(|(history, term)| *history += term);
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
fn subtract_slope(weight: f64, before: &[f64], here: &[f64], u: &mut [f64]) {
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
fn laplacian(weights: [f64; 4], [low, mid, high]: [&[f64]; 3], at: usize, row: usize, out: &mut [f64]) {
    let [x, y, lower, upper] = weights;
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
