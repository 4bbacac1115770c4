//! A sphere that settles and bounces: what its trajectory comes to.

use bedload_scene::MetricKind;

use super::accumulator::Accumulator;
use super::outcome::{Outcome, plain, require};
use super::subject::Subject;
use super::trajectory::Trajectory;

/// What the metrics of a bounce need besides the grain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings {
    /// Density and viscosity, if there is a fluid.
    pub(super) medium: Option<(f64, f64)>,
    /// Magnitude of gravity, m/s².
    pub(super) gravity: f64,
}

impl Surroundings {
    /// The definitions, one line each; [`MetricKind`] has them in words.
    pub(super) fn value(
        &self,
        kind: &MetricKind,
        accumulator: &Accumulator,
        subject: &Subject,
        way: &Trajectory,
    ) -> Outcome {
        let diameter = 2.0 * subject.radius;
        match kind {
            MetricKind::TerminalReynolds { .. } => {
                let (density, viscosity) = self.medium()?;
                plain(density * accumulator.value()? * diameter / viscosity)
            }
            MetricKind::Reynolds { .. } => {
                let (density, viscosity) = self.medium()?;
                plain(density * way.terminal * diameter / viscosity)
            }
            MetricKind::Stokes { .. } => {
                let (density, viscosity) = self.medium()?;
                plain((subject.density + 0.5 * density) * way.terminal * diameter / (9.0 * viscosity))
            }
            MetricKind::InitialAcceleration { .. } => {
                require(self.gravity > 0.0, "the scene has no gravity")?;
                plain(accumulator.value()?)
            }
            MetricKind::ImpactVelocityRatio { .. } => {
                require_contact(way)?;
                let impact = way.impact.ok_or("the DEM reports no impact speed")?;
                plain(impact / settled(way)?)
            }
            MetricKind::ReboundVelocityRatio { .. } => {
                require_contact(way)?;
                let terminal = settled(way)?;
                Ok(way.rebound.map_or((0.0, Some("the first contact never ended")), |v| (v / terminal, None)))
            }
            MetricKind::RestitutionAtGap { .. } => restitution(accumulator, way),
            MetricKind::ReboundHeight { .. } => {
                require_contact(way)?;
                plain(way.first_height / diameter)
            }
            MetricKind::SecondReboundHeight { .. } => {
                require(way.contacts >= 2, "there was no second contact")?;
                plain(way.second_height / diameter)
            }
            MetricKind::ReboundRiseTime { .. } => {
                self.after_touch(way, way.first_top, "there was no rebound", diameter)
            }
            MetricKind::ReboundDuration { .. } => {
                self.after_touch(way, way.second_touch, "there was no second contact", diameter)
            }
            MetricKind::RestingForceRatio { .. } => {
                require(subject.submerged_weight > 0.0, "the grain has no submerged weight")?;
                plain(accumulator.value()? / subject.submerged_weight)
            }
            _ => Err("is about no grain".into()),
        }
    }

    /// Time from the first touch to `then` over (D/g)^½.
    fn after_touch(&self, way: &Trajectory, then: Option<f64>, otherwise: &str, diameter: f64) -> Outcome {
        require(self.gravity > 0.0, "the scene has no gravity")?;
        let touch = way.first_touch.ok_or("there was no contact")?;
        plain((then.ok_or(otherwise)? - touch) / (diameter / self.gravity).sqrt())
    }

    fn medium(&self) -> Result<(f64, f64), String> {
        self.medium.ok_or_else(|| "the scene has no fluid".into())
    }
}

/// Speed out over speed in; 0 if the grain never comes back to the gap.
fn restitution(accumulator: &Accumulator, way: &Trajectory) -> Outcome {
    require_contact(way)?;
    let Accumulator::Crossing(crossing) = accumulator else { return Err("is not a crossing".into()) };
    let inward = crossing.inward.ok_or("the grain never came in through the gap")?;
    require(inward > 0.0, "the speed on the way in is not positive")?;
    Ok(crossing
        .outward
        .map_or((0.0, Some("the grain never came back to the gap")), |out| (out / inward, None)))
}

fn require_contact(way: &Trajectory) -> Result<(), String> {
    require(way.contacts > 0, "there was no contact")
}

fn settled(way: &Trajectory) -> Result<f64, String> {
    require(way.terminal > 0.0, "the grain never settled")?;
    Ok(way.terminal)
}
