//! When the grains have come to rest.

use crate::checked::CheckedScene;
use crate::grains::Motion;
use crate::shared::StopWhen;
use protocol::message::Kinematics;

/// Watches for rest.
#[derive(Clone, Debug)]
pub struct Rest {
    stop: StopWhen,
    /// Index and mass of the free grains.
    free: Vec<(usize, f64)>,
    /// Σ m g R, J.
    scale: f64,
    /// Number of grains that are there from the start.
    present: usize,
    /// Time, s, before which nothing counts: what is let go is slow at first.
    earliest: f64,
}

/// Times over which a fall from rest reaches the energy that counts as rest, before which nothing does.
const FALLS: f64 = 4.0;

impl Rest {
    /// For the scene's `stop_when`, if it has one.
    pub fn new(scene: &CheckedScene) -> Option<Self> {
        let stop = scene.scene.stop_when?;
        let gravity = scene.scene.largest_gravity();
        let free = || scene.grains.iter().enumerate().filter(|(_, grain)| grain.motion == Motion::Free);
        let largest = free().map(|(_, grain)| grain.radius).fold(0.0, f64::max);
        let fall = if gravity > 0.0 {
            (2.0 * stop.kinetic_energy_per_grain_below * largest / gravity).sqrt()
        } else {
            0.0
        };
        Some(Self {
            earliest: stop.after.max(FALLS * fall),
            stop,
            present: scene.present(),
            scale: free().map(|(_, grain)| grain.mass() * gravity * grain.radius).sum(),
            free: free().map(|(index, grain)| (index, grain.mass())).collect(),
        })
    }

    /// Kinetic energy of translation over Σ m g R; none while grains are still to be inserted.
    pub fn energy(&self, kinematics: &[Kinematics]) -> Option<f64> {
        let mut energy = 0.0;
        for &(index, mass) in &self.free {
            let motion = kinematics.get(index)?;
            if index >= self.present && !motion.is_there() {
                return None;
            }
            energy += 0.5 * mass * motion.velocity.iter().map(|v| v * v).sum::<f64>();
        }
        Some(energy / self.scale)
    }

    /// Do the grains rest at `time`?
    pub fn reached(&self, time: f64, kinematics: &[Kinematics]) -> bool {
        time >= self.earliest
            && self.energy(kinematics).is_some_and(|energy| energy < self.stop.kinetic_energy_per_grain_below)
    }
}
