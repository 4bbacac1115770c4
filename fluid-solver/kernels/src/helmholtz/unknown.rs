//! What a direct solver solves for.

use super::block_columns::BlockColumns;
use crate::grid::Grid;
use crate::stencil::Stencil;
use crate::transform::{Kind, Scratch, Transform};
use crate::tridiagonal::Sweep;

/// How the last axis of a separable solve is treated.
pub(super) enum LastAxis {
    /// Tridiagonal sweep: stretched, radial or walled axis.
    Sweep(Sweep),
    /// Transform, division by the eigenvalue, transform back; with the width squared, m².
    Transform(Box<Transform>, f64),
}

impl LastAxis {
    /// With `before` idle unknowns in front, see [`Sweep::padded`]; a transform needs none.
    pub(super) fn padded(self, before: usize) -> Self {
        match self {
            Self::Sweep(sweep) => Self::Sweep(sweep.padded(before)),
            other => other,
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Sweep(sweep) => sweep.len(),
            Self::Transform(transform, _) => transform.values(),
        }
    }

    /// Working memory for the transform, if there is one.
    pub(super) fn scratch(&self) -> Scratch {
        match self {
            Self::Sweep(_) => Scratch::default(),
            Self::Transform(transform, _) => transform.scratch(),
        }
    }
}

/// What is solved for: it decides positions and wall conditions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Velocity component on its faces, homogeneous wall conditions.
    Component(usize),
    /// Pressure at the centres, zero slope at walls.
    Pressure,
}

impl Unknown {
    /// Boundary type and staggering along `axis`.
    pub(super) fn kind<const D: usize>(self, grid: &Grid<D>, axis: usize) -> Kind {
        match self {
            Self::Component(d) => Kind::of_component(grid, d, axis),
            Self::Pressure if grid.periodic(axis) => Kind::Periodic,
            Self::Pressure => Kind::EvenEven,
        }
    }

    /// Index of the first unknown along `axis`.
    pub(super) fn first<const D: usize>(self, grid: &Grid<D>, axis: usize) -> usize {
        usize::from(self.kind(grid, axis) == Kind::Fixed)
    }

    /// Tridiagonal operator along `axis`, walls folded in; on a periodic axis the first and the last unknown
    /// are neighbours.
    pub(super) fn sweep<const D: usize>(self, grid: &Grid<D>, axis: usize) -> Sweep {
        let own = self == Self::Component(axis);
        let stencil = if own { Stencil::staggered(grid, axis) } else { Stencil::centred(grid, axis) };
        let range = self.first(grid, axis)..grid.cells[axis];
        let mut sweep = Sweep {
            last: range.len() - 1,
            lower: stencil.lower[range.clone()].to_vec(),
            upper: stencil.upper[range.clone()].to_vec(),
            diagonal: range
                .clone()
                .map(|i| -stencil.lower[i] - stencil.upper[i] - stencil.extra[i])
                .collect(),
            volume: if own {
                grid.axes[axis].face_volume[range].to_vec()
            } else {
                grid.axes[axis].cell_volume[range].to_vec()
            },
        };
        let last = sweep.last;
        let (low, high) = match self.kind(grid, axis) {
            // The neighbour is the wall itself.
            Kind::Fixed => (0.0, 0.0),
            Kind::EvenEven => (1.0, 1.0),
            Kind::OddOdd => (-1.0, -1.0),
            Kind::EvenOdd => (1.0, -1.0),
            Kind::OddEven => (-1.0, 1.0),
            // The neighbour is at the other end of the axis: only a sweep in blocks knows how.
            Kind::Periodic => return sweep,
        };
        sweep.diagonal[0] += low * sweep.lower[0];
        sweep.diagonal[last] += high * sweep.upper[last];
        sweep.lower[0] = 0.0;
        sweep.upper[last] = 0.0;
        sweep
    }

    /// How the last axis of the solve, `axis`, is treated.
    pub(super) fn across<const D: usize>(self, grid: &Grid<D>, axis: usize) -> LastAxis {
        if grid.periodic(axis) && grid.division.cuts.is_empty() {
            let width = grid.axes[axis].length() / grid.cells[axis] as f64;
            let transform = Transform::new(self.kind(grid, axis), grid.cells[axis]);
            LastAxis::Transform(Box::new(transform), width * width)
        } else {
            LastAxis::Sweep(self.sweep(grid, axis))
        }
    }

    /// The blocks of the last axis, if the grid has any.
    pub(super) fn blocks<const D: usize>(self, grid: &Grid<D>) -> Option<BlockColumns> {
        let (axis, division) = (D - 1, &grid.division);
        let columns = || {
            BlockColumns::new(self.sweep(grid, axis), division, self.first(grid, axis), grid.periodic(axis))
        };
        (!division.cuts.is_empty()).then(columns)
    }

    /// Eigenvalues along a transformed axis, 1/m².
    pub(super) fn eigenvalues<const D: usize>(self, grid: &Grid<D>, axis: usize) -> Vec<f64> {
        let (kind, cells) = (self.kind(grid, axis), grid.cells[axis]);
        let width = grid.axes[axis].length() / cells as f64;
        (0..kind.values(cells)).map(|q| kind.eigenvalue(q, cells) / (width * width)).collect()
    }
}
