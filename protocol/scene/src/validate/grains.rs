//! Grains as they begin: alone, in the grid, and from each other.

use super::check::{Check, finite, positive};
use super::missing;
use crate::domain::{Axis, Geometry, InitialVelocity, WallKind};
use crate::error::SceneError;
use crate::grains::{Freedom, Grain, Motion};
use crate::shared::Scene;
use crate::source::SceneSource;
use bedload_outline::Outline;
use protocol::facts::DemFacts;

/// Key of grain `index` where it is written out, of its file, layer, group or insertion where it is not.
fn grain_key(scene: &Scene, index: usize, name: &str) -> String {
    let written = scene.grains.len();
    if index < written {
        format!("grains[{index}].{name}")
    } else if scene.grain_files.is_empty() && scene.groups.is_empty() {
        if scene.rough_walls.is_empty() { "insertions" } else { "rough_walls" }.to_owned()
    } else if scene.grain_files.is_empty() && scene.rough_walls.is_empty() {
        let mut end = written;
        let group = scene.groups.iter().position(|group| {
            end += group.count;
            index < end
        });
        format!("groups[{}]", group.unwrap_or(0))
    } else if scene.grain_files.is_empty() {
        "rough_walls".to_owned()
    } else {
        "grain_files".to_owned()
    }
}

/// Each grain alone, and against the box, the walls and the other grains.
///
/// Grains from `present` on are inserted later, where there is room then.
pub(crate) fn grains(scene: &Scene, grains: &[Grain], present: usize, source: &SceneSource) -> Check {
    source.refuse_if(
        grains.is_empty() && scene.medium.is_none(),
        "grains",
        "the scene has neither fluid nor grains",
        "add [medium] or [[grains]]",
    )?;
    for (index, grain) in grains[..present].iter().enumerate() {
        one(scene, index, grain, source)?;
    }
    if from_state(scene) { Ok(()) } else { apart(scene, &grains[..present], source) }
}

/// Whether the places of the grains are those of another run, which the DEM reads and judges.
fn from_state(scene: &Scene) -> bool {
    scene.medium.is_none() && scene.dem.contains_key("initial_state")
}

fn one(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let key = |name: &str| grain_key(scene, index, name);
    positive(source, &key("radius"), grain.radius)?;
    positive(source, &key("density"), grain.density)?;
    finite(source, &key("position"), &grain.position)?;
    let norm: f64 = grain.orientation.iter().map(|q| q * q).sum();
    if (norm - 1.0).abs() > 1e-6 || norm.is_nan() {
        let message = format!("{:?} has norm² {norm}", grain.orientation);
        return Err(source.error(&key("orientation"), message, "give a unit quaternion (w, x, y, z)"));
    }
    let initial = scene.medium.as_ref().map(|medium| &medium.initial);
    source.refuse_if(
        grain.with_fluid && matches!(initial, None | Some(InitialVelocity::Run { .. })),
        &key("with_fluid"),
        "starts a grain with a fluid whose velocity the scene does not say",
        "give [medium] with an `initial` other than \"run\", or leave the key out and give velocities",
    )?;
    source.refuse_if(
        grain.with_fluid && grain.motion != Motion::Free,
        &key("with_fluid"),
        "starts a grain with the fluid that is fixed or prescribed",
        "leave it out, or leave out `motion`",
    )?;
    let geometry = scene.domain.geometry;
    if geometry == Geometry::Axisymmetric && grain.position[..2] != [0.0; 2] {
        let message = format!("{:?} is off the axis", grain.position);
        return Err(source.error(&key("position"), message, "an axisymmetric grain has x = y = 0"));
    }
    if geometry == Geometry::Plane && grain.position[1] != 0.0 {
        let message = format!("{:?} is out of the plane (x, z)", grain.position);
        return Err(source.error(&key("position"), message, "set y = 0"));
    }
    // The key of a grain of a table is that of its file.
    let named = |name: &str, checked: Check| {
        checked.map_err(|error| match error.key.ends_with(name) {
            true => error,
            false => SceneError { message: format!("{name} of grain {index} {}", error.message), ..error },
        })
    };
    named("velocity", missing::along_axis(&grain.velocity, geometry, &key("velocity"), source))?;
    named("spin", missing::of_spin(&grain.spin, geometry, &key("spin"), source))?;
    held(scene, index, grain, source)?;
    led(scene, index, grain, source)?;
    clear_of_faces(scene, index, grain, source)?;
    inside(scene, index, grain, source)?;
    resolved(scene, index, grain, source)
}

