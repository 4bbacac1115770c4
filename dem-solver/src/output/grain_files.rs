//! The grains as files: points for ParaView (`.vtp`) and a table from which another scene can start.

use crate::grains::Grains;
use crate::motion::{Motion, Vec3};
use crate::report::Observations;
use crate::spec::DemSpec;
use bedload_output::vtk::{Array, points, polygons};
use bedload_output::{GrainRow, grains_table};
use bedload_scene::Outline;

fn flat(vectors: &[Vec3]) -> Vec<f64> {
    vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

/// Velocity, spin, mean contact force of the last window, number and motion (0 free, 1 held) of the grains
/// `of`.
fn data(grains: &Grains, seen: &Observations, of: &[usize]) -> Vec<Array> {
    let vectors = |name, all: &[Vec3]| {
        let known = |i: &usize| all.get(*i).copied().unwrap_or_default();
        Array::real(name, 3, flat(&of.iter().map(known).collect::<Vec<_>>()))
    };
    let held = |i: &usize| i64::from(grains.motion[*i] != Motion::Free);
    vec![
        vectors("velocity", &grains.velocity),
        Array::scalar("speed", of.iter().map(|i| grains.velocity[*i].norm()).collect()),
        vectors("spin", &grains.spin),
        vectors("contact_force", &seen.mean_contact),
        Array::whole("id", of.iter().map(|i| *i as i64).collect()),
        Array::whole("held", of.iter().map(held).collect()),
    ]
}

/// Points with radius, velocity, spin, mean contact force of the last window, number and motion.
pub fn vtp(time: f64, grains: &Grains, seen: &Observations) -> Vec<u8> {
    let all: Vec<usize> = (0..grains.len()).collect();
    let mut data = data(grains, seen, &all);
    data.insert(0, Array::scalar("radius", grains.radius.clone()));
    points(time, flat(&grains.position), &data)
}

/// Polygons of the bodies that are not round, with the same but the radius; none where all are round.
pub fn outlines(time: f64, grains: &Grains, seen: &Observations, outlines: &[Outline]) -> Option<Vec<u8>> {
    let (mut position, mut ends, mut bodies) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..grains.len() {
        let Some(outline) = grains.outline[i].and_then(|place| outlines.get(place as usize)) else {
            continue;
        };
        for [x, z] in outline.corners() {
            let place = grains.position[i] + grains.orientation[i] * Vec3::new(x, 0.0, z);
            position.extend([place.x, place.y, place.z]);
        }
        ends.push((position.len() / 3) as i64);
        bodies.push(i);
    }
    if bodies.is_empty() {
        return None;
    }
    let data = data(grains, seen, &bodies);
    Some(polygons(time, position, ends, &data))
}

/// `grains.csv`, of the grains that `is_out` does not say to be outside the box.
pub fn table(time: f64, grains: &Grains, spec: &DemSpec, is_out: &[bool]) -> String {
    let row = |i: usize| GrainRow {
        id: i,
        position: grains.position[i].into(),
        radius: grains.radius[i],
        density: spec.grains[i].density,
        velocity: grains.velocity[i].into(),
        spin: grains.spin[i].into(),
        free: grains.motion[i] == Motion::Free,
        round: grains.is_round(i),
    };
    let inside = (0..grains.len()).filter(|i| !is_out.get(*i).copied().unwrap_or(false));
    grains_table(time, &inside.map(row).collect::<Vec<_>>())
}
