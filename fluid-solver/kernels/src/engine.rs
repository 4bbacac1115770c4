//! What the time step asks of a geometry.

use crate::flow::Flow;
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
