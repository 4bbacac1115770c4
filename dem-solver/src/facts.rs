//! Facts for the coupler: sub-step, bounds, notices.

use bedload_scene::{CheckedScene, SceneError, Wall};
use protocol::facts::DemFacts;

use crate::bounds::{self, LARGEST_DASHPOT};
use crate::grain::{Grain, Shape};
use crate::laws::linear::LinearSpringDashpot;
use crate::motion::{Motion, Vec3};
use crate::spec::{DemSpec, Integrator};
use crate::takes_bulk;

const LEAST_STEPS: f64 = DemFacts::LEAST_CONTACT_STEPS;

/// What the scene says of the sub-step.
pub(crate) struct StepChoice {
    /// Sub-step, s.
    pub(crate) dt: Option<f64>,
    pub(crate) steps_per_contact: f64,
    /// Whether sub-steps above t_c/10 are accepted.
    pub(crate) coarse: bool,
}

/// Facts of a checked spec; `resolved` is the section with all its defaults.
pub(crate) fn facts(
    scene: &CheckedScene,
    spec: &DemSpec,
    step: &StepChoice,
    resolved: toml::Table,
) -> Result<DemFacts, SceneError> {
    let can_touch = scene.grains.len() > 1 || !spec.walls.is_empty();
    let contact_time = contact_time(spec).filter(|_| can_touch).unwrap_or(f64::INFINITY);
    for (key, value) in [("dem.dt", step.dt), ("dem.steps_per_contact", Some(step.steps_per_contact))] {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(scene.source.error(
                key,
                format!("is {value}; allowed: a finite number > 0"),
                "give a positive number, or leave the key out",
            ));
        }
    }
    let dt =
        step.dt.unwrap_or(contact_time / step.steps_per_contact).min(gravity_step(scene, spec, can_touch));
    // In a coupled run the coupler divides windows on its own, and judges what comes out.
    let judged = scene.scene.medium.is_none() && !step.coarse;
    let key = if step.dt.is_some() { "dem.dt" } else { "dem.steps_per_contact" };
    scene.step_changes_time(key, dt)?;
    if judged && contact_time < LEAST_STEPS * dt * (1.0 - 1e-9) {
        let steps = contact_time / dt;
        return Err(scene.source.error(
            key,
            format!(
                "makes sub-steps of {dt} s, t_c/{steps:.3} of the contact time {contact_time} s; allowed: \
                 t_c/{LEAST_STEPS} at most"
            ),
            "shorten the sub-step, or accept wrong rebounds with dem.allow_coarse_dt = true",
        ));
    }
    let grains = spec.grains.len();
    let tangential_rate = least_mass(spec)
        .zip(spec.contact.linear())
        .map_or(0.0, |(mass, law)| law.tangential_rate(0.5 * mass));
    let facts = DemFacts {
        grains: grains as u64,
        memory: 4096 + 1024 * grains as u64,
        dt,
        contact_time,
        coarse_dt: step.coarse,
        interaction_range: spec.range(),
        values_over_time: true,
        bounds: bounds::of(scene, spec, contact_time, tangential_rate),
        field_bytes: field_bytes(scene, spec),
        // State, contacts of a bed, and the last motion.
        checkpoint_bytes: 1000 + 440 * grains as u64,
        substep_cost: cost(spec) * grains as f64,
        notices: notices(scene, spec),
        resolved,
    };
    let number = bounds::packing_rate(tangential_rate, grains).map(|rate| rate * dt);
    if let Some(number) = number.filter(|number| judged && *number > LARGEST_DASHPOT) {
        let most = dt * LARGEST_DASHPOT / number;
        return Err(scene.source.error(
            key,
            format!(
                "makes sub-steps of {dt:.3e} s, with which a packing of these grains never comes to rest \
                 (γ_t dt/m = {number:.3}, allowed: {LARGEST_DASHPOT}); allowed: {most:.3e} s, t_c/{:.0}",
                (contact_time / most).ceil()
            ),
            "shorten the sub-step, lower dem.contact.damping_ratio, or accept it with dem.allow_coarse_dt = true",
        ));
    }
    Ok(facts)
}

/// The longest sub-step of a grain that can touch nothing, where gravity changes, s: only symplectic Euler
/// takes the exact path of a free flight.
fn gravity_step(scene: &CheckedScene, spec: &DemSpec, can_touch: bool) -> f64 {
    if can_touch || spec.integrator == Integrator::SymplecticEuler {
        return f64::INFINITY;
    }
    let (gravity, until) = (&spec.gravity, scene.scene.until);
    let steepest = gravity.largest(until) / (16.0 * gravity.fastest(until));
    gravity.longest_step(0.0).min(steepest).max(1e-5 * until)
}

