//! Checks of the shared part: once, at the edge; behind it the types are trusted.

use super::Scene;
use super::domain::{Axis, Geometry, InitialVelocity, WallKind};
use super::error::SceneError;
use super::grains::{Grain, Motion, Shape};
use super::observe::MetricKind;
use super::open;
use super::source::SceneSource;

/// More cells than this need more memory than any one machine here is asked to have.
const MOST_CELLS: usize = 1 << 33;
/// More grains than this do not fit the exchange.
const MOST_GRAINS: usize = 1 << 26;

type Check = Result<(), SceneError>;

/// Everything but the grains themselves.
pub(super) fn shared(scene: &Scene, source: &SceneSource) -> Check {
    positive(source, "until", scene.until)?;
    finite(source, "gravity", &scene.gravity)?;
    domain(scene, source)?;
    medium(scene, source)?;
    layers(scene, source)?;
    groups(scene, source)?;
    pours(scene, source)?;
    walls(scene, source)?;
    stop(scene, source)?;
    observe(scene, source)
}

fn positive(source: &SceneSource, key: &str, value: f64) -> Check {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(source.error(
        key,
        format!("is {value}; allowed: a finite number > 0"),
        "give a positive number in consistent units",
    ))
}

fn not_negative(source: &SceneSource, key: &str, value: f64) -> Check {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(source.error(
        key,
        format!("is {value}; allowed: a finite number ≥ 0"),
        "give zero or a positive number",
    ))
}

fn finite(source: &SceneSource, key: &str, values: &[f64]) -> Check {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => {
            Err(source.error(key, format!("holds {value}; allowed: finite numbers"), "give finite numbers"))
        }
    }
}

fn domain(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let axes = domain.geometry.axes();
    for (key, length) in [("domain.lower", domain.lower.len()), ("domain.upper", domain.upper.len())] {
        if length != axes.len() {
            return Err(source.error(
                key,
                format!("has {length} numbers; {:?} has {} axes {axes:?}", domain.geometry, axes.len()),
                "give one number per axis",
            ));
        }
    }
    finite(source, "domain.lower", &domain.lower)?;
    finite(source, "domain.upper", &domain.upper)?;
    for ((lower, upper), axis) in domain.lower.iter().zip(&domain.upper).zip(axes) {
        if lower >= upper {
            let message = format!("upper {upper} is not above lower {lower} along {axis:?}");
            return Err(source.error(
                "domain.upper",
                message,
                "make every upper coordinate larger than its lower one",
            ));
        }
    }
    if domain.geometry == Geometry::Axisymmetric {
        if domain.lower[0] != 0.0 {
            return Err(source.error(
                "domain.lower",
                format!("starts at r = {}", domain.lower[0]),
                "an axisymmetric box starts at r = 0",
            ));
        }
        if scene.gravity[0] != 0.0 || scene.gravity[1] != 0.0 {
            return Err(source.error(
                "gravity",
                format!("is {:?}: across the axis of symmetry", scene.gravity),
                "write gravity = [0.0, 0.0, g] along z, or use geometry = \"space\"",
            ));
        }
    }
    if domain.geometry == Geometry::Plane && scene.gravity[1] != 0.0 {
        return Err(source.error(
            "gravity",
            format!("is {:?}: out of the plane (x, z)", scene.gravity),
            "set its y component to 0",
        ));
    }
    boundary(scene, source)?;
    cells(scene, source)
}

fn boundary(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let axes = domain.geometry.axes();
    for axis in [Axis::X, Axis::Y, Axis::Z, Axis::R] {
        let (both, lower, upper) = domain.boundary.of(axis);
        let name = format!("{axis:?}").to_lowercase();
        let given =
            [(both, name.clone()), (lower, format!("{name}_lower")), (upper, format!("{name}_upper"))];
        if let Some((_, face)) = given.iter().find(|(face, _)| face.is_some() && !axes.contains(&axis)) {
            return Err(source.error(
                &format!("domain.boundary.{face}"),
                format!("is a face of axis {name}, but {:?} has the axes {axes:?}", domain.geometry),
                "remove the faces of that axis",
            ));
        }
        if both.is_some() && (lower.is_some() || upper.is_some()) {
            return Err(source.error(
                &format!("domain.boundary.{name}"),
                format!("gives both faces at once, and {name}_lower or {name}_upper again"),
                "give either the pair or the two faces",
            ));
        }
    }
    (0..axes.len()).try_for_each(|axis| faces(scene, axis, source))?;
    open::through(scene, source)
}

