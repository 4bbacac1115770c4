//! Impulse on the walls of the box of the pressure that answers a jump, by its mean over planes.
//!
//! Where Λ is projected to δu = Λ − ∇φ, the mean of φ over a plane across an axis rises from cell to cell by
//! the distance times the mean of Λ − δu over the faces between them. Its level is as free as that of the
//! pressure: zero in the mean over the box.

use crate::field::for_each_own_unknown;
use crate::grid::Grid;

/// The impulse on each wall.
#[derive(Clone, Debug)]
pub(super) struct WallImpulse<const D: usize> {
    /// Along each axis that does not go on periodically: sums of Λ − δu and of weights over the faces of each
    /// plane.
    planes: [Vec<[f64; 2]>; D],
    /// By axis and side, out of the box: ∫ φ dA, m⁴/s (plane: m³/s).
    pub(super) on_walls: [[f64; 2]; D],
}

impl<const D: usize> WallImpulse<D> {
    pub(super) fn new(grid: &Grid<D>) -> Self {
        let planes = |a: usize| if grid.periodic(a) { 0 } else { grid.cells[a] + 1 };
        Self { planes: std::array::from_fn(|a| vec![[0.0; 2]; planes(a)]), on_walls: [[0.0; 2]; D] }
    }

    pub(super) fn clear(&mut self) {
        self.planes.iter_mut().for_each(|planes| planes.fill([0.0; 2]));
        self.on_walls = [[0.0; 2]; D];
    }

    /// Adds `sign` times the flow: Λ with 1, δu with −1.
    pub(super) fn add(&mut self, grid: &Grid<D>, sign: f64, flow: &[Vec<f64>; D]) {
        for (d, (planes, flow)) in self.planes.iter_mut().zip(flow).enumerate() {
            if planes.is_empty() {
                continue;
            }
            grid.division.ranks().relay(planes.as_flattened_mut(), |sums| {
                for_each_own_unknown(grid, d, |at, index| {
                    let volume = grid.control_volume(d, at);
                    sums[2 * at[d]] += sign * flow[index] * volume;
                    sums[2 * at[d] + 1] += volume;
                });
            });
        }
    }

    /// Finds the impulse on the walls once Λ and δu were added.
    pub(super) fn find(&mut self, grid: &Grid<D>) {
        for (d, planes) in self.planes.iter().enumerate().filter(|(_, planes)| !planes.is_empty()) {
            let axis = &grid.axes[d];
            // Λ and δu both brought the weight.
            let rise = |k: usize| axis.distances[k] * 2.0 * planes[k][0] / planes[k][1];
            let (mut potential, mut content, mut whole) = (0.0, 0.0, 0.0);
            for (k, volume) in axis.cell_volume.iter().enumerate() {
                potential += if k > 0 { rise(k) } else { 0.0 };
                content += potential * volume;
                whole += volume;
            }
            let level = content / whole;
            let rest: f64 =
                (0..D).filter(|a| *a != d).map(|a| grid.axes[a].cell_volume.iter().sum::<f64>()).product();
            let area = |cell: usize| grid.turn() * rest * axis.cell_volume[cell] / axis.widths[cell];
            self.on_walls[d] = [level * area(0), (potential - level) * area(grid.cells[d] - 1)];
        }
    }
}
