//! Factors of the terms, from grid and viscosity.

use super::fluxes::Parts;
use super::planes::LEAD;
use crate::grid::{Geometry, Grid};

/// σ²/Δx² of the mask and of a cell, 1/12 each but for the mask of spheres.
pub(super) fn variance(geometry: Geometry) -> f64 {
    match geometry {
        Geometry::Plane => 1.0 / 6.0,
        Geometry::Axisymmetric | Geometry::Space => 0.162,
    }
}

/// Change of the velocity from cell to cell, times Δx/ν, at which the gradient stress is halved: its series
/// in the width of the kernel no longer holds there.
pub(super) const LIMIT: f64 = 40.0;

#[derive(Clone, Debug)]
pub(super) struct Factors<const D: usize> {
    /// Along each axis; entry `LEAD + i` belongs to index `i`, from −1 to two behind the last.
    pub(super) axes: [Lines; D],
    pub(super) half: Vec<f64>,
    pub(super) one: Vec<f64>,
    /// Least width of a cell, m.
    pub(super) width: f64,
    pub(super) parts: Parts,
}

/// Factors along one axis.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    /// 1 where the flux through the edge at a face has the terms, else 0: all its nodes lie in the box.
    pub(super) edge: Vec<f64>,
    /// The same of the flux through a centre.
    pub(super) centre: Vec<f64>,
    /// Area of the faces.
    pub(super) area: Vec<f64>,
    /// Half of it.
    pub(super) half_area: Vec<f64>,
    /// Area at the centres.
    pub(super) centre_area: Vec<f64>,
    /// Half the volume of the cells below and above a face over that of the face.
    pub(super) shares: [Vec<f64>; 2],
    /// 1 / volume of cells and of faces.
    pub(super) inverse_cell: Vec<f64>,
    pub(super) inverse_face: Vec<f64>,
}

impl Lines {
    fn new<const D: usize>(grid: &Grid<D>, a: usize, length: usize) -> Self {
        let (axis, n, periodic) = (&grid.axes[a], grid.cells[a] as isize, grid.periodic(a));
        let fill = |value: &dyn Fn(isize) -> f64| {
            let mut line = vec![0.0; length];
            (-1..=n + 1).for_each(|i| line[(LEAD as isize + i) as usize] = value(i));
            line
        };
        let cell = |i: isize| (if periodic { i.rem_euclid(n) } else { i.clamp(0, n - 1) }) as usize;
        let face = |i: isize| (if periodic { i.rem_euclid(n) } else { i.clamp(0, n) }) as usize;
        let inside = |low: isize, high: isize| f64::from(periodic || (low >= 0 && high < n));
        let share =
            |side: isize| fill(&|i| 0.5 * axis.cell_volume[cell(i + side)] / axis.face_volume[face(i)]);
        Self {
            edge: fill(&|i| inside(i - 2, i + 1)),
            // A node on a wall does not count: it may be one that fluid passes through.
            centre: fill(&|i| inside(i - 2, i + 2)),
            area: fill(&|i| axis.face_area[face(i)]),
            half_area: fill(&|i| 0.5 * axis.face_area[face(i)]),
            centre_area: fill(&|i| axis.centre_area[cell(i)]),
            shares: [share(-1), share(0)],
            inverse_cell: fill(&|i| axis.inverse_cell_volume[cell(i)]),
            inverse_face: fill(&|i| 1.0 / axis.face_volume[face(i)]),
        }
    }
}

impl<const D: usize> Factors<D> {
    /// For rows of `row` values.
    pub(super) fn new(grid: &Grid<D>, viscosity: f64, row: usize) -> Self {
        let length = |a: usize| if a == 0 { row } else { grid.cells[a] + LEAD + 2 };
        Self {
            axes: std::array::from_fn(|a| Lines::new(grid, a, length(a))),
            half: vec![0.5; row],
            one: vec![1.0; row],
            width: grid.smallest_width(),
            parts: Parts {
                stress: variance(grid.geometry),
                limit: (grid.smallest_width() / (LIMIT * viscosity)).powi(2),
            },
        }
    }
}
