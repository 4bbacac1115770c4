//! Candidate pairs by a uniform cell search, in O(N).

use crate::Vec3;

/// Below this number of grains every pair is looked at: cheaper than cells.
const FEW: usize = 24;

/// Periodic directions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Periods {
    start: [f64; 3],
    length: [f64; 3],
    inverse: [f64; 3],
    any: bool,
}

impl Periods {
    /// From lower end and length per axis.
    #[must_use]
    pub fn new(axes: [Option<(f64, f64)>; 3]) -> Self {
        let mut periods = Self::default();
        for (axis, period) in axes.iter().enumerate() {
            if let Some((start, length)) = *period {
                periods.start[axis] = start;
                periods.length[axis] = length;
                periods.inverse[axis] = 1.0 / length;
                periods.any = true;
            }
        }
        periods
    }

    /// Whether `axis` is periodic.
    #[must_use]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.length[axis] > 0.0
    }

    /// The shortest of all images of the distance vector `d`.
    #[inline(always)]
    #[must_use]
    pub fn nearest(&self, mut d: Vec3) -> Vec3 {
        if self.any {
            /// Adding it rounds to a whole number.
            const WHOLE: f64 = 6_755_399_441_055_744.0;
            for axis in 0..3 {
                let turns = (d[axis] * self.inverse[axis] + WHOLE) - WHOLE;
                d[axis] -= self.length[axis] * turns;
            }
        }
        d
    }

    /// Where `x` is, its turns around the periods counted in.
    #[must_use]
    pub fn unwrap(&self, x: &Vec3, image: &[i32; 3]) -> Vec3 {
        x + Vec3::from_fn(|axis, _| self.length[axis] * f64::from(image[axis]))
    }

    /// Puts `x` back into the period and counts the turns in `image`.
    #[inline]
    pub fn wrap(&self, x: &mut Vec3, image: &mut [i32; 3]) {
        for axis in 0..3 {
            if self.length[axis] > 0.0 {
                let turns = ((x[axis] - self.start[axis]) * self.inverse[axis]).floor();
                if turns != 0.0 {
                    x[axis] -= turns * self.length[axis];
                    image[axis] = image[axis].saturating_add(turns as i32);
                }
            }
        }
    }
}

/// Uniform cells over the grains' bounding box (the period along periodic axes), by counting sort.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    origin: [f64; 3],
    inverse: [f64; 3],
    count: [usize; 3],
    start: Vec<u32>,
    item: Vec<u32>,
    cell: Vec<u32>,
}

impl Cells {
    /// Sorts `position` into cells at least `width` wide.
    pub fn sort(&mut self, position: &[Vec3], width: f64, periods: &Periods) {
        self.shape(position, width, periods);
        let cells = self.count[0] * self.count[1] * self.count[2];
        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell.clear();
        for x in position {
            let cell = self.cell_of(x, periods);
            self.start[cell + 1] += 1;
            self.cell.push(cell as u32);
        }
        for cell in 0..cells {
            self.start[cell + 1] += self.start[cell];
        }
        self.item.clear();
        self.item.resize(position.len(), 0);
        // backwards, so that each cell keeps its grains ascending; `start[c + 1]` ends as start of c + 1
        let mut fill = std::mem::take(&mut self.start);
        for i in (0..position.len()).rev() {
            let slot = &mut fill[self.cell[i] as usize + 1];
            *slot -= 1;
            self.item[*slot as usize] = i as u32;
        }
        fill.rotate_left(1);
        fill[cells] = position.len() as u32;
        self.start = fill;
    }

