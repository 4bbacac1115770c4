//! The plane in place of space.

use bedload_scene::{Axis, Geometry, InitialVelocity, OverTime, WallKind};
use toml::Value;

use super::Idea;
use super::change::Change;
use crate::prepare::Prepared;

/// A flow without grains that nothing makes depend on y is the same all along y.
pub(super) fn idea(prepared: &Prepared) -> Option<Idea> {
    let scene = &prepared.scene;
    let (domain, medium) = (&scene.scene.domain, scene.scene.medium.as_ref()?);
    let flat = |v: &OverTime<[f64; 3]>| v.extremes().all(|v| v[1] == 0.0);
    let y = if domain.geometry == Geometry::Space { domain.boundary(1)? } else { return None };
    let open = |kind: WallKind| matches!(kind, WallKind::Periodic | WallKind::FreeSlip);
    let sides_are_open = y.lower.as_ref().is_some_and(|lower| open(lower.kind)) && open(y.upper.kind);
    let faces = [0, 2].into_iter().filter_map(|axis| domain.boundary(axis));
    let faces_are_flat = faces.flat_map(|b| [b.lower, Some(b.upper)]).flatten().all(|f| flat(&f.velocity));
    let initial_is_flat = match &medium.initial {
        InitialVelocity::Rest => true,
        InitialVelocity::Uniform { velocity } => velocity[1] == 0.0,
        InitialVelocity::Shear { direction, gradient, .. } => *direction != Axis::Y && *gradient != Axis::Y,
        InitialVelocity::TaylorGreen { .. } | InitialVelocity::Run { .. } => false,
    };
    let drives_are_flat = flat(&medium.body_force)
        && flat(&medium.pressure_gradient)
        && flat(&scene.scene.gravity)
        && medium.flow_rate.as_ref().is_none_or(|flow| flow.axis != Axis::Y);
    let stretched = domain.stretching.is_some_and(|stretching| stretching.axis == Axis::Y);
    let fits = scene.grains.is_empty()
        && sides_are_open
        && faces_are_flat
        && initial_is_flat
        && drives_are_flat
        && !stretched;
    let without_y = |values: &[f64]| Value::from(vec![values[0], values[2]]);
    let cells: Vec<i64> = [domain.cells.first()?, domain.cells.get(2)?].map(|n| *n as i64).into();
    fits.then(|| Idea {
        name: "plane",
        what: "the plane in place of space",
        change: Change::default()
            .set("domain.geometry", "plane")
            .set("domain.lower", without_y(&domain.lower))
            .set("domain.upper", without_y(&domain.upper))
            .set("domain.cells", cells)
            .remove("domain.boundary.y")
            .remove("domain.boundary.y_lower")
            .remove("domain.boundary.y_upper"),
        error: 0.0,
        saving: None,
        why: "nothing depends on y, as long as the flow is stable to what does".into(),
    })
}
