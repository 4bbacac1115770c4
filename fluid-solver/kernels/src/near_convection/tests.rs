//! The terms against the formulas of the module, written out node by node.

use super::NearConvection;
use super::factors::{LIMIT, variance};
use crate::axis::AxisSpec;
use crate::boundary::Boundary;
use crate::field::{for_each_unknown, set_component};
use crate::grid::{Geometry, Grid, GridSpec};
use crate::immersed::body::along_axes;

const VISCOSITY: f64 = 0.02;

/// Grains, in a box of some ten cells: one across periodic faces, one near a wall, two that overlap in reach.
const GRAINS: [([f64; 3], f64); 3] =
    [([0.1, 0.5, 0.4], 0.2), ([1.1, 1.9, 1.5], 0.15), ([1.5, 1.2, 1.7], 0.2)];

fn uniform(cells: usize) -> AxisSpec {
    AxisSpec::Uniform { start: 0.0, end: 2.0, cells }
}

fn stretched() -> AxisSpec {
    let width = |k: usize| 0.1 + 0.004 * k as f64;
    AxisSpec::Faces((0..=17).map(|k| (0..k).map(width).sum()).collect())
}

fn grid<const D: usize>(geometry: Geometry, axes: [AxisSpec; D], periodic: [bool; D]) -> Grid<D> {
    let face = |a: usize| if periodic[a] { Boundary::Periodic } else { Boundary::WALL };
    let mut boundaries = std::array::from_fn(|a| [face(a); 2]);
    if geometry == Geometry::Axisymmetric {
        boundaries[0][0] = Boundary::Axis;
    }
    Grid::new(&GridSpec { geometry, axes, boundaries }).unwrap()
}

/// A field without symmetry, the same beyond periodic ends.
fn flow<const D: usize>(grid: &Grid<D>) -> [Vec<f64>; D] {
    let mut velocity = grid.new_vector();
    for (d, u) in velocity.iter_mut().enumerate() {
        set_component(grid, d, u, |x| {
            let phase = |a: usize, n: f64| (std::f64::consts::TAU * n * x[a] / grid.axes[a].length()).sin();
            let last = phase(D - 1, 2.0 + d as f64);
            0.3 + (1.0 + 0.2 * d as f64) * phase(0, 2.0) * last - 0.4 * phase(1, 3.0) + 0.2 * phase(0, 1.0)
        });
    }
    velocity
}

/// The formulas, for a node at a time.
struct Plain<'a, const D: usize> {
    grid: &'a Grid<D>,
    velocity: &'a [Vec<f64>; D],
}

type At = [isize; 3];

fn moved(mut at: At, axis: usize, by: isize) -> At {
    at[axis] += by;
    at
}

