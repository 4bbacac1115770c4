//! A grain as its metrics see it: which way it settles, how fast, and what it does in a window.

use super::trajectory::Passage;
use crate::sample::Sample;
use bedload_scene::{CheckedScene, Freedom, MetricKind};

pub(super) use bedload_scene::speeds::norm;

/// What the metrics need to know of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Subject {
    /// Number in the scene.
    pub(super) grain: usize,
    /// Unit vector along which it settles: of the submerged weight; zero without gravity.
    pub(super) settling: [f64; 3],
    /// m.
    pub(super) radius: f64,
    /// kg/m³.
    pub(super) density: f64,
    /// Whether it settles along an axis that has ends, so that a floor is level.
    is_level: bool,
    /// Weight less buoyancy, N.
    pub(super) submerged_weight: f64,
    /// Number of grains that are there from the start.
    present: usize,
}

impl Subject {
    /// The grain that a metric is about, if it is about one.
    pub(super) fn of(scene: &CheckedScene, kind: &MetricKind) -> Option<Self> {
        let grain = kind.grain()?;
        let data = &scene.grains[grain];
        let pull = scene.scene.gravity.longest(scene.scene.until);
        // What is locked along an axis does not settle there.
        let locked = [Freedom::X, Freedom::Y, Freedom::Z].map(|axis| data.locked.contains(&axis));
        let pull: [f64; 3] = std::array::from_fn(|c| if locked[c] { 0.0 } else { pull[c] });
        let gravity = norm(&pull);
        let excess = data.density - scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density);
        let way = if excess < 0.0 { -1.0 } else { 1.0 };
        let periods = scene.scene.domain.periods();
        let along: Vec<usize> = (0..3).filter(|c| pull[*c] != 0.0).collect();
        Some(Self {
            grain,
            is_level: along.len() == 1 && periods[along[0]].is_none(),
            settling: pull.map(|g| if gravity > 0.0 { way * g / gravity } else { 0.0 }),
            radius: data.radius,
            density: data.density,
            submerged_weight: excess.abs() * data.volume() * gravity,
            present: scene.present(),
        })
    }

    /// Speed along the settling direction, m/s; without gravity the magnitude of the velocity.
    pub(super) fn speed(&self, velocity: &[f64; 3]) -> f64 {
        if self.settling == [0.0; 3] { norm(velocity) } else { dot(velocity, &self.settling) }
    }

    /// The grain over the window, if it is there and its motion is observed.
    pub(super) fn passage(&self, sample: &Sample) -> Option<Passage> {
        let motion = sample.kinematics.get(self.grain).filter(|_| !sample.lacks(self.grain, self.present))?;
        Some(Passage {
            speed: self.speed(&motion.velocity),
            gap: motion.gap,
            depth: self.is_level.then(|| dot(&motion.position, &self.settling)),
            touching: motion.contact_force != [0.0; 3],
            impact: motion.impact_speed,
            rebound: motion.rebound_speed,
            time: sample.time(),
        })
    }
}

pub(super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
