//! Orders and limits of a refinement: Richardson's extrapolation, with Roache's uncertainty.

/// Safety factor of a grid convergence index from three grids (Roache 1994).
const SAFE: f64 = 1.25;

/// The same from two grids, or where no order is seen.
const SAFE_WITHOUT_ORDER: f64 = 3.0;

/// A larger observed order is not trusted to extrapolate with: no part of the solvers has more.
const LARGEST_ORDER: f64 = 2.0;

/// Nor a smaller one.
const SMALLEST_ORDER: f64 = 0.5;

/// Where a refinement leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Extrapolated value.
    pub value: f64,
    /// Observed order p; none where the three finest values do not go one way, ever slower.
    pub order: Option<f64>,
    /// Grid convergence index of the finest value, in the unit of the value.
    pub uncertainty: f64,
}

impl Limit {
    /// Uncertainty over the value; itself where that is 0.
    pub fn relative_uncertainty(&self) -> f64 {
        self.uncertainty / if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }
}

/// The limit of the three finest of some pairs (h, value), each h once. With the ratios of h alike
/// it is f₁ + (f₁ − f₂)/(r^p − 1), p = ln((f₃ − f₂)/(f₂ − f₁))/ln r.
pub fn richardson(points: &[(f64, f64)]) -> Option<Limit> {
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.dedup_by(|a, b| a.0 == b.0);
    let [(h1, f1), (h2, f2), (h3, f3)] = *points.get(..3)? else { return None };
    let order = order([h1, h2, h3], [f1, f2, f3]);
    let p = order.map_or(1.0, |p| p.clamp(SMALLEST_ORDER, LARGEST_ORDER));
    let step = (f1 - f2) / ((h2 / h1).powf(p) - 1.0);
    let trusted = order.is_some_and(|p| p >= SMALLEST_ORDER);
    Some(Limit {
        value: if order.is_some() { f1 + step } else { f1 },
        order,
        uncertainty: step.abs() * if trusted { SAFE } else { SAFE_WITHOUT_ORDER },
    })
}

/// What is an order of 2 but for the terms after the first.
const BEYOND_LARGEST_ORDER: f64 = LARGEST_ORDER + 0.05;

/// Largest distance of the finest of some pairs (h, value), each h once, finest first, from their limit, in
/// the unit of the value; none of one alone.
///
/// From two the larger of two: as if the order were 1, the worst of 1 to 2; and were 2, with the factor of
/// two grids, which is for an order that is not seen. From the three finest by [`richardson`]. Where they
/// show no order, or one above 2 as values do that turn back, their spread counts: with the factor of three
/// grids if the limit may lie between them, with that of two if they drift ever faster.
pub fn band(points: &[(f64, f64)]) -> Option<f64> {
    let (h, f): (Vec<f64>, Vec<f64>) = points.iter().take(3).copied().unzip();
    if let ([h1, h2], [f1, f2]) = (&h[..], &f[..]) {
        let ratio = h2 / h1;
        let steps = [SAFE / (ratio - 1.0), SAFE_WITHOUT_ORDER / (ratio.powf(LARGEST_ORDER) - 1.0)];
        return Some((f1 - f2).abs() * steps[0].max(steps[1]));
    }
    let limit = richardson(points)?;
    let drifts = (f[0] - f[1]) * (f[1] - f[2]) > 0.0;
    let spread = f.iter().fold(f64::NEG_INFINITY, |most, value| most.max(*value))
        - f.iter().fold(f64::INFINITY, |least, value| least.min(*value));
    Some(match limit.order {
        Some(order) if order <= BEYOND_LARGEST_ORDER => limit.uncertainty,
        None if drifts => SAFE_WITHOUT_ORDER * spread,
        _ => SAFE * spread,
    })
}

/// p in f = f₀ + c h^p: the root of (f₃ − f₂)/(f₂ − f₁) = (h₃^p − h₂^p)/(h₂^p − h₁^p), whose right
/// side grows with p.
fn order(h: [f64; 3], f: [f64; 3]) -> Option<f64> {
    let asked = (f[2] - f[1]) / (f[1] - f[0]);
    let ratio = |p: f64| (h[2].powf(p) - h[1].powf(p)) / (h[1].powf(p) - h[0].powf(p));
    let (mut low, mut high) = (0.05, 12.0);
    if !asked.is_finite() || asked < ratio(low) || asked > ratio(high) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < asked { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}
