//! What the Shields number of a bed needs.

use bedload_scene::{CheckedScene, Motion};

use super::subject::norm;
use crate::planes::Bed;

/// What the Shields number of the free grains needs.
pub(super) fn bed(scene: &CheckedScene) -> Bed {
    let free = || scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    let count = free().count().max(1) as f64;
    let medium = scene.scene.medium.as_ref();
    Bed {
        viscosity: medium.map_or(0.0, |medium| medium.viscosity),
        excess: free().map(|grain| grain.density).sum::<f64>() / count
            - medium.map_or(0.0, |medium| medium.density),
        gravity: norm(&scene.scene.gravity),
        diameter: free().map(|grain| 2.0 * grain.radius).sum::<f64>() / count,
    }
}
