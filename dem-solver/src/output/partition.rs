//! Where averages live: slabs across an axis, or the cells of a grid. Each says which part of a grain
//! and which part of a line belongs to which cell; the parts of what lies inside add up to one.

use crate::grain::Shape;
use crate::motion::Vec3;
use bedload_output::totals::part_below;

/// Slabs, with sharp edges: a grain belongs to a slab with the part of its volume that lies in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Slabs {
    /// Component across the slabs.
    pub axis: usize,
    /// Lower edge of the first, m.
    pub lower: f64,
    /// Thickness, m.
    pub width: f64,
    /// Number.
    pub count: usize,
    /// Area of a slab across the axis, m² (m for discs).
    pub area: f64,
    /// Length of the period along the axis, if it has one, m.
    pub period: Option<f64>,
    /// Shape of the grains.
    pub shape: Shape,
}

/// Cells of a uniform grid over which a Gaussian of width w is spread: φ ∝ exp(−|r|²/(2w²)) of all images,
/// cut at 3w and at the box, its sum over the cells in the box made one.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Lower corner, m.
    pub lower: [f64; 3],
    /// Edges of a cell, m; for discs the second is 1.
    pub spacing: [f64; 3],
    /// Numbers of cells, x fastest.
    pub cells: [usize; 3],
    /// Cells of this size between the grid and the faces of the box, below and above along each axis.
    pub beyond: [[usize; 2]; 3],
    /// w, m.
    pub width: f64,
    /// Length of the period along each axis, if it has one, m.
    pub periods: [Option<f64>; 3],
}

/// Slabs or grid.
#[derive(Clone, Debug, PartialEq)]
pub enum Partition {
    /// Slabs.
    Slabs(Slabs),
    /// Grid.
    Grid(Grid),
}

impl Partition {
    /// Number of cells.
    pub fn count(&self) -> usize {
        match self {
            Self::Slabs(slabs) => slabs.count,
            Self::Grid(grid) => grid.cells.iter().product(),
        }
    }

    /// Volume of each cell, m³ (m² for discs).
    pub fn volume(&self) -> f64 {
        match self {
            Self::Slabs(slabs) => slabs.area * slabs.width,
            Self::Grid(grid) => grid.spacing.iter().product(),
        }
    }

    /// Parts of a grain by cell.
    pub fn ball(&self, centre: &Vec3, radius: f64, mut share: impl FnMut(usize, f64)) {
        match self {
            Self::Slabs(slabs) => slabs.ball(centre[slabs.axis], radius, &mut share),
            Self::Grid(grid) => grid.spread(centre, 1.0, &mut share),
        }
    }

    /// Parts of the line from `start` to `end` by cell.
    pub fn line(&self, start: &Vec3, end: &Vec3, mut share: impl FnMut(usize, f64)) {
        match self {
            Self::Slabs(slabs) => slabs.line(start[slabs.axis], end[slabs.axis], &mut share),
            Self::Grid(grid) => {
                // A point every half width: ∫₀¹ φ(start + s (end − start)) ds by the midpoint rule.
                let points = 1 + ((end - start).norm() / (0.5 * grid.width)).ceil() as usize;
                for point in 0..points {
                    let s = (point as f64 + 0.5) / points as f64;
                    grid.spread(&(start + (end - start) * s), 1.0 / points as f64, &mut share);
                }
            }
        }
    }
}

impl Slabs {
    /// Where the images of something between `low` and `high` lie.
    fn images(&self, low: f64, high: f64) -> impl Iterator<Item = f64> {
        let (bottom, top) = (self.lower, self.lower + self.width * self.count as f64);
        let shifts = [Some(0.0), self.period.map(|period| -period), self.period].into_iter().flatten();
        shifts.filter(move |shift| high + shift > bottom && low + shift < top)
    }

