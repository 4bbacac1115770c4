//! The fields that decide the next step.
//!
//! Layout of every array: see [`crate::grid`].

use crate::grid::Grid;
use crate::open::OpenFaces;
use crate::threads::for_chunks;
use std::ops::Range;

/// Values that a thread clears at a time.
const CLEARED: usize = 16_384;

/// Everything that decides the next time step; putting a copy back and a restart go back to it.
#[derive(Clone, Debug, PartialEq)]
pub struct State<const D: usize> {
    /// Velocity components, m/s. The caller may change them between steps (direct forcing); halo
    /// and wall faces are refreshed by the solver at the start of every step.
    pub velocity: [Vec<f64>; D],
    /// Pressure over density, m²/s², without hydrostatic part and mean gradient; zero mean.
    pub pressure: Vec<f64>,
    /// Convection (and explicit viscosity) of the previous step, m/s²: used by Adams–Bashforth.
    pub history: [Vec<f64>; D],
    /// Velocity on the faces that fluid passes through.
    pub open: OpenFaces<D>,
    /// Length of the previous step, s; zero before the first one (no history yet).
    pub previous_dt: f64,
    /// Time, s.
    pub time: f64,
    /// Full steps done.
    pub steps: u64,
}

impl<const D: usize> State<D> {
    /// Fluid at rest at time zero.
    pub fn at_rest(grid: &Grid<D>) -> Self {
        Self {
            velocity: grid.new_vector(),
            pressure: grid.new_field(),
            history: grid.new_vector(),
            open: OpenFaces::new(grid),
            previous_dt: 0.0,
            time: 0.0,
            steps: 0,
        }
    }
}

/// Copies a field without allocating; of one with `whole` values the planes `own`, wall faces and halos
/// included.
pub fn copy_own(own: &Range<usize>, whole: usize, to: &mut [f64], from: &[f64]) {
    let place = if from.len() == whole { own.clone() } else { 0..from.len() };
    to[place.clone()].copy_from_slice(&from[place]);
}

/// Zero on the planes of this process, in those of some fields that there are.
pub fn clear_own<const D: usize>(grid: &Grid<D>, fields: &mut [Vec<f64>]) {
    let own = own_planes(grid);
    let fields = fields.iter_mut().filter(|field| !field.is_empty());
    fields.for_each(|field| for_chunks(&mut field[own.clone()], CLEARED, |_, chunk| chunk.fill(0.0)));
}

/// Where the planes of this process lie in a field; without ranks the whole field.
pub fn own_planes<const D: usize>(grid: &Grid<D>) -> Range<usize> {
    let ranks = grid.division.ranks();
    if ranks.is_alone() { 0..grid.len() } else { planes_of(grid, ranks.rank()) }
}

/// Where the planes of rank `rank` lie in a field.
fn planes_of<const D: usize>(grid: &Grid<D>, rank: usize) -> Range<usize> {
    let planes = grid.division.of(rank);
    grid.planes(planes.start as isize, planes.end as isize)
}

/// Every field whole on the first rank, in its own memory; says whether this is it.
pub fn gather_to_first<'a, const D: usize>(
    grid: &Grid<D>,
    fields: impl Iterator<Item = &'a mut Vec<f64>>,
) -> bool {
    let ranks = grid.division.ranks();
    for field in fields {
        if !ranks.is_first() {
            ranks.exchange(&[(0, &field[own_planes(grid)])], &mut []);
            continue;
        }
        for rank in 1..ranks.size() {
            ranks.exchange(&[], &mut [(rank, &mut field[planes_of(grid, rank)])]);
        }
    }
    ranks.is_first()
}

/// Sets the unknowns of component `d` from a function of position (m, one entry per axis), on the planes of
/// this process.
pub fn set_component<const D: usize>(
    grid: &Grid<D>,
    d: usize,
    u: &mut [f64],
    value: impl Fn([f64; D]) -> f64,
) {
    for_each_own_unknown(grid, d, |at, index| {
        u[index] = value(std::array::from_fn(|a| grid.nodes(d, a)[at[a]]));
    });
}

/// Visits every unknown of component `d` (`d = D`: every cell) in memory order: its indices and its place in
/// the field.
pub fn for_each_unknown<const D: usize>(grid: &Grid<D>, d: usize, visit: impl FnMut([usize; D], usize)) {
    for_each_in(grid, grid.unknowns(d), visit);
}

/// The same for the unknowns on the planes of this process.
pub fn for_each_own_unknown<const D: usize>(grid: &Grid<D>, d: usize, visit: impl FnMut([usize; D], usize)) {
    for_each_in(grid, own(grid, grid.unknowns(d)), visit);
}

/// Visits every value of component `d`, with those on open faces.
pub fn for_each_value<const D: usize>(grid: &Grid<D>, d: usize, visit: impl FnMut([usize; D], usize)) {
    for_each_in(grid, grid.values(d), visit);
}

/// Visits the rows of values of component `d` on the planes of this process, with those on open faces, in
/// memory order: the indices of the first one and the places of all.
pub fn for_each_own_row<const D: usize>(
    grid: &Grid<D>,
    d: usize,
    visit: impl FnMut([usize; D], Range<usize>),
) {
    for_each_row_in(grid, own(grid, grid.values(d)), visit);
}

/// What of `ranges` lies on the planes of this process: the last has the face above, too.
fn own<const D: usize>(grid: &Grid<D>, mut ranges: [Range<usize>; D]) -> [Range<usize>; D] {
    let (own, range) = (grid.division.own(), &mut ranges[D - 1]);
    range.start = range.start.max(own.start);
    if own.end < grid.cells[D - 1] {
        range.end = own.end;
    }
    ranges
}

fn for_each_in<const D: usize>(
    grid: &Grid<D>,
    ranges: [Range<usize>; D],
    mut visit: impl FnMut([usize; D], usize),
) {
    for_each_row_in(grid, ranges, |mut at, places| {
        for index in places {
            visit(at, index);
            at[0] += 1;
        }
    });
}

fn for_each_row_in<const D: usize>(
    grid: &Grid<D>,
    ranges: [Range<usize>; D],
    mut visit: impl FnMut([usize; D], Range<usize>),
) {
    let mut at: [usize; D] = std::array::from_fn(|a| ranges[a].start);
    'all: loop {
        let first = grid.index(at.map(|i| i as isize));
        visit(at, first..first + ranges[0].len());
        for a in 1..D {
            at[a] += 1;
            if at[a] < ranges[a].end {
                continue 'all;
            }
            at[a] = ranges[a].start;
        }
        return;
    }
}
