//! Grains that have left the box through a face that they do not touch.

use super::grains::Grains;
use bedload_scene::CheckedScene;
use protocol::message::Loads;

/// Where grains are beyond such a face, and what they are sent there.
pub(crate) struct Beyond {
    /// Limits of the box where grains can leave, m; infinite elsewhere.
    limits: [[f64; 2]; 3],
}

impl Beyond {
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        Self { limits: scene.scene.domain.open_limits() }
    }

    /// Of a grain that is out as a whole the grid says nothing any more. It keeps the velocity with which it
    /// left: the flow bears its weight.
    pub(crate) fn replace<const D: usize>(&self, grains: &Grains<D>, loads: &mut [Loads]) {
        if self.limits.iter().flatten().all(|limit| limit.is_infinite()) {
            return;
        }
        let Grains { immersed, memory, gravity, .. } = grains;
        for ((shape, motion), loads) in immersed.shapes().iter().zip(&memory.motions).zip(loads) {
            let is_out =
                |(x, [low, high]): (&f64, &[f64; 2])| x + shape.radius < *low || x - shape.radius > *high;
            if motion.centre.iter().zip(&self.limits).any(is_out) {
                let mass = shape.density * shape.volume;
                *loads = Loads { force: gravity.map(|g| -mass * g), ..Loads::default() };
            }
        }
    }
}
