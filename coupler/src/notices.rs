//! What a scene costs or does, where it breaks no bound but is hardly meant so.

use bedload_scene::{
    CheckedScene, Face, Grain, InitialVelocity, Motion, ObservedPlanes, OverTime, Shape, Total, Wall,
    WallKind, changing,
};
use protocol::facts::DemFacts;
use protocol::scheme::{Iterations, Scheme};
use serde_json::json;

use crate::bounds::{Facts, largest_overlap};
use crate::keys;
use crate::number::{AXES, Short};
use bedload_scene::speeds::{drive, volume, weights};

/// Overlap over radius that is hardly felt: a contact time that allows no more is shorter than it need be.
const LITTLE: f64 = 0.01;
/// A shorter contact time than needed is worth a word from this estimated cost on, s …
const COSTLY: f64 = 600.0;
/// … and from this ratio to the one that would do.
const MUCH_SHORTER: f64 = 10.0;
/// Sides of a cell that differ by this part are no cube.
const CUBE: f64 = 0.01;
/// St of bounces in which roughness was measured to count as it says.
const ROUGH: [f64; 2] = [28.0, 123.0];
/// Windows that a period of a driven oscillation should have.
const PERIOD: f64 = 50.0;
/// Longest windows after a release from rest, R²/ν.
const LAYER: f64 = 0.02;
/// Least St with a bounce at all, and the largest in which roughness is worth a word.
const BOUNCES: [f64; 2] = [10.0, 200.0];

/// Courant number where the scene names none.
const USUAL_COURANT: f64 = 0.5;

/// End of the clock of a log, s.
const CLOCK: f64 = 1.8446744e10;

/// Restitutions that differ by no more are the same.
const SAME_RESTITUTION: f64 = 0.002;

