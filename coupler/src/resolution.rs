//! D/Δx of a scene, and numbers of cells.

use bedload_scene::CheckedScene;

/// The least that is run: nothing was measured on coarser grids.
pub(crate) const LEAST: f64 = 5.0;

/// Cells over the diameter (least width) of the thinnest grain, where they are widest; none without a grid or
/// without grains.
pub fn of(scene: &CheckedScene) -> Option<f64> {
    let domain = &scene.scene.domain;
    let smallest = scene.grains.iter().map(|grain| grain.thickness()).reduce(f64::min);
    let diameter = smallest.filter(|_| !domain.cells.is_empty())?;
    let spacing = (0..domain.dimensions()).map(|axis| domain.spacing(axis)).fold(0.0, f64::max);
    Some(diameter / spacing)
}

/// `KEY=VALUE` of a grid: numbers of cells, and the width of the cells in the even part of a stretched axis,
/// m.
pub fn set(cells: &[u64], stretched: Option<f64>) -> Vec<String> {
    let spacing = stretched.map(|width| format!("domain.stretching.spacing={width:?}"));
    [format!("domain.cells={cells:?}")].into_iter().chain(spacing).collect()
}

/// Even, with no factors but 2, 3 and 5: all transforms take such numbers of cells fast.
pub(crate) fn is_fast(count: &u64) -> bool {
    let mut rest = *count;
    for factor in [2, 3, 5] {
        while rest > 0 && rest.is_multiple_of(factor) {
            rest /= factor;
        }
    }
    count.is_multiple_of(2) && rest == 1
}

/// The least such number from `least` on.
pub fn fast(least: u64) -> u64 {
    (least..).find(is_fast).unwrap_or(least)
}
