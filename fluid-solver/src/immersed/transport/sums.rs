//! Sums over the points of an interpolation, eight places at a time.
//!
//! Written so that all eight go together: whole vectors are read, and written at the end; nothing branches.

use super::taps::{INNER, TAPS, Weights};
use crate::lanes::{Lanes, ZERO, eight};

/// ⟨b²⟩ below which the cubic interpolation is not trusted.
const TRUSTED: f64 = 0.25;

/// Added to ⟨b²⟩: where it is zero there is nothing to take along. Much below any other ⟨b²⟩.
const NOTHING: f64 = 1e-100;

/// What stands in a row: b λ and b², by cubic and by linear weights.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sums([Vec<Lanes>; 4]);

/// Eights of places that hold all that `count` places ask for.
pub(super) fn eights(count: usize) -> usize {
    (count + 8).div_ceil(8)
}

impl Sums {
    /// Room for `count` eights.
    pub(super) fn fit(&mut self, count: usize) {
        for sums in &mut self.0 {
            sums.resize(sums.len().max(count), ZERO);
        }
    }

    /// Weighed sums of rows of λ and b.
    #[inline(always)]
    pub(super) fn of_fields(&mut self, taps: &Weights, [lambda, share]: [[&[Lanes]; TAPS]; 2], count: usize) {
        let [lambda, share] = [cut_to(lambda, count), cut_to(share, count)];
        let [a, b, c, d] = &mut self.0;
        let (a, b, c, d) = (&mut a[..count], &mut b[..count], &mut c[..count], &mut d[..count]);
        for e in 0..count {
            let mut sums = [ZERO; 4];
            for t in 0..TAPS {
                let (lambda, share) = (&lambda[t][e], &share[t][e]);
                for l in 0..8 {
                    let (force, square) = (share[l] * lambda[l], share[l] * share[l]);
                    sums[0][l] += taps.cubic[t] * force;
                    sums[1][l] += taps.cubic[t] * square;
                    if INNER.contains(&t) {
                        sums[2][l] += taps.linear[t] * force;
                        sums[3][l] += taps.linear[t] * square;
                    }
                }
            }
            [a[e], b[e], c[e], d[e]] = sums;
        }
    }

    /// Weighed sums of the places of rows of sums that begin at `first`.
    #[inline(always)]
    pub(super) fn of_sums(&mut self, taps: &Weights, rows: [&Self; TAPS], first: usize, count: usize) {
        for (s, sums) in self.0.iter_mut().enumerate() {
            let weights = if s < 2 { &taps.cubic } else { &taps.linear };
            let [p, q, r, s] = [
                at(&rows[0].0[s], first),
                at(&rows[1].0[s], first),
                at(&rows[2].0[s], first),
                at(&rows[3].0[s], first),
            ];
            let [p, q, r, s] = cut_to([p, q, r, s], count);
            for (e, sums) in sums[..count].iter_mut().enumerate() {
                *sums = weighed(weights, &p[e], &q[e], &r[e], &s[e]);
            }
        }
    }

    /// Adds what comes to the places of a row, the first of whose points stand at the beginning.
    #[inline(always)]
    pub(super) fn bring(&self, taps: &Weights, odds: &[f64], totals: &[f64], to: &mut [f64]) {
        let [a, b, c, d] = &self.0;
        let (a, b, c, d) = (a.as_flattened(), b.as_flattened(), c.as_flattened(), d.as_flattened());
        let places = to.as_chunks_mut::<8>().0.iter_mut();
        let grains = odds.as_chunks::<8>().0.iter().zip(totals.as_chunks::<8>().0);
        for (e, (to, (odds, totals))) in places.zip(grains).enumerate() {
            let cubic = [along(&taps.cubic, a, 8 * e), along(&taps.cubic, b, 8 * e)];
            let linear = [along(&taps.linear, c, 8 * e), along(&taps.linear, d, 8 * e)];
            let (mut force, mut share, mut sum) = (ZERO, ZERO, *to);
            for l in 0..8 {
                // no branch, so that all eight go together
                let trusted = if cubic[1][l] > TRUSTED { 1.0 } else { 0.0 };
                force[l] = linear[0][l] + trusted * (cubic[0][l] - linear[0][l]);
                share[l] = linear[1][l] + trusted * (cubic[1][l] - linear[1][l]);
            }
            for l in 0..8 {
                sum[l] += odds[l] * force[l] / ((1.0 + totals[l]) * (share[l] + NOTHING));
            }
            *to = sum;
        }
    }
}

/// The first `count` of each row.
#[inline(always)]
fn cut_to([p, q, r, s]: [&[Lanes]; TAPS], count: usize) -> [&[Lanes]; TAPS] {
    [&p[..count], &q[..count], &r[..count], &s[..count]]
}

/// Eights from place `first` on.
#[inline(always)]
fn at(values: &[Lanes], first: usize) -> &[Lanes] {
    values.as_flattened()[first..].as_chunks().0
}

/// Weighed sum of four vectors.
#[inline(always)]
fn weighed([p, q, r, s]: &[f64; TAPS], a: &Lanes, b: &Lanes, c: &Lanes, d: &Lanes) -> Lanes {
    let mut out = ZERO;
    for l in 0..8 {
        out[l] = (p * a[l] + q * b[l]) + (r * c[l] + s * d[l]);
    }
    out
}

/// Weighed sum of the points of the eight places from `at` on.
#[inline(always)]
fn along(weights: &[f64; TAPS], sums: &[f64], at: usize) -> Lanes {
    weighed(weights, eight(sums, at), eight(sums, at + 1), eight(sums, at + 2), eight(sums, at + 3))
}
