//! Pairs of grains that are near each other, by cells.

use crate::grid::Grid;
use crate::immersed::body::{Motion, Shape, laboratory};

/// One axis of the box of cells.
#[derive(Clone, Copy, Debug)]
struct Cells {
    start: f64,
    length: f64,
    count: usize,
    periodic: bool,
}

impl Cells {
    /// The cell of a place; places beyond a wall count to the last cell.
    fn of(&self, x: f64) -> usize {
        let mut part = (x - self.start) / self.length;
        if self.periodic {
            part -= part.floor();
        }
        // As NaN and negative numbers become 0, every place has a cell.
        ((part * self.count as f64) as usize).min(self.count - 1)
    }

    /// Numbers of the cell before, the cell itself and the cell after, each once.
    fn around(&self, cell: usize) -> impl Iterator<Item = usize> {
        let n = self.count;
        let before = if cell > 0 { Some(cell - 1) } else { (self.periodic && n > 2).then_some(n - 1) };
        let after = if cell + 1 < n { Some(cell + 1) } else { (self.periodic && n > 2).then_some(0) };
        [before, Some(cell), after].into_iter().flatten()
    }

    /// The shortest way between two places.
    fn shortest(&self, d: f64) -> f64 {
        if self.periodic { d - self.length * (d / self.length).round() } else { d }
    }
}

/// Two grains near each other, or twice the same at a wall, the direction from the first to the second, the
/// gap, and the radius of the sphere that has the same gap to a plane around its least.
#[derive(Clone, Debug)]
pub(super) struct Near {
    pub(super) grains: [usize; 2],
    pub(super) normal: [f64; 3],
    pub(super) gap: f64,
    pub(super) round: f64,
}

/// A cell list over the box of the grid, made anew for each window.
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    /// By laboratory axis; those that the grid does not have are one cell.
    axes: [Cells; 3],
    reach: f64,
    /// Grains by cell, and where each cell begins.
    order: Vec<usize>,
    begins: Vec<usize>,
    cell: Vec<usize>,
}

impl Neighbours {
    /// For pairs whose gap is below `reach` times the smaller radius.
    pub(super) fn new<const D: usize>(grid: &Grid<D>, shapes: &[Shape], reach: f64) -> Self {
        let largest = shapes.iter().map(|shape| shape.radius).fold(0.0, f64::max);
        // Half a reach more, for what a grain moves in a window.
        let size = (2.0 + 1.5 * reach) * largest;
        // No more cells than some per grain, however small grains are in their box.
        let most = (4.0 * (shapes.len() as f64).powf(1.0 / D as f64)).ceil();
        let mut axes = [Cells { start: 0.0, length: 1.0, count: 1, periodic: false }; 3];
        for a in 0..D {
            let (start, length) = (grid.axes[a].faces[0], grid.axes[a].length());
            let count = (length / size).clamp(1.0, most.max(1.0)) as usize;
            axes[laboratory(grid.geometry, a)] = Cells { start, length, count, periodic: grid.periodic(a) };
        }
        let cells = axes.iter().map(|axis| axis.count).product::<usize>();
        let (order, cell) = (vec![0; shapes.len()], vec![0; shapes.len()]);
        Self { axes, reach, order, begins: vec![0; cells + 1], cell }
    }

    /// Calls `each` once with every pair and its gaps at `now` and at `then`, of which one is within reach.
    pub(super) fn each_pair(
        &mut self,
        shapes: &[Shape],
        now: &[Motion],
        then: &[Motion],
        mut each: impl FnMut(usize, usize, [f64; 2]),
    ) {
        self.sort(now);
        self.each_neighbour(|i, j| {
            let gaps = [now, then].map(|motions| self.gap(shapes, motions, i, j));
            if gaps[0].min(gaps[1]) < self.reach * shapes[i].radius.min(shapes[j].radius) {
                each(i, j, gaps);
            }
        });
    }

    /// Calls `each` once with every pair whose gap is at most `most`, m.
    pub(super) fn each_near(
        &mut self,
        shapes: &[Shape],
        now: &[Motion],
        most: f64,
        mut each: impl FnMut(Near),
    ) {
        self.sort(now);
        self.each_neighbour(|i, j| {
            let way = self.way(now, i, j);
            let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
            let [a, b] = [i, j].map(|grain| shapes[grain].radius);
            let (gap, round) = (length - a - b, a * b / (a + b));
            if gap <= most {
                each(Near { grains: [i, j], normal: way.map(|way| way / length), gap, round });
            }
        });
    }

    /// The shortest way between the centres of two grains, m.
    fn way(&self, motions: &[Motion], i: usize, j: usize) -> [f64; 3] {
        let (from, to) = (&motions[i].centre, &motions[j].centre);
        std::array::from_fn(|c| self.axes[c].shortest(to[c] - from[c]))
    }

    fn gap(&self, shapes: &[Shape], motions: &[Motion], i: usize, j: usize) -> f64 {
        let [x, y, z] = self.way(motions, i, j);
        (x * x + y * y + z * z).sqrt() - shapes[i].radius - shapes[j].radius
    }

    /// Calls `each` once with every pair in cells beside each other.
    fn each_neighbour(&self, mut each: impl FnMut(usize, usize)) {
        let Self { axes: [x, y, z], order, begins, cell, .. } = self;
        for (i, at) in cell.iter().enumerate() {
            let [cx, cy, cz] = self.split(*at);
            for kz in z.around(cz) {
                for ky in y.around(cy) {
                    for kx in x.around(cx) {
                        let k = (kz * y.count + ky) * x.count + kx;
                        order[begins[k]..begins[k + 1]].iter().filter(|j| **j > i).for_each(|j| each(i, *j));
                    }
                }
            }
        }
    }

    /// Numbers of a cell along the axes.
    fn split(&self, cell: usize) -> [usize; 3] {
        let [x, y, _] = &self.axes;
        [cell % x.count, cell / x.count % y.count, cell / (x.count * y.count)]
    }

    /// Grains by cell: counted, then put in order.
    fn sort(&mut self, motions: &[Motion]) {
        let Self { axes: [x, y, z], order, begins, cell, .. } = self;
        begins.fill(0);
        for (cell, motion) in cell.iter_mut().zip(motions) {
            let [cx, cy, cz] = [x.of(motion.centre[0]), y.of(motion.centre[1]), z.of(motion.centre[2])];
            *cell = (cz * y.count + cy) * x.count + cx;
            begins[*cell] += 1;
        }
        let mut sum = 0;
        for begin in begins.iter_mut() {
            sum += *begin;
            *begin = sum;
        }
        for (i, cell) in cell.iter().enumerate().rev() {
            begins[*cell] -= 1;
            order[begins[*cell]] = i;
        }
    }
}
