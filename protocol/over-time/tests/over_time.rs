//! Values over time: forms, means and integrals against quadrature, steps that resolve them.

use bedload_over_time::{OverTime, Sine, peak_of_sum};

fn values() -> [OverTime<[f64; 3]>; 3] {
    let rows =
        vec![(-1.0, [1.0, 0.0, 2.0]), (0.25, [-1.0, 3.0, 0.0]), (0.5, [-1.0, 3.0, 1.0]), (2.0, [0.0; 3])];
    let sine = Sine { amplitude: [0.5, -1.0, 0.0], frequency: 0.7, phase: 0.3, offset: [0.1, 0.2, 0.3] };
    [OverTime::from([1.0, 2.0, -3.0]), OverTime::table(rows), OverTime::sine(sine)]
}

/// Midpoint sums of 2·10⁵ steps are 1e-9 off for these.
#[test]
fn means_and_integrals_are_those_of_the_values() {
    for value in values() {
        for (from, to) in [(0.0, 0.1), (0.0, 3.0), (0.3, 0.4), (0.2, 2.5), (-2.0, 0.3), (2.5, 4.0)] {
            let n = 200_000;
            let h = (to - from) / f64::from(n);
            let (mut sum, mut lead) = ([0.0; 3], [0.0; 3]);
            for k in 0..n {
                let t = from + (f64::from(k) + 0.5) * h;
                for (c, at) in value.at(t).into_iter().enumerate() {
                    sum[c] += h * at;
                    lead[c] += h * at * (0.5 * (from + to) - t);
                }
            }
            let found = value.lead(from, to);
            assert!((0..3).all(|c| (found[c] - lead[c]).abs() < 1e-8), "{value:?} from {from} to {to}");
            let (mean, ways) = (value.mean(from, to), [value.integral(from), value.integral(to)]);
            for c in 0..3 {
                assert!((mean[c] * (to - from) - sum[c]).abs() < 1e-8, "{value:?} from {from} to {to}");
                assert!((ways[1][c] - ways[0][c] - sum[c]).abs() < 1e-8, "{value:?} from {from} to {to}");
            }
        }
        assert_eq!(value.integral(0.0), [0.0; 3]);
        assert_eq!(value.mean(0.3, 0.3), value.at(0.3));
        let along = value.map(|v| v[1]);
        assert_eq!(along.at(0.4), value.at(0.4)[1]);
    }
}

#[test]
fn largest_values_and_rates_hold() {
    for value in values() {
        for until in [0.1, 0.5, 3.0] {
            let at = |k: u32| value.at(until * f64::from(k) / 1000.0);
            let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let largest = (0..=1000).map(|k| size(at(k))).fold(0.0, f64::max);
            assert!(largest <= value.largest(until) + 1e-12, "{value:?}: {largest}");
            let rate = |k: u32| size(std::array::from_fn(|c| at(k + 1)[c] - at(k)[c])) * 1000.0 / until;
            let fastest = (0..1000).map(rate).fold(0.0, f64::max);
            assert!(fastest <= value.fastest(until) * (1.0 + 1e-9), "{value:?}: {fastest}");
        }
    }
    let [constant, table, sine] = values();
    assert_eq!((constant.last_change(), sine.last_change()), (0.0, 0.0));
    assert_eq!((constant.fastest(1.0), constant.longest_step(0.0)), (0.0, f64::INFINITY));
    // The rows up to 0.25 alone, not what follows; from there on z grows.
    assert_eq!(table.largest(0.25), 10.0_f64.sqrt());
    assert!(table.largest(0.3) > table.largest(0.25) && table.largest(0.3) < table.largest(3.0));
}

