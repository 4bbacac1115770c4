//! The carried forcing in a dense bed against the window (docs/numerics.md).

use bedload_scene::CheckedScene;
use protocol::facts::Side;

use super::bound::Bound;
use super::facts::Facts;

/// Solid fraction of the grains' bounding box from which a bed counts as dense.
const DENSE: f64 = 0.3;
/// Fewer grains than this are no bed.
const FEWEST_OF_A_BED: usize = 8;

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let (Some(fluid), Some(nu)) = (facts.fluid.filter(|fluid| !fluid.foreign), facts.viscosity()) else {
        return;
    };
    if fluid.spacing > 0.0 && fluid.forcing.is_carried() && is_dense(facts.scene) {
        let number = nu * facts.steps.dt_fluid / fluid.spacing.powi(2);
        let bound = Bound::new("dense-bed-forcing", "ν dt/Δx²", number, Side::AtMost, 2.0).warning();
        bounds.push(bound.because(
            "the carried forcing of a dense bed converges slowly (340 steps to 1 % at φ = 0.52 and 16)",
            "docs/numerics.md, Forcing and viscosity",
            "lower the fluid's dt",
        ));
    }
}

/// Is the box around the grains filled as in a bed?
fn is_dense(scene: &CheckedScene) -> bool {
    if scene.grains.len() < FEWEST_OF_A_BED {
        return false;
    }
    let domain = &scene.scene.domain;
    let extent = |axis: usize| {
        let component = domain.geometry.component(axis);
        let lower = scene.grains.iter().map(|grain| grain.position[component] - grain.radius);
        let upper = scene.grains.iter().map(|grain| grain.position[component] + grain.radius);
        upper.fold(f64::NEG_INFINITY, f64::max) - lower.fold(f64::INFINITY, f64::min)
    };
    let room: f64 = (0..domain.dimensions()).map(extent).product();
    scene.grains.iter().map(bedload_scene::Grain::volume).sum::<f64>() > DENSE * room
}
