//! How many sub-steps a DEM is ordered in a window of a log, where `--set` gives it another sub-step.

use std::path::Path;
use std::time::Duration;

use bedload_scene::CheckedScene;
use protocol::message::Command;
use protocol::participant::Role;

use crate::config::Coupling;
use crate::failure::Failure;
use crate::plan::{Participants, substep_target, substeps};
use crate::solvers::{Ask, Solver, dem_facts, fluid_facts};

/// The sub-step that the run aimed at, and the one now, s; none where it is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Substeps {
    pub(super) logged: Option<f64>,
    pub(super) now: Option<f64>,
}

impl Substeps {
    /// The order of a window: as logged where the sub-step is the same, or where the run did one sub-step
    /// because nothing could touch.
    pub(super) fn order(&self, mut command: Command) -> Command {
        let Some(now) = self.now.filter(|_| self.now != self.logged) else { return command };
        let flies = self.logged.is_none_or(|logged| substeps(command.dt, logged) > 1);
        if !(command.substeps <= 1 && flies) {
            command.substeps = substeps(command.dt, now);
        }
        command
    }
}

/// The sub-step that a scene asks for: of our DEM what it says, of another one `dem.dt`.
pub(super) fn aimed_at(
    solver: &Solver,
    scene: &CheckedScene,
    coupling: &Coupling,
    path: &Path,
) -> Result<Option<f64>, Failure> {
    if !solver.is_ours() {
        let dt = scene.scene.dem.get("dt");
        return Ok(dt.and_then(|dt| dt.as_float()).filter(|dt| *dt > 0.0));
    }
    let ask = Ask { limit: Duration::from_secs_f64(coupling.startup_deadline), commands: true };
    if solver.role == Role::Fluid {
        fluid_facts(solver, scene, path, &[], ask)?;
        return Ok(None);
    }
    let facts = dem_facts(solver, scene, path, &[], ask)?;
    let aim = substep_target(Participants::of(scene), coupling, Some(&facts));
    Ok(Some(aim).filter(|aim| aim.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_sub_step_changes_the_windows_that_had_many() {
        let window = |substeps| Command { dt: 0.01, substeps, ..Command::default() };
        let same = Substeps { logged: Some(1e-3), now: Some(1e-3) };
        assert_eq!(same.order(window(7)).substeps, 7);
        let finer = Substeps { logged: Some(1e-3), now: Some(5e-4) };
        assert_eq!(finer.order(window(10)).substeps, 20);
        assert_eq!(finer.order(window(1)).substeps, 1, "free flight stays one sub-step");
        let coarse = Substeps { logged: Some(0.1), now: Some(5e-3) };
        assert_eq!(coarse.order(window(1)).substeps, 2, "one was all that the window needed");
        assert_eq!(Substeps::default().order(window(10)).substeps, 10);
    }
}
