//! A grain as its metrics see it: which way it settles, how fast, and what it does in a window.

use super::accumulator::Accumulator;
use super::trajectory::{Passage, Trajectory};
use crate::columns::Sample;
use bedload_scene::{CheckedScene, MetricKind};

/// What the metrics need to know of a grain.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Subject {
    /// Number in the scene.
    pub(super) grain: usize,
    /// Unit vector along which it settles: of the submerged weight; zero without gravity.
    pub(super) settling: [f64; 3],
    /// m.
    pub(super) radius: f64,
    /// kg/m³.
    pub(super) density: f64,
    /// Weight less buoyancy, N.
    pub(super) submerged_weight: f64,
}

impl Subject {
    /// Grain `grain` of the scene.
    pub(super) fn new(scene: &CheckedScene, grain: usize) -> Self {
        let data = &scene.grains[grain];
        let gravity = norm(&scene.scene.gravity);
        let excess = data.density - scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density);
        let way = if excess < 0.0 { -1.0 } else { 1.0 };
        Self {
            grain,
            settling: scene.scene.gravity.map(|g| if gravity > 0.0 { way * g / gravity } else { 0.0 }),
            radius: data.radius,
            density: data.density,
            submerged_weight: excess.abs() * data.volume() * gravity,
        }
    }

    /// Speed along the settling direction, m/s; without gravity the magnitude of the velocity.
    pub(super) fn speed(&self, velocity: &[f64; 3]) -> f64 {
        if self.settling == [0.0; 3] { norm(velocity) } else { dot(velocity, &self.settling) }
    }

    /// The grain over the window, if its motion is observed.
    pub(super) fn passage(&self, sample: &Sample) -> Option<Passage> {
        let motion = sample.kinematics.get(self.grain)?;
        Some(Passage {
            speed: self.speed(&motion.velocity),
            gap: motion.gap,
            touching: motion.contact_force != [0.0; 3],
            impact: motion.impact_speed,
            rebound: motion.rebound_speed,
            time: sample.time(),
        })
    }
}

/// One grain over one window, with its trajectory before and after.
pub(super) struct View<'a> {
    pub(super) subject: &'a Subject,
    pub(super) gravity: f64,
    pub(super) before: &'a Trajectory,
    pub(super) after: &'a Trajectory,
    pub(super) passage: &'a Passage,
}

impl View<'_> {
    /// Feeds the accumulator of a metric about this grain.
    pub(super) fn record(&self, kind: &MetricKind, accumulator: &mut Accumulator, sample: &Sample) {
        match kind {
            MetricKind::TerminalReynolds { .. } => accumulator.add(self.passage.speed, sample),
            MetricKind::InitialAcceleration { .. } => {
                let gained = self.passage.speed - self.before.speed;
                accumulator.add(gained / (sample.window.dt * self.gravity), sample);
            }
            MetricKind::RestingForceRatio { .. } => {
                let force = sample.kinematics[self.subject.grain].contact_force;
                accumulator.add(-dot(&force, &self.subject.settling), sample);
            }
            MetricKind::RestitutionAtGap { gap, .. } => {
                if let Accumulator::Crossing(crossing) = accumulator {
                    crossing.record(gap * self.subject.radius, self.before, self.passage, self.after);
                }
            }
            // The trajectory holds the others; columns come from the row.
            _ => {}
        }
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Length of a vector.
pub(super) fn norm(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
