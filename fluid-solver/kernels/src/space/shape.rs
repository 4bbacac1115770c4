//! What the step in space knows of a grid: plain numbers.

use crate::boundary::Boundary;
use crate::ghosts::Ghosts;
use crate::grid::Grid;
use std::ops::Range;

/// A grid of three axes, equal cells along the first two. A plane holds the rows −1 to `n[1]`.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Cells along each axis.
    pub(crate) n: [usize; 3],
    /// Planes that this process works on.
    pub(crate) own: Range<usize>,
    /// What brings the planes beside them.
    pub(crate) ghosts: Ghosts,
    /// Values from row to row.
    pub(crate) row: usize,
    /// Values from plane to plane.
    pub(crate) plane: usize,
    /// Values before plane −1.
    lead: usize,
    /// Length of the loops over the `n[0] + 1` edges of a row, in whole vectors.
    pub(crate) wide: usize,
    /// What holds on the faces of each axis.
    pub(crate) walls: [[Boundary<3>; 2]; 3],
    /// Whether fluid passes through a face: then halos and faces are filled between the sweeps.
    pub(crate) open: bool,
    /// 1/Δx, 1/Δy, 1/m.
    pub(crate) inverse: [f64; 2],
    /// 1/Δz of each cell, 1/m.
    pub(crate) cell: Vec<f64>,
    /// 1/height of the control volume of w on each face, 1/m, `n + 1`.
    pub(crate) face: Vec<f64>,
    /// 1/distance of the centres beside each face, 1/m, `n + 1`.
    pub(crate) slope: Vec<f64>,
    /// Weights of the cells below and above in the mass flux through the sides of the control
    /// volume of w on each face, `n + 1`; their sum is 1 (½ at a wall, where nothing is unknown).
    pub(crate) cell_weights: Vec<[f64; 2]>,
}

impl Shape {
    /// Of a grid of three axes.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>) -> Self {
        debug_assert!(D == 3, "a shape has three axes");
        let z = &grid.axes[D - 1];
        let n: [usize; 3] = std::array::from_fn(|a| grid.cells[a]);
        let mut origin = [-1; D];
        origin[0] = 0;
        let width =
            |k: usize| if grid.periodic(D - 1) { z.widths[k % n[2]] } else { z.widths[k.min(n[2] - 1)] };
        let below = |k: usize| {
            if k > 0 { width(k - 1) } else { width(if grid.periodic(D - 1) { n[2] - 1 } else { 0 }) }
        };
        Self {
            n,
            own: grid.division.own(),
            ghosts: Ghosts::new(grid),
            row: grid.stride(1),
            plane: grid.stride(D - 1),
            lead: grid.index(origin),
            wide: (n[0] + 1).next_multiple_of(8),
            walls: walls(grid),
            open: grid.is_open(),
            inverse: std::array::from_fn(|a| n[a] as f64 / grid.axes[a].length()),
            cell: z.widths.iter().map(|h| 1.0 / h).collect(),
            face: z.face_volume.iter().map(|h| 1.0 / h).collect(),
            slope: z.distances.iter().map(|h| 1.0 / h).collect(),
            cell_weights: (0..=n[2])
                .map(|k| [below(k), width(k)].map(|h| 0.5 * h / z.face_volume[k]))
                .collect(),
        }
    }

    /// Takes over the walls of `grid`: they may have been set in motion.
    pub(crate) fn refresh<const D: usize>(&mut self, grid: &Grid<D>) {
        self.walls = walls(grid);
    }

    /// Whether the field goes on at the other end of `axis`.
    pub(crate) fn periodic(&self, axis: usize) -> bool {
        self.walls[axis][0].is_periodic()
    }

    /// Place of the first value of row `j`, from −1 to `n`, in its plane.
    #[inline(always)]
    pub(crate) fn at(&self, j: isize) -> usize {
        (j + 1) as usize * self.row
    }

    /// Where the interior planes `from..to` lie in a field; −1 and `n` are the ghost planes.
    pub(crate) fn planes(&self, from: isize, to: isize) -> Range<usize> {
        let at = |k: isize| self.lead + (k + 1) as usize * self.plane;
        at(from)..at(to)
    }
}

fn walls<const D: usize>(grid: &Grid<D>) -> [[Boundary<3>; 2]; 3] {
    std::array::from_fn(|a| {
        grid.boundaries[a].map(|face| match face {
            Boundary::Periodic => Boundary::Periodic,
            Boundary::NoSlip { velocity } => {
                Boundary::NoSlip { velocity: std::array::from_fn(|d| velocity[d]) }
            }
            // Their velocity is not asked for here, see `open`.
            Boundary::Inflow { .. } | Boundary::Outflow => Boundary::WALL,
            Boundary::FreeSlip | Boundary::Axis => Boundary::FreeSlip,
        })
    })
}