pub(crate) fn of(facts: &Facts<'_>, cost: f64, windows: f64) -> Vec<String> {
    [
        substep(facts),
        oscillation(facts),
        release(facts),
        contact_time(facts, cost, windows),
        unbalanced_gravity(facts.scene),
        cells(facts.scene),
        roughness(facts),
        restitution(facts),
        moving_walls(facts.scene),
        leaving(facts.scene),
        no_film(facts.scene),
        late(facts.scene),
        through_walls(facts.scene),
        without_grains(facts),
        without_peer(facts),
        log_clock(facts),
        iterations(facts),
        courant(facts),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Times that the run does not reach.
fn late(scene: &CheckedScene) -> Option<String> {
    let (scene, until) = (&scene.scene, scene.scene.until);
    let (planes, substeps) = (scene.observe.planes.iter(), scene.observe.substeps.iter());
    let times = scene.observe.fields_at.iter().map(|at| ("observe.fields_at", *at));
    let times = times.chain([("observe.every", scene.observe.every)]);
    let times = times.chain(scene.observe.fields_every.map(|every| ("observe.fields_every", every)));
    let times = times.chain(planes.clone().map(|planes| ("observe.planes.from", planes.from)));
    let times = times.chain(planes.clone().map(|planes| ("observe.planes.every", planes.every)));
    // The first sample that counts, where neither is late.
    let first = |planes: &ObservedPlanes| (planes.from / planes.every * (1.0 - 1e-9)).ceil() * planes.every;
    let both = planes.clone().filter(|planes| planes.from.max(planes.every) <= until);
    let times =
        times.chain(both.map(|planes| ("observe.planes, first sample from `from` on", first(planes))));
    let times = times.chain(planes.flat_map(|planes| planes.at.iter().map(|at| ("observe.planes.at", *at))));
    let times = times.chain(substeps.map(|substeps| ("observe.substeps.from", substeps.from)));
    let times = times.chain(scene.walls.iter().map(|wall| ("walls.from", wall.from)));
    let times = times.chain(scene.insertions.iter().map(|insertion| ("insertions.start", insertion.start)));
    let times = times.chain(scene.stop_when.iter().map(|stop| ("stop_when.after", stop.after)));
    let late = times.filter(|(_, time)| *time > until * (1.0 + 1e-9));
    let late: Vec<String> = late.map(|(key, time)| format!("{key}: {} s", Short(time))).collect();
    (!late.is_empty()).then(|| {
        format!(
            "{} is after the end of the run, until = {} s: nothing comes of it; raise until, or take it out",
            late.join(", "),
            Short(until)
        )
    })
}

/// A flow at the start that goes through faces which let none pass.
fn through_walls(scene: &CheckedScene) -> Option<String> {
    let domain = &scene.scene.domain;
    let along = match &scene.scene.medium.as_ref()?.initial {
        InitialVelocity::Uniform { velocity } => *velocity,
        InitialVelocity::Shear { direction, rate, .. } => {
            std::array::from_fn(|c| if c == direction.component() { *rate } else { 0.0 })
        }
        _ => return None,
    };
    let closed = |face: &Face| matches!(face.kind, WallKind::NoSlip | WallKind::FreeSlip);
    let axes = (0..domain.dimensions()).filter(|axis| along[domain.geometry.component(*axis)] != 0.0);
    let mut axes = axes.filter(|axis| {
        domain.boundary(*axis).is_some_and(|faces| faces.lower.iter().chain([&faces.upper]).any(closed))
    });
    axes.next().map(|axis| {
        format!(
            "medium.initial: the flow along {} does not pass the faces there: the first window takes out what \
             would; leave that component at 0, or change the faces",
            domain.geometry.axes()[axis].name()
        )
    })
}

/// What is asked of the DEM, where none takes part.
fn without_grains(facts: &Facts<'_>) -> Option<String> {
    let observe = &facts.scene.scene.observe;
    let totals = observe.totals.iter().flat_map(|totals| &totals.columns);
    let of_grains = totals.filter(|column| match column {
        Total::Shields | Total::CoordinationNumber => true,
        Total::FluidFlux | Total::WallForce | Total::WallStress => false,
        Total::GrainFlux | Total::VelocityFlux | Total::BedHeight | Total::MovingGrains => {
            facts.scene.grains.is_empty()
        }
    });
    let columns = of_grains.map(|column| format!("observe.totals.columns {}", json!(column)));
    let profile = observe.profile.iter().map(|_| "observe.profile".to_owned());
    let substeps = observe.substeps.iter().map(|_| "observe.substeps".to_owned());
    let asked: Vec<String> = columns.chain(profile).chain(substeps).collect();
    (facts.dem.is_none() && !asked.is_empty()).then(|| {
        format!(
            "{}: nothing comes of it, as no grain is free and no DEM takes part; take it out",
            asked.join(", ")
        )
    })
}

/// What is said of an exchange, or of a fluid, where there is none.
fn without_peer(facts: &Facts<'_>) -> Option<String> {
    let scene = &facts.scene.scene;
    let exchange = ["scheme", "iterations", "substeps", "max_dt_over_contact_time", "steps_per_contact"];
    let exchange = exchange.iter().filter(|key| scene.coupling.contains_key(**key));
    let keys = exchange.map(|key| format!("coupling.{key}"));
    let fluid = scene.fluid.keys().filter(|_| facts.fluid.is_none()).map(|key| format!("fluid.{key}"));
    let said: Vec<String> = keys.chain(fluid).collect();
    let absent = if facts.fluid.is_none() { "there is no [medium]" } else { "no grain is free" };
    ((facts.fluid.is_none() || facts.dem.is_none()) && !said.is_empty())
        .then(|| format!("{}: no effect, as {absent}: one solver runs alone; take it out", said.join(", ")))
}

/// A run beyond the clock of its log.
fn log_clock(facts: &Facts<'_>) -> Option<String> {
    (facts.coupling.record && facts.scene.scene.until > CLOCK).then(|| {
        format!(
            "until: the clock of exchange.mcap counts 2^64 ns, {} s, and stands from then on, so that viewers \
             put all that is later there; choose a larger unit of time, or coupling.record = false",
            Short(CLOCK)
        )
    })
}

/// How windows are to be repeated, where none is.
fn iterations(facts: &Facts<'_>) -> Option<String> {
    let said = facts.coupling.iterations != Iterations::default();
    let scheme = facts.scheme.filter(|scheme| *scheme != Scheme::Iterated)?;
    said.then(|| {
        format!("coupling.iterations has no effect: the scheme is {scheme}; coupling.scheme = \"iterated\" repeats windows")
    })
}

/// A Courant number beside a fixed step.
fn courant(facts: &Facts<'_>) -> Option<String> {
    let cfl = facts.fluid.filter(|fluid| !fluid.adaptive && !fluid.foreign)?.cfl;
    (cfl != USUAL_COURANT)
        .then(|| format!("fluid.time.cfl = {cfl} has no effect beside fluid.time.dt: leave one of them out"))
}

/// A sub-step that the scene asks for and a coupled run does not take.
fn substep(facts: &Facts<'_>) -> Option<String> {
    let dem = facts.dem.filter(|_| facts.fluid.is_some())?;
    let longest = dem.contact_time / facts.coupling.steps_per_contact;
    // One that was not asked has an infinite one.
    (dem.dt.is_finite() && dem.dt > longest * (1.0 + 1e-9)).then(|| {
        format!(
            "dem.dt: the DEM asks for sub-steps of {} s ({} in a contact time); a coupled run takes at most {} s, \
             t_c/coupling.steps_per_contact = t_c/{}",
            Short(dem.dt),
            Short(dem.contact_time / dem.dt),
            Short(longest),
            Short(facts.coupling.steps_per_contact)
        )
    })
}

/// A driven oscillation that gets few windows a period of a fixed length.
fn oscillation(facts: &Facts<'_>) -> Option<String> {
    facts.fluid.filter(|fluid| !fluid.adaptive)?;
    let frequency =
        |value: &OverTime<_>| if let OverTime::Sine(swing) = value { swing.frequency } else { 0.0 };
    let highest = changing(facts.scene).iter().map(|value| frequency(&value.value)).fold(0.0, f64::max);
    let windows = 1.0 / (highest * facts.steps.dt_fluid);
    (windows < PERIOD).then(|| {
        format!(
            "oscillation: {} windows in a period; with 4 to 9 the amplitude of the force was 5 to 38 % and \
             its phase 32 to 97 degrees off, with 50 it was 1.4 % and 6 degrees: fluid.time.dt = {} s makes \
             {PERIOD}, without fluid.time.dt there are 100",
            Short(windows),
            Short(1.0 / (highest * PERIOD))
        )
    })
}

/// A release from rest in windows of a fixed length, which is long for the boundary layer that grows on the
/// grain.
fn release(facts: &Facts<'_>) -> Option<String> {
    let scene = facts.scene;
    facts.fluid.filter(|fluid| !fluid.adaptive)?;
    let medium = scene.scene.medium.as_ref()?;
    let starts = |grain: &&Grain| {
        grain.motion == Motion::Free && grain.velocity.is_zero() && grain.density != medium.density
    };
    let radius = scene.grains.iter().filter(starts).map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let layer = facts.steps.dt_fluid * medium.kinematic_viscosity() / (radius * radius);
    (scene.scene.largest_gravity() > 0.0 && layer > LAYER).then(|| {
        format!(
            "release: grains start from rest with windows of {} R²/ν; with 0.08 their velocity at 0.1 R²/ν \
             was 12 to 48 % above that of Basset and Boussinesq, with 0.008 it was 1.9 %: where the first \
             moments matter, fluid.time.dt = {} s, or none, which lets the windows grow from there",
            Short(layer),
            Short(0.4 * LAYER * radius * radius / medium.kinematic_viscosity())
        )
    })
}

/// A contact time that costs much and does little.
fn contact_time(facts: &Facts<'_>, cost: f64, windows: f64) -> Option<String> {
    let dem: &DemFacts = facts.dem?;
    let part = largest_overlap(facts).filter(|part| *part > 0.0)?;
    let steps = &facts.steps;
    let longer = LITTLE / part;
    let of_contacts = windows * dem.substep_cost * steps.substeps as f64;
    if longer < MUCH_SHORTER || cost < COSTLY || of_contacts < 0.5 * cost {
        return None;
    }
    Some(format!(
        "contact_time: t_c = {} s asks for {} sub-steps in a window, {} s of the {} s that the run is \
         estimated to cost if they are all taken; grains that meet at U = {} m/s overlap by {:.1e} of a \
         radius, U t_c/(π R). t_c = {} s lets them overlap by {} % and costs {} s",
        Short(steps.contact_time),
        steps.substeps,
        Short(of_contacts),
        Short(cost),
        Short(facts.speeds.approach),
        part,
        Short(steps.contact_time * longer),
        Short(100.0 * LITTLE),
        Short(cost - of_contacts + of_contacts / longer)
    ))
}

/// Gravity, or a drive, along an axis along which nothing resists.
fn unbalanced_gravity(scene: &CheckedScene) -> Option<String> {
    let domain = &scene.scene.domain;
    let periodic = |axis: usize| domain.is_periodic(axis);
    let along = (0..domain.dimensions()).filter(|axis| periodic(*axis)).find(|axis| {
        let component = domain.geometry.component(*axis);
        scene.scene.peak_gravity()[component] != 0.0
    })?;
    let held = scene.grains.iter().any(|grain| grain.motion != Motion::Free);
    let faces = (0..domain.dimensions()).filter_map(|axis| domain.boundary(axis));
    let sticks = faces
        .flat_map(|faces| faces.lower.into_iter().chain([faces.upper]))
        .any(|face| face.kind == WallKind::NoSlip && (scene.scene.medium.is_some() || face.contact));
    if held || sticks || !scene.scene.walls.is_empty() {
        return None;
    }
    let name = AXES[domain.geometry.component(along)];
    let until = scene.scene.until;
    let Some(medium) = &scene.scene.medium else {
        let speed = scene.scene.largest_gravity() * until;
        return Some(format!(
            "gravity acts along {name}, which is periodic, and nothing resists: the grains fall for ever, {} \
             m/s at the end; give a wall, or gravity = [0, 0, 0]",
            Short(speed)
        ));
    };
    if medium.flow_rate.is_some() {
        return None;
    }
    // Both phases together: the weight of all that is in the box, and what the scene sets against it.
    let component = domain.geometry.component(along);
    let volume = volume(scene);
    let solid = |weight: &dyn Fn(f64) -> f64| -> f64 {
        scene.grains.iter().map(|grain| weight(grain.density) * grain.volume()).sum::<f64>() / volume
    };
    let excess = solid(&|density| density / medium.density - 1.0) * scene.scene.peak_gravity()[component];
    let whole = drive(&scene.scene)[component] + excess;
    if whole.abs() <= 1e-6 * scene.scene.peak_gravity()[component].abs() {
        return None;
    }
    let balance = medium.body_force.peak(until)[component] - whole;
    Some(format!(
        "gravity acts along {name}, which is periodic: no pressure balances it and nothing resists, so fluid \
         and grains accelerate together for ever, to about {} m/s at the end; medium.body_force = {} along \
         {name} balances both phases, medium.flow_rate = {{ axis = \"{name}\", mean_velocity = 0.0 }} holds \
         the mean, and walls carry it",
        Short(whole.abs() * until),
        Short(balance)
    ))
}

/// Walls that move through a fluid, which does not see them.
fn moving_walls(scene: &CheckedScene) -> Option<String> {
    scene.scene.medium.as_ref()?;
    let wall = scene.scene.walls.iter().position(Wall::moves)?;
    Some(format!(
        "walls[{wall}] moves at {} m/s: grains touch it, the fluid does not see it and flows through; a face \
         of the box moves along itself with both, domain.boundary, and a body that moves a fluid is a grain \
         with motion = \"prescribed\"",
        Short(scene.scene.walls[wall].largest_speed(&scene.scene.domain, scene.scene.until))
    ))
}

/// A grain that is held or driven, less than two cells from what is held or driven otherwise: films act on
/// free grains.
fn no_film(scene: &CheckedScene) -> Option<String> {
    scene.scene.medium.as_ref()?;
    let domain = &scene.scene.domain;
    let near = 2.0 * (0..domain.dimensions()).map(|axis| domain.spacing(axis)).fold(0.0, f64::max);
    let moves = |grain: &Grain| !(grain.velocity.is_zero() && grain.spin.is_zero());
    // Beside a body that is not round there are no films.
    let round = |grain: &&Grain| grain.motion != Motion::Free && grain.shape.is_round();
    let led: Vec<&Grain> = scene.grains.iter().filter(round).collect();
    let driven = |grain: &&&Grain| grain.motion == Motion::Prescribed && moves(grain);
    let rests = led.iter().filter(|grain| !driven(grain)).take(64);
    let candidates = led.iter().filter(driven).take(64).chain(rests);
    let times = (0..=16).map(|k| scene.scene.until * f64::from(k) / 16.0);
    let velocity =
        |of: &Grain| if of.motion == Motion::Fixed { OverTime::default() } else { of.velocity.clone() };
    let at = |of: &Grain, t: f64| {
        let way = velocity(of).integral(t);
        std::array::from_fn(|c| of.position[c] + way[c])
    };
    // To the nearest image.
    let periods = domain.periods();
    let apart =
        |c: usize, way: f64| way - periods[c].map_or(0.0, |(_, length)| length * (way / length).round());
    let walls = scene.contact_walls();
    let to_wall = |grain: &Grain, t: f64| {
        let gaps = walls.iter().filter(|wall| wall.velocity != velocity(grain)).map(|wall| {
            let (x, [point, normal]): ([f64; 3], _) = (at(grain, t), wall.at(t));
            (0..3).map(|c| (x[c] - point[c]) * normal[c]).sum::<f64>() - grain.radius
        });
        gaps.map(f64::abs).fold(f64::INFINITY, f64::min)
    };
    let to_grains = |grain: &Grain, t: f64| {
        let others = led.iter().filter(|other| velocity(other) != velocity(grain));
        let gaps = others.map(|other| {
            let [a, b]: [[f64; 3]; 2] = [at(grain, t), at(other, t)];
            (0..3).map(|c| apart(c, a[c] - b[c]).powi(2)).sum::<f64>().sqrt() - grain.radius - other.radius
        });
        gaps.map(f64::abs).fold(f64::INFINITY, f64::min)
    };
    let nears = |grain: &&&Grain| times.clone().any(|t| to_wall(grain, t).min(to_grains(grain, t)) < near);
    let grain = candidates.into_iter().find(nears)?;
    let number = scene.grains.iter().position(|other| std::ptr::eq(other, *grain))?;
    Some(format!(
        "grain {number}, held or driven, passes a wall, or what is held or driven otherwise, nearer than two \
         cells: its force lacks the film that the grid does not resolve, as films act on free grains alone; make \
         it free with a density of 1e6 times the fluid's, or take finer cells"
    ))
}

/// A free grain whose weight or buoyancy leads to a face that no grain touches.
fn leaving(scene: &CheckedScene) -> Option<String> {
    let domain = &scene.scene.domain;
    let walls = scene.contact_walls();
    (0..domain.dimensions()).find_map(|axis| {
        let faces = domain.boundary(axis).filter(|_| !domain.is_periodic(axis))?;
        let component = domain.geometry.component(axis);
        let leads_to = |down: f64| {
            let is_led =
                |grain: &&Grain| weights(scene, grain, component).iter().any(|weight| weight * down > 0.0);
            let grain = scene.grains[..scene.present()].iter().find(is_led)?;
            let face = if down > 0.0 { Some(&faces.upper) } else { faces.lower.as_ref() }?;
            let stops = walls.iter().any(|wall| wall.normal[component] * down < 0.0);
            let name = AXES[component];
            let side = if down > 0.0 { "upper" } else { "lower" };
            let way = if grain.density > scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density) {
                "weight"
            } else {
                "buoyancy"
            };
            let kind = if face.kind == WallKind::NoSlip { "no-slip" } else { "free-slip" };
            (!face.contact && !face.kind.is_open() && !stops).then(|| {
                format!(
                    "{way} leads grains to the {side} face of {name}, which is {kind} and no wall to them: \
                     they leave the box there; {name}_{side} = {{ type = \"{kind}\", contact = true }} stops \
                     them"
                )
            })
        };
        [-1.0, 1.0].into_iter().find_map(leads_to)
    })
}

/// Cells that are no cubes.
fn cells(scene: &CheckedScene) -> Option<String> {
    let domain = &scene.scene.domain;
    if domain.cells.is_empty() || scene.scene.medium.is_none() || scene.grains.is_empty() {
        return None;
    }
    let sides = || (0..domain.dimensions()).map(|axis| domain.spacing(axis));
    let (least, most) = (sides().fold(f64::INFINITY, f64::min), sides().fold(0.0, f64::max));
    if most <= least * (1.0 + CUBE) {
        return None;
    }
    Some(format!(
        "the cells are no cubes, {} to {} m: the mask is as thick as the cell is wide along the normal of \
         the surface, so a grain is sharper along one axis than along the other; films and D/Δx count the \
         widest side, time steps the narrowest. Masks and films were measured with cubes only: domain.cells \
         in the ratio of the sides of the box makes cubes",
        Short(least),
        Short(most)
    ))
}

/// What the roughness, which is seldom known, makes of a bounce: with a film of −6πμR²U/(δ + η) on the way in
/// and out the restitution loses (1 + e) ln(δ₀/η)/St (Davis, Serayssol & Hinch 1986).
fn roughness(facts: &Facts<'_>) -> Option<String> {
    let scene = facts.scene;
    if scene.grains.len() < 2 && scene.contact_walls().is_empty() {
        return None;
    }
    let medium = scene.scene.medium.as_ref()?;
    let of = |section: &str, key: &str| facts.dem?.resolved.get(section)?.get(key)?.as_float();
    let rough = of("lubrication", "roughness")?;
    let dry = of("contact", "restitution").unwrap_or(1.0);
    let spheres =
        scene.grains.iter().filter(|grain| grain.motion == Motion::Free && grain.shape == Shape::Sphere);
    let stokes = spheres.map(|grain| {
        let mass = grain.density + 0.5 * medium.density;
        mass * facts.speeds.approach * 2.0 * grain.radius
            / (9.0 * medium.density * medium.kinematic_viscosity())
    });
    let stokes = stokes.fold(0.0, f64::max);
    if !(BOUNCES[0]..=BOUNCES[1]).contains(&stokes) {
        return None;
    }
    let source = if keys::look_up(scene, keys::ROUGHNESS).is_some() {
        "stands in the scene"
    } else {
        "is the default, which is that of Izard et al. 2014 and need not be that of these grains: give \
         dem.lubrication.roughness"
    };
    let range = if (ROUGH[0]..=ROUGH[1]).contains(&stokes) { "" } else { "; not measured at this St" };
    Some(format!(
        "roughness: grains that meet at U = {} m/s do so at St = {}, where ten times the roughness raises \
         the restitution by about {}, (1 + e) ln 10/St (films alone, Davis, Serayssol & Hinch 1986; 0.88 to \
         0.94 of it were measured at St = {} to {}{range}); η/R = {rough} {source}",
        Short(facts.speeds.approach),
        Short(stokes),
        Short((1.0 + dry) * std::f64::consts::LN_10 / stokes),
        ROUGH[0],
        ROUGH[1],
    ))
}

/// A restitution that the form of the contact law does not give back: docs/equations.md (7).
fn restitution(facts: &Facts<'_>) -> Option<String> {
    let contact = facts.dem?.resolved.get("contact")?;
    let asked = contact.get("restitution")?.as_float()?;
    let r = -asked.ln() / std::f64::consts::PI;
    let given = (-r * (std::f64::consts::PI - (2.0 * r).atan2(1.0 - r * r))).exp();
    let printed = contact.get("form")?.as_str()? == "izard-2014";
    (printed && (given - asked).abs() > SAME_RESTITUTION).then(|| {
        format!(
            "restitution: {asked} is asked for; dem.contact.form = \"izard-2014\", whose force is cut off \
             where it would pull, gives back {:.3}; \"exact-restitution\" gives back {asked}",
            given
        )
    })
}
