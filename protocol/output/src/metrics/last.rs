//! The last state of all grains, for metrics of heaps and collisions.

use super::touching::Ball;
use crate::sample::Sample;
use bedload_scene::{CheckedScene, Grain, Motion};
use protocol::message::Kinematics;

/// The grains at t = 0 and after the last window.
#[derive(Clone, Debug)]
pub(super) struct LastState {
    pub(super) grains: Vec<Grain>,
    /// End of the last window, s.
    pub(super) time: f64,
    /// Empty before the first window.
    pub(super) kinematics: Vec<Kinematics>,
    /// Lower z face, m.
    pub(super) floor: f64,
    /// Number of grains that are there from the start.
    present: usize,
    /// Length of the box along y, if it is periodic there, m.
    pub(super) period: Option<f64>,
    /// Length of the box along y, if there is such an axis, m.
    pub(super) depth: Option<f64>,
}

impl LastState {
    pub(super) fn new(scene: &CheckedScene) -> Self {
        Self {
            grains: scene.grains.clone(),
            time: 0.0,
            kinematics: Vec::new(),
            floor: scene.scene.domain.lower.last().copied().unwrap_or(0.0),
            present: scene.present(),
            period: length_along_y(scene).filter(|(_, periodic)| *periodic).map(|(length, _)| length),
            depth: length_along_y(scene).map(|(length, _)| length),
        }
    }

    /// Keeps the state after a window.
    pub(super) fn record(&mut self, sample: &Sample) {
        self.time = sample.time();
        sample.kinematics.clone_into(&mut self.kinematics);
    }

    /// The free grains that are there.
    pub(super) fn balls(&self) -> Vec<Ball> {
        let there = |(index, (grain, motion)): &(usize, (&Grain, &Kinematics))| {
            grain.motion == Motion::Free && (*index < self.present || motion.is_there())
        };
        let all = self.grains.iter().zip(&self.kinematics).enumerate().filter(there);
        all.map(|(_, (grain, motion))| (motion.position, grain.radius)).collect()
    }
}

/// Length of the box along y, m, and whether it is periodic there.
fn length_along_y(scene: &CheckedScene) -> Option<(f64, bool)> {
    let domain = &scene.scene.domain;
    let axis = (0..domain.dimensions()).find(|axis| domain.geometry.component(*axis) == 1)?;
    Some((domain.upper[axis] - domain.lower[axis], domain.is_periodic(axis)))
}