/// The two faces of grid axis `axis`.
fn faces(scene: &Scene, axis: usize, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let name = format!("{:?}", domain.geometry.axes()[axis]).to_lowercase();
    let pair = format!("domain.boundary.{name}");
    let (both, lower, upper) = domain.boundary.of(domain.geometry.axes()[axis]);
    let Some(faces) = domain.boundary(axis) else {
        let key = match (lower, upper) {
            (Some(_), None) => format!("{pair}_upper"),
            (None, Some(_)) => format!("{pair}_lower"),
            _ if name == "r" => format!("{pair}_upper"),
            _ => pair,
        };
        return Err(source.error(
            &key,
            "is missing: every face of the box needs a boundary".to_owned(),
            &format!("add {name} = \"periodic\", or {name}_lower and {name}_upper = \"no-slip\", \"free-slip\", an inflow or \"outflow\" (axis r: r_upper alone)"),
        ));
    };
    let periodic = faces.upper.kind == WallKind::Periodic;
    if periodic && domain.geometry.axes()[axis] == Axis::R {
        return Err(source.error(
            "domain.boundary.r_upper",
            "is periodic".to_owned(),
            "the outer cylinder is no-slip or free-slip",
        ));
    }
    if faces.lower.is_some_and(|lower| (lower.kind == WallKind::Periodic) != periodic) {
        return Err(source.error(
            &format!("{pair}_{}", if periodic { "lower" } else { "upper" }),
            format!("is not periodic, but the other face of {name} is"),
            &format!("write {name} = \"periodic\" for both"),
        ));
    }
    let component = domain.geometry.component(axis);
    for (face, side) in faces.lower.iter().map(|lower| (lower, "_lower")).chain([(&faces.upper, "_upper")]) {
        let key = format!("{pair}{}.velocity", if both.is_some() { "" } else { side });
        finite(source, &key, &face.velocity)?;
        let written = key.trim_end_matches(".velocity");
        open::face(scene, axis, side == "_upper", face, written, source)?;
        if face.kind == WallKind::Inflow {
            continue;
        }
        if face.velocity[component] != 0.0 {
            return Err(source.error(
                &key,
                format!("moves a face of {name} through itself at {}", face.velocity[component]),
                "a wall's velocity lies in its plane: set this component to 0",
            ));
        }
        if face.velocity != [0.0; 3] && face.kind != WallKind::NoSlip {
            return Err(source.error(
                &key,
                format!("is {:?} on a face of {name} that is not no-slip", face.velocity),
                "only a no-slip wall or an inflow has a velocity: remove it, or make the face one of them",
            ));
        }
    }
    Ok(())
}

fn cells(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let axes = domain.geometry.axes();
    if scene.medium.is_none() && domain.cells.is_empty() {
        return Ok(());
    }
    if domain.cells.len() != axes.len() {
        return Err(source.error(
            "domain.cells",
            format!("has {} numbers; {:?} has the axes {axes:?}", domain.cells.len(), domain.geometry),
            "give the number of cells along each axis",
        ));
    }
    if let Some(few) = domain.cells.iter().find(|count| **count < 4) {
        return Err(source.error(
            "domain.cells",
            format!("has {few} cells along an axis; at least 4"),
            "refine the grid",
        ));
    }
    let total = domain.cells.iter().try_fold(1usize, |product, count| product.checked_mul(*count));
    if total.is_none_or(|total| total > MOST_CELLS) {
        return Err(source.error(
            "domain.cells",
            format!("asks for {:?} cells; at most {MOST_CELLS} in all", domain.cells),
            "coarsen the grid",
        ));
    }
    let Some(stretching) = domain.stretching else { return Ok(()) };
    positive(source, "domain.stretching.spacing", stretching.spacing)?;
    let Some(axis) = axes.iter().position(|axis| *axis == stretching.axis) else {
        return Err(source.error(
            "domain.stretching.axis",
            format!("is {:?}, but the axes are {axes:?}", stretching.axis),
            "name an axis of this geometry",
        ));
    };
    if domain.is_periodic(axis) {
        return Err(source.error(
            "domain.stretching.axis",
            "is periodic".to_owned(),
            "stretch an axis with walls; periodic axes are uniform",
        ));
    }
    let (lower, upper, count) = (domain.lower[axis], domain.upper[axis], domain.cells[axis]);
    let uniform = (stretching.uniform_to - lower) / stretching.spacing;
    if !(uniform.round() >= 1.0 && (uniform - uniform.round()).abs() < 1e-6) {
        return Err(source.error(
            "domain.stretching.uniform_to",
            format!("makes {uniform} cells of {}", stretching.spacing),
            "let the uniform part hold a whole number of cells",
        ));
    }
    let rest = count as f64 - uniform.round();
    if !(stretching.uniform_to < upper
        && rest >= 2.0
        && rest * stretching.spacing <= upper - stretching.uniform_to)
    {
        let message = format!(
            "{count} cells do not reach from {lower} to {upper} with widths that grow from {}",
            stretching.spacing
        );
        return Err(source.error(
            "domain.stretching",
            message,
            "take fewer cells, a smaller spacing, or no stretching",
        ));
    }
    Ok(())
}

