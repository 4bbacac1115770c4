//! Classes of signals that are known.

use study::stability::classify::{Class, classify, growth};

/// A sphere that approaches its terminal velocity 1 within `time` windows.
fn start_up(time: f64, windows: usize) -> Vec<f64> {
    (0..windows).map(|n| 1.0 - (-(n as f64) / time).exp()).collect()
}

fn alternation(n: usize) -> f64 {
    if n.is_multiple_of(2) { 1.0 } else { -1.0 }
}

fn with(signal: &[f64], extra: impl Fn(usize) -> f64) -> Vec<f64> {
    signal.iter().enumerate().map(|(n, s)| s + extra(n)).collect()
}

#[test]
fn growth_is_recovered_within_5_per_cent() {
    for rate in [0.01, 0.03, 0.1, 0.3, 1.0] {
        let signal = with(&start_up(10.0, 200), |n| 1e-2 * alternation(n) * (rate * n as f64).exp());
        let found = classify(&signal, None);
        assert!((found.growth / rate - 1.0).abs() < 0.05, "{rate}: {}", found.growth);
        assert_eq!(found.class, Class::Failed, "{rate}: {}", found.note);
    }
    // A period of 8 windows, not of 2: seen through sin²(π/8) = 0.15.
    let slow = with(&start_up(10.0, 200), |n| {
        1e-2 * (std::f64::consts::TAU * n as f64 / 8.0).sin() * (0.05 * n as f64).exp()
    });
    let found = classify(&slow, None);
    assert!((found.growth / 0.05 - 1.0).abs() < 0.05, "{}", found.growth);
    assert_eq!(found.class, Class::Failed);
}

#[test]
fn growth_from_rounding_is_seen_before_it_shows() {
    let signal = with(&start_up(4.0, 200), |n| 1e-14 * alternation(n) * (0.1 * n as f64).exp());
    assert!(signal.iter().all(|value| (0.0..1.01).contains(value)));
    let found = classify(&signal, None);
    assert_eq!(found.class, Class::Failed, "{}", found.note);
    assert!((found.growth / 0.1 - 1.0).abs() < 0.05, "{}", found.growth);
}

#[test]
fn what_decays_is_stable_and_its_rate_negative() {
    for rate in [0.02, 0.1, 0.5] {
        let signal = with(&start_up(5.0, 200), |n| 0.5 * alternation(n) * (-rate * n as f64).exp());
        let found = classify(&signal, None);
        assert_eq!(found.class, Class::Stable, "{rate}: {}", found.note);
        assert!(found.growth < 0.0);
    }
}

#[test]
fn alternation_that_stays_is_an_oscillation() {
    for size in [0.02, 0.5, 30.0] {
        let found = classify(&with(&start_up(10.0, 200), |n| size * alternation(n)), None);
        assert_eq!(found.class, Class::Oscillating, "{size}: {}", found.note);
        assert!(found.growth.abs() < 1e-3);
    }
    let below = classify(&with(&start_up(10.0, 200), |n| 0.005 * alternation(n)), None);
    assert_eq!(below.class, Class::Stable, "half a per cent is let pass");
}

#[test]
fn a_start_up_and_a_slow_drift_are_stable() {
    for time in [2.0, 10.0, 50.0, 400.0] {
        let found = classify(&start_up(time, 200), None);
        assert_eq!(found.class, Class::Stable, "{time}: {}", found.note);
    }
    let drift: Vec<f64> = (0..200).map(|n| -1e-3 * f64::from(n) - 1e-6 * f64::from(n * n)).collect();
    assert_eq!(classify(&drift, None).class, Class::Stable);
    // Noise of a grain that crosses cells ever faster.
    let falls: Vec<f64> = (0..200)
        .map(|n| {
            let z = 1e-4 * f64::from(n * n);
            -2e-2 * f64::from(n) * (1.0 + 1e-3 * (std::f64::consts::TAU * z / 0.1).sin())
        })
        .collect();
    assert_eq!(classify(&falls, None).class, Class::Stable);
    let rest = [vec![1.0, 0.5], vec![0.0; 198]].concat();
    assert_eq!(classify(&rest, None).class, Class::Stable);
}

/// `velocity_z[0]` of a run of `scenes/stability/light-axisymmetric.toml`: yu-shao-fixed-point, C_v = ½,
/// ρ_r = 8, ν dt/D² = 0.0024.
#[test]
fn a_real_start_up_is_stable() {
    let text = include_str!("start-up.csv");
    let signal: Vec<f64> = text.lines().skip(1).filter_map(|line| line.parse().ok()).collect();
    assert!(signal.len() > 100);
    let found = classify(&signal, None);
    assert_eq!(found.class, Class::Stable, "{}", found.note);
}

#[test]
fn what_is_not_finite_has_failed_and_few_windows_still_give_a_rate() {
    let mut signal: Vec<f64> = (0..12).map(|n| alternation(n) * (0.7 * n as f64).exp()).collect();
    signal.push(f64::NAN);
    let found = classify(&signal, None);
    assert_eq!(found.class, Class::Failed);
    assert!((found.growth / 0.7 - 1.0).abs() < 0.05, "{}", found.growth);
    assert!((growth(&signal) / 0.7 - 1.0).abs() < 0.05);
    // Flung out, it moves on smoothly: that is not what grew.
    let mut flung: Vec<f64> = signal[..12].to_vec();
    flung.extend((0..80).map(|n| signal[11] * (1.0 - 1e-3 * f64::from(n))));
    assert!((growth(&flung) / 0.7 - 1.0).abs() < 0.05, "{}", growth(&flung));
    assert!(classify(&[0.0, 1.0, f64::INFINITY], None).growth.is_nan());
    assert_eq!(classify(&[0.0, 1.0], None).note, "too short to classify");
}

#[test]
fn a_given_scale_counts_instead_of_the_signals_own() {
    let jitter: Vec<f64> = (0..200).map(|n| 1e-6 * alternation(n)).collect();
    assert_eq!(classify(&jitter, None).class, Class::Oscillating);
    assert_eq!(classify(&jitter, Some(1.0)).class, Class::Stable);
}
