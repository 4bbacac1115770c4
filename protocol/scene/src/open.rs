//! Checks of the faces that fluid passes through, and of a flow that is held along a periodic axis.

use crate::domain::{Axis, Face, Geometry, WallKind};
use crate::error::Check;
use crate::over_time::acts_along;
use crate::shared::Scene;
use crate::source::SceneSource;

/// One face of grid axis `axis` by itself; `key` is where it is written, `upper` which it is.
pub(crate) fn face(
    scene: &Scene,
    axis: usize,
    upper: bool,
    face: &Face,
    key: &str,
    source: &SceneSource,
) -> Check {
    let domain = &scene.domain;
    source.refuse_if(
        face.kind != WallKind::Inflow && !face.profile.is_uniform(),
        &format!("{key}.profile"),
        "shapes a face through which nothing enters",
        "remove it, or set type = \"inflow\"",
    )?;
    if !face.kind.is_open() {
        return Ok(());
    }
    let name = format!("{:?}", face.kind).to_lowercase();
    source.refuse_if(
        domain.geometry == Geometry::Axisymmetric && domain.geometry.axes()[axis] == Axis::R,
        key,
        format_args!("is an {name} through the outer cylinder; allowed: \"no-slip\" or \"free-slip\""),
        "let the fluid enter and leave along z",
    )?;
    source.refuse_if(
        scene.medium.is_none(),
        key,
        format_args!("is an {name}, but the scene has no fluid"),
        "add [medium], or write \"free-slip\", through which grains pass too",
    )?;
    if face.kind == WallKind::Inflow { inflow(scene, axis, upper, face, key, source) } else { Ok(()) }
}

/// The velocity and the shape of an inflow.
fn inflow(scene: &Scene, axis: usize, upper: bool, face: &Face, key: &str, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let component = domain.geometry.component(axis);
    // The largest of each component, and of the normal one the least: at times an inflow may stand.
    let velocity = face.velocity.peak(scene.until);
    let normal = face.velocity.map(|v| if upper { -v[component] } else { v[component] }).range(scene.until);
    if normal[0] < 0.0 || normal[1] <= 0.0 {
        let (axis, sign) = (["x", "y", "z"][component], if upper { "below" } else { "above" });
        return Err(source.error(
            &format!("{key}.velocity"),
            format!(
                "is {}: an inflow enters the box; allowed: a component along {axis} {sign} 0, at times 0",
                if face.velocity.varies() {
                    format!("between {} and {} m/s into the box", normal[0], normal[1])
                } else {
                    format!("{velocity:?}")
                }
            ),
            "give the mean velocity of what enters, as { type = \"inflow\", velocity = [x, y, z] }, or \
             write \"outflow\"",
        ));
    }
    let absent = match domain.geometry {
        Geometry::Plane => velocity[1] != 0.0,
        Geometry::Axisymmetric => velocity[0] != 0.0 || velocity[1] != 0.0,
        Geometry::Space => false,
    };
    source.refuse_if(
        absent,
        &format!("{key}.velocity"),
        format_args!("is {:?}, with a component that {:?} geometry has not", velocity, domain.geometry),
        "set that component to 0",
    )?;
    if face.profile.is_uniform() {
        return Ok(());
    }
    source.refuse_if(
        (0..3).any(|c| c != component && velocity[c] != 0.0),
        &format!("{key}.velocity"),
        format_args!("is {:?}: a parabolic inflow enters straight", velocity),
        "set the other components to 0, or take profile = \"uniform\"",
    )?;
    source.refuse_if(
        domain.peak_over_mean(axis, face) == 1.0,
        &format!("{key}.profile"),
        "is parabolic, but no axis across has a no-slip wall for it to be zero on",
        "take profile = \"uniform\", or make faces across no-slip",
    )
}

/// What enters must leave.
pub(crate) fn through(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    let has = |kind: WallKind| {
        (0..domain.dimensions()).filter_map(|axis| domain.boundary(axis)).find_map(|faces| {
            let lower = faces.lower.filter(|face| face.kind == kind);
            lower.or(Some(faces.upper).filter(|face| face.kind == kind))
        })
    };
    match (has(WallKind::Inflow), has(WallKind::Outflow)) {
        (Some(_), None) => Err(source.error(
            &written(scene, WallKind::Inflow),
            "is an inflow, but no face is an outflow: what enters must leave".to_owned(),
            "write \"outflow\" for the face opposite, or for another",
        )),
        (None, Some(_)) => Err(source.error(
            &written(scene, WallKind::Outflow),
            "is an outflow, but no face is an inflow: nothing could leave".to_owned(),
            "write { type = \"inflow\", velocity = [x, y, z] } for another face, or \"free-slip\" for this one",
        )),
        _ => Ok(()),
    }
}

/// Key of the first face of that kind.
fn written(scene: &Scene, kind: WallKind) -> String {
    let domain = &scene.domain;
    for axis in domain.geometry.axes() {
        let (both, lower, upper) = domain.boundary.of(*axis);
        for (face, end) in [(both, ""), (lower, "_lower"), (upper, "_upper")] {
            if face.is_some_and(|face| face.kind == kind) {
                return format!("domain.boundary.{}{end}", axis.name());
            }
        }
    }
    "domain.boundary".to_owned()
}

/// `medium.flow_rate`: only where no face and no other drive decides it already.
pub(crate) fn flow_rate(scene: &Scene, source: &SceneSource) -> Check {
    let Some(medium) = &scene.medium else { return Ok(()) };
    let Some(flow) = &medium.flow_rate else { return Ok(()) };
    let domain = &scene.domain;
    let axes = domain.geometry.axes();
    let Some(axis) = axes.iter().position(|axis| *axis == flow.axis) else {
        let what = format!("is {:?}; the axes of this geometry are {axes:?}", flow.axis);
        return Err(source.error("medium.flow_rate.axis", what, "name one that is periodic"));
    };
    if !domain.is_periodic(axis) {
        let name = flow.axis.name();
        return Err(source.error(
            "medium.flow_rate.axis",
            format!("is {name}, which is not periodic: there the faces decide what flows"),
            &format!(
                "write {name} = \"periodic\" in [domain.boundary], or give an inflow and an outflow instead"
            ),
        ));
    }
    source.refuse_if(
        acts_along(&medium.pressure_gradient, flow.axis.component()),
        "medium.pressure_gradient",
        "drives along the axis whose flow rate is held: the gradient is then an outcome",
        "set that component to 0, or remove medium.flow_rate",
    )
}
