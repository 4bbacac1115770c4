//! No fluid, where the grains' inertia rules.

use bedload_scene::Motion;

use super::change::Change;
use super::{Idea, drive, is_driven_at_faces, norm};
use crate::keys;
use crate::number::Short;
use crate::prepare::Prepared;
use bedload_scene::speeds::over_stokes;

/// What a grain loses by the fluid, in parts of its velocity: buoyancy and virtual mass 3/2 ρ/ρ_p, drag over
/// the run (Stokes, and Schiller & Naumann 1933 above), and in a bounce 1 − exp(−35/St). Twice their sum,
/// because a bounce turns a delay δt into a difference of velocity (1 + e_n) g δt.
pub(super) fn idea(prepared: &Prepared) -> Option<Idea> {
    let scene = &prepared.scene;
    let medium = scene.scene.medium.as_ref()?;
    let at_rest = medium.initial == bedload_scene::InitialVelocity::Rest;
    let driven = !medium.body_force.is_zero() || !medium.pressure_gradient.is_zero();
    if !scene.has_free_grains() || !at_rest || driven || is_driven_at_faces(&scene.scene) {
        return None;
    }
    // Along a periodic axis gravity drives the fluid too, and grains and fluid fall together.
    if norm(&drive(&scene.scene)) > 0.0 {
        return None;
    }
    let domain = &scene.scene.domain;
    let (until, gravity) = (scene.scene.until, scene.scene.largest_gravity());
    let tallest = (0..domain.dimensions()).map(|axis| domain.upper[axis] - domain.lower[axis]);
    let fall = until.min((2.0 * tallest.fold(0.0, f64::max) / gravity).sqrt());
    let free = scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    let loss = |grain: &bedload_scene::Grain| {
        let (diameter, mu) = (2.0 * grain.radius, medium.viscosity);
        let fast = norm(&grain.velocity.start()) + gravity * fall;
        let slow = norm(&grain.velocity.start()).max(gravity * fall);
        let reynolds = fast * diameter * medium.density / mu;
        let drag = 18.0 * mu / (grain.density * diameter * diameter) * over_stokes(reynolds);
        let stokes = grain.density * slow * diameter / (9.0 * mu);
        2.0 * (1.5 * medium.density / grain.density + drag * until + 1.0 - (-35.0 / stokes).exp())
    };
    let error = free.map(loss).fold(0.0, f64::max);
    // Without films, which are the fluid's; a box for a dry scene needs no cells.
    let change = Change::default()
        .remove("medium")
        .remove("fluid")
        .remove("domain.cells")
        .remove("domain.stretching")
        .remove(keys::LUBRICATION)
        .remove("observe.planes");
    Some(Idea {
        name: "dry",
        what: "no fluid",
        change,
        error,
        saving: None,
        why: format!(
            "of the velocity: twice buoyancy and virtual mass, drag over {} s, 1 − exp(−35/St) of a bounce",
            Short(until)
        ),
    })
}