fn medium(scene: &Scene, source: &SceneSource) -> Check {
    let Some(medium) = &scene.medium else { return Ok(()) };
    positive(source, "medium.density", medium.density)?;
    positive(source, "medium.viscosity", medium.viscosity)?;
    finite(source, "medium.body_force", &medium.body_force)?;
    finite(source, "medium.pressure_gradient", &medium.pressure_gradient)?;
    for axis in 0..scene.domain.dimensions() {
        let component = scene.domain.geometry.component(axis);
        if medium.pressure_gradient[component] != 0.0 && !scene.domain.is_periodic(axis) {
            return Err(source.error(
                "medium.pressure_gradient",
                "drives along an axis with walls, where the pressure balances it".to_owned(),
                "make that axis periodic, or remove the gradient",
            ));
        }
    }
    open::flow_rate(scene, source)?;
    match &medium.initial {
        InitialVelocity::Rest => Ok(()),
        InitialVelocity::Uniform { velocity } => finite(source, "medium.initial.velocity", velocity),
        InitialVelocity::Shear { direction, gradient, rate, origin } => {
            finite(source, "medium.initial", &[*rate, *origin])?;
            let axes = scene.domain.geometry.axes();
            if direction == gradient || !axes.contains(direction) || !axes.contains(gradient) {
                return Err(source.error(
                    "medium.initial",
                    format!("shears {direction:?} along {gradient:?}; the axes are {axes:?}"),
                    "name two different axes of this geometry",
                ));
            }
            Ok(())
        }
        InitialVelocity::TaylorGreen { amplitude } => {
            finite(source, "medium.initial.amplitude", &[*amplitude])
        }
    }
}

fn groups(scene: &Scene, source: &SceneSource) -> Check {
    let geometry = scene.domain.geometry;
    let layered: f64 = scene.layers.iter().map(|layer| layer.count(geometry)).sum();
    let grouped = scene.groups.iter().map(|group| group.count as f64).sum::<f64>();
    let poured = scene.pours.iter().map(|pour| pour.count as f64).sum::<f64>();
    for (key, count) in [("groups", grouped), ("layers", layered), ("pours", poured)] {
        if count + scene.grains.len() as f64 > MOST_GRAINS as f64 {
            return Err(source.error(
                key,
                format!("asks for more than {MOST_GRAINS} grains"),
                "ask for fewer grains",
            ));
        }
    }
    for (index, group) in scene.groups.iter().enumerate() {
        let key = |name: &str| format!("groups[{index}].{name}");
        positive(source, &key("radius"), group.radius)?;
        positive(source, &key("density"), group.density)?;
        finite(source, &key("lower"), &group.lower)?;
        finite(source, &key("upper"), &group.upper)?;
        spread(source, &key("radius_spread"), group.radius_spread)?;
        not_negative(source, &key("velocity_deviation"), group.velocity_deviation)?;
        let width = 2.0 * group.radius * (1.0 + group.radius_spread);
        let flat = scene.domain.geometry == Geometry::Plane;
        if (0..3).any(|axis| !(flat && axis == 1) && group.upper[axis] - group.lower[axis] < width) {
            return Err(source.error(
                &key("upper"),
                format!("leaves no room for a grain of diameter {width}"),
                "make the region larger than the largest grain",
            ));
        }
        if scene.domain.geometry == Geometry::Axisymmetric {
            return Err(source.error(
                &format!("groups[{index}]"),
                "an axisymmetric scene has its grains on the axis".to_owned(),
                "write them out in [[grains]], or use geometry = \"space\"",
            ));
        }
    }
    Ok(())
}

