//! Averages over planes, the bed that moves as a whole, and what a solver alone measures at the end.

use bedload_scene::{Axis, CheckedScene, Grain, MetricKind, Motion, OfSurface, WallKind};

use super::accumulator::Accumulator;
use super::rule::{End, Rule, plain};
use super::subject::norm;
use crate::planes::{Plane, Planes, Record};

/// The rule of a kind that is measured at the end; `None` for others.
pub(super) fn rule(scene: &CheckedScene, kind: &MetricKind) -> Option<Rule> {
    Some(match *kind {
        MetricKind::MeanFluidVelocity(of) => mean_velocity(0, of.component.component()),
        MetricKind::MeanGrainVelocity(of) => mean_velocity(1, of.component.component()),
        MetricKind::Shields(of) => {
            let balance = StressBalance::of(scene);
            shields(scene, of, move |planes| balance.at_surface(planes, of.surface))
        }
        MetricKind::FluidShields(of) => {
            let viscosity = scene.scene.medium.as_ref().map_or(0.0, |medium| medium.viscosity);
            shields(scene, of, move |planes| Some(viscosity * planes.shear_at_surface(of.surface)?))
        }
        MetricKind::MobilisationTime { speed, share } => {
            let free: Vec<usize> =
                (0..scene.grains.len()).filter(|i| scene.grains[*i].motion == Motion::Free).collect();
            Rule::new(
                "s",
                Accumulator::First(None),
                move |seen, kept| {
                    let motion = seen.sample.kinematics;
                    let moves = |i: &&usize| motion.get(**i).is_some_and(|m| norm(&m.velocity) >= speed);
                    let moving = free.iter().filter(moves).count();
                    if moving > 0 && moving as f64 >= share * free.len() as f64 {
                        kept.add(seen.sample.time(), seen.sample);
                    }
                },
                |kept, _| plain(kept.value().map_err(|_| "so many grains never moved so fast")?),
            )
        }
        MetricKind::JanssenFit(_) | MetricKind::JanssenDirect(_) | MetricKind::PlateauPressure(_) => {
            elsewhere("-", "bedload-dem at the end of a dry run with [observe.profile]")
        }
        MetricKind::VelocityDifference { .. } => elsewhere("m/s", FLUID),
        MetricKind::WakeLength { .. } => elsewhere("-", FLUID),
        _ => return None,
    })
}

const FLUID: &str = "bedload-fluid at the end of a run without free grains";

/// Measured by another than this run, if at all.
fn elsewhere(unit: &str, by: &'static str) -> Rule {
    Rule::at_end(unit, move |_| Err(format!("is measured by {by}")))
}

fn record<'a>(end: &End<'a>) -> Result<&'a Record, String> {
    end.planes.ok_or_else(|| "this run has no fluid of its own to average".into())
}

fn mean(record: &Record) -> Result<&Planes, String> {
    record.mean.as_ref().ok_or_else(|| "the run ended before the mean of observe.planes begins".into())
}

fn mean_velocity(phase: usize, component: usize) -> Rule {
    Rule::at_end("m/s", move |end| plain(mean(record(end)?)?.mean_velocity(phase, component)))
}

/// A stress at the surface of the bed over (ρ_p − ρ) g D of the free grains.
fn shields(
    scene: &CheckedScene,
    of: OfSurface,
    stress: impl Fn(&Planes) -> Option<f64> + Send + Sync + 'static,
) -> Rule {
    let weight = excess_density(scene) * norm(&scene.scene.peak_gravity()) * diameter(scene);
    Rule::at_end("-", move |end| {
        let record = record(end)?;
        let planes = match of.at {
            Some(t) => record.nearest(t).ok_or_else(|| format!("the run ended before t = {t} s"))?,
            None => mean(record)?,
        };
        let stress = stress(planes);
        let stress = stress.ok_or_else(|| format!("no solid fraction of {} was found", of.surface))?;
        if weight > 0.0 { plain(stress / weight) } else { Err("no grain has a weight".into()) }
    })
}

fn free_grains(scene: &CheckedScene) -> impl Iterator<Item = &Grain> {
    scene.grains.iter().filter(|grain| grain.motion == Motion::Free)
}

/// Mean over the free grains.
fn mean_of(scene: &CheckedScene, value: impl Fn(&Grain) -> f64) -> f64 {
    free_grains(scene).map(value).sum::<f64>() / free_grains(scene).count().max(1) as f64
}

/// ρ_p − ρ of the free grains, kg/m³.
fn excess_density(scene: &CheckedScene) -> f64 {
    mean_of(scene, |grain| grain.density) - scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density)
}

