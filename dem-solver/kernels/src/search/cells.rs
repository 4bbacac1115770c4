//! Grains sorted into uniform cells, in O(N): the search of both engines.

use crate::periods::Periods;

/// Cells that a search looks around itself at most.
pub(crate) const CELLS: usize = 2;

/// Flag of a grain that forces do not move.
pub(crate) const IMMOBILE: u32 = 1 << 31;

/// Grains sorted into cells at least as wide as the reach of a pair.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cells {
    low: [f64; 3],
    inverse: [f64; 3],
    count: [usize; 3],
    length: [f64; 3],
    /// Axes from the one whose cells follow one another to the slowest.
    axes: [usize; 3],
    start: Vec<u32>,
    cell: Vec<u32>,
    /// Centres, and radii with half the skins, cell by cell: x, y, z, r; then eight more numbers of no
    /// meaning.
    pub(crate) item: [Vec<f64>; 4],
    /// Numbers of the grains, with [`IMMOBILE`].
    pub(crate) who: Vec<u32>,
}

/// Stretches of `item` that hold the neighbours of a place.
pub(crate) struct Around {
    run: [(u32, u32); 2 * (2 * CELLS + 1) * (2 * CELLS + 1)],
    count: usize,
}

impl Around {
    /// From, to.
    pub(crate) fn runs(&self) -> &[(u32, u32)] {
        &self.run[..self.count]
    }
}

impl Cells {
    /// Sorts `n` grains (centre and radius; whether forces move it) into cells of at least `width`.
    pub(crate) fn sort(
        &mut self,
        grains: impl Iterator<Item = ([f64; 4], bool)> + Clone,
        n: usize,
        width: f64,
        periods: &Periods,
    ) {
        self.shape(grains.clone().map(|([x, y, z, _], _)| [x, y, z]), n, width, periods);
        let cells = self.count.iter().product::<usize>();
        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell.clear();
        for ([x, y, z, _], _) in grains.clone() {
            let cell = self.cell_of(&self.place(&[x, y, z]));
            self.start[cell] += 1;
            self.cell.push(cell as u32);
        }
        let mut sum = 0;
        for start in &mut self.start {
            sum += std::mem::replace(start, sum);
        }
        for item in &mut self.item {
            item.resize(n + 8, 0.0);
        }
        self.who.resize(n, 0);
        for (g, (grain, moves)) in grains.enumerate() {
            let slot = &mut self.start[self.cell[g] as usize];
            let k = *slot as usize;
            *slot += 1;
            for (item, value) in self.item.iter_mut().zip(grain) {
                item[k] = value;
            }
            self.who[k] = g as u32 | if moves { 0 } else { IMMOBILE };
        }
        // each start now is the next one's
        self.start.rotate_right(1);
        self.start[0] = 0;
    }

    /// Chooses number and width of cells over the box of all centres, or over the period.
    fn shape(&mut self, centres: impl Iterator<Item = [f64; 3]>, n: usize, width: f64, periods: &Periods) {
        let (mut low, mut high) = extent(centres);
        let mut count = [1.0; 3];
        for axis in 0..3 {
            let (start, length) = periods.of(axis);
            self.length[axis] = length;
            if length > 0.0 {
                (low[axis], high[axis]) = (start, start + length);
            }
            count[axis] = ((high[axis] - low[axis]) / width).floor().clamp(1.0, 1e6);
        }
        // a few cells per grain, whatever the extent
        while count.iter().product::<f64>() > 4.0 * n as f64 + 64.0 {
            let longest = by_length(count)[2];
            count[longest] = (0.5 * count[longest]).floor().max(1.0);
        }
        for axis in 0..3 {
            let size = high[axis] - low[axis];
            self.count[axis] = count[axis] as usize;
            self.inverse[axis] = if size > 0.0 { count[axis] / size } else { 0.0 };
        }
        (self.low, self.axes) = (low, by_length(count));
    }

    /// Cell indices of a place.
    #[inline]
    fn place(&self, x: &[f64; 3]) -> [usize; 3] {
        let mut at = [0; 3];
        for axis in 0..3 {
            let n = self.count[axis];
            let mut cell = (x[axis] - self.low[axis]) * self.inverse[axis];
            if self.length[axis] > 0.0 && !(cell >= 0.0 && cell < n as f64) {
                cell = cell.rem_euclid(n as f64);
            }
            // the conversion cuts off the fraction, and takes 0 for what is below or no number
            at[axis] = (cell as usize).min(n - 1);
        }
        at
    }

    #[inline]
    fn cell_of(&self, at: &[usize; 3]) -> usize {
        let [a, b, c] = self.axes;
        (at[c] * self.count[b] + at[b]) * self.count[a] + at[a]
    }

    /// Ranges of cells up to `k` further along one axis; the second is empty except at a period's end.
    #[inline]
    fn near(&self, axis: usize, at: usize, k: usize) -> [(usize, usize); 2] {
        let n = self.count[axis];
        if n <= 2 * k + 1 && self.length[axis] > 0.0 {
            return [(0, n), (0, 0)];
        }
        let inner = (at.saturating_sub(k), (at + k + 1).min(n));
        let around = if self.length[axis] > 0.0 && at < k {
            (n + at - k, n)
        } else if self.length[axis] > 0.0 && at + k >= n {
            (0, at + k + 1 - n)
        } else {
            (0, 0)
        };
        [inner, around]
    }

    /// Where the neighbours of `x` are, up to `cells` further.
    #[inline]
    pub(crate) fn around(&self, x: &[f64; 3], cells: usize) -> Around {
        let at = self.place(x);
        let [a, b, c] = self.axes;
        let mut around = Around { run: [(0, 0); 2 * (2 * CELLS + 1) * (2 * CELLS + 1)], count: 0 };
        let near = [a, b, c].map(|axis| self.near(axis, at[axis], cells));
        for k in near[2].iter().flat_map(|&(from, to)| from..to) {
            for j in near[1].iter().flat_map(|&(from, to)| from..to) {
                let row = (k * self.count[b] + j) * self.count[a];
                for &(from, to) in &near[0] {
                    if from < to {
                        let (from, to) = (self.start[row + from], self.start[row + to]);
                        around.run[around.count] = (from, to);
                        around.count += usize::from(from < to);
                    }
                }
            }
        }
        around
    }
}

/// Lower and upper corner of the box of all places.
#[inline]
pub(crate) fn extent(places: impl Iterator<Item = [f64; 3]>) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for x in places {
        for axis in 0..3 {
            low[axis] = low[axis].min(x[axis]);
            high[axis] = high[axis].max(x[axis]);
        }
    }
    (low, high)
}

/// Axes from the shortest to the longest box.
pub(crate) fn by_length(count: [f64; 3]) -> [usize; 3] {
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| count[a].total_cmp(&count[b]));
    axes
}
