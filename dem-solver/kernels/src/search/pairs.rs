//! Search of all pairs with a gap below a reach, ascending: for the lists of the general engine.

use crate::motion::Vec3;
use crate::periods::Periods;
use crate::search::cells::Cells;

/// Below this number of grains every pair is looked at: cheaper than cells.
const FEW: usize = 24;

/// Search for pairs nearer than the sum of their radii and a reach.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairSearch {
    cells: Cells,
    sorted: bool,
}

impl PairSearch {
    /// Prepares a search of all pairs with a gap below `reach`.
    pub(crate) fn prepare(&mut self, position: &[Vec3], radius: &[f64], reach: f64, periods: &Periods) {
        self.sorted = position.len() > FEW;
        if self.sorted {
            let largest = radius.iter().copied().fold(0.0, f64::max);
            let grains = position.iter().zip(radius).map(|(x, r)| ([x.x, x.y, x.z, *r], true));
            self.cells.sort(grains, position.len(), 2.0 * largest + reach, periods);
        }
    }

    /// Appends all j > i with a gap to `i` below `reach`, ascending, to `found`.
    pub(crate) fn partners(
        &self,
        i: usize,
        position: &[Vec3],
        radius: &[f64],
        reach: f64,
        periods: &Periods,
        found: &mut Vec<u32>,
    ) {
        let near = |x: Vec3, r: f64| {
            let limit = radius[i] + r + reach;
            periods.nearest(position[i] - x).norm_squared() < limit * limit
        };
        if self.sorted {
            let Cells { item: [xs, ys, zs, radii], who, .. } = &self.cells;
            for &(from, to) in self.cells.around(&position[i].into(), 1).runs() {
                for k in from as usize..to as usize {
                    if who[k] > i as u32 && near(Vec3::new(xs[k], ys[k], zs[k]), radii[k]) {
                        found.push(who[k]);
                    }
                }
            }
            found.sort_unstable();
        } else {
            let later = (i + 1..position.len()).filter(|&j| near(position[j], radius[j]));
            found.extend(later.map(|j| j as u32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A deterministic stream of numbers in [0, 1) (SplitMix64).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }

        fn vector(&mut self, low: f64, high: f64) -> [f64; 3] {
            std::array::from_fn(|_| low + (high - low) * self.next())
        }
    }

    fn brute(
        position: &[Vec3],
        radius: &[f64],
        reach: f64,
        axes: [Option<(f64, f64)>; 3],
    ) -> Vec<(usize, usize)> {
        // shortest of all 27 images, without the search's own arithmetic
        let distance = |i: usize, j: usize, shift: i32| {
            let turns = [shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1];
            let along = |axis: usize| {
                let Some((start, length)) = axes[axis] else { return position[i][axis] - position[j][axis] };
                let wrap = |x: f64| start + (x - start).rem_euclid(length);
                wrap(position[i][axis]) - wrap(position[j][axis]) + f64::from(turns[axis]) * length
            };
            Vec3::from_fn(|axis, _| along(axis)).norm()
        };
        let near = |&(i, j): &(usize, usize)| {
            (0..27).any(|shift| distance(i, j, shift) < radius[i] + radius[j] + reach)
        };
        let pairs = (0..position.len()).flat_map(|i| (i + 1..position.len()).map(move |j| (i, j)));
        pairs.filter(near).collect()
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
                    let mut x =
                        Vec3::from_fn(|axis, _| start[axis] + size[axis] * (1.2 * random.next() - 0.1));
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
}
