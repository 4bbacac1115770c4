//! What the fluid needs to know of `[coupling]`: the order of the exchange. The coupler owns the section, and
//! refuses a scheme that the form of the loads cannot follow.

use protocol::facts::LoadsForm;
use protocol::scene::{CheckedScene, SceneError};
use protocol::scheme::{Iterations, Scheme, SchemeKey};
use serde::Deserialize;

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
}

/// The order of the exchange for loads of `form`, and how attempts are relaxed. `auto` that no coupler has
/// settled, and a scheme that the form cannot follow, are the order of the form itself.
///
/// # Errors
/// [`SceneError`] with the place of a wrong type.
pub fn read(scene: &CheckedScene, form: LoadsForm) -> Result<(Scheme, Iterations), SceneError> {
    let Section { scheme, iterations } = scene.source.section::<Document>()?.coupling;
    let named = scheme.named().filter(|scheme| scheme.forms().contains(&form));
    Ok((named.unwrap_or(Scheme::of(form)), iterations))
}