    /// Slabs that the interval touches.
    fn range(&self, low: f64, high: f64) -> std::ops::RangeInclusive<usize> {
        let place =
            |x: f64| ((x - self.lower) / self.width).floor().clamp(0.0, (self.count - 1) as f64) as usize;
        place(low)..=place(high)
    }

    /// Parts of a grain with its centre at `x`, by slab.
    pub(super) fn ball(&self, x: f64, radius: f64, share: &mut impl FnMut(usize, f64)) {
        for shift in self.images(x - radius, x + radius) {
            let x = x + shift;
            let disc = self.shape == Shape::Disc;
            let edge = |slab: usize| part_below((self.lower + self.width * slab as f64 - x) / radius, disc);
            for slab in self.range(x - radius, x + radius) {
                share(slab, edge(slab + 1) - edge(slab));
            }
        }
    }

    fn line(&self, start: f64, end: f64, share: &mut impl FnMut(usize, f64)) {
        let (low, high) = (start.min(end), start.max(end));
        for shift in self.images(low, high + f64::MIN_POSITIVE) {
            let (low, high) = (low + shift, high + shift);
            for slab in self.range(low, high) {
                let from = self.lower + self.width * slab as f64;
                let inside = high.min(from + self.width) - low.max(from);
                if high > low {
                    share(slab, inside.max(0.0) / (high - low));
                } else if low >= from && low < from + self.width {
                    share(slab, 1.0);
                }
            }
        }
    }
}

impl Grid {
    fn spread(&self, at: &Vec3, whole: f64, share: &mut impl FnMut(usize, f64)) {
        let sum = self.visit(at, 0.0, &mut |_, _| {});
        if sum > 0.0 {
            self.visit(at, whole / sum, share);
        }
    }

    /// Shares the Gaussian about `at` and its images out, times `scale`; returns its sum over the cells.
    fn visit(&self, at: &Vec3, scale: f64, share: &mut impl FnMut(usize, f64)) -> f64 {
        let reach = 3.0 * self.width;
        // Cells along an axis with the squares of their distances, of each image that reaches any.
        let lines: [Vec<(Option<usize>, f64)>; 3] = std::array::from_fn(|axis| {
            let (count, [below, above]) = (self.cells[axis], self.beyond[axis]);
            let (first, last) = (-(below as f64), (count + above) as f64 - 1.0);
            let turns = self.periods[axis].map_or(0, |period| 1 + (reach / period) as i32);
            let images = (-turns..=turns).flat_map(|turn| {
                let x = at[axis] + f64::from(turn) * self.periods[axis].unwrap_or(0.0);
                let place = |x: f64| ((x - self.lower[axis]) / self.spacing[axis]).floor();
                let (low, high) = (place(x - reach).max(first), place(x + reach).min(last));
                (low as i64..=high as i64).map(move |cell| (cell, x))
            });
            let square = |(cell, x): (i64, f64)| {
                let middle = self.lower[axis] + (cell as f64 + 0.5) * self.spacing[axis];
                let distance = if first == last { 0.0 } else { middle - x };
                (usize::try_from(cell).ok().filter(|cell| *cell < count), distance.powi(2))
            };
            let mut line: Vec<(Option<usize>, f64)> = images.map(square).collect();
            // From the nearest on: a Gaussian much narrower than a cell would be 0 in all.
            let least = line.iter().fold(f64::INFINITY, |least, (_, square)| least.min(*square));
            line.iter_mut().for_each(|(_, square)| *square -= least);
            line
        });
        let mut sum = 0.0;
        for (k, z) in &lines[2] {
            for (j, y) in &lines[1] {
                for (i, x) in &lines[0] {
                    let weight = (-0.5 * (x + y + z) / (self.width * self.width)).exp();
                    sum += weight;
                    if let (Some(i), Some(j), Some(k)) = (i, j, k) {
                        share((k * self.cells[1] + j) * self.cells[0] + i, weight * scale);
                    }
                }
            }
        }
        sum
    }
}
