//! A coarser grid and a longer step, where the chart of a class of scenes says that they do.

use super::change::Change;
use super::{Idea, WORTH};
use crate::accuracy;
use crate::number::Short;
use crate::prepare::Prepared;

/// What `accuracy` would take for the largest error that is worth proposing. A scene that asks for an
/// accuracy has it already.
pub(super) fn idea(prepared: &Prepared) -> Option<Idea> {
    prepared.scene.scene.medium.as_ref()?;
    let expected = accuracy::offered(&prepared.scene, WORTH)?;
    let why = format!(
        "as {}, run {} of {}, {} % there",
        expected.class,
        expected.label,
        expected.chart,
        Short(100.0 * expected.error)
    );
    let change = Change::default().overrides(expected.set);
    Some(Idea {
        name: "coarser",
        what: "grid and step of the chart",
        change,
        error: WORTH,
        saving: None,
        why,
    })
}
