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
    #[must_use]
    pub fn relative_uncertainty(&self) -> f64 {
        self.uncertainty / if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }
}

/// The limit of the three finest of some pairs (h, value), each h once. With the ratios of h alike
/// it is f₁ + (f₁ − f₂)/(r^p − 1), p = ln((f₃ − f₂)/(f₂ − f₁))/ln r.
#[must_use]
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
#[must_use]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_and_limit_of_a_known_series_are_found() {
        for (p, c) in [(1.0, 0.3), (1.5, -2.0), (2.0, 0.7)] {
            let points = [5.0, 8.0, 10.0, 16.0].map(|n: f64| (1.0 / n, 19.6 + c * n.powf(-p)));
            let limit = richardson(&points).unwrap();
            assert!((limit.order.unwrap() - p).abs() < 1e-6, "{limit:?} for order {p}");
            assert!((limit.value - 19.6).abs() < 1e-9, "{limit:?}");
            // Roache: 1.25 times the difference between the finest value and the limit.
            let off = (c * 16.0_f64.powf(-p)).abs();
            assert!((limit.uncertainty - 1.25 * off).abs() < 1e-6, "{limit:?}");
        }
    }

    #[test]
    fn a_series_without_an_order_gives_its_finest_value_and_a_wide_margin() {
        let swinging = [(0.1, 1.0), (0.2, 1.1), (0.4, 0.9)];
        let limit = richardson(&swinging).unwrap();
        assert_eq!((limit.value, limit.order), (1.0, None));
        assert!((limit.uncertainty - 0.3).abs() < 1e-12);
        let still = richardson(&[(0.1, 1.0), (0.2, 1.0), (0.4, 1.0)]).unwrap();
        assert_eq!((still.value, still.order, still.uncertainty), (1.0, None, 0.0));
        assert!(richardson(&swinging[..2]).is_none());
        assert!(richardson(&[(0.1, 1.0), (0.1, 1.0), (0.4, 1.0)]).is_none(), "each h once");
    }

    #[test]
    fn an_order_above_two_is_shown_but_not_used() {
        let points = [8.0, 16.0, 32.0].map(|n: f64| (1.0 / n, 1.0 + n.powi(-4)));
        let limit = richardson(&points).unwrap();
        assert!((limit.order.unwrap() - 4.0).abs() < 1e-6);
        let second = points[2].1 + (points[2].1 - points[1].1) / 3.0;
        assert!((limit.value - second).abs() < 1e-15);
    }

    /// Values 1 + c h^p at D/Δx = 6, 9, …, finest first.
    fn series(count: i32, value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let h = |k: i32| 1.5_f64.powi(-k) / 6.0;
        (0..count).rev().map(|k| (h(k), value(h(k)))).collect()
    }

    #[test]
    fn a_band_holds_the_error_of_the_finest_value_whatever_the_order() {
        type Case = (&'static str, fn(f64) -> f64);
        let cases: [Case; 6] = [
            ("1", |h| 1.0 + h),
            ("1.5", |h| 1.0 - h.powf(1.5)),
            ("2", |h| 1.0 + 3.0 * h * h),
            ("1 and 2", |h| 1.0 + 0.2 * h + 3.0 * h * h),
            ("3", |h| 1.0 - 4.0 * h * h * h),
            ("1 against 2, which turns back", |h| 1.0 + 0.3 * h - 3.0 * h * h),
        ];
        for (order, value) in cases {
            for count in [2, 3, 4] {
                let points = series(count, value);
                let (error, band) = ((points[0].1 - 1.0).abs(), band(&points).unwrap());
                assert!(error <= band, "order {order}, {count} grids: {error} > {band}");
                assert!(band < 8.0 * error + 0.1, "order {order}, {count} grids: {band} for {error}");
            }
        }
        // Of a scheme of order 1, from two grids and from three, 1.25 times the error.
        for count in [2, 3] {
            let points = series(count, |h| 1.0 + h);
            assert!((band(&points).unwrap() - SAFE * points[0].0).abs() < 1e-9);
        }
        assert_eq!([band(&[]), band(&[(0.1, 1.0)])], [None; 2]);
    }

    #[test]
    fn what_does_not_settle_has_a_band_of_its_spread() {
        let points =
            |f: [f64; 3]| series(3, |_| 0.0).iter().zip(f).map(|(p, f)| (p.0, f)).collect::<Vec<_>>();
        assert!((band(&points([1.0, 1.1, 0.95])).unwrap() - 1.25 * 0.15).abs() < 1e-12, "swings");
        assert!((band(&points([1.0, 1.1, 1.1])).unwrap() - 1.25 * 0.1).abs() < 1e-12, "moves at last");
        assert!((band(&points([1.4, 1.1, 1.0])).unwrap() - 3.0 * 0.4).abs() < 1e-12, "drifts ever faster");
        assert_eq!(band(&points([1.0; 3])), Some(0.0));
    }
}
