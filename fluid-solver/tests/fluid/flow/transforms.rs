//! Every transform against its defining sum, at easy and awkward lengths.

use crate::flow::common::Random;
use fluid_solver::transform::{Kind, Transform};
use std::f64::consts::PI;

const KINDS: [Kind; 6] =
    [Kind::Periodic, Kind::EvenEven, Kind::OddOdd, Kind::EvenOdd, Kind::OddEven, Kind::Fixed];

/// Basis function `q` at value `j` of an axis of `n` cells, the definition of each transform.
fn basis(kind: Kind, n: usize, q: usize, j: usize) -> f64 {
    // The angle in units of π/4n, reduced in integers so that the reference is exact.
    let angle = |numerator: usize| PI * (numerator % (8 * n)) as f64 / (4 * n) as f64;
    match kind {
        Kind::Periodic if 2 * q <= n => angle(8 * q * j).cos(),
        Kind::Periodic => -angle(8 * (n - q) * j).sin(),
        Kind::EvenEven => angle(2 * q * (2 * j + 1)).cos(),
        Kind::OddOdd => angle(2 * (q + 1) * (2 * j + 1)).sin(),
        Kind::EvenOdd => angle((2 * q + 1) * (2 * j + 1)).cos(),
        Kind::OddEven => angle((2 * q + 1) * (2 * j + 1)).sin(),
        Kind::Fixed => angle(4 * (q + 1) * (j + 1)).sin(),
    }
}

/// Forward equals the sum over the basis, and the scaled inverse brings the line back. Sums of n
/// terms of size 1, and sine I by a running sum of n/2 terms: n · 4e-15 covers both (awkward lengths go
/// through longer transforms).
#[test]
fn transforms_equal_their_definition() {
    let lengths = (2..50).chain([60, 64, 100, 128, 135, 250, 256, 300, 360, 494]);
    for n in lengths {
        for (kind, reference) in KINDS.iter().flat_map(|k| [(*k, false), (*k, true)]) {
            let plan = if reference { Transform::reference } else { Transform::new };
            let transform = plan(kind, n);
            let (values, mut scratch) = (transform.values(), transform.scratch());
            let mut random = Random(n as u64);
            let line: Vec<[f64; 8]> = (0..values).map(|_| std::array::from_fn(|_| random.next())).collect();
            let mut data = line.clone();
            transform.forward(&mut data, &mut scratch);
            let tolerance = 4e-15 * (n as f64).max(8.0);
            for (q, row) in data.iter().enumerate() {
                for lane in [0, 7] {
                    let sum: f64 = (0..values).map(|j| line[j][lane] * basis(kind, n, q, j)).sum();
                    let wrong = (row[lane] - sum).abs();
                    assert!(wrong <= tolerance, "{kind:?} {n} mode {q}: {wrong:e}");
                }
            }
            transform.inverse(&mut data, &mut scratch);
            for (x, y) in line.iter().zip(&data) {
                for lane in 0..8 {
                    let wrong = (x[lane] - y[lane] * kind.scale(n)).abs();
                    assert!(wrong <= tolerance, "{kind:?} {n} back: {wrong:e}");
                }
            }
        }
    }
}
