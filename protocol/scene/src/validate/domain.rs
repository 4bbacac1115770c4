//! Box, grid and faces.

use super::check::{Check, finite, positive};
use super::missing;
use crate::domain::{Axis, Geometry, WallKind};
use crate::open;
use crate::over_time::acts_along;
use crate::shared::Scene;
use crate::source::SceneSource;

/// More cells than this need more memory than any one machine here is asked to have.
const MOST_CELLS: usize = 1 << 33;

pub(super) fn domain(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let axes = domain.geometry.axes();
    for (key, length) in [("domain.lower", domain.lower.len()), ("domain.upper", domain.upper.len())] {
        source.refuse_if(
            length != axes.len(),
            key,
            format_args!("has {length} numbers; {:?} has {} axes {axes:?}", domain.geometry, axes.len()),
            "give one number per axis",
        )?;
    }
    finite(source, "domain.lower", &domain.lower)?;
    finite(source, "domain.upper", &domain.upper)?;
    for ((lower, upper), axis) in domain.lower.iter().zip(&domain.upper).zip(axes) {
        source.refuse_if(
            lower >= upper,
            "domain.upper",
            format_args!("upper {upper} is not above lower {lower} along {axis:?}"),
            "make every upper coordinate larger than its lower one",
        )?;
    }
    source.refuse_if(
        domain.geometry == Geometry::Axisymmetric && domain.lower[0] != 0.0,
        "domain.lower",
        format_args!("starts at r = {}", domain.lower[0]),
        "an axisymmetric box starts at r = 0",
    )?;
    missing::along_axis(&scene.gravity, domain.geometry, "gravity", source)?;
    boundary(scene, source)?;
    cells(scene, source)
}

fn boundary(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let axes = domain.geometry.axes();
    for axis in [Axis::X, Axis::Y, Axis::Z, Axis::R] {
        let (both, lower, upper) = domain.boundary.of(axis);
        let name = axis.name();
        let given =
            [(&both, name.to_owned()), (&lower, format!("{name}_lower")), (&upper, format!("{name}_upper"))];
        if let Some((_, face)) = given.iter().find(|(face, _)| face.is_some() && !axes.contains(&axis)) {
            return Err(source.error(
                &format!("domain.boundary.{face}"),
                format!("is a face of axis {name}, but {:?} has the axes {axes:?}", domain.geometry),
                "remove the faces of that axis",
            ));
        }
        source.refuse_if(
            both.is_some() && (lower.is_some() || upper.is_some()),
            &format!("domain.boundary.{name}"),
            format_args!("gives both faces at once, and {name}_lower or {name}_upper again"),
            "give either the pair or the two faces",
        )?;
    }
    (0..axes.len()).try_for_each(|axis| faces(scene, axis, source))?;
    open::through(scene, source)
}

/// The two faces of grid axis `axis`.
fn faces(scene: &Scene, axis: usize, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let name = domain.geometry.axes()[axis].name();
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
            &format!(
                "add {name} = \"periodic\", or {name}_lower and {name}_upper \
                = \"no-slip\", \"free-slip\", an inflow or \"outflow\" (axis r: r_upper alone)"
            ),
        ));
    };
    let periodic = faces.upper.kind == WallKind::Periodic;
    source.refuse_if(
        periodic && domain.geometry.axes()[axis] == Axis::R,
        "domain.boundary.r_upper",
        "is periodic",
        "the outer cylinder is no-slip or free-slip",
    )?;
    source.refuse_if(
        faces.lower.as_ref().is_some_and(|lower| (lower.kind == WallKind::Periodic) != periodic),
        &format!("{pair}_{}", if periodic { "lower" } else { "upper" }),
        format_args!("is not periodic, but the other face of {name} is"),
        &format!("write {name} = \"periodic\" for both"),
    )?;
    let component = domain.geometry.component(axis);
    for (face, side) in faces.lower.iter().map(|lower| (lower, "_lower")).chain([(&faces.upper, "_upper")]) {
        let key = format!("{pair}{}.velocity", if both.is_some() { "" } else { side });
        let written = key.trim_end_matches(".velocity");
        open::face(scene, axis, side == "_upper", face, written, source)?;
        missing::along_axis(&face.velocity, domain.geometry, &key, source)?;
        if face.kind == WallKind::Inflow {
            continue;
        }
        source.refuse_if(
            !face.velocity.is_zero() && face.kind != WallKind::NoSlip,
            &key,
            format_args!("is {:?} on a face of {name} that is not no-slip", face.velocity.peak(scene.until)),
            "only a no-slip wall or an inflow has a velocity: remove it, or make the face one of them",
        )?;
        source.refuse_if(
            acts_along(&face.velocity, component),
            &key,
            format_args!(
                "moves a face of {name} through itself at {}",
                face.velocity.map(|v| v[component]).peak(f64::INFINITY)
            ),
            "a wall's velocity lies in its plane: set this component to 0",
        )?;
    }
    Ok(())
}

fn cells(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let axes = domain.geometry.axes();
    if scene.medium.is_none() && domain.cells.is_empty() {
        return Ok(());
    }
    source.refuse_if(
        domain.cells.len() != axes.len(),
        "domain.cells",
        format_args!("has {} numbers; {:?} has the axes {axes:?}", domain.cells.len(), domain.geometry),
        "give the number of cells along each axis",
    )?;
    if let Some(few) = domain.cells.iter().find(|count| **count < 4) {
        let what = format!("has {few} cells along an axis; at least 4");
        return Err(source.error("domain.cells", what, "refine the grid"));
    }
    let total = domain.cells.iter().try_fold(1usize, |product, count| product.checked_mul(*count));
    source.refuse_if(
        total.is_none_or(|total| total > MOST_CELLS),
        "domain.cells",
        format_args!("asks for {:?} cells; at most {MOST_CELLS} in all", domain.cells),
        "coarsen the grid",
    )?;
    let Some(stretching) = domain.stretching else { return Ok(()) };
    positive(source, "domain.stretching.spacing", stretching.spacing)?;
    let Some(axis) = axes.iter().position(|axis| *axis == stretching.axis) else {
        let what = format!("is {:?}, but the axes are {axes:?}", stretching.axis);
        return Err(source.error("domain.stretching.axis", what, "name an axis of this geometry"));
    };
    source.refuse_if(
        domain.is_periodic(axis),
        "domain.stretching.axis",
        "is periodic",
        "stretch an axis with walls; periodic axes are uniform",
    )?;
    let (lower, upper, count) = (domain.lower[axis], domain.upper[axis], domain.cells[axis]);
    let uniform = (stretching.uniform_to - lower) / stretching.spacing;
    source.refuse_if(
        !(uniform.round() >= 1.0 && (uniform - uniform.round()).abs() < 1e-6),
        "domain.stretching.uniform_to",
        format_args!("makes {uniform} cells of {}", stretching.spacing),
        "let the uniform part hold a whole number of cells",
    )?;
    let rest = count as f64 - uniform.round();
    let left = upper - stretching.uniform_to;
    source.refuse_if(
        !(stretching.uniform_to < upper && rest >= 2.0 && rest * stretching.spacing <= left),
        "domain.stretching",
        format_args!(
            "{count} cells do not reach from {lower} to {upper} with widths that grow from {}",
            stretching.spacing
        ),
        "take fewer cells, a smaller spacing, or no stretching",
    )
}