/// What is held has no motion of its own.
fn held(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let key = |name: &str| grain_key(scene, index, name);
    source.refuse_if(
        grain.motion == Motion::Prescribed && !grain.locked.is_empty(),
        &key("locked"),
        "locks a prescribed grain, which moves as `velocity` and `spin` say",
        "leave it out, and give velocities of zero where nothing moves",
    )?;
    if grain.motion == Motion::Prescribed {
        return Ok(());
    }
    let along = [Freedom::X, Freedom::Y, Freedom::Z];
    let about = [Freedom::SpinX, Freedom::SpinY, Freedom::SpinZ];
    for (name, value, axes) in [("velocity", &grain.velocity, along), ("spin", &grain.spin, about)] {
        let start = value.start();
        let held = |c: &usize| grain.motion == Motion::Fixed || grain.locked.contains(&axes[*c]);
        source.refuse_if(
            (0..3).filter(held).any(|c| start[c] != 0.0),
            &key(name),
            format_args!("is {start:?}, but grain {index} is fixed or locked there"),
            "leave it out, or write motion = \"prescribed\" for a grain that moves as it says",
        )?;
    }
    Ok(())
}

/// Times of a run at which the place of a driven grain is looked at.
const INSTANTS: u32 = 256;

/// What is driven through a fluid does not pass a face that grains touch.
fn led(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    if grain.motion != Motion::Prescribed || grain.velocity.is_zero() || scene.medium.is_none() {
        return Ok(());
    }
    let (limits, open) = (scene.domain.limits(), scene.domain.open_limits());
    for t in (1..=INSTANTS).map(|k| scene.until * f64::from(k) / f64::from(INSTANTS)) {
        let way = grain.velocity.integral(t);
        for c in 0..3 {
            let x = grain.position[c] + way[c];
            let [below, above] = [limits[c][0] - grain.radius - x, x - limits[c][1] - grain.radius];
            if (below > 0.0 && open[c][0].is_infinite()) || (above > 0.0 && open[c][1].is_infinite()) {
                let name = ["x", "y", "z"][c];
                let message = format!(
                    "drives grain {index} through a wall: at t = {t} s it is at {name} = {x}, a radius outside \
                     the box"
                );
                let remedy = "let it turn back or stop, or end the run before";
                return Err(source.error(&grain_key(scene, index, "velocity"), message, remedy));
            }
        }
    }
    Ok(())
}

/// Part of its reach by which a grain that moves along a face may stand behind it.
const BEHIND: f64 = 0.05;

/// What does not move keeps clear of faces through which fluid leaves: as much leaves as enters, so that the
/// face drives fluid through the grain, and the force that stops it grows as the window gets shorter. What
/// moves along a free-slip face keeps clear of it: it would cut off a part of its force, and none of its
/// mass.
fn clear_of_faces(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    for axis in (0..domain.dimensions()).filter(|_| scene.medium.is_some()) {
        let Some(faces) = domain.boundary(axis) else { continue };
        let component = domain.geometry.component(axis);
        let freedom = [Freedom::X, Freedom::Y, Freedom::Z][component];
        let stands = match grain.motion {
            Motion::Free => grain.locked.contains(&freedom),
            Motion::Fixed => true,
            Motion::Prescribed => grain.velocity.is_zero(),
        };
        let sides =
            [(faces.lower.as_ref(), -1.0, domain.lower[axis]), (Some(&faces.upper), 1.0, domain.upper[axis])];
        for (face, side, at) in sides {
            let is_outflow = face.is_some_and(|face| face.kind == WallKind::Outflow);
            let mut direction = [0.0; 3];
            direction[component] = side;
            let reach = grain.reach_along(direction);
            let left = side * (at - grain.position[component]) - reach;
            source.refuse_if(
                stands && is_outflow && left < 0.0,
                &grain_key(scene, index, "position"),
                format_args!("puts grain {index}, which does not move, {} m into an outflow face", -left),
                "end what stands before the face, by a cell or more",
            )?;
            let passes = face.is_some_and(|face| face.kind == WallKind::FreeSlip && !face.contact);
            source.refuse_if(
                grain.motion == Motion::Free && stands && passes && left < -BEHIND * reach,
                &grain_key(scene, index, "position"),
                format_args!(
                    "puts grain {index}, which stays there, {} m behind a free-slip face, where no fluid acts on it",
                    -left
                ),
                "move it in, or take the whole box where the face is a plane of symmetry",
            )?;
        }
    }
    Ok(())
}

