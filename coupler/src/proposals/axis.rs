//! r–z in place of space, for one sphere on the axis of its box.

use std::f64::consts::PI;

use bedload_scene::{Geometry, InitialVelocity, OverTime, Shape, Wall, WallKind};
use toml::{Table, Value};

use super::change::Change;
use super::{Idea, drive, is_driven_at_faces, same};
use crate::number::Short;
use crate::prepare::Prepared;

/// Difference between the drag of a sphere on the axis of a square duct and of the tube of equal
/// cross-section: (1.9033 − 2.1044 √π/2) D/L of Stokes's (Happel & Brenner 1983, sections 7-3 and 7-4).
const DUCT: f64 = 0.0383;

/// Difference between the radius of the mask in space and in r–z, as drag, times (D/Δx)²: space corrects its
/// radius (docs/equations-immersed.md, section 8). Measured: 1.1 % at D/Δx = 6
/// (`tests/tests/runs/proposals.rs`).
const RADIUS: f64 = 0.41;

/// The tube has the cross-section of the square box, so what is left of the shape is the difference of how
/// far walls retard a sphere. Beside free-slip sides it is of the same size or less.
pub(super) fn idea(prepared: &Prepared) -> Option<Idea> {
    let scene = &prepared.scene;
    let (domain, medium) = (&scene.scene.domain, scene.scene.medium.as_ref()?);
    let [grain] = &scene.grains[..] else { return None };
    if domain.geometry != Geometry::Space || domain.stretching.is_some() {
        return None;
    }
    let extent = |axis: usize| domain.upper[axis] - domain.lower[axis];
    let side = extent(0);
    let centred =
        |axis: usize| same(grain.position[axis], 0.5 * (domain.lower[axis] + domain.upper[axis]), side);
    let square =
        same(extent(1), side, side) && centred(0) && centred(1) && domain.cells[0] == domain.cells[1];
    let along = |v: &OverTime<[f64; 3]>| v.extremes().all(|v| v[0] == 0.0 && v[1] == 0.0);
    let moves = along(&grain.velocity) && along(&grain.spin) && grain.shape == Shape::Sphere;
    let kinds = |axis: usize| {
        let faces = domain.boundary(axis)?;
        Some([faces.lower?.kind, faces.upper.kind])
    };
    // Neither periodic nor open sides have a tube that stands for them.
    let closed = |kind: WallKind| matches!(kind, WallKind::NoSlip | WallKind::FreeSlip);
    let kind = kinds(0)?[0];
    let sides = [kinds(0)?, kinds(1)?].concat();
    let alike = closed(kind) && sides.iter().all(|side| *side == kind);
    let walls = &scene.scene.walls;
    let of_tube = |wall: &Wall| wall.spin.is_zero() && wall.servo.is_none() && along(&wall.velocity);
    let level = walls.iter().all(|wall| along(&wall.normal.into()) && of_tube(wall));
    let drives = along(&scene.scene.gravity) && along(&drive(&scene.scene).into());
    let at_rest = medium.initial == InitialVelocity::Rest && !is_driven_at_faces(&scene.scene);
    if !(square && moves && alike && level && drives && at_rest) {
        return None;
    }
    // Cells as near to square as a whole number of them lets them be.
    let radius = side / PI.sqrt();
    let columns = (radius / domain.spacing(0)).ceil();
    let ratio = 2.0 * grain.radius / side;
    let mut boundary = Table::new();
    let name = if kind == WallKind::NoSlip { "no-slip" } else { "free-slip" };
    boundary.insert("r_upper".into(), name.into());
    let faces = domain.boundary(2)?;
    for (key, face) in [("z_lower", faces.lower?), ("z_upper", faces.upper)] {
        boundary.insert(key.into(), Value::try_from(face).ok()?);
    }
    let mut place = grain.clone();
    place.position = [0.0, 0.0, grain.position[2]];
    let grains = vec![Value::try_from(&place).ok()?];
    let change = Change::default()
        .set("domain.geometry", "axisymmetric")
        .set("domain.lower", vec![0.0, domain.lower[2]])
        .set("domain.upper", vec![radius, domain.upper[2]])
        .set("domain.cells", vec![columns as i64, domain.cells[2] as i64])
        .set("domain.boundary", boundary)
        .set("grains", grains)
        .remove("grain_files")
        .remove("groups");
    Some(Idea {
        name: "axisymmetric",
        what: "a tube of the same cross-section, in r and z",
        change,
        error: DUCT * ratio + RADIUS * (domain.spacing(0) / (2.0 * grain.radius)).powi(2),
        saving: None,
        why: format!(
            "of the drag, by the other shape of the sides at D/L = {} and by the mask's radius, which is \
             corrected in space alone",
            Short(ratio)
        ),
    })
}
