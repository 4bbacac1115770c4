//! How the fluid imposes the motion of the grains, for a DEM whose films are what that does not resolve.

use serde::Deserialize;

use crate::error::SceneError;
use crate::source::SceneSource;
use protocol::facts::Forcing;

/// The only key of the fluid's section that others read.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Sections {
    fluid: Fluid,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Fluid {
    immersed: Immersed,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Immersed {
    method: Forcing,
}

/// `fluid.immersed.method` of a scene.
///
/// # Errors
/// [`SceneError`] if it names no method.
pub fn forcing(source: &SceneSource) -> Result<Forcing, SceneError> {
    Ok(source.section::<Sections>()?.fluid.immersed.method)
}
