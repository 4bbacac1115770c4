//! Real-to-real transforms that diagonalise the second difference on equal cells.
//!
//! Which one follows from the boundary type and the staggering (Schumann & Sweet 1988): see
//! [`Kind`]. Eight lines are transformed at once. `inverse(forward(x)) = x / scale`; the caller
//! folds `scale` into the division by the eigenvalues.

mod butterfly;
mod cosine;
mod ends;
mod fast;
mod fft;
mod four;
mod fourier;
mod line;
mod reference;
mod rows;
mod sine;
mod vector;

use crate::grid::Grid;
use crate::lanes::Lanes;
use fast::Fast;
use reference::Reference;
pub use rows::{Rows, RowsMut, Write};
use std::f64::consts::PI;

/// Boundary type and staggering of one line of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Periodic, `n` values: real Fourier transform, cosine amplitudes of wave number k at place k,
    /// sine amplitudes at place n − k.
    Periodic,
    /// Cell centres, zero slope at both ends, `n` values: cosine transform II.
    EvenEven,
    /// Cell centres, zero value at both ends, `n` values: sine transform II.
    OddOdd,
    /// Cell centres, zero slope below and zero value above: cosine transform IV.
    EvenOdd,
    /// Cell centres, zero value below and zero slope above: sine transform IV.
    OddEven,
    /// Faces between two walls, zero on both, `n − 1` values: sine transform I.
    Fixed,
}

impl Kind {
    /// Kind of velocity component `d` along `axis`.
    pub fn of_component<const D: usize>(grid: &Grid<D>, d: usize, axis: usize) -> Self {
        let [low, high] = grid.boundaries[axis];
        match (low.is_periodic(), d == axis, low.is_odd(), high.is_odd()) {
            (true, ..) => Self::Periodic,
            (_, true, ..) => Self::Fixed,
            (_, _, false, false) => Self::EvenEven,
            (_, _, true, true) => Self::OddOdd,
            (_, _, false, true) => Self::EvenOdd,
            (_, _, true, false) => Self::OddEven,
        }
    }

    /// Kind of pressure along `axis`.
    pub fn of_pressure<const D: usize>(grid: &Grid<D>, axis: usize) -> Self {
        if grid.periodic(axis) { Self::Periodic } else { Self::EvenEven }
    }

    /// Number of values on an axis of `cells` cells.
    pub fn values(self, cells: usize) -> usize {
        cells - usize::from(self == Self::Fixed)
    }

    /// Eigenvalue of the second difference (unit width) that belongs to place `q` of the transform.
    pub fn eigenvalue(self, q: usize, cells: usize) -> f64 {
        let n = cells as f64;
        let angle = match self {
            Self::Periodic => 2.0 * PI * q.min(cells - q) as f64 / n,
            Self::EvenEven => PI * q as f64 / n,
            Self::OddOdd | Self::Fixed => PI * (q + 1) as f64 / n,
            Self::EvenOdd | Self::OddEven => PI * (q as f64 + 0.5) / n,
        };
        -4.0 * (0.5 * angle).sin().powi(2)
    }

    /// What `inverse(forward(x))` must be multiplied by to give `x`.
    pub fn scale(self, cells: usize) -> f64 {
        if self == Self::Periodic { 1.0 / cells as f64 } else { 2.0 / cells as f64 }
    }
}

/// Working memory of one thread for [`Transform`].
#[derive(Debug, Default)]
pub struct Scratch {
    reference: reference::Scratch,
    fast: Vec<Lanes>,
}

/// Which way a transform goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Values to amplitudes.
    Forward,
    /// Amplitudes to values, times 1/scale.
    Inverse,
}

/// Who does the work.
enum Engine {
    /// Lengths 2ᵃ 3ᵇ 5ᶜ from 8 on, even or periodic.
    Fast(Fast),
    /// Any other length.
    Reference(Reference),
}

/// Whether an axis of `cells` cells has fast transforms: without prime factors above 5, even but where it is
/// `periodic`, not tiny. Any other length is taken by a library, line by line.
pub fn is_fast(cells: usize, periodic: bool) -> bool {
    Fast::places(cells, periodic).is_some()
}

/// The nearest lengths below (0: there is none) and above `cells` that are fast.
pub fn fast_lengths(cells: usize, periodic: bool) -> [usize; 2] {
    let below = (1..cells).rev().find(|n| is_fast(*n, periodic)).unwrap_or(0);
    // Ends at a power of two at the latest.
    let above = (cells + 1..).find(|n| is_fast(*n, periodic)).unwrap_or(cells);
    [below, above]
}

/// A transform of eight lines at once.
pub struct Transform {
    kind: Kind,
    cells: usize,
    engine: Engine,
}

impl Transform {
    /// Plans a transform along an axis of `cells` cells.
    pub fn new(kind: Kind, cells: usize) -> Self {
        let engine = match Fast::new(kind, cells) {
            Some(fast) => Engine::Fast(fast),
            None => Engine::Reference(Reference::new(kind, cells)),
        };
        Self { kind, cells, engine }
    }

    /// Plans a transform by `rustdct` and `realfft` whatever the length: for comparison.
    pub fn reference(kind: Kind, cells: usize) -> Self {
        Self { kind, cells, engine: Engine::Reference(Reference::new(kind, cells)) }
    }

    /// Boundary type and staggering.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Number of cells of the axis.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Number of values of a line.
    pub fn values(&self) -> usize {
        self.kind.values(self.cells)
    }

    /// Working memory for this transform.
    pub fn scratch(&self) -> Scratch {
        match &self.engine {
            Engine::Fast(fast) => Scratch { fast: fast.scratch(), ..Scratch::default() },
            Engine::Reference(engine) => Scratch { reference: engine.scratch(), ..Scratch::default() },
        }
    }

    /// Values to amplitudes, in place; `data` has [`Transform::values`] entries.
    pub fn forward(&self, data: &mut [Lanes], scratch: &mut Scratch) {
        self.load(Direction::Forward, Rows::of(data), scratch);
        self.store(Direction::Forward, RowsMut::of(data), scratch);
    }

    /// Amplitudes to values (times 1/scale), in place.
    pub fn inverse(&self, data: &mut [Lanes], scratch: &mut Scratch) {
        self.load(Direction::Inverse, Rows::of(data), scratch);
        self.store(Direction::Inverse, RowsMut::of(data), scratch);
    }

    /// First half of a transform: takes the lines from [`Transform::values`] rows.
    pub fn load(&self, direction: Direction, rows: Rows<'_>, scratch: &mut Scratch) {
        let inverse = direction == Direction::Inverse;
        match &self.engine {
            Engine::Fast(fast) => fast.load(inverse, rows, &mut scratch.fast),
            Engine::Reference(engine) => engine.load(inverse, rows, &mut scratch.reference),
        }
    }

    /// Second half: writes the result of [`Transform::load`] (same direction, same scratch).
    pub fn store(&self, direction: Direction, rows: RowsMut<'_>, scratch: &mut Scratch) {
        match &self.engine {
            Engine::Fast(fast) => fast.store(direction == Direction::Inverse, rows, &mut scratch.fast),
            Engine::Reference(engine) => engine.store(rows, &mut scratch.reference),
        }
    }
}
