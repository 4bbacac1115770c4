//! Averages over planes, the bed that moves as a whole, and what a solver alone measures at the end.

use bedload_scene::{Axis, CheckedScene, MetricKind, Motion, OfSurface};

use super::accumulator::Accumulator;
use super::rule::{End, Rule, plain};
use super::subject::norm;
use crate::balance::{StressBalance, weight_per_area};
use crate::planes::{Planes, Record};

/// The rule of a kind that is measured at the end; `None` for others.
pub(super) fn rule(scene: &CheckedScene, kind: &MetricKind) -> Option<Rule> {
    Some(match *kind {
        MetricKind::MeanFluidVelocity(of) => mean_velocity(scene, 0, of.component.component()),
        MetricKind::MeanGrainVelocity(of) => mean_velocity(scene, 1, of.component.component()),
        MetricKind::Shields(of) => {
            let planes = scene.scene.observe.planes.as_ref().map_or(Axis::Z, |planes| planes.axis);
            let balance = StressBalance::of(scene, planes);
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
        MetricKind::JanssenFit(_)
        | MetricKind::JanssenDirect(_)
        | MetricKind::PlateauPressure(_)
        | MetricKind::StressRatio(_)
        | MetricKind::InertialNumber(_)
        | MetricKind::ShearExponent(_) => {
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

fn mean_velocity(scene: &CheckedScene, phase: usize, component: usize) -> Rule {
    let rings = scene.scene.observe.planes.as_ref().is_some_and(|planes| planes.axis == Axis::R);
    Rule::at_end("m/s", move |end| plain(mean(record(end)?)?.mean_velocity(phase, component, rings)))
}

/// A stress at the surface of the bed over (ρ_p − ρ) g D of the free grains.
fn shields(
    scene: &CheckedScene,
    of: OfSurface,
    stress: impl Fn(&Planes) -> Option<f64> + Send + Sync + 'static,
) -> Rule {
    let weight = weight_per_area(scene);
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