fn layers(scene: &Scene, source: &SceneSource) -> Check {
    for (index, layer) in scene.layers.iter().enumerate() {
        let key = |name: &str| format!("layers[{index}].{name}");
        positive(source, &key("radius"), layer.radius)?;
        positive(source, &key("density"), layer.density)?;
        positive(source, &key("spacing"), layer.spacing())?;
        finite(source, &key("lower"), &layer.lower)?;
        finite(source, &key("upper"), &layer.upper)?;
        spread(source, &key("radius_spread"), layer.radius_spread)?;
        if scene.domain.geometry == Geometry::Axisymmetric || !layer.is_flat(scene.domain.geometry) {
            return Err(source.error(
                &key("upper"),
                format!("{:?} and lower {:?} do not span a rectangle", layer.upper, layer.lower),
                "let the two corners agree along one axis and differ along the others (plane: differ along x or z alone)",
            ));
        }
    }
    Ok(())
}

fn pours(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    for (index, pour) in scene.pours.iter().enumerate() {
        let key = |name: &str| format!("pours[{index}].{name}");
        positive(source, &key("radius"), pour.radius)?;
        positive(source, &key("density"), pour.density)?;
        positive(source, &key("rate"), pour.rate)?;
        not_negative(source, &key("start"), pour.start)?;
        finite(source, &key("lower"), &pour.lower)?;
        finite(source, &key("upper"), &pour.upper)?;
        finite(source, &key("velocity"), &pour.velocity)?;
        finite(source, &key("rise"), &pour.rise)?;
        let shift = pour.shift(f64::INFINITY);
        spread(source, &key("radius_spread"), pour.radius_spread)?;
        if domain.geometry == Geometry::Axisymmetric || scene.medium.is_some() {
            return Err(source.error(
                &format!("pours[{index}]"),
                "pours grains into an axisymmetric scene or one with a fluid, which sees every grain from the start",
                "pour in a dry scene, and begin the other from its grains.csv with [[grain_files]]",
            ));
        }
        let width = 2.0 * pour.radius * (1.0 + pour.radius_spread);
        for axis in 0..domain.dimensions() {
            let c = domain.geometry.component(axis);
            if pour.upper[c] - pour.lower[c] < width {
                return Err(source.error(
                    &key("upper"),
                    format!("leaves no room for a grain of diameter {width}"),
                    "make the region larger than the largest grain",
                ));
            }
            let (low, high) = (pour.lower[c] + shift[c].min(0.0), pour.upper[c] + shift[c].max(0.0));
            if low < domain.lower[axis] || high > domain.upper[axis] {
                return Err(source.error(
                    &key("upper"),
                    format!(
                        "{:?} and lower {:?} reach outside the box, moving by {shift:?}",
                        pour.upper, pour.lower
                    ),
                    "keep the region in the box, or enlarge [domain]",
                ));
            }
        }
    }
    Ok(())
}

fn spread(source: &SceneSource, key: &str, spread: f64) -> Check {
    if (0.0..1.0).contains(&spread) {
        return Ok(());
    }
    Err(source.error(
        key,
        format!("is {spread}; allowed: 0 ≤ spread < 1"),
        "a spread of 1 or more makes a radius ≤ 0",
    ))
}

/// A dry run alone stops by itself.
fn stop(scene: &Scene, source: &SceneSource) -> Check {
    let Some(stop) = &scene.stop_when else { return Ok(()) };
    positive(source, "stop_when.kinetic_energy_per_grain_below", stop.kinetic_energy_per_grain_below)?;
    not_negative(source, "stop_when.after", stop.after)?;
    if scene.medium.is_some() {
        return Err(source.error(
            "stop_when",
            "ends dry runs only",
            "leave it out, and let `until` end the run",
        ));
    }
    if scene.gravity == [0.0; 3] {
        return Err(source.error(
            "stop_when",
            "measures energy in m g R, but the scene has no gravity",
            "give gravity, or leave it out",
        ));
    }
    Ok(())
}

