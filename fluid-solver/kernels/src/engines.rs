//! What the time step asks of a geometry, and the engine for a grid.

use crate::flow::Flow;
use crate::grid::Grid;
use crate::plane::PlaneEngine;
use crate::scheme::Options;
use crate::space::SpaceEngine;
use crate::stages::{PlannedStage, PressureUpdate};

/// The four parts of a stage on one kind of grid, each for the whole field.
///
/// There are two, for two axes and for space; `docs/decisions/two-fluid-engines.md` says why.
pub trait Engine<const D: usize>: Send + Sync {
    /// Whether the engine fills halos as it goes, and can do parts of neighbouring stages in one sweep.
    fn fuses(&self) -> bool;

    /// u* but for implicit viscosity: the increment dt (γ N + ζ N_old) + 2 α dt (f − ∇p + ν ∇²u), which
    /// [`Engine::diffuse`] adds where it must be solved for. `force`: of the caller, m/s².
    fn predict(&mut self, flow: &mut Flow<D>, stage: &PlannedStage, force: Option<&[Vec<f64>; D]>);

    /// (1 − α ν dt ∇²) (u* − u) = increment, where viscosity is implicit.
    fn diffuse(&mut self, flow: &mut Flow<D>, stage: &PlannedStage);

    /// ∇²φ = ∇·u*/duration; `divergence_done`: in the sweep of predictor or viscosity. `false`, with the
    /// velocity as it was, if φ is not finite.
    fn project(&mut self, flow: &mut Flow<D>, update: PressureUpdate, divergence_done: bool) -> bool;

    /// u = u* − duration ∇φ and the pressure, halos included.
    fn correct(&mut self, flow: &mut Flow<D>, update: PressureUpdate);

    /// Makes the velocity divergence-free without touching the pressure. Halos are filled before.
    fn project_velocity(&mut self, flow: &mut Flow<D>);

    /// From now on the predictor has the pressure gradient even where the projection undoes it: the
    /// caller changes the velocity between the two, by what the velocity is.
    fn keep_pressure_gradient(&mut self, flow: &Flow<D>);
}

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
