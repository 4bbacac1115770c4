//! D/Δx of a scene.

use bedload_scene::CheckedScene;

/// Cells over the diameter (least width) of the thinnest grain, where they are widest; none without a grid or
/// without grains.
#[must_use]
pub fn of(scene: &CheckedScene) -> Option<f64> {
    let domain = &scene.scene.domain;
    let smallest = scene.grains.iter().map(|grain| grain.thickness()).reduce(f64::min);
    let diameter = smallest.filter(|_| !domain.cells.is_empty())?;
    let spacing = (0..domain.dimensions()).map(|axis| domain.spacing(axis)).fold(0.0, f64::max);
    Some(diameter / spacing)
}