fn walls(scene: &Scene, source: &SceneSource) -> Check {
    for (index, wall) in scene.walls.iter().enumerate() {
        let key = |name: &str| format!("walls[{index}].{name}");
        finite(source, &key("point"), &wall.point)?;
        finite(source, &key("velocity"), &wall.velocity)?;
        let length: f64 = wall.normal.iter().map(|n| n * n).sum();
        if !(length.is_finite() && length > 0.0) {
            return Err(source.error(
                &key("normal"),
                format!("is {:?}", wall.normal),
                "give a normal of non-zero length that points to the grains",
            ));
        }
        if !(wall.from.is_finite() && wall.until > wall.from) {
            return Err(source.error(
                &key("until"),
                format!("is {}, from {}", wall.until, wall.from),
                "give times from < until between which the wall is there, or leave them out",
            ));
        }
    }
    Ok(())
}

fn observe(scene: &Scene, source: &SceneSource) -> Check {
    not_negative(source, "observe.every", scene.observe.every)?;
    not_negative(source, "observe.fields_every", scene.observe.fields_every)?;
    finite(source, "observe.fields_at", &scene.observe.fields_at)?;
    if scene.observe.energy && scene.medium.is_some() {
        return Err(source.error(
            "observe.energy",
            "is for dry scenes: the work of the fluid is not counted".to_owned(),
            "leave it out, or remove [medium]",
        ));
    }
    observed_planes(scene, source)?;
    let Some(profile) = &scene.observe.profile else { return Ok(()) };
    finite(source, "observe.profile.lower", &profile.lower)?;
    finite(source, "observe.profile.upper", &profile.upper)?;
    let flat = scene.domain.geometry == Geometry::Plane;
    let empty = (0..3).any(|c| !(flat && c == 1) && profile.upper[c] <= profile.lower[c]);
    if empty || profile.slabs == 0 || profile.axis() > 2 || (flat && profile.axis() == 1) {
        return Err(source.error(
            "observe.profile",
            format!(
                "spans {:?} to {:?} in {} slabs along {:?}",
                profile.lower, profile.upper, profile.slabs, profile.axis
            ),
            "give a box of positive size, one slab at least, and an axis x, y or z of this geometry",
        ));
    }
    Ok(())
}

fn observed_planes(scene: &Scene, source: &SceneSource) -> Check {
    let Some(planes) = &scene.observe.planes else { return Ok(()) };
    positive(source, "observe.planes.every", planes.every)?;
    not_negative(source, "observe.planes.from", planes.from)?;
    finite(source, "observe.planes.at", &planes.at)?;
    if planes.to.is_nan() || planes.to <= planes.from {
        return Err(source.error(
            "observe.planes.to",
            format!("is {}, from {}", planes.to, planes.from),
            "give times from < to of the mean, or leave them out",
        ));
    }
    if scene.medium.is_none() {
        return Err(source.error(
            "observe.planes",
            "averages the fluid, and the scene has none".to_owned(),
            "give [observe.profile] for the grains alone, or add [medium]",
        ));
    }
    let axes = scene.domain.geometry.axes();
    if !axes.contains(&planes.axis) {
        return Err(source.error(
            "observe.planes.axis",
            format!("is {:?}; the axes of this geometry are {axes:?}", planes.axis),
            "name one of them",
        ));
    }
    Ok(())
}

/// Key of grain `index` where it is written out, of its file, layer, group or pour where it is not.
fn grain_key(scene: &Scene, index: usize, name: &str) -> String {
    let written = scene.grains.len();
    if index < written {
        format!("grains[{index}].{name}")
    } else if scene.grain_files.is_empty() && scene.groups.is_empty() {
        if scene.layers.is_empty() { "pours" } else { "layers" }.to_owned()
    } else if scene.grain_files.is_empty() && scene.layers.is_empty() {
        let mut end = written;
        let group = scene.groups.iter().position(|group| {
            end += group.count;
            index < end
        });
        format!("groups[{}]", group.unwrap_or(0))
    } else if scene.grain_files.is_empty() {
        "layers".to_owned()
    } else {
        "grain_files".to_owned()
    }
}

/// Each grain alone, and against the box, the walls and the other grains.
///
/// Grains from `present` on are poured in later, where there is room then.
pub(super) fn grains(scene: &Scene, grains: &[Grain], present: usize, source: &SceneSource) -> Check {
    if grains.is_empty() && scene.medium.is_none() {
        return Err(source.error(
            "grains",
            "the scene has neither fluid nor grains",
            "add [medium] or [[grains]]",
        ));
    }
    for (index, grain) in grains[..present].iter().enumerate() {
        one(scene, index, grain, source)?;
    }
    apart(scene, &grains[..present], source)
}

