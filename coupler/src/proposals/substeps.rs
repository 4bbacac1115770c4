//! One sub-step where nothing can touch.

use protocol::scene::CheckedScene;

use super::Idea;
use super::change::Change;

/// `coupling.substeps = "full"` does sub-steps even where no contact can begin; `"auto"` leaves them out by a
/// rule that misses none (docs/decisions/one-substep-windows.md).
pub(super) fn idea(scene: &CheckedScene) -> Option<Idea> {
    let full = scene.scene.coupling.get("substeps").and_then(toml::Value::as_str) == Some("full");
    let coupled = scene.scene.medium.is_some() && scene.has_free_grains();
    (full && coupled).then(|| Idea {
        name: "one-sub-step",
        what: "one sub-step in windows in which nothing can touch",
        change: Change::default().set("coupling.substeps", "auto"),
        error: 0.0,
        why: "no contact is missed: docs/decisions/one-substep-windows.md".into(),
    })
}
