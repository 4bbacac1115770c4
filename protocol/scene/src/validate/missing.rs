//! Components that a geometry does not have.

use super::check::Check;
use crate::domain::Geometry;
use crate::source::SceneSource;
use bedload_over_time::OverTime;

/// Refuses a vector out of the plane (x, z) or off the axis of symmetry.
pub(super) fn along_axis(
    value: &OverTime<[f64; 3]>,
    geometry: Geometry,
    key: &str,
    source: &SceneSource,
) -> Check {
    match geometry {
        Geometry::Space => Ok(()),
        Geometry::Plane => refuse(value, &[1], key, "out of the plane (x, z)", "with y = 0", source),
        Geometry::Axisymmetric => {
            refuse(value, &[0, 1], key, "across the axis of symmetry", "along z alone", source)
        }
    }
}

/// Refuses a spin of a grain other than about y in the plane, and any on the axis of symmetry.
pub(super) fn of_spin(
    value: &OverTime<[f64; 3]>,
    geometry: Geometry,
    key: &str,
    source: &SceneSource,
) -> Check {
    match geometry {
        Geometry::Space => Ok(()),
        Geometry::Plane => refuse(value, &[0, 2], key, "out of the plane (x, z)", "about y alone", source),
        Geometry::Axisymmetric => {
            refuse(value, &[0, 1, 2], key, "not there on the axis of symmetry", "no spin", source)
        }
    }
}

/// Refuses some components.
pub(super) fn refuse(
    value: &OverTime<[f64; 3]>,
    components: &[usize],
    key: &str,
    what: &str,
    remedy: &str,
    source: &SceneSource,
) -> Check {
    let wrong = |value: &[f64; 3]| components.iter().any(|c| value[*c] != 0.0);
    let Some(wrong) = value.extremes().find(wrong) else { return Ok(()) };
    Err(source.error(
        key,
        format!("is {wrong:?}: {what}"),
        &format!("give it {remedy}, or use geometry = \"space\""),
    ))
}