fn diameter(scene: &CheckedScene) -> f64 {
    mean_of(scene, |grain| 2.0 * grain.radius)
}

/// What makes the whole shear stress on a plane, of fluid and grains together, in steady flow: that of the
/// lid, and the forces on all that is between.
struct StressBalance {
    /// Component across the planes.
    across: usize,
    /// Viscosity, Pa s, and velocity of the lid, m/s; none where it is free of shear.
    lid: Option<(f64, [f64; 3])>,
    /// Force on the mixture along periodic axes, N/m³: where there is fluid alone, and more where there is
    /// solid.
    drive: [f64; 3],
    excess: [f64; 3],
}

impl StressBalance {
    fn of(scene: &CheckedScene) -> Self {
        let domain = &scene.scene.domain;
        let axes = domain.geometry.axes();
        let planes = scene.scene.observe.planes.as_ref().map_or(Axis::Z, |planes| planes.axis);
        let axis = axes.iter().position(|axis| *axis == planes).unwrap_or(0);
        let medium = scene.scene.medium.as_ref();
        let face =
            domain.boundary(axis).map(|faces| faces.upper).filter(|face| face.kind == WallKind::NoSlip);
        let until = scene.scene.until;
        let (mut drive, mut excess) = ([0.0; 3], [0.0; 3]);
        for along in (0..domain.dimensions()).filter(|along| domain.is_periodic(*along)) {
            let c = domain.geometry.component(along);
            let gravity = scene.scene.peak_gravity()[c];
            drive[c] =
                medium.map_or(0.0, |medium| medium.density * (gravity + medium.body_force.peak(until)[c]));
            excess[c] = excess_density(scene) * gravity;
        }
        Self {
            across: domain.geometry.component(axis),
            lid: face.zip(medium).map(|(face, medium)| (medium.viscosity, face.velocity.peak(until))),
            drive,
            excess,
        }
    }

    /// Stress where the solid fraction falls below `fraction` for the last time, Pa.
    fn at_surface(&self, planes: &Planes, fraction: f64) -> Option<f64> {
        let above = planes.above_surface(fraction)?;
        let top = above.last()?;
        let square = (0..3).filter(|c| *c != self.across).map(|c| {
            let lid = self.lid.map_or(0.0, |(viscosity, velocity)| {
                viscosity * (velocity[c] - top.fluid_velocity[c]) / (0.5 * top.width)
            });
            let force = |p: &Plane| p.width * (self.drive[c] + p.solid_fraction * self.excess[c]);
            (lid + above.iter().map(force).sum::<f64>()).powi(2)
        });
        Some(square.sum::<f64>().sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bed up to z = 2 in a channel of height 4, whose fluid is at `velocity` on each plane.
    fn planes(velocity: impl Fn(f64) -> f64) -> Planes {
        let plane = |k: usize| {
            let at = 0.25 + 0.5 * k as f64;
            let solid_fraction = if at < 2.0 { 0.5 } else { 0.0 };
            Plane {
                at,
                width: 0.5,
                solid_fraction,
                fluid_velocity: [velocity(at), 0.0, 0.0],
                ..Plane::default()
            }
        };
        Planes { time: 0.0, planes: (0..8).map(plane).collect() }
    }

    #[test]
    fn under_a_lid_the_whole_stress_is_the_lids_wherever_grains_carry_it() {
        // Grains carry so much above z = 2 that the fluid there is sheared at 1 where it is sheared at 3 by
        // the lid.
        let velocity = |z: f64| if z < 3.0 { z } else { 3.0 * (z - 3.0) + 3.0 };
        let balance =
            StressBalance { across: 2, lid: Some((0.7, [6.0, 0.0, 0.0])), drive: [0.0; 3], excess: [0.0; 3] };
        let stress = balance.at_surface(&planes(velocity), 0.3).unwrap();
        assert!((stress - 0.7 * 3.0).abs() < 1e-12, "{stress}");
        assert_eq!(planes(velocity).shear_at_surface(0.3), Some(1.0));
        assert_eq!(balance.at_surface(&planes(velocity), 0.6), None);
    }

    #[test]
    fn under_a_free_surface_the_stress_is_the_weight_along_the_slope() {
        let balance = StressBalance { across: 2, lid: None, drive: [0.4, 0.0, 0.0], excess: [0.6, 0.0, 0.0] };
        // The surface at 0.5 is that of the last plane of the bed; 2 of clear fluid stand above it.
        let stress = balance.at_surface(&planes(|_| 0.0), 0.5).unwrap();
        assert!((stress - 0.4 * 2.0).abs() < 1e-12, "{stress}");
    }
}
