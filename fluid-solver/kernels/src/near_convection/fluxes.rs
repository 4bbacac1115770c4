//! What the fluxes near grains have more than those of second order, a line of vectors at a time.

use crate::vector::Real;
use pulp::Simd;

/// Factor of the fourth-order interpolation.
const FOURTH: f64 = 1.0 / 12.0;

/// Numbers of the gradient stress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts {
    /// σ²/Δx² of the gradient stress.
    pub(super) stress: f64,
    /// (Δx/ν)² over the square of the number at which the stress is halved, s²/m².
    pub(super) limit: f64,
}

impl Parts {
    /// The stress of a `product` of gradients, where the velocity changes by the root of `square` from cell
    /// to cell.
    #[inline(always)]
    fn limited<S: Simd>(&self, square: Real<S>, product: Real<S>) -> Real<S> {
        let x = square * self.limit;
        product * self.stress / (x * x + x.splat(1.0))
    }
}

/// A line of vectors.
pub(super) type Line<'a, S> = &'a [<S as Simd>::f64s];

/// The first `m` vectors of some lines.
#[inline(always)]
fn cut<'a, S: Simd, const N: usize>(lines: [Line<'a, S>; N], m: usize) -> [Line<'a, S>; N] {
    lines.map(|line| &line[..m])
}

/// Vector `t` of a line.
#[inline(always)]
fn at<S: Simd>(simd: S, line: Line<'_, S>, t: usize) -> Real<S> {
    Real::new(simd, line[t])
}