/// Each component has its own largest value, and sources that swing one against the other do not cancel.
#[test]
fn components_and_sums_have_their_own_peaks() {
    let turned = OverTime::table(vec![(0.0, [0.0, 0.0, -10.0]), (1.0, [6.0, 0.0, -8.0]), (2.0, [0.0; 3])]);
    assert_eq!(turned.peak(2.0), [6.0, 0.0, -10.0]);
    assert_eq!(turned.peak(0.5), [3.0, 0.0, -10.0]);
    assert_eq!(turned.range(2.0), [[0.0, 0.0, -10.0], [6.0, 0.0, 0.0]]);
    assert_eq!(turned.largest(2.0), 10.0);
    let ramp = OverTime::table(vec![(0.0, 0.0), (1.0, 0.05)]);
    let back = OverTime::table(vec![(0.0, 0.0), (0.5, 0.05), (1.0, -0.05)]);
    assert!((peak_of_sum(&[ramp.clone(), back.clone()], 1.0) - 0.075).abs() < 1e-15);
    let sine = OverTime::sine(Sine { amplitude: -0.3, frequency: 2.0, phase: 0.0, offset: 0.1 });
    assert!((peak_of_sum(&[ramp, sine, back, OverTime::from(-1.0)], 1.0) + 1.2).abs() < 1e-12);
}

/// A step never passes the part of a table that it has to resolve, and a jump ends in few steps.
#[test]
fn steps_resolve_a_jump() {
    let jump = OverTime::table(vec![(0.0, 0.0), (1.0, 0.0), (1.001, 2.0), (5.0, 2.0)]);
    let (mut t, mut steps, mut within) = (0.0, 0, 0);
    while t < 5.0 {
        let step = jump.longest_step(t).min(0.3);
        assert!(t >= 1.0 || t + step <= 1.0 + 0.001 / 16.0 + 1e-12, "{t} {step}");
        within += u32::from((1.0..1.001).contains(&t));
        (t, steps) = (t + step, steps + 1);
    }
    assert!((15..=18).contains(&within) && steps < 50, "{within} of {steps}");
}

/// What never changes, or by less than squares can tell, asks for no step.
#[test]
fn a_table_of_zeros_takes_any_step() {
    for last in [0.0, 1e-300] {
        let table = OverTime::table(vec![(0.0, [0.0; 3]), (1.0, [0.0; 3]), (2.0, [0.0, last, 0.0])]);
        assert_eq!(table.longest_step(0.5), f64::INFINITY);
    }
    let later = OverTime::table(vec![(0.0, 0.0), (1.0, 0.0), (2.0, 3.0)]);
    assert_eq!(later.longest_step(0.25), 0.75);
}

#[test]
fn every_form_is_read_and_written() {
    #[derive(serde::Deserialize, serde::Serialize)]
    struct Scene {
        v: OverTime<[f64; 3]>,
        f: OverTime<f64>,
    }
    let read = |text: &str| toml::from_str::<Scene>(text);
    let vector = [
        "[0, 1.5, -2]",
        "[[0, [0, 0, 0]], [1.5, [1.0, 0, 0]]]",
        "{ file = \"v.csv\" }",
        "{ amplitude = [1, 0, 0], frequency = 2 }",
    ];
    let number = [
        "3",
        "[[0.0, 1], [2, 3.5]]",
        "{ file = \"f.csv\" }",
        "{ amplitude = 1.0, frequency = 2.0, phase = 0.5, offset = 3.0 }",
    ];
    for (v, f) in vector.iter().zip(number) {
        let scene = read(&format!("v = {v}\nf = {f}")).unwrap_or_else(|error| panic!("{v} {f}: {error}"));
        let again = read(&toml::to_string(&scene).expect("text")).expect("read again");
        assert!(again.v == scene.v && again.f == scene.f, "{v} {f}");
    }
    for (v, words) in [
        ("\"fast\"", "string \"fast\""),
        ("2.0", "3 numbers"),
        ("[1.0, 2.0]", "length 2"),
        ("[1.0, [1.0, [0, 0, 0]]]", "mixes"),
        ("[[1.0]]", "length 1"),
        ("[[1.0, [0, 0, 0], 2.0]]", "length 3"),
        ("[[1.0, 2.0]]", "floating point"),
        ("{ amplitude = [1, 0, 0] }", "frequency"),
        ("{ frequency = 1.0 }", "amplitude"),
        ("{ amplitude = [1, 0, 0], frequency = 1.0, delay = 2 }", "delay"),
        ("{ file = \"a.csv\", frequency = 1.0 }", "give one"),
    ] {
        let error =
            read(&format!("v = {v}\nf = 1")).err().unwrap_or_else(|| panic!("{v} is read")).to_string();
        assert!(error.contains(words), "{v}: {error}");
    }
}
