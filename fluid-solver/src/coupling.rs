//! What the fluid needs to know of `[coupling]`: the order of the exchange, and how long to wait. The coupler
//! owns the section, and refuses an order that the method cannot follow.

use crate::methods::method::Method;
use bedload_scene::{CheckedScene, SceneError};
use protocol::scheme::{Iterations, Scheme, SchemeKey};
use serde::Deserialize;
use std::time::Duration;

#[derive(Deserialize)]
struct Document {
    #[serde(default)]
    coupling: Section,
}

/// The keys that are read here; the others are the coupler's.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Section {
    scheme: SchemeKey,
    iterations: Iterations,
    deadline: Option<f64>,
}

/// `coupling.deadline` where a scene does not say it, s; the coupler's own.
const DEADLINE: f64 = 10.0;

/// Longest time for a solver to answer within a window, `coupling.deadline`.
///
/// # Errors
/// [`SceneError`] with the place of a wrong type, or of what is no time.
pub fn deadline(scene: &CheckedScene) -> Result<Duration, SceneError> {
    let seconds = scene.source.section::<Document>()?.coupling.deadline.unwrap_or(DEADLINE);
    Duration::try_from_secs_f64(seconds).ok().filter(|deadline| !deadline.is_zero()).ok_or_else(|| {
        scene.source.error(
            "coupling.deadline",
            format!("is {seconds} s"),
            "give a positive number of seconds",
        )
    })
}

/// The order of the exchange for a method, and which windows are repeated. `auto` that no coupler has
/// settled, and an order that the method cannot follow, are the method's own.
///
/// # Errors
/// [`SceneError`] with the place of a wrong type.
pub fn read(scene: &CheckedScene, method: Method) -> Result<(Scheme, Iterations), SceneError> {
    let Section { scheme, iterations, .. } = scene.source.section::<Document>()?.coupling;
    let named = scheme.named().filter(|scheme| method.schemes().contains(scheme));
    Ok((named.unwrap_or(method.schemes()[0]), iterations))
}
