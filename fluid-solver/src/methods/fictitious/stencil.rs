//! Which values of the grid a point of a body is tied to, and how strongly.

use crate::boundary::Boundary;
use crate::grid::Grid;

/// Values along one axis that a point is tied to.
pub(super) const WIDTH: usize = 3;

/// One point on one velocity component: the first row's three places along x, and what the other rows add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stencil {
    /// Places along axis 0.
    columns: [u32; WIDTH],
    /// Places of the rows along axis 1.
    rows: [u32; WIDTH],
    /// Weights along axis 0; away from walls their sum is 1.
    across: [f64; WIDTH],
    /// Weights along axis 1.
    up: [f64; WIDTH],
    /// What moving walls add to the value at the point, m/s.
    wall: f64,
}

/// Weights of the values about a point that lies `s` cells, −½ to ½, beyond the middle one (Roma, Peskin &
/// Berger 1999, eq. 22).
fn weights(s: f64) -> [f64; WIDTH] {
    let middle = (1.0 + (1.0 - 3.0 * s * s).sqrt()) / 3.0;
    // Their sum is 1, their first moment is 0.
    let beside = 1.0 - middle;
    [0.5 * (beside - s), middle, 0.5 * (beside + s)]
}

/// The whole number nearest to `s`, without the call of a function that `round` is.
#[inline(always)]
fn nearest(s: f64) -> isize {
    let s = s + 0.5;
    let towards_zero = s as isize;
    towards_zero - isize::from(s < towards_zero as f64)
}

/// Places, weights and what the walls add, along `axis` of component `d`, for a point at `x`, m.
fn along<const D: usize>(grid: &Grid<D>, d: usize, axis: usize, x: f64) -> Along {
    let cells = grid.cells[axis] as isize;
    let width = grid.axes[axis].length() / cells as f64;
    let s = (x - grid.nodes(d, axis)[0]) / width;
    let nearest = nearest(s);
    let weights = weights(s - nearest as f64);
    if nearest > 1 && nearest < cells - 2 {
        return Along { places: [nearest - 1, nearest, nearest + 1], weights, wall: 0.0 };
    }
    let mut found = Along::default();
    for (k, weight) in weights.into_iter().enumerate() {
        let index = nearest + k as isize - 1;
        if grid.periodic(axis) {
            (found.places[k], found.weights[k]) = (index.rem_euclid(cells), weight);
            continue;
        }
        // Beyond a wall stands the mirror image: of the other sign where the wall holds the fluid.
        let faces = d == axis;
        let last = cells - isize::from(!faces);
        let (beyond, image, wall) = match index {
            i if i < 0 => (true, if faces { -i } else { -1 - i }, &grid.boundaries[axis][0]),
            i if i > last => (true, 2 * last + isize::from(!faces) - i, &grid.boundaries[axis][1]),
            i => (false, i, &grid.boundaries[axis][0]),
        };
        // What stands on an open face is no unknown: the next value inside stands for it and those beyond.
        if faces && (index <= 0 || index >= last) {
            let side = usize::from(index > 0);
            if grid.boundaries[axis][side].is_open() {
                let range = &grid.unknowns(d)[axis];
                found.places[k] = index.clamp(range.start as isize, range.end as isize - 1);
                found.weights[k] = weight;
                continue;
            }
        }
        let slips = !faces && !matches!(wall, Boundary::NoSlip { .. });
        let on_wall = faces && (image <= 0 || image >= last);
        let weight = if on_wall { 0.0 } else { weight };
        let range = &grid.unknowns(d)[axis];
        found.places[k] = image.clamp(range.start as isize, range.end as isize - 1);
        found.weights[k] = if beyond && !slips { -weight } else { weight };
        if beyond && !faces {
            found.wall += 2.0 * weight * wall.velocity(d);
        }
    }
    found
}

/// Whether a point at `x`, m, is beyond an open face across `axis`.
fn has_left<const D: usize>(grid: &Grid<D>, axis: usize, x: f64) -> bool {
    let (faces, boundaries) = (&grid.axes[axis].faces, &grid.boundaries[axis]);
    (x < faces[0] && boundaries[0].is_open()) || (x > faces[faces.len() - 1] && boundaries[1].is_open())
}

/// What a point is tied to along one axis.
#[derive(Default)]
struct Along {
    places: [isize; WIDTH],
    weights: [f64; WIDTH],
    /// What a moving wall adds, m/s.
    wall: f64,
}

impl Stencil {
    /// Of a point at `at` (first two axes of the grid, m) on component `d`. A point that has left through an
    /// open face is tied to nothing.
    pub(super) fn new<const D: usize>(grid: &Grid<D>, d: usize, at: [f64; 2]) -> Self {
        if (0..2).any(|axis| has_left(grid, axis, at[axis])) {
            return Self::default();
        }
        let [x, z] = [along(grid, d, 0, at[0]), along(grid, d, 1, at[1])];
        let row = |j: isize| grid.index(std::array::from_fn(|a| if a == 1 { j } else { 0 })) as u32;
        Self {
            columns: x.places.map(|i| i as u32),
            rows: z.places.map(row),
            across: x.weights,
            up: z.weights,
            wall: x.wall + z.wall,
        }
    }