impl<const D: usize> Plain<'_, D> {
    /// Index along axis `a`, round a periodic one; none beyond the ends of another.
    fn index(&self, a: usize, index: isize) -> Option<usize> {
        let n = self.grid.cells[a] as isize;
        if self.grid.periodic(a) {
            return Some(index.rem_euclid(n) as usize);
        }
        (0..n).contains(&index).then_some(index as usize)
    }

    /// A value; beyond a wall the nearest one.
    fn u(&self, c: usize, at: At) -> f64 {
        let places = std::array::from_fn(|a| {
            let n = self.grid.cells[a] as isize;
            if self.grid.periodic(a) { at[a].rem_euclid(n) } else { at[a].clamp(0, n - 1) }
        });
        self.velocity[c][self.grid.index(places)]
    }

    fn weight(&self, at: At) -> f64 {
        let mut most: f64 = 0.0;
        let cell: Vec<Option<usize>> = (0..D).map(|a| self.index(a, at[a])).collect();
        for (centre, radius) in GRAINS {
            let centre: [f64; D] = along_axes(self.grid.geometry, centre);
            let (mut square, mut width) = (0.0, 0.0_f64);
            for a in 0..D {
                let axis = &self.grid.axes[a];
                let Some(index) = cell[a] else { return 0.0 };
                let arm = axis.centres[index] - centre[a];
                let turns = if self.grid.periodic(a) { (arm / axis.length()).round() } else { 0.0 };
                square += (arm - turns * axis.length()).powi(2);
                let of_grain = (0..axis.cells()).rfind(|i| axis.faces[*i] <= centre[a]).unwrap();
                width = width.max(axis.widths[of_grain]);
            }
            let share = 3.0 - (square.sqrt() - radius) / width;
            most = most.max((255.0 * share.clamp(0.0, 1.0)).floor() / 255.0);
        }
        most
    }

    /// Whether the four nodes along `a` that the flux between `low` and `low` + 1 asks for lie in the box.
    fn inside(&self, a: usize, low: isize, first: isize) -> bool {
        let n = self.grid.cells[a] as isize;
        self.grid.periodic(a) || (low > first && low + 2 < n)
    }

    fn stress(&self, product: f64, square: f64) -> f64 {
        let number = square.sqrt() * self.grid.smallest_width() / (VISCOSITY * LIMIT);
        variance(self.grid.geometry) * product / (1.0 + number.powi(4))
    }

    fn curve(&self, c: usize, a: usize, low: At) -> f64 {
        let u = |by: isize| self.u(c, moved(low, a, by));
        (u(-1) - u(0) - u(1) + u(2)) / 12.0
    }

    /// Flux of component `d` through the centre of cell `at`, its area included.
    fn centre(&self, d: usize, at: At) -> f64 {
        if !self.inside(d, at[d], 1) {
            return 0.0;
        }
        let axis = &self.grid.axes[d];
        let (here, next) = (at, moved(at, d, 1));
        let mut square = (self.u(d, next) - self.u(d, here)).powi(2);
        for k in (0..D).filter(|k| *k != d) {
            for node in [here, next] {
                for by in [-1, 0] {
                    let (low, high) = (moved(node, k, by), moved(node, k, by + 1));
                    square += 0.25 * (self.u(d, high) - self.u(d, low)).powi(2);
                }
            }
        }
        let cell = self.index(d, at[d]).unwrap();
        let flux =
            0.5 * (axis.face_area[cell] * self.u(d, here) + axis.face_area[cell + 1] * self.u(d, next));
        let area = axis.centre_area[cell];
        self.weight(at) * (flux * self.curve(d, d, here) - area * self.stress(square, square))
    }

    /// Flux of component `d` along `a` over the lower edge of cell `at` along the two, without its area.
    fn edge(&self, d: usize, a: usize, at: At) -> f64 {
        if !self.inside(a, at[a] - 1, 0) || !self.inside(d, at[d] - 1, 0) {
            return 0.0;
        }
        let (below, before) = (moved(at, a, -1), moved(at, d, -1));
        let (du, dv) = (self.u(d, at) - self.u(d, below), self.u(a, at) - self.u(a, before));
        let mut product = 0.0;
        for k in 0..D {
            // Mean of what there is of the change along k.
            let mean = |c: usize, nodes: [At; 2]| {
                let changes = nodes.map(|node| self.u(c, moved(node, k, 1)) - self.u(c, moved(node, k, -1)));
                0.25 * (changes[0] + changes[1])
            };
            let along_k = |c: usize, own: f64, nodes: [At; 2], native: usize| {
                if k == native { own } else { mean(c, nodes) }
            };
            product += along_k(d, du, [below, at], a) * along_k(a, dv, [before, at], d);
        }
        let axis = &self.grid.axes[d];
        let (low, high) = (self.index(d, at[d] - 1).unwrap(), self.index(d, at[d]).unwrap());
        let share = |cell: usize| 0.5 * axis.cell_volume[cell] / axis.face_volume[high];
        let mass = share(low) * self.u(a, before) + share(high) * self.u(a, at);
        let weights = [at, below, before, moved(below, d, -1)].map(|cell| self.weight(cell));
        0.25 * weights.iter().sum::<f64>()
            * (mass * self.curve(d, a, below) - self.stress(product, du * du + dv * dv))
    }

    fn term(&self, d: usize, at: At) -> f64 {
        let mut sum = 0.0;
        for a in 0..D {
            let axis = &self.grid.axes[a];
            let index = self.index(a, at[a]).unwrap();
            if a == d {
                let low = moved(at, d, -1);
                let below = if self.index(d, low[d]).is_some() { self.centre(d, low) } else { 0.0 };
                sum += (self.centre(d, at) - below) / axis.face_volume[index];
            } else {
                let high = axis.face_area[index + 1] * self.edge(d, a, moved(at, a, 1));
                sum += (high - axis.face_area[index] * self.edge(d, a, at)) / axis.cell_volume[index];
            }
        }
        let r = self.grid.axes[0].faces[at[0] as usize];
        if self.grid.geometry == Geometry::Axisymmetric && d == 0 && r > 0.0 {
            let rate = self.u(0, at) / r * self.grid.smallest_width();
            sum += variance(self.grid.geometry) * self.weight(at) * rate * rate / r;
        }
        sum
    }
}

/// The terms as fields.
fn fields<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> [Vec<f64>; D] {
    let mut near = NearConvection::new(grid, VISCOSITY);
    // The second time from what the first one left.
    for grains in [&GRAINS[..1], &GRAINS] {
        near.set(grid, grains.iter().copied());
        near.evaluate(grid, velocity);
    }
    let mut out = grid.new_vector();
    for (d, out) in out.iter_mut().enumerate() {
        for row in 0..grid.rows() {
            for (first, terms) in near.terms(d, row) {
                out[grid.row(row) + first..][..terms.len()].copy_from_slice(terms);
            }
        }
    }
    out
}

