//! Grains that have left the box through a face that they do not touch.

use crate::immersed::body::{Motion, Shape};
use bedload_scene::CheckedScene;
use protocol::message::Loads;

/// Where grains are beyond such a face, and what they are sent there.
pub(crate) struct Beyond {
    /// Limits of the box where grains can leave, m; infinite elsewhere.
    limits: [[f64; 2]; 3],
    /// m/s².
    gravity: [f64; 3],
}

impl Beyond {
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        Self { limits: scene.scene.domain.open_limits(), gravity: scene.scene.gravity }
    }

    /// Of a grain that is out as a whole the grid says nothing any more. It keeps the velocity with which it
    /// left: the flow bears its weight.
    pub(crate) fn replace(&self, shapes: &[Shape], motions: &[Motion], loads: &mut [Loads]) {
        if self.limits.iter().flatten().all(|limit| limit.is_infinite()) {
            return;
        }
        for ((shape, motion), loads) in shapes.iter().zip(motions).zip(loads) {
            let is_out =
                |(x, [low, high]): (&f64, &[f64; 2])| x + shape.radius < *low || x - shape.radius > *high;
            if motion.centre.iter().zip(&self.limits).any(is_out) {
                let mass = shape.density * shape.volume;
                *loads = Loads { force: self.gravity.map(|g| -mass * g), ..Loads::default() };
            }
        }
    }
}