    /// Whether the point has left the box.
    pub(super) fn is_out(&self) -> bool {
        self.across == [0.0; WIDTH] && self.up == [0.0; WIDTH]
    }

    /// Along both axes: the side of the nearer wall, and the part of what is spread that it takes.
    pub(super) fn held_by_walls<const D: usize>(&self, grid: &Grid<D>) -> [(usize, f64); 2] {
        let [across, up]: [f64; 2] = [self.across, self.up].map(|weights| weights.iter().sum());
        let middle = grid.index(std::array::from_fn(|a| if a == 1 { grid.cells[1] as isize / 2 } else { 0 }));
        let upper = [self.columns[1] as usize >= grid.cells[0] / 2, self.rows[1] as usize >= middle];
        let parts = if self.is_out() { [0.0; 2] } else { [1.0 - across, across * (1.0 - up)] };
        std::array::from_fn(|axis| (usize::from(upper[axis]), parts[axis]))
    }

    /// The value of a field at the point.
    #[inline]
    pub(super) fn interpolate(&self, field: &[f64]) -> f64 {
        let mut sum = self.wall;
        for (row, up) in self.rows.iter().zip(self.up) {
            let row = &field[*row as usize..];
            let along: f64 = self.columns.iter().zip(self.across).map(|(i, w)| w * row[*i as usize]).sum();
            sum += up * along;
        }
        sum
    }

    /// Adds `amount`, shared by the same weights.
    #[inline]
    pub(super) fn spread(&self, amount: f64, field: &mut [f64]) {
        for (row, up) in self.rows.iter().zip(self.up) {
            let row = &mut field[*row as usize..];
            for (i, w) in self.columns.iter().zip(self.across) {
                row[*i as usize] += amount * up * w;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::AxisSpec;
    use crate::boundary::Profile;
    use crate::field::set_component;
    use crate::grid::{Geometry, GridSpec};

    fn grid(boundaries: [[Boundary<2>; 2]; 2]) -> Grid<2> {
        let axes = [12, 8].map(|cells| AxisSpec::Uniform { start: 0.0, end: cells as f64 * 0.1, cells });
        Grid::new(&GridSpec { geometry: Geometry::Plane, axes, boundaries }).expect("the grid is allowed")
    }

    #[test]
    fn kernel_keeps_sum_and_moment_and_ends_at_one_and_a_half() {
        for s in [-0.5, -0.2, 0.0, 0.1, 0.25, 0.5] {
            let weights = weights(s);
            let moment = |power: i32| -> f64 {
                weights.iter().enumerate().map(|(k, w)| w * (k as f64 - 1.0 - s).powi(power)).sum()
            };
            assert!((moment(0) - 1.0).abs() < 1e-14 && moment(1).abs() < 1e-14, "{s}");
            let squares: f64 = weights.iter().map(|w| w * w).sum();
            assert!((squares - 0.5).abs() < 1e-14, "{s}: {squares}");
        }
        assert!(weights(-0.5)[2].abs() < 1e-14 && weights(0.5)[0].abs() < 1e-14);
    }

    #[test]
    fn nearest_is_nearest_on_both_sides_of_zero() {
        for k in -3000..3000 {
            let s = f64::from(k) * 0.01 + 0.003;
            assert_eq!(nearest(s), s.round() as isize, "{s}");
        }
    }

    /// A stream through open faces is read as it is, up to them; what is beyond reads nothing.
    #[test]
    fn a_uniform_stream_is_read_exactly_at_open_faces() {
        let inflow = Boundary::Inflow { velocity: [0.7, 0.0], profile: Profile::Uniform };
        let grid = grid([[inflow, Boundary::Outflow], [Boundary::FreeSlip; 2]]);
        for (d, stream) in [(0, 0.7), (1, 0.0)] {
            let mut u = grid.new_field();
            set_component(&grid, d, &mut u, |_| stream);
            assert!([-0.06, 1.24].iter().all(|x| Stencil::new(&grid, d, [*x, 0.37]).is_out()));
            for x in [0.0, 0.03, 0.11, 0.6, 1.08, 1.17, 1.2] {
                let read = Stencil::new(&grid, d, [x, 0.37]).interpolate(&u);
                assert!((read - stream).abs() < 1e-14, "{d} {x}: {read}");
            }
        }
    }

    /// What a point reads of a shear between walls that move is the shear, up to the walls.
    #[test]
    fn a_linear_flow_is_read_exactly_beside_walls() {
        let wall = |speed: f64| Boundary::NoSlip { velocity: [speed, 0.0] };
        let grid = grid([[Boundary::Periodic; 2], [wall(0.0), wall(0.8)]]);
        let mut u = grid.new_field();
        set_component(&grid, 0, &mut u, |x| x[1]);
        for z in [0.01, 0.06, 0.33, 0.74, 0.79] {
            let stencil = Stencil::new(&grid, 0, [1.17, z]);
            assert!((stencil.interpolate(&u) - z).abs() < 1e-14, "{z}");
            let mut spread = grid.new_field();
            stencil.spread(2.0, &mut spread);
            let sum: f64 = spread.iter().sum();
            assert!(
                sum <= 2.0 + 1e-12 && (!(0.15..0.65).contains(&z) || (sum - 2.0).abs() < 1e-12),
                "{z}: {sum}"
            );
        }
    }
}
