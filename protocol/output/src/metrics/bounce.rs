//! A sphere that settles and bounces: what its trajectory comes to.

use bedload_scene::{CheckedScene, MetricKind};

use super::accumulator::Accumulator;
use super::rule::{Moved, Outcome, Rule, plain, require};
use super::subject::{Subject, dot};
use super::trajectory::{Crossing, Trajectory};
use crate::sample::{Sample, When};

/// Part of the run, at its end, over which "terminal" and "resting" are averaged.
const TAIL: f64 = 0.1;

/// Why there is no height of a rebound.
const RISES: &str = "the run ends on the way up: end it later";

/// A mean speed below this part of the largest before the first touch is no terminal speed: the grain rests.
const RESTS: f64 = 1e-3;

/// The definitions; [`MetricKind`] has them in words. `None` for kinds that are about no grain.
pub(super) fn rule(scene: &CheckedScene, kind: &MetricKind) -> Option<Rule> {
    let subject = Subject::of(scene, kind)?;
    let (diameter, weight) = (2.0 * subject.radius, subject.submerged_weight);
    let medium = scene.scene.medium.as_ref().map(|medium| (medium.density, medium.viscosity));
    let fluid = move || medium.ok_or_else(|| "the scene has no fluid".to_owned());
    let gravity = scene.scene.largest_gravity();
    // Time from the first touch to `then` over (D/g)^½.
    let after_touch = move |way: &Trajectory, then: Option<f64>, otherwise: &str| {
        require(gravity > 0.0, "the scene has no gravity")?;
        let touch = way.first_touch.ok_or("there was no contact")?;
        plain((then.ok_or(otherwise)? - touch) / (diameter / gravity).sqrt())
    };
    let tail = |when| Accumulator::mean((1.0 - TAIL) * scene.scene.until, when);
    Some(match *kind {
        MetricKind::TerminalReynolds(_) => fed(
            tail(When::End),
            |now, sample, kept| kept.add(now.passage.speed, sample),
            move |kept, way| {
                let (density, viscosity) = fluid()?;
                let speed = kept.value()?;
                require(
                    way.terminal == 0.0 || speed >= RESTS * way.terminal,
                    "the grain rests at the end of the run: end it before, or use `reynolds`, of its largest \
                     speed before the first touch",
                )?;
                plain(density * speed * diameter / viscosity)
            },
        ),
        MetricKind::Reynolds(_) => of_way(move |way| {
            let (density, viscosity) = fluid()?;
            plain(density * way.terminal * diameter / viscosity)
        }),
        MetricKind::Stokes(_) => of_way(move |way| {
            let (density, viscosity) = fluid()?;
            plain((subject.density + 0.5 * density) * way.terminal * diameter / (9.0 * viscosity))
        }),
        MetricKind::InitialAcceleration(_) => fed(
            Accumulator::First(None),
            move |now, sample, kept| {
                let gained = now.passage.speed - now.before.speed;
                kept.add(gained / (sample.window.dt * gravity), sample);
            },
            move |kept, _| {
                require(gravity > 0.0, "the scene has no gravity")?;
                plain(kept.value()?)
            },
        ),
        MetricKind::ImpactVelocityRatio(_) => of_way(|way| {
            require_contact(way)?;
            let impact = way.impact.ok_or("the DEM reports no impact speed")?;
            plain(impact / settled(way)?)
        }),
        MetricKind::ReboundVelocityRatio(_) => of_way(|way| {
            require_contact(way)?;
            let terminal = settled(way)?;
            Ok(or_zero(way.rebound.map(|v| v / terminal), "the first contact never ended"))
        }),
        MetricKind::RestitutionAtGap { gap, .. } => fed(
            Accumulator::Crossing(Crossing::default()),
            move |now, _, kept| {
                if let Accumulator::Crossing(crossing) = kept {
                    crossing.record(gap * subject.radius, &now.before, &now.passage, &now.after);
                }
            },
            |kept, way| {
                require_contact(way)?;
                let Accumulator::Crossing(crossing) = kept else { return Err("is not a crossing".into()) };
                let inward = crossing.inward.ok_or("the grain never came in through the gap")?;
                require(inward > 0.0, "the speed on the way in is not positive")?;
                Ok(or_zero(crossing.outward.map(|out| out / inward), "the grain never came back to the gap"))
            },
        ),
        MetricKind::ReboundHeight(_) => of_way(move |way| {
            require_contact(way)?;
            require(!way.rises(1, way.first_height), RISES)?;
            plain(way.first_height / diameter)
        }),
        MetricKind::SecondReboundHeight(_) => of_way(move |way| {
            require(way.contacts >= 2, "there was no second contact")?;
            require(!way.rises(2, way.second_height), RISES)?;
            plain(way.second_height / diameter)
        }),
        MetricKind::ReboundRiseTime(_) => of_way(move |way| {
            require(!way.rises(1, way.first_height), RISES)?;
            after_touch(way, way.first_top, "there was no rebound")
        }),
        MetricKind::ReboundDuration(_) => {
            of_way(move |way| after_touch(way, way.second_touch, "there was no second contact"))
        }
        MetricKind::RestingForceRatio(_) => fed(
            tail(When::Window),
            move |_, sample, kept| {
                let force = sample.kinematics[subject.grain].contact_force;
                kept.add(-dot(&force, &subject.settling), sample);
            },
            move |kept, _| {
                require(weight > 0.0, "the grain has no submerged weight")?;
                plain(kept.value()? / weight)
            },
        ),
        _ => return None,
    })
}

/// A rule about a grain: what its motion over a window adds, and what that and its trajectory come to.
fn fed(
    keeps: Accumulator,
    add: impl Fn(&Moved, &Sample, &mut Accumulator) + Send + Sync + 'static,
    give: impl Fn(&Accumulator, &Trajectory) -> Outcome + Send + Sync + 'static,
) -> Rule {
    let add = move |seen: &super::rule::Seen, kept: &mut Accumulator| {
        if let Some(now) = seen.grain {
            add(now, seen.sample, kept);
        }
    };
    Rule::new("-", keeps, add, move |kept, end| {
        let way = end.way.filter(|way| way.windows > 0).ok_or("the motion of the grain was not observed")?;
        give(kept, way)
    })
}

/// A rule that needs the trajectory alone.
fn of_way(give: impl Fn(&Trajectory) -> Outcome + Send + Sync + 'static) -> Rule {
    fed(Accumulator::Trajectory, |_, _, _| {}, move |_, way| give(way))
}

/// A ratio, or zero and why.
fn or_zero(ratio: Option<f64>, otherwise: &str) -> (f64, Option<String>) {
    ratio.map_or_else(|| (0.0, Some(otherwise.to_owned())), |ratio| (ratio, None))
}

fn require_contact(way: &Trajectory) -> Result<(), String> {
    require(way.contacts > 0, "there was no contact")
}

fn settled(way: &Trajectory) -> Result<f64, String> {
    require(way.terminal > 0.0, "the grain never settled")?;
    Ok(way.terminal)
}