/// Vector `t` of four lines.
#[inline(always)]
fn four<S: Simd>(simd: S, [a, b, c, d]: [Line<'_, S>; 4], t: usize) -> [Real<S>; 4] {
    [at(simd, a, t), at(simd, b, t), at(simd, c, t), at(simd, d, t)]
}

/// Makes a value vector `t` of a line.
#[inline(always)]
fn put<S: Simd>(line: &mut [S::f64s], t: usize, value: Real<S>) {
    line[t] = value.get();
}

/// Sum of two differences over four lines.
#[inline(always)]
fn slope<S: Simd>(simd: S, lines: [Line<'_, S>; 4], t: usize) -> Real<S> {
    let [a, b, c, d] = four(simd, lines, t);
    (b - a) + (d - c)
}

/// Mean of the squared differences to the values `down` and `up` beside, and beside the one behind.
#[inline(always)]
fn square_beside<S: Simd>(
    [before, behind]: [Real<S>; 2],
    [down, up, behind_down, behind_up]: [Real<S>; 4],
) -> Real<S> {
    let (a, b, c, d) = (up - before, before - down, behind_up - behind, behind - behind_down);
    ((a * a + b * b) + (c * c + d * d)) * 0.25
}

/// Lines of the fluxes over an edge, the lower one of a cell along two axes `d` and `a`.
pub(super) struct Edge<'a, S: Simd> {
    /// u_d along `a`: two below the edge, two above.
    pub(super) u: [Line<'a, S>; 4],
    /// u_d one place along `d` down and up, below and above the edge.
    pub(super) u_along: [Line<'a, S>; 4],
    /// u_a along `d`.
    pub(super) v: [Line<'a, S>; 4],
    /// u_a one place along `a` down and up, before and behind the edge.
    pub(super) v_along: [Line<'a, S>; 4],
    /// The same along the third axis: u_d below and above, u_a before and behind.
    pub(super) third: Option<[[Line<'a, S>; 4]; 2]>,
    /// Weights of the four cells about the edge.
    pub(super) weights: [Line<'a, S>; 4],
    /// Factor of all.
    pub(super) open: Line<'a, S>,
    /// What the cells before and behind weigh in the mass flux of u_a that carries u_d.
    pub(super) shares: [Line<'a, S>; 2],
    /// The same of u_d that carries u_a.
    pub(super) shares_across: [f64; 2],
    /// Factors of the whole line: of `open`, and of `shares`.
    pub(super) scale: f64,
    /// See `scale`.
    pub(super) share_scale: [f64; 2],
}

/// Flux of u_d along `a` and of u_a along `d`: weight · (mass flux · (u₋ − u − u₊ + u₊₊)/12 − σ² Σ_k ∂_k u_d
/// ∂_k u_a).
#[inline(always)]
pub(super) fn over_edge<S: Simd>(simd: S, outs: [&mut [f64]; 2], edge: &Edge<'_, S>, parts: Parts) {
    let [out, out_across] = outs.map(|out| S::as_mut_simd_f64s(out).0);
    let m = out.len();
    let out_across = &mut out_across[..m];
    let third = edge.third.map(|[u, v]| [cut::<S, 4>(u, m), cut::<S, 4>(v, m)]);
    let [u, v] = [cut::<S, 4>(edge.u, m), cut::<S, 4>(edge.v, m)];
    let [u_along, v_along] = [cut::<S, 4>(edge.u_along, m), cut::<S, 4>(edge.v_along, m)];
    let (weights, [open, share, share_behind]) =
        (cut::<S, 4>(edge.weights, m), cut::<S, 3>([edge.open, edge.shares[0], edge.shares[1]], m));
    let (scale, [before_scale, behind_scale]) = (0.25 * edge.scale, edge.share_scale);
    let [across, across_above] = edge.shares_across;
    for t in 0..m {
        let [low, below, above, high] = four(simd, u, t);
        let [left, before, behind, right] = four(simd, v, t);
        let [w, x, y, z] = four(simd, weights, t);
        let (du, dv) = (above - below, behind - before);
        let mut product = (slope(simd, u_along, t) * dv + slope(simd, v_along, t) * du) * 0.25;
        if let Some([u, v]) = third {
            product = product + slope(simd, u, t) * slope(simd, v, t) * (1.0 / 16.0);
        }
        let stress = parts.limited(du * du + dv * dv, product);
        let weight = at(simd, open, t) * scale * ((w + x) + (y + z));
        let mass =
            at(simd, share, t) * before_scale * before + at(simd, share_behind, t) * behind_scale * behind;
        let mass_across = below * across + above * across_above;
        let curve = (low + high) - (below + above);
        let curve_across = (left + right) - (before + behind);
        put(out, t, weight * (mass * curve * FOURTH - stress));
        put(out_across, t, weight * (mass_across * curve_across * FOURTH - stress));
    }
}

/// Lines of a flux of component `d` along its own axis, through the centre of a cell.
pub(super) struct Centre<'a, S: Simd> {
    /// u_d along `d`: two before the centre, two behind.
    pub(super) u: [Line<'a, S>; 4],
    /// u_d before and behind, one place down and up along another axis.
    pub(super) beside: [Line<'a, S>; 4],
    /// The same along the third axis.
    pub(super) third: Option<[Line<'a, S>; 4]>,
    /// Half the area of the faces before and behind.
    pub(super) mass: [Line<'a, S>; 2],
    /// Area at the centre.
    pub(super) area: Line<'a, S>,
    /// Weight of the cell.
    pub(super) weight: Line<'a, S>,
    /// Factor of all.
    pub(super) open: Line<'a, S>,
    /// Factor of the whole line.
    pub(super) scale: f64,
}

/// The same through a centre, where the stress is σ² Σ_k (∂_k u_d)².
#[inline(always)]
pub(super) fn through_centre<S: Simd>(simd: S, out: &mut [f64], centre: &Centre<'_, S>, parts: Parts) {
    let out = S::as_mut_simd_f64s(out).0;
    let m = out.len();
    let (u, mass) = (cut::<S, 4>(centre.u, m), cut::<S, 2>(centre.mass, m));
    let beside = cut::<S, 4>(centre.beside, m);
    let third = centre.third.map(|lines| cut::<S, 4>(lines, m));
    let [area, weight, open] = cut::<S, 3>([centre.area, centre.weight, centre.open], m);
    for t in 0..m {
        let [low, before, behind, high] = four(simd, u, t);
        let du = behind - before;
        let mut square = du * du + square_beside([before, behind], four(simd, beside, t));
        if let Some(third) = third {
            square = square + square_beside([before, behind], four(simd, third, t));
        }
        let stress = at(simd, area, t) * parts.limited(square, square);
        let flux = at(simd, mass[0], t) * before + at(simd, mass[1], t) * behind;
        let curve = (low + high) - (before + behind);
        let weight = at(simd, open, t) * centre.scale * at(simd, weight, t);
        put(out, t, weight * (flux * curve * FOURTH - stress));
    }
}
