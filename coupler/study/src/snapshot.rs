//! Grains at one instant, from the points files (`grains_*.vtp`) of a run.

use std::path::Path;

use bedload_output::vtk::Appended;

/// A grain as the picture shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Disc {
    /// Centre along x and z, m.
    pub(super) centre: (f64, f64),
    /// Radius in the plane of the picture, m.
    pub(super) radius: f64,
    /// Speed, m/s.
    pub(super) speed: f64,
    /// Is it fixed, or moved by prescription?
    pub(super) held: bool,
}

/// The grains in the plane (x, z) at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Snapshot {
    /// Time, s.
    pub(super) time: f64,
    /// Number of grains in all.
    pub(super) count: usize,
    /// Position of the plane that cuts spheres, m; none for grains that all lie in it.
    pub(super) cut: Option<f64>,
    pub(super) discs: Vec<Disc>,
}

impl Snapshot {
    /// Reads a file.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let place = |why: String| format!("{}: {why}", path.display());
        let bytes = std::fs::read(path).map_err(|error| place(format!("cannot read: {error}")))?;
        Self::parse(&bytes).map_err(place)
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let file = Appended::parse(bytes, "PolyData")?;
        let real = |name: &str| file.real(&file.find(name)?);
        let (position, radius, speed) = (real("position")?, real("radius")?, real("speed")?);
        let held = file.whole(&file.find("held")?)?;
        let position = position.as_chunks::<3>().0;
        if [position.len(), speed.len(), held.len()].iter().any(|length| *length != radius.len()) {
            return Err(format!("its arrays are not of {} grains each", radius.len()));
        }
        let cut = middle(position);
        // The plane of the picture cuts a sphere in a smaller circle.
        let seen = |i: usize| {
            let aside = cut.map_or(0.0, |y| position[i][1] - y);
            let radius = (radius[i].powi(2) - aside.powi(2)).max(0.0).sqrt();
            let centre = (position[i][0], position[i][2]);
            (radius > 0.0).then_some(Disc { centre, radius, speed: speed[i], held: held[i] != 0 })
        };
        let discs = (0..radius.len()).filter_map(seen).collect();
        Ok(Self { time: file.time(), count: radius.len(), cut, discs })
    }
}

/// Halfway between the outermost grains along y, unless all lie in one plane.
fn middle(position: &[[f64; 3]]) -> Option<f64> {
    let (low, high) = position
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (x[1].min(low), x[1].max(high)));
    (high > low).then_some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use bedload_output::vtk::{Array, points};

    use super::*;

    fn file(y: [f64; 3]) -> Vec<u8> {
        let data = [
            Array::scalar("radius", vec![1.0; 3]),
            Array::scalar("speed", vec![0.0, 2.0, 3.0]),
            Array::whole("held", vec![0, 0, 1]),
        ];
        points(0.5, vec![1.0, y[0], 2.0, 3.0, y[1], 4.0, 5.0, y[2], 6.0], &data)
    }

    #[test]
    fn discs_are_whole_and_spheres_cut() {
        let plane = Snapshot::parse(&file([0.0; 3])).unwrap();
        assert_eq!((plane.time, plane.count, plane.cut, plane.discs.len()), (0.5, 3, None, 3));
        assert_eq!(plane.discs[1], Disc { centre: (3.0, 4.0), radius: 1.0, speed: 2.0, held: false });
        assert!(plane.discs[2].held && plane.discs[2].radius == 1.0);
        let space = Snapshot::parse(&file([-2.0, 2.0, 0.6])).unwrap();
        assert_eq!(space.cut, Some(0.0));
        assert_eq!(space.discs.len(), 1, "two do not reach the plane");
        assert!((space.discs[0].radius - 0.8).abs() < 1e-12);
    }

    #[test]
    fn a_file_of_something_else_is_refused() {
        let bytes = points(0.0, vec![0.0; 3], &[Array::scalar("radius", vec![1.0])]);
        assert!(Snapshot::parse(&bytes).unwrap_err().contains("speed"));
        assert!(Snapshot::parse(b"abc").is_err());
        let mut torn = file([0.0; 3]);
        torn.truncate(torn.len() - 200);
        assert!(Snapshot::parse(&torn).unwrap_err().contains("beyond the end"));
    }
}
