//! The engine for a grid.

use crate::engine::Engine;
use crate::grid::Grid;
use crate::plane::PlaneEngine;
use crate::scheme::Options;
use crate::space::SpaceEngine;

/// A grid that the step is written for. Concrete for two and for three axes, so that engines are compiled in
/// this crate.
pub trait HasEngine<const D: usize> {
    /// The engine for this grid.
    fn engine(&self, options: &Options<D>) -> Box<dyn Engine<D>>;
}

impl HasEngine<2> for Grid<2> {
    fn engine(&self, _: &Options<2>) -> Box<dyn Engine<2>> {
        Box::new(PlaneEngine::new(self))
    }
}

impl HasEngine<3> for Grid<3> {
    fn engine(&self, options: &Options<3>) -> Box<dyn Engine<3>> {
        Box::new(SpaceEngine::new(self, options))
    }
}
