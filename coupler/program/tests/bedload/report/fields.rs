//! Field files of an analytic vortex ring, and the reader on them.

use std::path::Path;

use bedload_output::vtk::{Array, Vtr, rectilinear_part};
use protocol::message::Kinematics;

use super::sample::R;

/// Vorticity of a ring around a sphere at height `zc` that moves with `speed`, at (r, z); odd in r.
pub(crate) fn vorticity(r: f64, z: f64, zc: f64, speed: f64) -> f64 {
    let (dr, dz) = (r.abs() - 0.9 * R, z - zc + speed * 0.3);
    let ring = 9.0 * speed * (-(dr * dr + 0.3 * dz * dz) / 0.05).exp();
    ring * r.signum() - 6.0 * speed * r * (-z * 12.0).exp() * (-r * r).exp()
}

pub(crate) fn write(folder: &Path, step: usize, time: f64, motion: &Kinematics) {
    let faces =
        |count: usize, width: f64| (0..=count).map(|i| width * i as f64 / count as f64).collect::<Vec<_>>();
    let faces = [faces(80, 4.0), vec![0.0], faces(260, 13.0)];
    let centre = |faces: &[f64], i: usize| 0.5 * (faces[i] + faces[i + 1]);
    let mut values = Vec::new();
    for k in 0..260 {
        for i in 0..80 {
            let (r, z) = (centre(&faces[0], i), centre(&faces[2], k));
            values.extend([0.0, vorticity(r, z, motion.position[2], motion.velocity[2]), 0.0]);
        }
    }
    let velocity = Array::real("velocity", 3, vec![0.0; values.len()]);
    let bytes = rectilinear_part(time, &faces, 0, &[velocity, Array::real("vorticity", 3, values)]);
    std::fs::write(folder.join(format!("fluid_{step:08}.vtr")), bytes).expect("a field file");
}

fn small() -> Vec<u8> {
    let faces = [vec![0.0, 1.0, 3.0], vec![0.0], vec![-1.0, 0.0, 1.0, 4.0]];
    let values: Vec<f64> = (0..18).map(f64::from).collect();
    let data = [Array::real("vorticity", 3, values), Array::scalar("pressure", vec![7.0; 6])];
    rectilinear_part(0.25, &faces, 0, &data)
}

#[test]
fn a_field_file_reads_back_cell_by_cell() {
    let read = Vtr::parse(&small()).expect("reads");
    assert_eq!(read.time, 0.25);
    assert_eq!(read.counts(), [2, 1, 3]);
    assert_eq!(read.faces, [vec![0.0, 1.0, 3.0], vec![0.0], vec![-1.0, 0.0, 1.0, 4.0]]);
    assert_eq!(read.arrays["vorticity"], (3, (0..18).map(f64::from).collect()));
    assert_eq!(read.arrays["pressure"], (1, vec![7.0; 6]));
}

#[test]
fn a_cut_or_foreign_file_is_refused_without_a_panic() {
    let whole = small();
    let needed = whole.len() - "\n</AppendedData>\n</VTKFile>\n".len();
    for end in 0..needed {
        assert!(Vtr::parse(&whole[..end]).is_err(), "cut at {end}");
    }
    for at in 0..whole.len() {
        let mut flipped = whole.clone();
        flipped[at] ^= 0x10;
        // A changed number may go unseen; a panic or a huge allocation may not happen.
        let _ = Vtr::parse(&flipped);
    }
    let big_endian = String::from_utf8_lossy(&whole).replace("LittleEndian", "BigEndian").into_bytes();
    assert!(Vtr::parse(&big_endian).expect_err("refused").contains("byte_order"));
}
