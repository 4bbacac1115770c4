//! The grains as files: points for ParaView (`.vtp`) and a table from which another scene can start.

use std::fmt::Write;

use crate::grains::Grains;
use crate::motion::Motion;
use crate::report::Observations;
use crate::spec::DemSpec;
use bedload_output::vtk::{Array, points};

fn flat(vectors: &[crate::motion::Vec3]) -> Vec<f64> {
    vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

/// Points with radius, velocity, spin, mean contact force of the last window, number and motion
/// (0 free, 1 held).
#[must_use]
pub fn vtp(time: f64, grains: &Grains, seen: &Observations) -> Vec<u8> {
    let speed = grains.velocity.iter().map(|v| v.norm()).collect();
    let held = |motion: &Motion| i64::from(*motion != Motion::Free);
    let data = [
        Array::scalar("radius", grains.radius.clone()),
        Array::real("velocity", 3, flat(&grains.velocity)),
        Array::scalar("speed", speed),
        Array::real("spin", 3, flat(&grains.spin)),
        Array::real("contact_force", 3, flat(&seen.mean_contact)),
        Array::whole("id", (0..grains.len() as i64).collect()),
        Array::whole("held", grains.motion.iter().map(held).collect()),
    ];
    points(time, flat(&grains.position), &data)
}

/// CSV that `[[grain_files]]` reads back to the same bits. Springs of contacts are not in it.
#[must_use]
pub fn table(time: f64, grains: &Grains, spec: &DemSpec) -> String {
    let mut text = format!("# grains: {}\n# t = {time} s\n", grains.len());
    text += "id,x,y,z,radius,density,vx,vy,vz,wx,wy,wz,motion\n";
    for i in 0..grains.len() {
        let (x, v, w) = (grains.position[i], grains.velocity[i], grains.spin[i]);
        let motion = if grains.motion[i] == Motion::Free { "free" } else { "fixed" };
        let _ = writeln!(
            text,
            "{i},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{motion}",
            x.x, x.y, x.z, grains.radius[i], spec.grains[i].density, v.x, v.y, v.z, w.x, w.y, w.z
        );
    }
    text
}