/// Cost of a grain and sub-step, s, as measured: with films (114 to 145 ns), without (38 ns: `repose`), and
/// with the engine for many grains, where a bed rests (24 to 29 ns: `collapse-2d`, `packing-8000`) or flows
/// (52 to 66 ns: `collapse-beads`, `incline`, `beverloo`); a gas takes 8 ns (`haff`).
fn cost(spec: &DemSpec) -> f64 {
    match (spec.lubrication_model().is_some(), takes_bulk(spec)) {
        (true, _) => 1.2e-7,
        (false, false) => 5e-8,
        (false, true) => 4e-8,
    }
}

/// Bytes of the files of an instant: 18 numbers for a grain, and for the outline of a body 13 and four a
/// corner.
fn field_bytes(scene: &CheckedScene, spec: &DemSpec) -> u64 {
    let corners: usize = scene.grains.iter().filter_map(|grain| Some(grain.outline()?.corners().len())).sum();
    let bodies = scene.grains.iter().filter(|grain| grain.outline().is_some()).count();
    let head = if bodies > 0 { 2 * 1300 } else { 1300 };
    (head + 144 * spec.grains.len() + 104 * bodies + 32 * corners) as u64
}

/// What a scene says and probably does not mean.
fn notices(scene: &CheckedScene, spec: &DemSpec) -> Vec<String> {
    let mut notices = Vec::new();
    let films = spec.lubrication_model().is_some_and(|model| model.tangential);
    if films && spec.shape == Shape::Disc && free(spec).count() > 1 {
        notices.push(
            "dem.lubrication.tangential = true between discs: where it is stable was not measured (one of 32 \
             beds trembled)"
                .into(),
        );
    }
    let slips = |law: &LinearSpringDashpot| {
        law.friction > 0.0 && law.stiffness_ratio == 0.0 && law.damping_ratio == 0.0
    };
    if spec.contact.linear().is_some_and(slips) {
        notices.push(
            "dem.contact.friction has no effect: stiffness_ratio and damping_ratio are 0, and nothing holds along \
             the tangent"
                .into(),
        );
    }
    notices.extend(twice(scene));
    notices
}

/// Two walls in one plane that face the same way: a grain touches both.
fn twice(scene: &CheckedScene) -> Option<String> {
    let walls = scene.contact_walls();
    let unit = |wall: &Wall| Vec3::from(wall.normal).normalize();
    let length = scene.grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let one_plane = |one: &Wall, other: &Wall| {
        let between = Vec3::from(one.point) - Vec3::from(other.point);
        let together = one.from < other.until && other.from < one.until;
        together && unit(one).dot(&unit(other)) > 1.0 - 1e-12 && between.dot(&unit(one)).abs() < 1e-9 * length
    };
    let (one, other) = walls.iter().enumerate().find_map(|(i, one)| {
        let mut after = walls.iter().enumerate().skip(i + 1);
        after.find(|(_, other)| one_plane(one, other)).map(|(j, _)| (i, j))
    })?;
    let name = |wall: usize| match wall.checked_sub(scene.scene.walls.len()) {
        None => format!("walls[{wall}]"),
        Some(_) => format!("a face of the box at {:?}", walls[wall].point),
    };
    Some(format!(
        "{} and {} lie in one plane at the start: grains touch both, with twice the force; where one is meant, give \
         the face `contact = false`",
        name(one),
        name(other)
    ))
}

fn free(spec: &DemSpec) -> impl Iterator<Item = &Grain> {
    spec.grains.iter().filter(|grain| grain.motion == Motion::Free)
}

/// Least mass that a point of contact of a grain can have, kg: a body that is not round turns away, 1/m* =
/// 1/m + R²/I.
fn contact_mass(spec: &DemSpec, grain: &Grain) -> f64 {
    let (mass, inertia) = grain.mass_and_inertia(spec.shape, &spec.outlines);
    let turns = grain.outline.is_some() && grain.free.rotation[1];
    if turns { 1.0 / (1.0 / mass + grain.radius * grain.radius / inertia) } else { mass }
}

/// Least mass at a point of contact of the grains that are free, kg.
fn least_mass(spec: &DemSpec) -> Option<f64> {
    free(spec).map(|grain| contact_mass(spec, grain)).min_by(f64::total_cmp)
}

/// Shortest contact of all that can happen: between the two lightest grains. None of a law without a contact
/// time.
fn contact_time(spec: &DemSpec) -> Option<f64> {
    Some(spec.contact.linear()?.contact_time_of(0.5 * least_mass(spec)?))
}