fn compare<const D: usize>(name: &str, grid: &Grid<D>) {
    let velocity = flow(grid);
    let ours = fields(grid, &velocity);
    let plain = Plain { grid, velocity: &velocity };
    let (mut most, mut worst) = (0.0_f64, 0.0_f64);
    for (d, ours) in ours.iter().enumerate() {
        for_each_unknown(grid, d, |at, index| {
            let exact = plain.term(d, std::array::from_fn(|a| at.get(a).map_or(0, |at| *at as isize)));
            let error = (ours[index] - exact).abs();
            most = most.max(exact.abs());
            worst = worst.max(error);
            assert!(error < 1e-9, "{name}: component {d} at {at:?}: {error} of {exact}");
        });
    }
    assert!(most > 0.1 && worst < 1e-12 * most, "{name}: {worst} of {most}");
}

#[test]
fn terms_are_the_formulas_on_two_axes() {
    let (plane, turned) = (Geometry::Plane, Geometry::Axisymmetric);
    compare("plane, periodic", &grid(plane, [uniform(20), uniform(18)], [true; 2]));
    compare("plane, walls", &grid(plane, [uniform(20), stretched()], [true, false]));
    compare("plane, closed", &grid(plane, [stretched(), uniform(21)], [false, false]));
    compare("axisymmetric", &grid(turned, [stretched(), uniform(20)], [false, true]));
}

#[test]
fn terms_are_the_formulas_in_space() {
    let space = Geometry::Space;
    compare("periodic", &grid(space, [uniform(20), uniform(18), uniform(16)], [true; 3]));
    compare("walls", &grid(space, [uniform(19), uniform(20), stretched()], [true, true, false]));
    compare("closed", &grid(space, [uniform(20), uniform(17), uniform(22)], [false; 3]));
}

/// They are fluxes: what one node gains another one loses, with stretched cells and about an axis of symmetry
/// along z, too.
#[test]
fn momentum_is_conserved() {
    fn sums<const D: usize>(grid: &Grid<D>, components: std::ops::Range<usize>) {
        let terms = fields(grid, &flow(grid));
        for d in components {
            let (mut sum, mut all) = (0.0, 0.0);
            for_each_unknown(grid, d, |at, index| {
                let part = grid.control_volume(d, at) * terms[d][index];
                (sum, all) = (sum + part, all + f64::abs(part));
            });
            assert!(all > 1e-3 && sum.abs() < 1e-13 * all, "component {d}: {sum} of {all}");
        }
    }
    sums(&grid(Geometry::Space, [uniform(20), uniform(18), stretched()], [true, true, false]), 0..2);
    sums(&grid(Geometry::Axisymmetric, [stretched(), uniform(20)], [false, true]), 1..2);
}

#[test]
fn a_uniform_stream_has_none() {
    let grid = grid(Geometry::Space, [uniform(20), uniform(18), uniform(16)], [true; 3]);
    let mut velocity = grid.new_vector();
    velocity.iter_mut().zip([1.0, -2.0, 0.5]).for_each(|(u, value)| u.fill(value));
    assert!(fields(&grid, &velocity).iter().flatten().all(|term| *term == 0.0));
}

#[test]
fn threads_change_no_bit() {
    let grid = grid(Geometry::Space, [uniform(40), uniform(40), uniform(40)], [true; 3]);
    let velocity = flow(&grid);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fields(&grid, &velocity))
    };
    let one = with(1);
    for threads in [2, 3, 5] {
        assert!(one == with(threads), "{threads} threads");
    }
}

/// A wave that a uniform stream carries along: with the terms its convection is of fourth order, without them
/// of second.
#[test]
fn convection_by_a_uniform_stream_is_of_fourth_order() {
    let error = |cells: usize| {
        let grid = grid(Geometry::Plane, [uniform(cells), uniform(cells)], [true; 2]);
        let wave = std::f64::consts::TAU;
        let mut velocity = grid.new_vector();
        velocity[0].fill(1.0);
        set_component(&grid, 1, &mut velocity[1], |x| (wave * x[0]).sin());
        let mut near = NearConvection::new(&grid, VISCOSITY);
        near.set(&grid, std::iter::once(([1.0, 0.0, 1.0], 1.5)));
        near.evaluate(&grid, &velocity);
        let width = 2.0 / cells as f64;
        let mut worst = [0.0_f64; 2];
        for (first, terms) in near.terms(1, 0) {
            for (i, term) in (first..).zip(terms) {
                let x = grid.axes[0].centres[i];
                let plain = -((wave * (x + width)).sin() - (wave * (x - width)).sin()) / (2.0 * width);
                let exact = -wave * (wave * x).cos();
                worst[0] = worst[0].max((plain - exact).abs());
                worst[1] = worst[1].max((plain + term - exact).abs());
            }
        }
        worst
    };
    let (coarse, fine) = (error(32), error(64));
    let order = |n: usize| (coarse[n] / fine[n]).log2();
    assert!((order(0) - 2.0).abs() < 0.05, "plain: {}", order(0));
    assert!((order(1) - 4.0).abs() < 0.05, "with the terms: {}", order(1));
}
