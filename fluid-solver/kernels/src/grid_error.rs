//! Why a grid is impossible.

use crate::geometry::Geometry;
use thiserror::Error;

/// Why a grid is impossible.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// Geometry and number of axes disagree.
    #[error("{geometry:?} geometry has {needed} axes, but the grid was given {given}")]
    Axes {
        /// The geometry asked for.
        geometry: Geometry,
        /// Axes it has.
        needed: usize,
        /// Axes given.
        given: usize,
    },
    /// Too few cells.
    #[error("axis {axis} has {cells} cells: at least 2 are needed")]
    TooFewCells {
        /// Axis number.
        axis: usize,
        /// Cells given.
        cells: usize,
    },
    /// Faces out of order.
    #[error("axis {axis}: face {face} at {at} is followed by a face at {next}: positions must increase")]
    NotIncreasing {
        /// Axis number.
        axis: usize,
        /// Number of the offending face.
        face: usize,
        /// Its position, m.
        at: f64,
        /// Position of the next one, m.
        next: f64,
    },
    /// A position is infinite or not a number.
    #[error("axis {axis} has a face at {at}: every position must be a finite number")]
    NotFinite {
        /// Axis number.
        axis: usize,
        /// The position, m.
        at: f64,
    },
    /// A radial axis starts below zero.
    #[error("the radial axis starts at r = {start}: it must start at r = 0 or above")]
    NegativeRadius {
        /// Lowest position, m.
        start: f64,
    },
    /// The equal part of a growing axis does not hold a whole number of cells, or too many.
    #[error(
        "axis {axis}: the uniform part, {core} long, must hold a whole number of cells of width \
         {width}, at least one and fewer than the {cells} cells of the axis"
    )]
    Core {
        /// Axis number.
        axis: usize,
        /// Length of the equal part, m.
        core: f64,
        /// Width of its cells, m.
        width: f64,
        /// Cells of the whole axis.
        cells: usize,
    },
    /// A growing axis would have to shrink.
    #[error(
        "axis {axis}: {cells} cells are too many for widths that grow outwards: give at most {most}, \
         or a smaller uniform width"
    )]
    Shrinking {
        /// Axis number.
        axis: usize,
        /// Cells asked for.
        cells: usize,
        /// Most cells that fit.
        most: usize,
    },
    /// More than one axis has unequal cells or a metric.
    #[error(
        "axes {first} and {second} are both stretched or radial: the direct solver allows one; make the other uniform"
    )]
    TwoStretched {
        /// First such axis.
        first: usize,
        /// Second such axis.
        second: usize,
    },
    /// In space the swept axis must be the last one.
    #[error("axis {axis} is stretched: in space only the last axis (z) may be; rename the axes of the scene")]
    StretchedSpace {
        /// Axis number.
        axis: usize,
    },
    /// Only one face of an axis is periodic.
    #[error("axis {axis} is periodic on one face only: make both faces periodic, or neither")]
    HalfPeriodic {
        /// Axis number.
        axis: usize,
    },
    /// A periodic axis must be uniform and not radial.
    #[error("axis {axis} is periodic: its cells must be equal and it cannot be radial")]
    PeriodicStretched {
        /// Axis number.
        axis: usize,
    },
    /// The axis of symmetry stands in the wrong place.
    #[error(
        "face {side} of axis {axis}: the axis of symmetry belongs on the lower face of axis 0 of an \
         axisymmetric grid that starts at r = 0, and nothing else can stand there"
    )]
    MisplacedAxis {
        /// Axis number.
        axis: usize,
        /// 0 lower, 1 upper.
        side: usize,
    },
    /// Fluid passes through a face where it cannot.
    #[error("face {side} of axis {axis} is radial: fluid enters and leaves along z only")]
    RadialFlow {
        /// Axis number.
        axis: usize,
        /// 0 lower, 1 upper.
        side: usize,
    },
    /// A wall moves along its normal.
    #[error(
        "the wall on face {side} of axis {axis} has the normal velocity {velocity}: walls move in \
         their own plane only, set it to 0"
    )]
    NormalVelocity {
        /// Axis number.
        axis: usize,
        /// 0 lower, 1 upper.
        side: usize,
        /// The velocity, m/s.
        velocity: f64,
    },
}
