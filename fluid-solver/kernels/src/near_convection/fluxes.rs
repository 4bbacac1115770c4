//! What the fluxes near grains have more than those of second order, a line at a time.

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
    /// Factor of the stress where the velocity changes by the root of `square` from cell to cell.
    #[inline(always)]
    fn limited(&self, square: f64) -> f64 {
        let x = self.limit * square;
        self.stress / (1.0 + x * x)
    }
}

/// Lines of the fluxes over an edge, the lower one of a cell along two axes `d` and `a`.
pub(super) struct Edge<'a> {
    /// u_d along `a`: two below the edge, two above.
    pub(super) u: [&'a [f64]; 4],
    /// u_d one place along `d` down and up, below and above the edge.
    pub(super) u_along: [&'a [f64]; 4],
    /// u_a along `d`.
    pub(super) v: [&'a [f64]; 4],
    /// u_a one place along `a` down and up, before and behind the edge.
    pub(super) v_along: [&'a [f64]; 4],
    /// The same along the third axis: u_d below and above, u_a before and behind.
    pub(super) third: Option<[[&'a [f64]; 4]; 2]>,
    /// Weights of the four cells about the edge.
    pub(super) weights: [&'a [f64]; 4],
    /// Factor of all.
    pub(super) open: &'a [f64],
    /// What the cells before and behind weigh in the mass flux of u_a that carries u_d.
    pub(super) shares: [&'a [f64]; 2],
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
pub(super) fn over_edge(out: &mut [f64], out_across: &mut [f64], edge: &Edge<'_>, parts: Parts) {
    let n = out.len();
    let out_across = &mut out_across[..n];
    if let Some([u, v]) = edge.third {
        let ([a, b, c, d], [e, f, g, h]) = (u.map(|line| &line[..n]), v.map(|line| &line[..n]));
        for i in 0..n {
            out[i] = ((b[i] - a[i]) + (d[i] - c[i])) * ((f[i] - e[i]) + (h[i] - g[i])) * (1.0 / 16.0);
        }
    } else {
        out.fill(0.0);
    }
    let [low, below, above, high] = edge.u.map(|line| &line[..n]);
    let [left, before, behind, right] = edge.v.map(|line| &line[..n]);
    let [below_down, below_up, above_down, above_up] = edge.u_along.map(|line| &line[..n]);
    let [before_down, before_up, behind_down, behind_up] = edge.v_along.map(|line| &line[..n]);
    let [w, x, y, z] = edge.weights.map(|line| &line[..n]);
    let (open, [share, share_behind]) = (&edge.open[..n], edge.shares.map(|line| &line[..n]));
    let (scale, [before_scale, behind_scale]) = (edge.scale, edge.share_scale);
    let [across, across_above] = edge.shares_across;
    for i in 0..n {
        let weight = 0.25 * scale * open[i] * ((w[i] + x[i]) + (y[i] + z[i]));
        let (du, dv) = (above[i] - below[i], behind[i] - before[i]);
        let u_along = (below_up[i] - below_down[i]) + (above_up[i] - above_down[i]);
        let v_along = (before_up[i] - before_down[i]) + (behind_up[i] - behind_down[i]);
        let stress = parts.limited(du * du + dv * dv) * (out[i] + 0.25 * (u_along * dv + v_along * du));
        let mass = before_scale * share[i] * before[i] + behind_scale * share_behind[i] * behind[i];
        let mass_across = across * below[i] + across_above * above[i];
        let curve = (low[i] + high[i]) - (below[i] + above[i]);
        let curve_across = (left[i] + right[i]) - (before[i] + behind[i]);
        out[i] = weight * (FOURTH * mass * curve - stress);
        out_across[i] = weight * (FOURTH * mass_across * curve_across - stress);
    }
}

/// Lines of a flux of component `d` along its own axis, through the centre of a cell.
pub(super) struct Centre<'a> {
    /// u_d along `d`: two before the centre, two behind.
    pub(super) u: [&'a [f64]; 4],
    /// u_d before and behind, one place down and up along each other axis.
    pub(super) beside: [Option<[&'a [f64]; 4]>; 2],
    /// Half the area of the faces before and behind.
    pub(super) mass: [&'a [f64]; 2],
    /// Area at the centre.
    pub(super) area: &'a [f64],
    /// Weight of the cell.
    pub(super) weight: &'a [f64],
    /// Factor of all.
    pub(super) open: &'a [f64],
    /// Factor of the whole line.
    pub(super) scale: f64,
}

/// The same through a centre, where the stress is σ² Σ_k (∂_k u_d)².
#[inline(always)]
pub(super) fn through_centre(out: &mut [f64], centre: &Centre<'_>, parts: Parts) {
    let n = out.len();
    let [low, before, behind, high] = centre.u.map(|line| &line[..n]);
    // The squares first: what limits the stress is their sum.
    for i in 0..n {
        let du = behind[i] - before[i];
        out[i] = du * du;
    }
    for beside in centre.beside.into_iter().flatten() {
        let [down, up, behind_down, behind_up] = beside.map(|line| &line[..n]);
        for i in 0..n {
            let (a, b) = (up[i] - before[i], before[i] - down[i]);
            let (c, d) = (behind_up[i] - behind[i], behind[i] - behind_down[i]);
            out[i] += 0.25 * ((a * a + b * b) + (c * c + d * d));
        }
    }
    let [mass, mass_behind] = centre.mass.map(|line| &line[..n]);
    let (area, weight, open) = (&centre.area[..n], &centre.weight[..n], &centre.open[..n]);
    for i in 0..n {
        let flux = mass[i] * before[i] + mass_behind[i] * behind[i];
        let curve = (low[i] + high[i]) - (before[i] + behind[i]);
        let stress = area[i] * parts.limited(out[i]) * out[i];
        out[i] = centre.scale * open[i] * weight[i] * (FOURTH * flux * curve - stress);
    }
}
