//! When the grains have come to rest.

use crate::changing::changing;
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
    /// Time, s, before which nothing counts: what comes later may move grains that rest.
    earliest: f64,
    /// Time, s, that they rest without a break: what is let go is slow at first, and so is what turns back.
    hold: f64,
}

/// Time that grains rest over that in which one of them, falling, reaches the energy that counts as rest.
const FALLS: f64 = 4.0;

impl Rest {
    /// For the scene's `stop_when`, if it has one.
    pub fn new(scene: &CheckedScene) -> Option<Self> {
        let stop = scene.scene.stop_when?;
        let gravity = scene.scene.largest_gravity();
        let free = || scene.grains.iter().enumerate().filter(|(_, grain)| grain.motion == Motion::Free);
        let largest = free().map(|(_, grain)| grain.radius).fold(0.0, f64::max);
        let fall = if gravity > 0.0 {
            (2.0 * stop.kinetic_energy_per_grain_below * free().count() as f64 * largest / gravity).sqrt()
        } else {
            0.0
        };
        let walls = scene.scene.walls.iter().flat_map(|wall| [wall.from, wall.until]);
        let tables = changing(scene).into_iter().map(|changing| changing.value.last_change());
        let last = walls.chain(tables).filter(|time| time.is_finite()).fold(0.0, f64::max);
        Some(Self {
            earliest: stop.after.max(last),
            hold: FALLS * fall,
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

    /// Do the grains rest at `time`, s, and have for as long as that takes? `since`: from when on, s.
    pub fn reached(&self, time: f64, kinematics: &[Kinematics], since: &mut Option<f64>) -> bool {
        let below = |energy| energy < self.stop.kinetic_energy_per_grain_below;
        if time < self.earliest || !self.energy(kinematics).is_some_and(below) {
            *since = None;
        } else if since.is_none() {
            *since = Some(time);
        }
        since.is_some_and(|since| time - since >= self.hold && time > since)
    }
}
