//! The grains of a scene in this crate's words.

use crate::grid::Geometry;
use crate::immersed::body::{Motion, Shape};
use bedload_scene::{CheckedScene, Freedom, Grain};
use std::sync::Arc;

/// Geometry of the scene in this crate's words.
pub(crate) fn geometry(scene: &CheckedScene) -> Geometry {
    match scene.scene.domain.geometry {
        bedload_scene::Geometry::Plane => Geometry::Plane,
        bedload_scene::Geometry::Axisymmetric => Geometry::Axisymmetric,
        bedload_scene::Geometry::Space => Geometry::Space,
    }
}

/// Which grains the fluid moves.
pub(crate) fn free(scene: &CheckedScene) -> Vec<bool> {
    let geometry = scene.scene.domain.geometry;
    let moves = |grain: &Grain| grain.motion == bedload_scene::Motion::Free && !grain.stays(geometry);
    scene.grains.iter().map(moves).collect()
}

/// Of each grain: the motions along x, y, z and about them that obey Newton's law.
pub(crate) fn freedoms(scene: &CheckedScene) -> Vec<[bool; 6]> {
    let geometry = scene.scene.domain.geometry;
    scene.grains.iter().map(|grain| Freedom::ALL.map(|freedom| grain.is_free(freedom, geometry))).collect()
}

/// Shapes of the grains, in message order.
pub(crate) fn shapes(scene: &CheckedScene) -> Vec<Shape> {
    let shape = |grain: &Grain| Shape {
        outline: grain.outline().map(Arc::new),
        ..Shape::round(grain.radius, grain.density, grain.volume(), grain.gyration())
    };
    scene.grains.iter().map(shape).collect()
}

/// Motion of the grains at t = 0.
pub(crate) fn motions(scene: &CheckedScene) -> Vec<Motion> {
    let geometry = geometry(scene);
    let motion = |grain: &Grain| {
        let from = protocol::message::Kinematics {
            position: grain.position,
            velocity: grain.velocity.start(),
            spin: grain.spin.start(),
            orientation: grain.orientation,
            ..Default::default()
        };
        let motion = Motion::received(geometry, &from);
        match grain.motion {
            bedload_scene::Motion::Fixed => Motion { velocity: [0.0; 3], spin: [0.0; 3], ..motion },
            _ => motion,
        }
    };
    scene.grains.iter().map(motion).collect()
}
