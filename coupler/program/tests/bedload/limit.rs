//! Order, limit and band of series of known order.

use coupler::limit::{band, richardson};

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
        assert!((band(&points).unwrap() - 1.25 * points[0].0).abs() < 1e-9);
    }
    assert_eq!([band(&[]), band(&[(0.1, 1.0)])], [None; 2]);
}

#[test]
fn what_does_not_settle_has_a_band_of_its_spread() {
    let points = |f: [f64; 3]| series(3, |_| 0.0).iter().zip(f).map(|(p, f)| (p.0, f)).collect::<Vec<_>>();
    assert!((band(&points([1.0, 1.1, 0.95])).unwrap() - 1.25 * 0.15).abs() < 1e-12, "swings");
    assert!((band(&points([1.0, 1.1, 1.1])).unwrap() - 1.25 * 0.1).abs() < 1e-12, "moves at last");
    assert!((band(&points([1.4, 1.1, 1.0])).unwrap() - 3.0 * 0.4).abs() < 1e-12, "drifts ever faster");
    assert_eq!(band(&points([1.0; 3])), Some(0.0));
}
