//! Stokes flow, where Re ≪ 1.

use std::f64::consts::PI;

use bedload_scene::{CheckedScene, Motion, Shape};

use super::change::Change;
use super::{Idea, drive, is_driven_at_faces, norm, volume};
use crate::keys;
use crate::number::Short;
use crate::prepare::Prepared;

/// Without convection one stage is enough. Oseen's correction, 3/16 Re of the drag, is what is lost
/// (Proudman & Pearson 1957); time derivatives stay.
pub(super) fn idea(prepared: &Prepared) -> Option<Idea> {
    let scene = &prepared.scene;
    let medium = scene.scene.medium.as_ref()?;
    let on = keys::look_up(scene, keys::CONVECTION).is_none_or(|on| on.as_bool() == Some(true));
    let at_rest = medium.initial == bedload_scene::InitialVelocity::Rest;
    if !on || !at_rest || is_driven_at_faces(&scene.scene) || scene.grains.is_empty() {
        return None;
    }
    let nu = medium.kinematic_viscosity();
    let speeds = scene.grains.iter().map(|grain| stokes_speed(scene, grain, nu));
    let reynolds = scene.grains.iter().zip(speeds).map(|(grain, u)| 2.0 * grain.radius * u / nu);
    let reynolds = reynolds.fold(0.0, f64::max);
    let change = Change::default().set(keys::CONVECTION, false).set(keys::TIME_SCHEME, keys::AB2);
    Some(Idea {
        name: "stokes",
        what: "Stokes flow, one stage a step",
        change,
        error: 3.0 / 16.0 * reynolds,
        saving: None,
        why: format!("of the drag, 3/16 Re with Re ≤ {}", Short(reynolds)),
    })
}

/// A bound on the speed between grain and fluid, m/s: what is prescribed, the speed of settling and that
/// of a driven flow, each with Stokes's drag, which is the least there is.
fn stokes_speed(scene: &CheckedScene, grain: &bedload_scene::Grain, nu: f64) -> f64 {
    let medium_density = scene.scene.medium.as_ref().map_or(1.0, |medium| medium.density);
    let swing = grain.oscillation.map_or(0.0, |swing| norm(&swing.amplitude));
    let spin = grain.radius * norm(&grain.spin);
    let mut speed = norm(&grain.velocity) + swing + spin;
    // A body of the plane has no Stokes drag of its own: walls and neighbours decide, of the order of its
    // viscous time.
    let drag = match grain.shape {
        Shape::Sphere => 6.0 * PI * nu * grain.radius,
        _ => 4.0 * PI * nu,
    };
    if grain.motion == Motion::Free {
        let excess = (grain.density / medium_density - 1.0).abs();
        speed += excess * grain.volume() * norm(&scene.scene.gravity) / drag;
    }
    let held = scene.grains.iter().filter(|grain| grain.motion != Motion::Free).count();
    let drive = norm(&drive(&scene.scene));
    if drive > 0.0 {
        // Nothing but free grains holds the flow back: its speed is not known.
        let alone = if held == 0 { f64::INFINITY } else { volume(scene) / held as f64 };
        speed += drive * alone / drag;
    }
    speed
}
