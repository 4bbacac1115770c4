//! One sub-step where nothing can touch.

use super::Idea;
use super::change::Change;
use crate::prepare::Prepared;

/// `coupling.substeps = "full"` does sub-steps even where no contact can begin; `"auto"` leaves them out by a
/// rule that misses none (docs/decisions/one-substep-windows.md).
pub(super) fn idea(prepared: &Prepared) -> Option<Idea> {
    let full = prepared.coupling.substeps == crate::config::Substeps::Full;
    let (fluid, dem) = (&prepared.fluid.as_ref()?.facts, &prepared.dem.as_ref()?.facts);
    let window = |substeps: f64| fluid.step_cost + substeps * dem.substep_cost;
    full.then(|| Idea {
        name: "one-sub-step",
        what: "one sub-step in windows in which nothing can touch",
        change: Change::default().set("coupling.substeps", "auto"),
        error: 0.0,
        // Where nothing touches at all: the plan does not know how often that is.
        saving: Some(window(prepared.plan.steps.substeps as f64) / window(1.0)),
        why: "no contact is missed: docs/decisions/one-substep-windows.md".into(),
    })
}
