//! When fields, planes and sub-steps are due.

use bedload_scene::{Axis, Observe, ObservedPlanes, ObservedSubsteps};

#[test]
fn fields_are_due_once_each() {
    let observe = Observe { fields_at: vec![0.0, 0.25], fields_every: Some(0.1), ..Observe::default() };
    let dt = 0.05;
    let due: Vec<bool> =
        (0..8).map(|k| observe.fields_due(f64::from(k) * dt, f64::from(k + 1) * dt)).collect();
    // t = 0 in the first window, 0.1, 0.2, 0.25, 0.3, 0.4 at the ends of others
    assert_eq!(due, [true, true, false, true, true, true, false, true]);
}

/// Ends of the windows in which fields are due, of steps `dt` up to t = 1 s whose times are summed, as a
/// solver alone does, or multiplied, as the coupler does.
fn due_at(observe: &Observe, dt: f64, summed: bool) -> Vec<f64> {
    let (mut start, mut due, mut step) = (0.0, Vec::new(), 0.0);
    while start < 1.0 - 0.5 * dt {
        step += 1.0;
        if observe.fields_due(start, start + dt) {
            due.push(start + dt);
        }
        start = if summed { start + dt } else { step * dt };
    }
    due
}

#[test]
fn fields_are_due_in_the_window_that_ends_then_whatever_the_rounding() {
    let asked = vec![0.1, 0.3, 0.300_000_000_000_000_04, 0.7, 1.0];
    for dt in [0.01, 0.02, 1.0 / 60.0] {
        for summed in [true, false] {
            let at = Observe { fields_at: asked.clone(), ..Observe::default() };
            let every = Observe { fields_every: Some(0.1), ..Observe::default() };
            let near = |due: Vec<f64>, times: &[f64]| {
                assert_eq!(due.len(), times.len(), "{dt} {summed}: {due:?}");
                assert!(due.iter().zip(times).all(|(end, t)| (end - t).abs() < 1e-12), "{dt}: {due:?}");
            };
            near(due_at(&at, dt, summed), &[0.1, 0.3, 0.7, 1.0]);
            let tenths: Vec<f64> = (1..=10).map(|k| f64::from(k) / 10.0).collect();
            near(due_at(&every, dt, summed), &tenths);
        }
    }
}

#[test]
fn a_time_between_the_ends_of_windows_is_due_once_whatever_their_lengths() {
    let observe = Observe { fields_at: vec![0.104, 0.55], ..Observe::default() };
    let ends = [0.0, 0.1, 0.13, 0.2, 0.5, 0.56, 1.0];
    let due: Vec<f64> = ends.windows(2).filter(|w| observe.fields_due(w[0], w[1])).map(|w| w[1]).collect();
    assert_eq!(due, [0.13, 0.56]);
}

#[test]
fn the_ends_of_a_span_are_not_a_matter_of_rounding() {
    let (before, behind) = (0.099_999_999_999_999_99, 0.100_000_000_000_000_02);
    let substeps = ObservedSubsteps { grains: vec![0], from: 0.1, to: 0.3 };
    assert!(!substeps.has(0.09, behind) && substeps.has(before, 0.11));
    assert!(substeps.has(0.29, 0.3) && !substeps.has(0.299_999_999_999_999_9, 0.31));
    let forever = ObservedSubsteps { to: f64::INFINITY, ..substeps };
    assert!(forever.has(1e9, 2e9));
    let planes =
        ObservedPlanes { axis: Axis::Z, every: 0.1, from: 0.1, to: 0.3, at: Vec::new(), stress: false };
    assert!(planes.counts(before) && planes.counts(0.300_000_000_000_000_04) && !planes.counts(0.31));
}
