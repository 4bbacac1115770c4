//! Search of all pairs with a gap below a reach, ascending: for the lists of the general engine.

use crate::motion::Vec3;
use crate::periods::Periods;
use crate::search::cells::Cells;

/// Below this number of grains every pair is looked at: cheaper than cells.
const FEW: usize = 24;

/// PairSearch for pairs nearer than the sum of their radii and a reach.
#[derive(Clone, Debug, Default)]
pub struct PairSearch {
    cells: Cells,
    sorted: bool,
}

impl PairSearch {
    /// Prepares a search of all pairs with a gap below `reach`.
    pub fn prepare(&mut self, position: &[Vec3], radius: &[f64], reach: f64, periods: &Periods) {
        self.sorted = position.len() > FEW;
        if self.sorted {
            let largest = radius.iter().copied().fold(0.0, f64::max);
            let grains = position.iter().zip(radius).map(|(x, r)| ([x.x, x.y, x.z, *r], true));
            self.cells.sort(grains, position.len(), 2.0 * largest + reach, periods);
        }
    }

    /// Appends all j > i with a gap to `i` below `reach`, ascending, to `found`.
    pub fn partners(
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
