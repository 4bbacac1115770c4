//! The cell search finds what brute force finds.
mod common;
use common::Random;
use dem_solver::Vec3;
use dem_solver::periods::Periods;
use dem_solver::search::pairs::PairSearch;

fn brute(
    position: &[Vec3],
    radius: &[f64],
    reach: f64,
    axes: [Option<(f64, f64)>; 3],
) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    for i in 0..position.len() {
        for j in i + 1..position.len() {
            // shortest of all 27 images, without the search's own arithmetic
            let mut least = f64::INFINITY;
            for shift in 0..27 {
                let turns = [shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1];
                let d = Vec3::from_fn(|axis, _| {
                    let wrap = |x: f64| {
                        axes[axis].map_or(x, |(start, length)| start + (x - start).rem_euclid(length))
                    };
                    let length = axes[axis].map_or(0.0, |period| period.1);
                    wrap(position[i][axis]) - wrap(position[j][axis]) + f64::from(turns[axis]) * length
                });
                least = least.min(d.norm());
            }
            if least < radius[i] + radius[j] + reach {
                found.push((i, j));
            }
        }
    }
    found
}

#[test]
fn cells_equal_brute_force() {
    let mut random = Random(5);
    let mut pairs = 0;
    for case in 0..60 {
        let n = [2, 10, 30, 120, 300][case % 5];
        let size = random.vector(2.5, 12.0);
        let start = random.vector(-20.0, 20.0);
        let axes: [Option<(f64, f64)>; 3] =
            std::array::from_fn(|axis| (random.next() < 0.5).then_some((start[axis], size[axis])));
        let flat = random.next() < 0.3;
        let position: Vec<Vec3> = (0..n)
            .map(|_| {
                // some a little outside the period, as within a window
                let mut x = Vec3::from_fn(|axis, _| start[axis] + size[axis] * (1.2 * random.next() - 0.1));
                if flat && axes[1].is_none() {
                    x.y = 0.0;
                }
                x
            })
            .collect();
        let radius: Vec<f64> = (0..n).map(|_| 0.1 + 0.3 * random.next()).collect();
        let reach = 0.2 * random.next();
        let periods = Periods::new(axes);
        let mut search = PairSearch::default();
        search.prepare(&position, &radius, reach, &periods);
        let mut found = Vec::new();
        for i in 0..n {
            let mut partners = Vec::new();
            search.partners(i, &position, &radius, reach, &periods, &mut partners);
            found.extend(partners.into_iter().map(|j| (i, j as usize)));
        }
        let expected = brute(&position, &radius, reach, axes);
        pairs += expected.len();
        assert_eq!(found, expected, "case {case}, n {n}, {axes:?}");
    }
    assert!(pairs > 5000, "{pairs}");
}

/// Far apart grains, all in one place, or in a line: no panic, no memory blow-up, right pairs.
#[test]
fn odd_configurations() {
    let periods = Periods::new([None; 3]);
    let far: Vec<Vec3> = (0..40).map(|i| Vec3::new(f64::from(i) * 1e12, 0.0, 0.0)).collect();
    let same = vec![Vec3::new(1.0, 2.0, 3.0); 40];
    let line: Vec<Vec3> = (0..40).map(|i| Vec3::new(0.0, 0.0, f64::from(i))).collect();
    for (position, expected) in [(far, 0), (same, 780), (line, 39)] {
        let radius = vec![0.55; 40];
        let mut search = PairSearch::default();
        search.prepare(&position, &radius, 0.0, &periods);
        let mut found = Vec::new();
        (0..40).for_each(|i| search.partners(i, &position, &radius, 0.0, &periods, &mut found));
        assert_eq!(found.len(), expected);
    }
}
