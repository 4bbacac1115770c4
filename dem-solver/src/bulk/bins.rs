//! Cells of the neighbour search, filled in the order of the engine.

use super::afar::CELLS;
use super::order::by_length;
use super::row::Row;

/// Marks a grain that forces do not move.
pub(super) const IMMOBILE: u32 = 1 << 31;

/// Grains sorted into cells at least as wide as the reach of a pair.
#[derive(Clone, Debug, Default)]
pub(super) struct Bins {
    low: [f64; 3],
    inverse: [f64; 3],
    count: [usize; 3],
    length: [f64; 3],
    /// Axes from the one whose cells follow one another to the slowest.
    axes: [usize; 3],
    start: Vec<u32>,
    cell: Vec<u32>,
    /// Centres, and radii with half the skins, cell by cell: x, y, z, r; then eight more numbers of no meaning.
    pub(super) item: [Vec<f64>; 4],
    /// Numbers in the order of the engine, with [`IMMOBILE`].
    pub(super) who: Vec<u32>,
}

/// Stretches of `item` that hold the neighbours of a place.
pub(super) struct Around {
    run: [(u32, u32); 2 * (2 * CELLS + 1) * (2 * CELLS + 1)],
    count: usize,
}

impl Around {
    /// From, to.
    pub(super) fn runs(&self) -> &[(u32, u32)] {
        &self.run[..self.count]
    }
}

impl Bins {
    /// Sorts `rows` (each without its last, empty row, and with half a skin) into cells of at least `width`;
    /// periodic axes start at `start` and have a `length`.
    pub(super) fn sort<'a>(
        &mut self,
        rows: impl Iterator<Item = (&'a [Row], f64)> + Clone,
        n: usize,
        width: f64,
        (start, length): ([f64; 3], [f64; 3]),
    ) {
        self.shape(rows.clone().map(|(rows, _)| rows), n, width, (start, length));
        let cells = self.count.iter().product::<usize>();
        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell.clear();
        for row in rows.clone().flat_map(|(rows, _)| rows) {
            let cell = self.cell_of(&self.place(&row.position()));
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
        let rows = rows.flat_map(|(rows, half)| rows.iter().map(move |row| (row, half)));
        for (g, (row, half)) in rows.enumerate() {
            let slot = &mut self.start[self.cell[g] as usize];
            let k = *slot as usize;
            *slot += 1;
            for (item, value) in self.item.iter_mut().zip(row.a) {
                item[k] = value;
            }
            self.item[3][k] += half;
            self.who[k] = g as u32 | if row.inverse_mass() > 0.0 { 0 } else { IMMOBILE };
        }
        // each start now is the next one's
        self.start.rotate_right(1);
        self.start[0] = 0;
    }

    fn shape<'a>(
        &mut self,
        rows: impl Iterator<Item = &'a [Row]>,
        n: usize,
        width: f64,
        (start, length): ([f64; 3], [f64; 3]),
    ) {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for row in rows.flatten() {
            for (axis, x) in row.position().into_iter().enumerate() {
                low[axis] = low[axis].min(x);
                high[axis] = high[axis].max(x);
            }
        }
        let mut count = [1.0; 3];
        for axis in 0..3 {
            if length[axis] > 0.0 {
                (low[axis], high[axis]) = (start[axis], start[axis] + length[axis]);
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
        (self.low, self.length, self.axes) = (low, length, by_length(count));
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
    pub(super) fn around(&self, x: &[f64; 3], cells: usize) -> Around {
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
