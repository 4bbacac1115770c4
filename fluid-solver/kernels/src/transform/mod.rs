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
mod kind;
mod line;
mod plan;
mod reference;
mod rows;
mod sine;

use crate::lanes::Lanes;
use fast::Fast;
pub use kind::Kind;
use plan::Plan;
use reference::Reference;
pub use rows::{Rows, RowsMut, Write};

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
    Plan::places(cells, periodic).is_some()
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
    pub(crate) kind: Kind,
    pub(crate) cells: usize,
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