fn inside(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    for axis in 0..domain.dimensions() {
        let component = domain.geometry.component(axis);
        let x = grain.position[component];
        let (lower, upper) = (domain.lower[axis], domain.upper[axis]);
        if domain.is_beyond(axis, &grain.position) {
            let folded = lower + (x - lower).rem_euclid(upper - lower);
            let name = ["x", "y", "z"][component];
            let fold = format!("{name} is periodic: write its image in the box, {name} = {folded}");
            let remedy =
                if domain.is_periodic(axis) { &*fold } else { "move the grain in, or enlarge [domain]" };
            let message = format!(
                "{:?} of grain {index} is outside the box {lower}..{upper} along {:?}",
                grain.position,
                domain.geometry.axes()[axis]
            );
            return Err(source.error(&grain_key(scene, index, "position"), message, remedy));
        }
    }
    if from_state(scene) {
        return Ok(());
    }
    let mut planes = scene.walls.clone();
    planes.retain(|wall| wall.from <= 0.0);
    planes.extend(domain.contact_faces());
    let half = grain.half_width();
    for wall in &planes {
        let length: f64 = wall.normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        let gap = (0..3).map(|a| (grain.position[a] - wall.point[a]) * wall.normal[a]).sum::<f64>() / length
            - grain.reach_along(wall.normal.map(|n| -n / length));
        let (most, words) = deepest(scene, half, half);
        if -gap > most && grain.motion == Motion::Free {
            let message = format!(
                "{:?} puts grain {index} (radius {}) {} into the wall at {:?}; allowed: {words}",
                grain.position, grain.radius, -gap, wall.point
            );
            let remedy = format!("move the grain or the wall{}", going_on(scene));
            return Err(source.error(&grain_key(scene, index, "position"), message, &remedy));
        }
    }
    Ok(())
}

fn resolved(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    if scene.medium.is_none() {
        return Ok(());
    }
    let width = grain.thickness();
    for axis in 0..domain.dimensions() {
        let spacing = domain.spacing(axis);
        if width < 2.0 * spacing {
            let what = if grain.shape.is_round() { "diameter" } else { "least width" };
            let message = format!(
                "grain {index} of {what} {width} has fewer than 2 cells of {spacing} along {:?}",
                domain.geometry.axes()[axis]
            );
            let remedy = format!(
                "the grid does not hold the grain: refine it (cells of {} and less; 8 per {what} and more \
                 for its drag)",
                0.5 * width
            );
            return Err(source.error("domain.cells", message, &remedy));
        }
        if domain.is_periodic(axis) && 2.0 * grain.radius > domain.upper[axis] - domain.lower[axis] {
            let message = format!(
                "grain {index} of diameter {} is larger than the periodic box along {:?}",
                2.0 * grain.radius,
                domain.geometry.axes()[axis]
            );
            return Err(source.error(
                &grain_key(scene, index, "radius"),
                message,
                "enlarge the box, or shrink the grain",
            ));
        }
    }
    if let Some(stretching) = domain.stretching {
        let far = match stretching.axis {
            Axis::R => grain.radius,
            Axis::X => grain.position[0] + grain.radius,
            Axis::Y => grain.position[1] + grain.radius,
            Axis::Z => grain.position[2] + grain.radius,
        };
        if far > stretching.uniform_to {
            return Err(source.error(
                "domain.stretching.uniform_to",
                format!("is {}, but grain {index} reaches to {far}", stretching.uniform_to),
                "let the uniform part hold every grain",
            ));
        }
    }
    Ok(())
}

/// Deepest overlap at the start, m, and what it is in words: 1 % of the (smaller) radius; where the run goes
/// on from another, what that may have ended with.
fn deepest(scene: &Scene, radius: f64, largest: f64) -> (f64, &'static str) {
    let forced = scene.coupling.get("force").and_then(toml::Value::as_array);
    let forced = forced.is_some_and(|names| names.iter().any(|name| name.as_str() == Some("overlap")));
    if !scene.dem.contains_key("initial_state") {
        (0.01 * radius, "1 % of R")
    } else if forced {
        (radius, "R")
    } else {
        (DemFacts::MOST_OVERLAP * largest, "10 % of the largest radius")
    }
}

/// What else helps where grains overlap by no more than a run may end with.
fn going_on(scene: &Scene) -> &'static str {
    match scene.dem.contains_key("initial_state") {
        true => "",
        false => "; where another run ended so, dem.initial_state = its output folder goes on from it",
    }
}

