//! What the coupler is told of a scene's grains: sub-step, bounds, engine.

use bedload_scene::{CheckedScene, SceneError};
use protocol::facts::DemFacts;

use crate::bounds::{self, LARGEST_DASHPOT};
use crate::bulk::requirements::{Choice, FROM, choice};
use crate::grain::{Grain, Shape};
use crate::lubrication::settings::LubricationIntegration;
use crate::motion::Motion;
use crate::spec::{DemSpec, Engine};

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
    let dt = step.dt.unwrap_or(contact_time / step.steps_per_contact);
    // In a coupled run the coupler divides windows on its own, and judges what comes out.
    let judged = scene.scene.medium.is_none() && !step.coarse;
    let key = if step.dt.is_some() { "dem.dt" } else { "dem.steps_per_contact" };
    if judged && contact_time < LEAST_STEPS * dt * (1.0 - 1e-9) {
        let steps = contact_time / dt;
        return Err(scene.source.error(
            key,
            format!(
                "makes sub-steps of {dt} s, t_c/{steps:.3} of the contact time {contact_time} s; allowed: t_c/{LEAST_STEPS} at most"
            ),
            "shorten the sub-step, or accept wrong rebounds with dem.allow_coarse_dt = true",
        ));
    }
    let grains = spec.grains.len();
    let tangential_rate = least_mass(spec).map_or(0.0, |mass| spec.contact.tangential_rate(0.5 * mass));
    let limits = bounds::Limits { contact_time, tangential_rate, lubrication_dt: lubrication_dt(spec) };
    let facts = DemFacts {
        grains: grains as u64,
        memory: 4096 + 1024 * grains as u64,
        dt,
        contact_time,
        coarse_dt: step.coarse,
        interaction_range: spec.range(),
        bounds: bounds::of(scene, spec, &limits),
        substep_cost: 2e-7 * grains as f64,
        notices: engine_notice(scene, spec).into_iter().chain(sliding_notice(spec)).collect(),
        resolved,
    };
    let number = bounds::packing_rate(tangential_rate, grains).map(|rate| rate * dt);
    if let Some(number) = number.filter(|number| judged && *number > LARGEST_DASHPOT) {
        let most = dt * LARGEST_DASHPOT / number;
        return Err(scene.source.error(
            key,
            format!(
                "makes sub-steps of {dt:.3e} s, with which a packing of these grains never comes to rest (γ_t dt/m = {number:.3}, \
                 allowed: {LARGEST_DASHPOT}); allowed: {most:.3e} s, t_c/{:.0}",
                (contact_time / most).ceil()
            ),
            "shorten the sub-step, lower dem.contact.damping_ratio, or accept it with dem.allow_coarse_dt = true",
        ));
    }
    Ok(facts)
}

/// Which engine `auto` takes, and why.
fn engine_notice(scene: &CheckedScene, spec: &DemSpec) -> Option<String> {
    if spec.engine != Engine::Auto || spec.grains.is_empty() {
        return None;
    }
    let Choice { engine, why } = choice(spec);
    let (name, later) = match engine {
        Engine::Bulk if scene.present() < FROM => ("bulk", ", once 256 of them are inserted"),
        Engine::Bulk => ("bulk", ""),
        _ => ("general", ""),
    };
    Some(format!("dem.engine = \"auto\" takes the {name} engine: {why}{later}"))
}

/// Films of discs that slide past each other: no map says where they are stable.
fn sliding_notice(spec: &DemSpec) -> Option<String> {
    let films = spec.lubrication_model().is_some_and(|model| model.tangential);
    (films && spec.shape == Shape::Disc && free(spec).count() > 1).then(|| {
        "dem.lubrication.tangential = true between discs: where it is stable was not measured (one of 32 beds trembled)".into()
    })
}

fn free(spec: &DemSpec) -> impl Iterator<Item = &Grain> {
    spec.grains.iter().filter(|grain| grain.motion == Motion::Free)
}

/// Least mass that a point of contact of a grain can have, kg: a body that is not round turns away, 1/m* = 1/m + R²/I.
fn contact_mass(spec: &DemSpec, grain: &Grain) -> f64 {
    let (mass, inertia) = grain.mass_and_inertia(spec.shape, &spec.outlines);
    let turns = grain.outline.is_some() && grain.free.rotation[1];
    if turns { 1.0 / (1.0 / mass + grain.radius * grain.radius / inertia) } else { mass }
}

/// Least mass at a point of contact of the grains that are free, kg.
fn least_mass(spec: &DemSpec) -> Option<f64> {
    free(spec).map(|grain| contact_mass(spec, grain)).min_by(f64::total_cmp)
}

/// Shortest contact of all that can happen: between the two lightest grains and between the two
/// smallest, one of which may be a wall.
fn contact_time(spec: &DemSpec) -> Option<f64> {
    let mass = least_mass(spec)?;
    let radius = free(spec).map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    // m*/R* is least for two equal grains, R* alone largest at a wall: the shorter of both.
    let pair = spec.contact.contact_time(0.5 * mass, 0.5 * radius)?;
    let wall = spec.contact.contact_time(0.5 * mass, radius)?;
    Some(pair.min(wall))
}

/// Bound of explicit lubrication on the sub-step: 2 (η + δ) m/(6πμR²) at δ = 0, over all free grains.
fn lubrication_dt(spec: &DemSpec) -> f64 {
    let Some(explicit) =
        spec.lubrication.settings().filter(|it| it.integration == LubricationIntegration::Explicit)
    else {
        return f64::INFINITY;
    };
    let limit = free(spec).map(|grain| {
        let mass = spec.shape.mass(grain.radius, grain.density);
        let r = grain.radius;
        2.0 * explicit.roughness * r * mass / (6.0 * std::f64::consts::PI * spec.viscosity * r * r)
    });
    limit.fold(f64::INFINITY, f64::min)
}
