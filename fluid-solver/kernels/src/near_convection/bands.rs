//! The cells near grains, as segments of rows, with a weight each.

use crate::grid::Grid;
use crate::immersed::body::along_axes;
use crate::immersed::mask_model::ROUND;
use crate::immersed::nodes::Nodes;
use crate::lanes::{Kernel, dispatch};
use crate::threads::{Chunks, share};
use pulp::Simd;
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
        let centre: [f64; D] = along_axes(grid.geometry, centre);
        let width = (0..D).map(|a| grid.axes[a].width_at(centre[a])).fold(0.0, f64::max);
        Self { centre, radius, width }
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

/// What a cell within reach holds beside twice its weight.
const REACHED: u16 = 1;

/// Cells within reach of grains, and those beside them.
#[derive(Clone, Debug)]
pub(super) struct Bands<const D: usize> {
    nodes: Nodes<D>,
    /// Whether this process needs a plane: its own ones and those beside them.
    wanted: Vec<bool>,
    /// Rows of a plane between the lowest and the highest that any plane has segments on; empty without any.
    pub(super) rows: Range<usize>,
    /// Where the segments of each row begin, one entry more than rows.
    begins: Vec<usize>,
    segments: Vec<Segment>,
    /// Number of cells of all segments.
    pub(super) count: usize,
    /// Of each cell twice its weight, 255 for 1, and [`REACHED`]; 0 beyond reach.
    cells: Vec<u16>,
    /// Of each row the first cell within reach and the one after the last.
    reach: Vec<[u32; 2]>,
}

/// The cells of a row about a grain.
#[derive(Clone, Copy)]
struct Arms<'a> {
    /// Positions, m.
    x: &'a [f64],
    /// Of the grain, m.
    centre: f64,
    /// Squared distance of the row from it, m².
    across: f64,
    /// The weight at the centre if it rose on, 255 for 1, and how much it falls in a metre.
    most: f64,
    fall: f64,
}

impl Arms<'_> {
    /// Raises the cells from place `at` on, as many as there are lanes.
    #[inline(always)]
    fn raise<const N: usize>(&self, cells: &mut [u16], at: usize) {
        let x = self.x[at..].first_chunk::<N>().expect("as many as asked for");
        let cells = cells[at..].first_chunk_mut::<N>().expect("as many as asked for");
        for l in 0..N {
            let arm = x[l] - self.centre;
            let weight = (self.most - self.fall * (self.across + arm * arm).sqrt()).clamp(0.0, 255.0);
            // The whole number below, by the last bits: a cast would take the lanes one by one.
            let near = weight + ROUND;
            let level = (near.to_bits() as u16) - u16::from(near - ROUND > weight);
            cells[l] = cells[l].max(2 * level + REACHED);
        }
    }

    #[inline(always)]
    fn raise_all(&self, cells: &mut [u16]) {
        let n = cells.len();
        for at in 0..if n < 8 { n } else { 0 } {
            self.raise::<1>(cells, at);
        }
        // The last eight may be raised twice.
        for eight in 0..if n < 8 { 0 } else { n.div_ceil(8) } {
            self.raise::<8>(cells, (8 * eight).min(n - 8));
        }
    }
}

/// The weights of the cells of some planes near all grains.
struct Weigh<'a, const D: usize> {
    grid: &'a Grid<D>,
    nodes: &'a Nodes<D>,
    wanted: &'a [bool],
    grains: &'a [Ball<D>],
    planes: Range<usize>,
    /// See [`Bands::cells`] and [`Bands::reach`]: from the first of the planes on.
    cells: &'a mut [u16],
    reach: &'a mut [[u32; 2]],
}

impl<const D: usize> Kernel for Weigh<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(mut self, _: S) {
        for (cells, reach) in self.cells.chunks_exact_mut(self.grid.cells[0]).zip(&mut *self.reach) {
            if let [from, to] = std::mem::replace(reach, NOTHING)
                && from < to
            {
                cells[from as usize..to as usize].fill(0);
            }
        }
        for grain in self.grains {
            self.weigh(grain);
        }
    }
}

impl<const D: usize> Weigh<'_, D> {
    /// Weights of the cells near a grain, where they are above those of other grains.
    #[inline(always)]
    fn weigh(&mut self, grain: &Ball<D>) {
        let Self { grid, nodes, wanted, planes, cells, reach, .. } = self;
        let half = grain.radius + (REACH + MARGIN) * grain.width;
        let fall = 255.0 / ((REACH - FULL) * grain.width);
        let most = 255.0 * REACH / (REACH - FULL) + fall * grain.radius;
        let range = |a: usize, half: f64| nodes.range(grid, a, grain.centre[a], half);
        let (n, x) = (grid.cells[0] as isize, grid.nodes(D, 0));
        let (j_range, k_range) = (range(1, half), if D == 3 { range(D - 1, half) } else { (0, 1) });
        for k in k_range.0..k_range.1 {
            let deep = (D == 3).then(|| nodes.node(grid, D - 1, grain.centre[D - 1], k));
            let plane = deep.map_or(0, |deep| deep.index);
            if !wanted[plane] || !planes.contains(&plane) {
                continue;
            }
            for j in j_range.0..j_range.1 {
                let node = nodes.node(grid, 1, grain.centre[1], j);
                let row = node.index + (plane - planes.start) * grid.cells[1];
                let across = node.arm * node.arm + deep.map_or(0.0, |deep| deep.arm * deep.arm);
                let left = half * half - across;
                if left <= 0.0 {
                    continue;
                }
                let (from, to) = range(0, left.sqrt());
                // On a periodic axis a part may lie beyond either end.
                for turn in [-1, 0, 1] {
                    let (from, to) = ((from - turn * n).clamp(0, n), (to - turn * n).clamp(0, n));
                    if from >= to {
                        continue;
                    }
                    let [first, last] = &mut reach[row];
                    (*first, *last) = ((*first).min(from as u32), (*last).max(to as u32));
                    let centre = grain.centre[0] - turn as f64 * grid.axes[0].length();
                    let (from, to) = (from as usize, to as usize);
                    let cells = &mut cells[row * n as usize + from..][..to - from];
                    Arms { x: &x[from..to], centre, across, most, fall }.raise_all(cells);
                }
            }
        }
    }
}

