//! The cells near grains, as segments of rows, with a weight each.

use crate::grid::Grid;
use crate::immersed::body::along_axes;
use crate::immersed::nodes::Nodes;
use std::ops::Range;

/// Cells from the surface of a grain within which the weight is 1, and beyond which it is 0.
const FULL: f64 = 2.0;
/// See [`FULL`].
const REACH: f64 = 3.0;
/// Cells from there to the last value that depends on such a weight: a diagonal of a cell, and a bit.
const MARGIN: f64 = 1.5;

/// A grain: where it is, along the axes of the grid, its radius and the width of the cells about it, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball<const D: usize> {
    centre: [f64; D],
    radius: f64,
    /// The largest at the centre.
    width: f64,
}

impl<const D: usize> Ball<D> {
    pub(super) fn new(grid: &Grid<D>, centre: [f64; 3], radius: f64) -> Self {
        let centre = along_axes(grid.geometry, centre);
        let width = (0..D).map(|a| {
            let axis = &grid.axes[a];
            axis.widths[axis.faces.partition_point(|face| *face <= centre[a]).clamp(1, axis.cells()) - 1]
        });
        Self { centre, radius, width: width.fold(0.0, f64::max) }
    }
}

/// Neighbouring cells of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// First cell, and the one after the last.
    pub(super) from: usize,
    pub(super) to: usize,
    /// Where its values begin.
    pub(super) at: usize,
}

/// Part of a row that a grain reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Reached {
    from: u32,
    to: u32,
    grain: u32,
}

/// Cells within reach of grains, and those beside them.
#[derive(Clone, Debug)]
pub(super) struct Bands<const D: usize> {
    nodes: Nodes<D>,
    /// Whether this process needs a plane: its own ones and those beside them.
    wanted: Vec<bool>,
    /// Rows of a plane.
    of_a_plane: usize,
    /// See [`Bands::rows`].
    rows: Range<usize>,
    /// Where the segments of each row begin, one entry more than rows.
    begins: Vec<usize>,
    segments: Vec<Segment>,
    /// Weight of each cell, 255 for 1.
    weights: Vec<u8>,
    reached: Vec<Reached>,
}