    /// Chooses origin, number and width of cells: at most about eight per grain, whatever the extent.
    fn shape(&mut self, position: &[Vec3], width: f64, periods: &Periods) {
        let mut count = [1.0f64; 3];
        let mut extent = [0.0; 3];
        for axis in 0..3 {
            let (low, size) = if periods.is_periodic(axis) {
                (periods.start[axis], periods.length[axis])
            } else {
                let low = position.iter().map(|x| x[axis]).fold(f64::INFINITY, f64::min);
                let high = position.iter().map(|x| x[axis]).fold(f64::NEG_INFINITY, f64::max);
                (low, (high - low).max(0.0))
            };
            self.origin[axis] = low;
            extent[axis] = size;
            count[axis] = (size / width).floor().clamp(1.0, 1e6);
        }
        let most = 8.0 * position.len() as f64 + 64.0;
        while count.iter().product::<f64>() > most {
            let longest = if count[0] >= count[1] && count[0] >= count[2] {
                0
            } else if count[1] >= count[2] {
                1
            } else {
                2
            };
            count[longest] = (0.5 * count[longest]).floor().max(1.0);
        }
        for axis in 0..3 {
            self.count[axis] = count[axis] as usize;
            self.inverse[axis] = if extent[axis] > 0.0 { count[axis] / extent[axis] } else { 0.0 };
        }
    }

    fn cell_of(&self, x: &Vec3, periods: &Periods) -> usize {
        let mut cell = 0;
        for axis in (0..3).rev() {
            let n = self.count[axis];
            let at = ((x[axis] - self.origin[axis]) * self.inverse[axis]).floor();
            let index = if periods.is_periodic(axis) {
                at.rem_euclid(n as f64) as usize
            } else {
                at.max(0.0) as usize
            };
            cell = cell * n + index.min(n - 1);
        }
        cell
    }

    /// Calls `visit` with every grain in the cells around grain `i`, each once.
    fn around(&self, i: usize, periods: &Periods, mut visit: impl FnMut(usize)) {
        let cell = self.cell[i] as usize;
        let at = [
            cell % self.count[0],
            cell / self.count[0] % self.count[1],
            cell / (self.count[0] * self.count[1]),
        ];
        let reach: [Neighbours; 3] =
            std::array::from_fn(|axis| Neighbours::of(at[axis], self.count[axis], periods.is_periodic(axis)));
        for z in reach[2].iter() {
            for y in reach[1].iter() {
                for x in reach[0].iter() {
                    let cell = (z * self.count[1] + y) * self.count[0] + x;
                    for &j in &self.item[self.start[cell] as usize..self.start[cell + 1] as usize] {
                        visit(j as usize);
                    }
                }
            }
        }
    }
}

/// Up to three neighbouring cell indices along one axis.
struct Neighbours {
    index: [usize; 3],
    count: usize,
}

impl Neighbours {
    fn of(at: usize, n: usize, periodic: bool) -> Self {
        let mut list = Self { index: [at; 3], count: 1 };
        if at > 0 {
            list.add(at - 1);
        } else if periodic {
            list.add(n - 1);
        }
        if at + 1 < n {
            list.add(at + 1);
        } else if periodic {
            list.add(0);
        }
        list
    }

    fn add(&mut self, index: usize) {
        if !self.index[..self.count].contains(&index) {
            self.index[self.count] = index;
            self.count += 1;
        }
    }

    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.index[..self.count].iter().copied()
    }
}

/// Search for pairs nearer than the sum of their radii and a reach.
#[derive(Clone, Debug, Default)]
pub struct Search {
    cells: Cells,
    sorted: bool,
}

impl Search {
    /// Prepares a search of all pairs with a gap below `reach`.
    pub fn prepare(&mut self, position: &[Vec3], radius: &[f64], reach: f64, periods: &Periods) {
        self.sorted = position.len() > FEW;
        if self.sorted {
            let largest = radius.iter().copied().fold(0.0, f64::max);
            self.cells.sort(position, 2.0 * largest + reach, periods);
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
        let near = |j: usize| {
            let limit = radius[i] + radius[j] + reach;
            periods.nearest(position[i] - position[j]).norm_squared() < limit * limit
        };
        if self.sorted {
            self.cells.around(i, periods, |j| {
                if j > i && near(j) {
                    found.push(j as u32);
                }
            });
            found.sort_unstable();
        } else {
            found.extend((i + 1..position.len()).filter(|&j| near(j)).map(|j| j as u32));
        }
    }
}