/// Reach of a row without grains.
const NOTHING: [u32; 2] = [u32::MAX, 0];

impl<const D: usize> Bands<D> {
    pub(super) fn new(grid: &Grid<D>) -> Self {
        let (own, planes) = (grid.division.own(), grid.cells[D - 1]);
        let beside =
            |k: usize| own.contains(&((k + 1) % planes)) || own.contains(&((k + planes - 1) % planes));
        Self {
            wanted: (0..planes).map(|k| own.contains(&k) || beside(k)).collect(),
            nodes: Nodes::new(grid, D),
            rows: 0..0,
            begins: vec![0; grid.rows() + 1],
            segments: Vec::new(),
            count: 0,
            cells: vec![0; grid.rows() * grid.cells[0]],
            reach: vec![NOTHING; grid.rows()],
        }
    }

    /// The segments of a row, from left to right.
    pub(super) fn row(&self, row: usize) -> &[Segment] {
        &self.segments[self.begins[row]..self.begins[row + 1]]
    }

    /// Where the values of `rows` stand.
    pub(super) fn values(&self, rows: Range<usize>) -> Range<usize> {
        let at = |row: usize| self.segments.get(self.begins[row]).map_or(self.count, |first| first.at);
        at(rows.start)..at(rows.end)
    }

    /// Finds the cells near `grains`.
    pub(super) fn set(&mut self, grid: &Grid<D>, grains: &[Ball<D>]) {
        let (n, rows) = (grid.cells[0], grid.cells[1]);
        let Self { nodes, wanted, cells, reach, .. } = self;
        let (count, threads) = (wanted.len(), rayon::current_num_threads());
        let most = if D == 3 && threads > 1 { count.div_ceil(2 * threads) } else { count };
        let rows_each = if D == 3 { rows * most } else { reach.len() };
        let parts = (
            Chunks { fields: [&mut cells[..]], size: rows_each * n },
            Chunks { fields: [&mut reach[..]], size: rows_each },
        );
        share(parts, 0..count.div_ceil(most.max(1)), 1, &|part, (cells, reach)| {
            let ([cells], [reach], first) = (cells.fields, reach.fields, part.start * most);
            let planes = first..count.min(first + most);
            dispatch(Weigh { grid, nodes, wanted, grains, planes, cells, reach });
        });
        self.cut(n, rows);
    }

    /// Segments of the cells within reach, in rows of `n` cells and planes of `rows` rows.
    fn cut(&mut self, n: usize, rows: usize) {
        self.segments.clear();
        self.count = 0;
        let [mut low, mut high] = [usize::MAX, 0];
        for (row, (reach, cells)) in self.reach.iter().zip(self.cells.chunks_exact(n)).enumerate() {
            self.begins[row] = self.segments.len();
            let [mut from, end] = reach.map(|place| place as usize);
            if from >= end {
                continue;
            }
            (low, high) = (low.min(row % rows), high.max(row % rows + 1));
            while from < end {
                let length = cells[from..end].iter().position(|cell| *cell == 0).unwrap_or(end - from);
                let to = from + length;
                self.segments.push(Segment { from, to, at: self.count });
                self.count += length;
                from = to + cells[to..end].iter().position(|cell| *cell != 0).unwrap_or(end - to);
            }
        }
        self.begins[self.reach.len()] = self.segments.len();
        self.rows = low..high;
    }

    /// Writes the weights of a row to `out`, whose place `first` is cell 0, what lies beyond a periodic end
    /// included.
    pub(super) fn write(&self, grid: &Grid<D>, row: usize, first: usize, out: &mut [f64]) {
        let n = grid.cells[0] as isize;
        let cells = &self.cells[row * n as usize..][..n as usize];
        let turns = if grid.periodic(0) { &[-1, 0, 1][..] } else { &[0] };
        for segment in self.row(row) {
            for turn in turns {
                let (from, to) = (segment.from as isize + turn * n, segment.to as isize + turn * n);
                let (low, high) = (from.max(-1), to.min(n + 1));
                if low < high {
                    let cells = &cells[(low - turn * n) as usize..][..(high - low) as usize];
                    let out = &mut out[(low + first as isize) as usize..];
                    out.iter_mut().zip(cells).for_each(|(out, cell)| *out = f64::from(*cell / 2) / 255.0);
                }
            }
        }
    }
}
