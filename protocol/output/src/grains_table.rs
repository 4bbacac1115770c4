//! `grains.csv`: the grains as a run leaves them, for the next.

use std::fmt::Write;

/// A grain as the table has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainRow {
    /// Number of the grain in the scene.
    pub id: usize,
    /// Centre, m.
    pub position: [f64; 3],
    /// Radius, m; of a body that is not round the largest distance of its surface from the centre.
    pub radius: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Velocity of the centre, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
    /// Free, or held.
    pub free: bool,
    /// Sphere or disc.
    pub round: bool,
}

/// CSV that `[[grain_files]]` reads back to the same bits. Springs of contacts are not in it.
pub fn grains_table(time: f64, grains: &[GrainRow]) -> String {
    let mut text = format!("# grains: {}\n# t = {time} s\n", grains.len());
    let odd = grains.iter().filter(|grain| !grain.round).count();
    if odd > 0 {
        let _ = writeln!(
            text,
            "# not round: {odd} (their radius is the largest distance of the surface from the centre; a \
             scene cannot read this table)"
        );
    }
    text += "id,x,y,z,radius,density,vx,vy,vz,wx,wy,wz,motion\n";
    for GrainRow { id, position: x, radius, density, velocity: v, spin: w, free, .. } in grains {
        let motion = if *free { "free" } else { "fixed" };
        let _ = writeln!(
            text,
            "{id},{:?},{:?},{:?},{radius:?},{density:?},{:?},{:?},{:?},{:?},{:?},{:?},{motion}",
            x[0], x[1], x[2], v[0], v[1], v[2], w[0], w[1], w[2]
        );
    }
    text
}