fn one(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let key = |name: &str| grain_key(scene, index, name);
    positive(source, &key("radius"), grain.radius)?;
    positive(source, &key("density"), grain.density)?;
    finite(source, &key("position"), &grain.position)?;
    finite(source, &key("velocity"), &grain.velocity)?;
    finite(source, &key("spin"), &grain.spin)?;
    let norm: f64 = grain.orientation.iter().map(|q| q * q).sum();
    if (norm - 1.0).abs() > 1e-6 || norm.is_nan() {
        return Err(source.error(
            &key("orientation"),
            format!("{:?} has norm² {norm}", grain.orientation),
            "give a unit quaternion (w, x, y, z)",
        ));
    }
    if grain.oscillation.is_some() && grain.motion != Motion::Prescribed {
        return Err(source.error(
            &key("oscillation"),
            "swings a grain that is not prescribed".to_owned(),
            "add motion = \"prescribed\"",
        ));
    }
    if let Some(swing) = grain.oscillation {
        positive(source, &key("oscillation.frequency"), swing.frequency)?;
        finite(source, &key("oscillation.amplitude"), &swing.amplitude)?;
        finite(source, &key("oscillation.phase"), &[swing.phase])?;
    }
    let geometry = scene.domain.geometry;
    if geometry == Geometry::Axisymmetric && (grain.position[0] != 0.0 || grain.position[1] != 0.0) {
        return Err(source.error(
            &key("position"),
            format!("{:?} is off the axis", grain.position),
            "an axisymmetric grain has x = y = 0",
        ));
    }
    if geometry == Geometry::Plane && grain.position[1] != 0.0 {
        return Err(source.error(
            &key("position"),
            format!("{:?} is out of the plane (x, z)", grain.position),
            "set y = 0",
        ));
    }
    if geometry != Geometry::Plane && grain.shape == Shape::Disc {
        return Err(source.error(
            &key("shape"),
            "is a disc".to_owned(),
            "discs live in geometry = \"plane\"",
        ));
    }
    inside(scene, index, grain, source)?;
    resolved(scene, index, grain, source)
}

fn inside(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    for axis in 0..domain.dimensions() {
        let component = domain.geometry.component(axis);
        let x = grain.position[component];
        let (lower, upper) = (domain.lower[axis], domain.upper[axis]);
        if x < lower || x > upper {
            let message = format!(
                "{:?} of grain {index} is outside the box {lower}..{upper} along {:?}",
                grain.position,
                domain.geometry.axes()[axis]
            );
            return Err(source.error(
                &grain_key(scene, index, "position"),
                message,
                "move the grain in, or enlarge [domain]",
            ));
        }
    }
    let mut planes = scene.walls.clone();
    planes.retain(|wall| wall.from <= 0.0);
    planes.extend(domain.contact_faces());
    for wall in &planes {
        let length: f64 = wall.normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        let gap = (0..3).map(|a| (grain.position[a] - wall.point[a]) * wall.normal[a]).sum::<f64>() / length
            - grain.radius;
        if gap < -0.01 * grain.radius && grain.motion == Motion::Free {
            let message = format!(
                "{:?} puts grain {index} (radius {}) {} into the wall at {:?}; allowed: 1 % of R",
                grain.position, grain.radius, -gap, wall.point
            );
            return Err(source.error(
                &grain_key(scene, index, "position"),
                message,
                "move the grain or the wall",
            ));
        }
    }
    Ok(())
}

