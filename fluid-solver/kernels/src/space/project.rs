//! The two halves of a projection on one plane: ∇·u*, and u − weight ∇φ.

use super::halo::{fill_ends, fill_sides};
use super::shape::Shape;
use crate::lanes::Kernel;
use pulp::Simd;

/// `u −= weight ∇φ` on one plane, halos along x and y included; `p += φ` where the predictor has its
/// gradient.
pub(super) struct CorrectPlane<'a> {
    pub(super) shape: &'a Shape,
    pub(super) k: usize,
    pub(super) weight: f64,
    /// φ on this plane, halos filled, and below.
    pub(super) phi: [&'a [f64]; 2],
    pub(super) velocity: [&'a mut [f64]; 3],
    pub(super) pressure: Option<&'a mut [f64]>,
}

impl Kernel for CorrectPlane<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { shape, k, weight, phi: [phi, low], velocity: [u, v, w], mut pressure } = self;
        let n = shape.n[0];
        let weights = [weight * shape.inverse[0], weight * shape.inverse[1], weight * shape.slope[k]];
        for j in 0..shape.n[1] as isize {
            let (at, under) = (shape.at(j), shape.at(j - 1));
            let here = &phi[at..][..n];
            let before = [&phi[at - 1..][..n], &phi[under..][..n], &low[at..][..n]];
            correct(weights, here, before, &mut u[at..][..n], &mut v[at..][..n], &mut w[at..][..n]);
            if let Some(p) = &mut pressure {
                add(here, &mut p[at..][..n]);
            }
            fill_ends(shape, 0, u, j..j + 1);
            fill_ends(shape, 1, v, j..j + 1);
            fill_ends(shape, 2, w, j..j + 1);
            if let Some(p) = &mut pressure {
                fill_ends(shape, 3, p, j..j + 1);
            }
        }
        fill_sides(shape, 0, u);
        fill_sides(shape, 1, v);
        fill_sides(shape, 2, w);
        if let Some(p) = pressure {
            fill_sides(shape, 3, p);
        }
    }
}

/// Subtracts weight (here − before) along each axis. The results are arguments, which tells that they overlap
/// nothing.
#[inline(always)]
fn correct(
    [x, y, z]: [f64; 3],
    here: &[f64],
    [left, under, below]: [&[f64]; 3],
    u: &mut [f64],
    v: &mut [f64],
    w: &mut [f64],
) {
    let n = here.len();
    let (left, under, below) = (&left[..n], &under[..n], &below[..n]);
    let (u, v, w) = (&mut u[..n], &mut v[..n], &mut w[..n]);
    for i in 0..n {
        let next = [
            u[i] - x * (here[i] - left[i]),
            v[i] - y * (here[i] - under[i]),
            w[i] - z * (here[i] - below[i]),
        ];
        [u[i], v[i], w[i]] = next;
    }
}

/// `out = inverse ∇·u`, `p −= correction ∇·u` on one plane; closes u and v at their upper ends.
pub(super) struct DivergencePlane<'a> {
    pub(super) shape: &'a Shape,
    pub(super) k: usize,
    pub(super) inverse: f64,
    pub(super) velocity: [&'a mut [f64]; 3],
    /// w on the plane above.
    pub(super) above: &'a [f64],
    pub(super) out: &'a mut [f64],
    /// Pressure and what multiplies ∇·u in it.
    pub(super) pressure: Option<(&'a mut [f64], f64)>,
}

impl Kernel for DivergencePlane<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { shape, k, inverse, velocity: [u, v, w], above, out, mut pressure } = self;
        let n = shape.n[0];
        let (x, y, z) = (inverse * shape.inverse[0], inverse * shape.inverse[1], inverse * shape.cell[k]);
        let rows = shape.n[1] as isize;
        if shape.periodic(1) {
            let (first, last) = (shape.at(0), shape.at(rows));
            v.copy_within(first..first + n, last);
        }
        for j in 0..rows {
            let (at, over) = (shape.at(j), shape.at(j + 1));
            if shape.periodic(0) {
                u[at + n] = u[at];
            }
            let row = &mut out[at..][..shape.wide];
            row[n..].fill(0.0);
            let row = &mut row[..n];
            let low = [&u[at..][..n], &v[at..][..n], &w[at..][..n]];
            divergence([x, y, z], low, [&u[at + 1..][..n], &v[over..][..n], &above[at..][..n]], row);
            if let Some((p, correction)) = &mut pressure {
                let weight = *correction / inverse;
                for (p, row) in p[at..][..n].iter_mut().zip(&*row) {
                    *p -= weight * row;
                }
            }
        }
    }
}

/// Σ weight (high − low); the result is an argument, which tells that it overlaps nothing.
#[inline(always)]
fn divergence([x, y, z]: [f64; 3], [u, v, w]: [&[f64]; 3], [east, north, top]: [&[f64]; 3], out: &mut [f64]) {
    let n = out.len();
    let (u, east, v, north, w, top) = (&u[..n], &east[..n], &v[..n], &north[..n], &w[..n], &top[..n]);
    for i in 0..n {
        out[i] = (x * (east[i] - u[i]) + y * (north[i] - v[i])) + z * (top[i] - w[i]);
    }
}

/// `u += increment` on one plane.
pub(super) struct AddPlane<'a> {
    pub(super) shape: &'a Shape,
    pub(super) d: usize,
    pub(super) k: usize,
    pub(super) increment: &'a [f64],
    pub(super) velocity: &'a mut [f64],
}

impl Kernel for AddPlane<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { shape, d, k, increment, velocity } = self;
        let n = shape.n[0];
        for j in 0..shape.n[1] {
            let at = shape.at(j as isize);
            let row = &mut velocity[at..][..n];
            add(&increment[at..][..n], row);
            super::momentum::reset_wall_faces(shape, d, [j, k], row);
        }
    }
}

/// u += x.
#[inline(always)]
fn add(x: &[f64], u: &mut [f64]) {
    for (u, x) in u.iter_mut().zip(x) {
        *u += x;
    }
}
