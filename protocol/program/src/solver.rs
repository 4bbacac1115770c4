//! What a solver adds to the contract to become a program.

use std::collections::BTreeMap;
use std::path::Path;

use bedload_output::{MetricValue, OutputFolder};
use bedload_scene::{CheckedScene, SceneError};
use protocol::facts::{DemFacts, FluidFacts};
use protocol::log::Logged;
use protocol::participant::{Participant, SolverError};

use crate::clock::Clock;
use crate::stand_in::Answer;

/// What a solver adds to [`Participant`] to become a program.
pub trait Solver: Participant<Incoming: Logged, Outgoing: Logged> + Send + Sized {
    /// Name of the executable.
    const PROGRAM: &'static str;
    /// What it is, for `--help`.
    const ABOUT: &'static str;
    /// What it tells the coupler before a run.
    type Facts: serde::Serialize + Send + Sync;

    /// Facts of a scene, without building the solver.
    ///
    /// # Errors
    /// [`SceneError`] if its section is wrong.
    fn facts(scene: &CheckedScene) -> Result<Self::Facts, SceneError>;

    /// The solver at time zero; files of its own go below `out`.
    ///
    /// # Errors
    /// [`SceneError`] if the scene does not make a solver.
    fn build(scene: &CheckedScene, out: &Path) -> Result<Self, SceneError>;

    /// JSON Schema of its section of the scene.
    fn schema() -> serde_json::Value;

    /// What stands in for the absent peer when it runs alone.
    ///
    /// # Errors
    /// [`SceneError`] if the scene needs the peer.
    fn stand_in(scene: &CheckedScene) -> Result<Answer<Self::Incoming>, SceneError>;

    /// Windows and sub-steps when it runs alone.
    fn clock(scene: &CheckedScene, facts: &Self::Facts) -> Clock;

    /// What it writes and measures at the end of a run alone that went well: files into `folder`,
    /// values of the metrics that only it can measure.
    ///
    /// # Errors
    /// [`SolverError`] if a file cannot be written.
    fn finish(
        &mut self,
        _scene: &CheckedScene,
        _folder: &OutputFolder,
    ) -> Result<BTreeMap<String, MetricValue>, SolverError> {
        Ok(BTreeMap::new())
    }

    /// Values of the columns that only it knows, in a run alone ([`bedload_output::energy_columns`]).
    fn scalars(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Largest speed of a fluid after the last window, m/s.
    fn speed(&self) -> Option<f64> {
        None
    }

    /// The facts under the role they belong to.
    fn facts_by_role(facts: &Self::Facts) -> (Option<&FluidFacts>, Option<&DemFacts>);
}