fn resolved(scene: &Scene, index: usize, grain: &Grain, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    if scene.medium.is_none() {
        return Ok(());
    }
    for axis in 0..domain.dimensions() {
        let spacing = domain.spacing(axis);
        if 2.0 * grain.radius < 2.0 * spacing {
            let message = format!(
                "grain {index} of diameter {} has fewer than 2 cells of {spacing} along {:?}",
                2.0 * grain.radius,
                domain.geometry.axes()[axis]
            );
            return Err(source.error(
                "domain.cells",
                message,
                "the grid does not hold the grain: refine it (8 cells per diameter and more)",
            ));
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

/// No two grains overlap by more than 1 % of the smaller radius (sweep along the longest axis).
fn apart(scene: &Scene, grains: &[Grain], source: &SceneSource) -> Check {
    let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
    let mut places = places(scene, grains, largest);
    let extent = |axis: usize| {
        let x = || places.iter().map(|(place, _)| place[axis]);
        x().fold(f64::NEG_INFINITY, f64::max) - x().fold(f64::INFINITY, f64::min)
    };
    let longest = (0..3).max_by(|a, b| extent(*a).total_cmp(&extent(*b))).unwrap_or(2);
    places.sort_by(|a, b| a.0[longest].total_cmp(&b.0[longest]));
    for (number, (here, i)) in places.iter().enumerate() {
        for (there, j) in &places[number + 1..] {
            let (a, b) = (&grains[*i], &grains[*j]);
            if there[longest] - here[longest] > a.radius + largest {
                break;
            }
            let distance2: f64 = (0..3).map(|axis| (here[axis] - there[axis]).powi(2)).sum();
            let overlap = a.radius + b.radius - distance2.sqrt();
            let both_held = a.motion != Motion::Free && b.motion != Motion::Free;
            if i != j && overlap > 0.01 * a.radius.min(b.radius) && !both_held {
                let (first, second) = (*i.min(j), *i.max(j));
                let message = format!(
                    "grains {first} and {second} overlap by {overlap}; allowed: 1 % of the smaller radius"
                );
                return Err(source.error(&grain_key(scene, second, "position"), message, "move one of them"));
            }
        }
    }
    Ok(())
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

/// Metrics have names of their own; they and `observe.grains` name grains that exist.
pub(super) fn metrics(scene: &Scene, count: usize, source: &SceneSource) -> Check {
    for (index, metric) in scene.metrics.iter().enumerate() {
        let key = |name: &str| format!("metrics[{index}].{name}");
        if scene.metrics[..index].iter().any(|other| other.name == metric.name) {
            return Err(source.error(
                &key("name"),
                format!("is `{}` a second time", metric.name),
                "give every metric a name of its own",
            ));
        }
        match &metric.kind {
            MetricKind::RestitutionAtGap { gap, .. } => positive(source, &key("gap"), *gap)?,
            MetricKind::Mean { from, .. } | MetricKind::Max { from, .. } => {
                not_negative(source, &key("from"), *from)?;
            }
            MetricKind::Frequency { from, level, .. } => {
                not_negative(source, &key("from"), *from)?;
                finite(source, &key("level"), &[*level])?;
            }
            MetricKind::VelocityDifference { component, along, through, .. } => {
                let axes = scene.domain.geometry.axes();
                if scene.medium.is_none() || !axes.contains(component) || !axes.contains(along) {
                    return Err(source.error(
                        &key("kind"),
                        format!("is about {component:?} along {along:?} of a fluid; the axes are {axes:?}"),
                        "name axes of this geometry, in a scene with [medium]",
                    ));
                }
                finite(source, &key("through"), through)?;
            }
            MetricKind::HaffTime(span) | MetricKind::HaffMisfit(span) => {
                not_negative(source, &key("from"), span.from)?;
                positive(source, &key("to"), span.to.min(f64::MAX))?;
            }
            MetricKind::MeanFluidVelocity { .. }
            | MetricKind::MeanGrainVelocity { .. }
            | MetricKind::Shields { .. }
                if scene.observe.planes.is_none() =>
            {
                return Err(source.error(
                    &key("kind"),
                    "is read from averages over planes, which the scene does not ask for".to_owned(),
                    "add observe.planes = { every = ... }",
                ));
            }
            MetricKind::Shields { surface, .. } => positive(source, &key("surface"), *surface)?,
            MetricKind::MobilisationTime { speed, share } => {
                positive(source, &key("speed"), *speed)?;
                positive(source, &key("share"), *share)?;
            }
            MetricKind::HeapAngle(slope) => not_negative(source, &key("bin"), slope.bin)?,
            _ => {}
        }
        if let Some(column) = metric.kind.column() {
            positive(source, &key("half_length"), column.half_length)?;
            not_negative(source, &key("release"), column.release)?;
            not_negative(source, &key("bin"), column.bin)?;
        }
        if let Some(grain) = metric.kind.grain().filter(|grain| *grain >= count) {
            return Err(source.error(
                &key("grain"),
                format!("is {grain}, but the scene has {count} grains"),
                "count grains from 0",
            ));
        }
    }
    if let Some(grain) = scene.observe.grains.iter().flatten().find(|grain| **grain >= count) {
        return Err(source.error(
            "observe.grains",
            format!("holds {grain}, but the scene has {count} grains"),
            "count grains from 0",
        ));
    }
    Ok(())
}