/// No two grains overlap by more than [`deepest`] (sweep along the longest axis).
fn apart(scene: &Scene, grains: &[Grain], source: &SceneSource) -> Check {
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    let half: Vec<f64> = grains.iter().map(Grain::half_width).collect();
    let widest = half.iter().copied().fold(0.0, f64::max);
    let mut places = places(scene, grains, largest);
    let extent = |axis: usize| {
        let x = || places.iter().map(|(place, _)| place[axis]);
        x().fold(f64::NEG_INFINITY, f64::max) - x().fold(f64::INFINITY, f64::min)
    };
    let longest = (0..3).max_by(|a, b| extent(*a).total_cmp(&extent(*b))).unwrap_or(2);
    places.sort_by(|a, b| a.0[longest].total_cmp(&b.0[longest]));
    let mut twins = Vec::new();
    for (number, (here, i)) in places.iter().enumerate() {
        for (there, j) in &places[number + 1..] {
            let (a, b) = (&grains[*i], &grains[*j]);
            if there[longest] - here[longest] > a.radius + largest {
                break;
            }
            let distance2: f64 = (0..3).map(|axis| (here[axis] - there[axis]).powi(2)).sum();
            if distance2 > (a.radius + b.radius).powi(2) {
                continue;
            }
            let mut overlap = a.radius + b.radius - distance2.sqrt();
            if overlap > 0.0 && !(a.shape.is_round() && b.shape.is_round()) {
                overlap = penetration(a, b, [there[0] - here[0], there[2] - here[2]]);
            }
            let both_held = a.motion != Motion::Free && b.motion != Motion::Free;
            if both_held && i != j && distance2.sqrt() + (a.radius - b.radius).abs() <= 1e-9 * a.radius {
                twins.push((*i.min(j), *i.max(j)));
            }
            let (most, words) = deepest(scene, half[*i].min(half[*j]), widest);
            if i != j && overlap > most && !both_held {
                let (first, second) = (*i.min(j), *i.max(j));
                let message = format!(
                    "grains {first} and {second} overlap by {overlap}; allowed: {words}, R the smaller radius \
                     (half width)"
                );
                let remedy = format!("move one of them{}", going_on(scene));
                return Err(source.error(&grain_key(scene, second, "position"), message, &remedy));
            }
        }
    }
    doubled(scene, grains, &twins, source)
}

/// What is held twice, as a floor that a table of grains holds already: `twins` are pairs of held grains at
/// one place. Where rough walls meet, some may be.
fn doubled(scene: &Scene, grains: &[Grain], twins: &[(usize, usize)], source: &SceneSource) -> Check {
    let held = grains.iter().filter(|grain| grain.motion != Motion::Free).count();
    let Some((first, second)) = twins.first().filter(|_| 4 * twins.len() >= held) else { return Ok(()) };
    let message = format!(
        "{} of {held} held grains stand where another does, as {first} and {second}",
        2 * twins.len()
    );
    let remedy = "name each once: a table that a run left holds its held grains, too, as fixed";
    Err(source.error(&grain_key(scene, *second, "position"), message, remedy))
}

/// Directions in which smooth bodies are looked at.
const DIRECTIONS: u32 = 720;

/// How far two bodies of the plane overlap, `apart` from the first centre to the second; negative if they do
/// not. The least sum of their reaches over all directions, edges' normals among them (separating axes).
fn penetration(a: &Grain, b: &Grain, apart: [f64; 2]) -> f64 {
    let edges = [a, b].into_iter().filter_map(|grain| Some((grain, grain.outline()?))).flat_map(
        |(grain, outline)| {
            let (sine, cosine) = grain.angle().sin_cos();
            let vertices = match outline {
                Outline::Polygon { vertices } => vertices,
                Outline::Ellipse { .. } => Vec::new(),
            };
            (0..vertices.len()).flat_map(move |k| {
                let (p, q) = (vertices[k], vertices[(k + 1) % vertices.len()]);
                let (x, z) = (q[1] - p[1], p[0] - q[0]);
                let size = x.hypot(z);
                let normal = [(cosine * x + sine * z) / size, (cosine * z - sine * x) / size];
                [normal, normal.map(|n| -n)]
            })
        },
    );
    let around = (0..DIRECTIONS).map(|k| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(DIRECTIONS);
        [angle.cos(), angle.sin()]
    });
    let overlap = |[x, z]: [f64; 2]| {
        a.reach_along([x, 0.0, z]) + b.reach_along([-x, 0.0, -z]) - (apart[0] * x + apart[1] * z)
    };
    edges.chain(around).map(overlap).fold(f64::INFINITY, f64::min)
}

/// Centre and index of every grain, and of the images beyond the upper periodic faces of those that
/// a grain there can reach.
fn places(scene: &Scene, grains: &[Grain], largest: f64) -> Vec<([f64; 3], usize)> {
    let domain = &scene.domain;
    let mut places: Vec<_> =
        grains.iter().enumerate().map(|(index, grain)| (grain.position, index)).collect();
    for axis in (0..domain.dimensions()).filter(|axis| domain.is_periodic(*axis)) {
        let component = domain.geometry.component(axis);
        let (lower, length) = (domain.lower[axis], domain.upper[axis] - domain.lower[axis]);
        for number in 0..places.len() {
            let (mut place, index) = places[number];
            if place[component] - lower < grains[index].radius + largest {
                place[component] += length;
                places.push((place, index));
            }
        }
    }
    places
}
