//! What the speeds of a scene, known before it runs, do to the step and to contacts.

use bedload_scene::Wall;
use protocol::facts::{DemFacts, Level, Measure, Side, SolverBound};

use super::bound::Bound;
use super::facts::Facts;
use super::names::{CFL, OVERLAP};
use crate::number::Short;

/// Largest overlap over radius.
pub(crate) const MOST_OVERLAP: f64 = DemFacts::MOST_OVERLAP;

/// Two equal grains of a linear spring that meet at U overlap by U t_c/π at most, whatever their mass: half a
/// period of the spring. A dashpot makes it less.
pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    bounds.extend(wall_speed(facts));
    let Some(part) = largest_overlap(facts) else { return };
    let speed = facts.speeds.approach;
    let named = part * facts.speeds.named_approach > MOST_OVERLAP * speed;
    let how = if named { "" } else { ", estimated from above," };
    let bound = Bound::new(OVERLAP, "U t_c/(π R)", part, Side::AtMost, MOST_OVERLAP).because(
        format!("grains that meet at U = {} m/s{how} sink so far into each other", Short(speed)),
        "half a period of a linear spring, without its dashpot",
        "shorten dem.contact.contact_time, or stiffen the law",
    );
    // A coupled run ends at this overlap; a DEM alone goes on. What is estimated warns, and is watched.
    bounds.push(if facts.fluid.is_some() && named { bound } else { bound.warning() });
}

/// The way in a window of a wall that turns, follows a pressure or changes its velocity: the free grains that
/// it meets must be known before.
fn wall_speed(facts: &Facts<'_>) -> Option<Bound> {
    let (scene, until) = (facts.scene, facts.scene.scene.until);
    let radius = thinnest_free(facts)?;
    let changes = |wall: &Wall| wall.velocity.varies() || !wall.spin.is_zero() || wall.servo.is_some();
    let walls = scene.contact_walls().into_iter().filter(changes);
    let speed = walls.map(|wall| wall.largest_speed(&scene.scene.domain, until)).reduce(f64::max)?;
    Some(
        Bound::new("wall-speed", "V dt/R", speed * facts.steps.dt_fluid / radius, Side::AtMost, 1.0).because(
            format!("a wall that moves at V = {} m/s passes a grain's radius within a window", Short(speed)),
            "geometry: a grain that is beside a wall at the start of a window is behind it at the end",
            "lower the velocity of the wall, or the step (fluid.time.dt, dem.dt)",
        ),
    )
}

/// Half of the least width of the thinnest free grain, m: its radius if it is round.
fn thinnest_free(facts: &Facts<'_>) -> Option<f64> {
    let free = facts.scene.grains.iter().filter(|grain| grain.motion == bedload_scene::Motion::Free);
    free.map(bedload_scene::Grain::half_width).reduce(f64::min)
}

/// U t_c/(π R) of the thinnest free grain, where anything can touch; R is half of its least width.
pub(crate) fn largest_overlap(facts: &Facts<'_>) -> Option<f64> {
    let radius = thinnest_free(facts)?;
    let contact_time = facts.dem.map(|_| facts.steps.contact_time).filter(|time| time.is_finite())?;
    Some(facts.speeds.approach * contact_time / (std::f64::consts::PI * radius))
}

/// The solver's own bound on a fixed step knows the speeds that the scene names; those that follow from it
/// count too. What a drive leads to only warns: grains that resist it may hold the fluid far below.
pub(super) fn with_speeds(bound: &SolverBound, facts: &Facts<'_>) -> SolverBound {
    let spacing = facts.fluid.map_or(0.0, |fluid| fluid.spacing);
    let factor = facts.speeds.largest() / spacing;
    if bound.name != CFL || bound.measure != Measure::Window || spacing <= 0.0 || factor <= bound.factor {
        return bound.clone();
    }
    let why = format!(
        "the time scheme of the convection is unstable beyond it; U = {} m/s follows from the scene \
         (settling, drive, fall)",
        Short(factor * spacing)
    );
    let without_drive = bound.factor.max(facts.speeds.undriven / spacing);
    let holds = without_drive * facts.steps.measure(bound.measure) <= bound.limit;
    let level = if holds { Level::Warn } else { bound.level };
    SolverBound { factor, why, level, ..bound.clone() }
}