impl<const D: usize> Bands<D> {
    pub(super) fn new(grid: &Grid<D>) -> Self {
        let (own, planes) = (grid.division.own(), grid.cells[D - 1]);
        let beside =
            |k: usize| own.contains(&((k + 1) % planes)) || own.contains(&((k + planes - 1) % planes));
        Self {
            wanted: (0..planes).map(|k| own.contains(&k) || beside(k)).collect(),
            of_a_plane: grid.rows() / planes,
            nodes: Nodes::new(grid, D),
            rows: 0..0,
            begins: vec![0; grid.rows() + 1],
            segments: Vec::new(),
            weights: Vec::new(),
            reached: Vec::new(),
        }
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    /// Rows of a plane between the lowest and the highest that any plane has segments on; empty without any.
    pub(super) fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// The segments of a row, from left to right.
    pub(super) fn row(&self, row: usize) -> &[Segment] {
        &self.segments[self.begins[row]..self.begins[row + 1]]
    }

    /// Where the values of `rows` stand.
    pub(super) fn values(&self, rows: Range<usize>) -> Range<usize> {
        let at =
            |row: usize| self.segments.get(self.begins[row]).map_or(self.weights.len(), |first| first.at);
        at(rows.start)..at(rows.end)
    }

    /// Finds the cells near `grains`.
    pub(super) fn set(&mut self, grid: &Grid<D>, grains: &[Ball<D>]) {
        self.begins.fill(0);
        self.each(grid, grains, |bands, row, _| bands.begins[row] += 1);
        // Where each row begins, for now among what grains reach of it.
        let mut sum = 0;
        for begin in &mut self.begins {
            sum += std::mem::replace(begin, sum);
        }
        self.reached.clear();
        self.reached.resize(sum, Reached::default());
        self.each(grid, grains, |bands, row, reached| {
            bands.reached[bands.begins[row]] = reached;
            bands.begins[row] += 1;
        });
        self.join(grid, grains);
    }

    /// Calls `note` for every row that a grain reaches.
    fn each(&mut self, grid: &Grid<D>, grains: &[Ball<D>], note: impl Fn(&mut Self, usize, Reached)) {
        for (number, grain) in grains.iter().enumerate() {
            let half = grain.radius + (REACH + MARGIN) * grain.width;
            let range = |bands: &Self, a: usize, half: f64| bands.nodes.range(grid, a, grain.centre[a], half);
            let (j, k) = (range(self, 1, half), if D == 3 { range(self, D - 1, half) } else { (0, 1) });
            for k in k.0..k.1 {
                for j in j.0..j.1 {
                    let (row, across) = self.place(grid, grain, [j, k]);
                    let left = half * half - across;
                    if left <= 0.0 || !self.wanted[row / self.of_a_plane] {
                        continue;
                    }
                    let (from, to) = range(self, 0, left.sqrt());
                    let n = grid.cells[0] as isize;
                    // On a periodic axis a part may lie beyond either end.
                    for turn in [-n, 0, n] {
                        let (from, to) = ((from - turn).clamp(0, n) as u32, (to - turn).clamp(0, n) as u32);
                        if from < to {
                            note(self, row, Reached { from, to, grain: number as u32 });
                        }
                    }
                }
            }
        }
    }

    /// Row at the unwrapped indices `at` along the axes after the first, and the square of its distance from
    /// the centre of a grain, m².
    fn place(&self, grid: &Grid<D>, grain: &Ball<D>, at: [isize; 2]) -> (usize, f64) {
        let (mut row, mut across, mut rows) = (0, 0.0, 1);
        for a in 1..D {
            let node = self.nodes.node(grid, a, grain.centre[a], at[a - 1]);
            row += rows * node.index;
            across += node.arm * node.arm;
            rows *= grid.cells[a];
        }
        (row, across)
    }

    /// Segments and weights from what grains reach; `begins` are then the ends of the rows.
    fn join(&mut self, grid: &Grid<D>, grains: &[Ball<D>]) {
        self.segments.clear();
        self.weights.clear();
        let (mut end, [mut low, mut high]) = (0, [usize::MAX, 0]);
        for row in 0..grid.rows() {
            let begin = std::mem::replace(&mut end, self.begins[row]);
            self.begins[row] = self.segments.len();
            self.reached[begin..end].sort_unstable();
            for index in begin..end {
                let Reached { from, to, .. } = self.reached[index];
                let (from, to) = (from as usize, to as usize);
                let added = match self.segments[self.begins[row]..].last_mut() {
                    Some(last) if from <= last.to => {
                        let added = to.saturating_sub(last.to);
                        last.to = last.to.max(to);
                        added
                    }
                    _ => {
                        self.segments.push(Segment { from, to, at: self.weights.len() });
                        to - from
                    }
                };
                self.weights.resize(self.weights.len() + added, 0);
            }
            self.weigh(grid, grains, row, begin..end);
            if begin < end {
                (low, high) = (low.min(row % grid.cells[1]), high.max(row % grid.cells[1] + 1));
            }
        }
        self.rows = low..high;
        self.begins[grid.rows()] = self.segments.len();
    }

    /// Weights of a row: the largest over the grains.
    fn weigh(&mut self, grid: &Grid<D>, grains: &[Ball<D>], row: usize, reached: Range<usize>) {
        let indices = if D == 3 { [row % grid.cells[1], row / grid.cells[1]] } else { [row, 0] };
        let segments = self.begins[row]..self.segments.len();
        let centres = grid.nodes(D, 0);
        for reached in &self.reached[reached] {
            let grain = &grains[reached.grain as usize];
            // Where the image of the grain lies that is nearest to cell `index`.
            let image = |a: usize, index: usize| {
                let (at, length) = (grid.nodes(D, a)[index], grid.axes[a].length());
                let turns = if grid.periodic(a) { ((at - grain.centre[a]) / length).round() } else { 0.0 };
                grain.centre[a] + turns * length
            };
            let arm = |a: usize, index: usize| grid.nodes(D, a)[index] - image(a, index);
            let across: f64 = (1..D).map(|a| arm(a, indices[a - 1]).powi(2)).sum();
            let (from, to) = (reached.from as usize, reached.to as usize);
            let holds = |segment: &&Segment| segment.from <= from && to <= segment.to;
            let segment = self.segments[segments.clone()].iter().find(holds).expect("every part was joined");
            let at = segment.at + from - segment.from;
            let centre = image(0, (from + to) / 2);
            let [scale, most] = [255.0 / ((REACH - FULL) * grain.width), 255.0 * REACH / (REACH - FULL)];
            let most = most + scale * grain.radius;
            for (weight, x) in self.weights[at..][..to - from].iter_mut().zip(&centres[from..to]) {
                let distance = (across + (x - centre) * (x - centre)).sqrt();
                *weight = (*weight).max((most - scale * distance) as u8);
            }
        }
    }

    /// Writes the weights of a row to `out`, whose place `first` is cell 0, what lies beyond a periodic end
    /// included.
    pub(super) fn write(&self, grid: &Grid<D>, row: usize, first: usize, out: &mut [f64]) {
        let n = grid.cells[0] as isize;
        let turns = if grid.periodic(0) { &[-1, 0, 1][..] } else { &[0] };
        for segment in self.row(row) {
            for turn in turns {
                let (from, to) = (segment.from as isize + turn * n, segment.to as isize + turn * n);
                let (low, high) = (from.max(-1), to.min(n + 1));
                if low < high {
                    let weights =
                        &self.weights[segment.at + (low - from) as usize..][..(high - low) as usize];
                    let out = &mut out[(low + first as isize) as usize..];
                    out.iter_mut().zip(weights).for_each(|(out, weight)| *out = f64::from(*weight) / 255.0);
                }
            }
        }
    }
}
