//! Sums over the points of an interpolation, eight places at a time.
//!
//! Written so that all eight go together: whole vectors are read, and written at the end; nothing branches.

use super::interpolation::{INNER, POINTS, Weights};
use crate::lanes::{Lanes, ZERO, lanes_at};

/// ⟨b²⟩ below which the cubic interpolation is not trusted.
const TRUSTED: f64 = 0.25;

/// Added to ⟨b²⟩: where it is zero there is nothing to take along. Much below any other ⟨b²⟩.
const NOTHING: f64 = 1e-100;

/// What stands in a row: b λ and b², by cubic and by linear weights.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sums([Vec<Lanes>; 4]);

/// Groups of eight places that hold all that `count` places ask for.
pub(super) fn lane_count(count: usize) -> usize {
    (count + 8).div_ceil(8)
}

impl Sums {
    pub(super) fn fit(&mut self, count: usize) {
        for sums in &mut self.0 {
            sums.resize(sums.len().max(count), ZERO);
        }
    }

    /// Weighed sums of rows of b λ and b².
    #[inline(always)]
    pub(super) fn of_fields(
        &mut self,
        points: &Weights,
        [forces, squares]: [[&[Lanes]; POINTS]; 2],
        count: usize,
    ) {
        let [forces, squares] = [cut_to(forces, count), cut_to(squares, count)];
        let [a, b, c, d] = &mut self.0;
        let (a, b, c, d) = (&mut a[..count], &mut b[..count], &mut c[..count], &mut d[..count]);
        for e in 0..count {
            let mut sums = [ZERO; 4];
            for t in 0..POINTS {
                let (force, square) = (&forces[t][e], &squares[t][e]);
                for l in 0..8 {
                    sums[0][l] += points.cubic[t] * force[l];
                    sums[1][l] += points.cubic[t] * square[l];
                    if INNER.contains(&t) {
                        sums[2][l] += points.linear[t] * force[l];
                        sums[3][l] += points.linear[t] * square[l];
                    }
                }
            }
            [a[e], b[e], c[e], d[e]] = sums;
        }
    }

    /// Weighed sums of the places of rows of sums that begin at `first`.
    #[inline(always)]
    pub(super) fn of_sums(&mut self, points: &Weights, rows: [&Self; POINTS], first: usize, count: usize) {
        for (s, sums) in self.0.iter_mut().enumerate() {
            let weights = if s < 2 { &points.cubic } else { &points.linear };
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
    pub(super) fn bring(&self, points: &Weights, ratios: &[f64], totals: &[f64], to: &mut [f64]) {
        let [a, b, c, d] = &self.0;
        let (a, b, c, d) = (a.as_flattened(), b.as_flattened(), c.as_flattened(), d.as_flattened());
        let places = to.as_chunks_mut::<8>().0.iter_mut();
        let grains = ratios.as_chunks::<8>().0.iter().zip(totals.as_chunks::<8>().0);
        for (e, (to, (ratios, totals))) in places.zip(grains).enumerate() {
            let cubic = [along(&points.cubic, a, 8 * e), along(&points.cubic, b, 8 * e)];
            let linear = [along(&points.linear, c, 8 * e), along(&points.linear, d, 8 * e)];
            let (mut force, mut mask, mut sum) = (ZERO, ZERO, *to);
            for l in 0..8 {
                // no branch, so that all eight go together
                let trusted = if cubic[1][l] > TRUSTED { 1.0 } else { 0.0 };
                force[l] = linear[0][l] + trusted * (cubic[0][l] - linear[0][l]);
                mask[l] = linear[1][l] + trusted * (cubic[1][l] - linear[1][l]);
            }
            for l in 0..8 {
                sum[l] += ratios[l] * force[l] / ((1.0 + totals[l]) * (mask[l] + NOTHING));
            }
            *to = sum;
        }
    }
}

/// What [`Sums::bring`] adds where all stays in its place, `force` b λ and `square` b².
#[inline(always)]
pub(super) fn keep([force, square]: [&[f64]; 2], ratios: &[f64], totals: &[f64], to: &mut [f64]) {
    let places = to.as_chunks_mut::<8>().0.iter_mut();
    let grains = ratios.as_chunks::<8>().0.iter().zip(totals.as_chunks::<8>().0);
    let values = force.as_chunks::<8>().0.iter().zip(square.as_chunks::<8>().0);
    for ((to, (ratios, totals)), (force, square)) in places.zip(grains).zip(values) {
        for l in 0..8 {
            to[l] += ratios[l] * force[l] / ((1.0 + totals[l]) * (square[l] + NOTHING));
        }
    }
}

/// The first `count` of each row.
#[inline(always)]
fn cut_to([p, q, r, s]: [&[Lanes]; POINTS], count: usize) -> [&[Lanes]; POINTS] {
    [&p[..count], &q[..count], &r[..count], &s[..count]]
}

/// Eights from place `first` on.
#[inline(always)]
fn at(values: &[Lanes], first: usize) -> &[Lanes] {
    values.as_flattened()[first..].as_chunks().0
}

/// Weighed sum of four vectors.
#[inline(always)]
fn weighed([p, q, r, s]: &[f64; POINTS], a: &Lanes, b: &Lanes, c: &Lanes, d: &Lanes) -> Lanes {
    let mut out = ZERO;
    for l in 0..8 {
        out[l] = (p * a[l] + q * b[l]) + (r * c[l] + s * d[l]);
    }
    out
}

/// Weighed sum of the points of the eight places from `at` on.
#[inline(always)]
fn along(weights: &[f64; POINTS], sums: &[f64], at: usize) -> Lanes {
    weighed(
        weights,
        lanes_at(sums, at),
        lanes_at(sums, at + 1),
        lanes_at(sums, at + 2),
        lanes_at(sums, at + 3),
    )
}
