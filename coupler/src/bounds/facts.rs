//! What the bounds are checked on.

use bedload_scene::CheckedScene;
use protocol::facts::{DemFacts, FluidFacts, Measure};
use protocol::scheme::Scheme;
use serde::Serialize;

use crate::config::Coupling;
use bedload_scene::speeds::Speeds;

/// The time steps of a plan, without which no bound can be checked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeSteps {
    /// Window: the fluid's step, or the DEM's where there is no fluid, s.
    pub dt_fluid: f64,
    /// Sub-step as it comes out: window over sub-steps, s.
    pub dt_dem: f64,
    /// Sub-steps in a full window.
    pub substeps: u64,
    /// Shortest contact duration, s; infinite where nothing can touch.
    pub contact_time: f64,
}

impl TimeSteps {
    /// What a solver's bound is proportional to.
    pub fn measure(&self, measure: Measure) -> f64 {
        match measure {
            Measure::One => 1.0,
            Measure::Window => self.dt_fluid,
            Measure::Substep => self.dt_dem,
            Measure::WindowOverContact => self.dt_fluid / self.contact_time,
        }
    }
}

/// What the bounds are checked on.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// Scene.
    pub scene: &'a CheckedScene,
    /// The fluid, where one takes part.
    pub fluid: Option<&'a FluidFacts>,
    /// The DEM, where one takes part.
    pub dem: Option<&'a DemFacts>,
    /// `[coupling]`.
    pub coupling: &'a Coupling,
    /// Order of the exchange; none where nothing is exchanged.
    pub scheme: Option<Scheme>,
    /// Time steps.
    pub steps: TimeSteps,
    /// Speeds that follow from the scene.
    pub(crate) speeds: Speeds,
    /// Memory that the machine can still give, bytes.
    pub memory: Option<u64>,
}
