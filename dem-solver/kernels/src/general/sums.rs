//! Sums of forces.

use crate::motion::Vec3;

/// Forces and torques on the grains.
#[derive(Clone, Debug, Default)]
pub(crate) struct Forces {
    /// Contact forces, N.
    pub contact: Vec<Vec3>,
    /// Contact torques, N m.
    pub torque: Vec<Vec3>,
    /// Lubrication forces, N.
    pub lubrication: Vec<Vec3>,
    /// Contact forces on the walls, N.
    pub walls: Vec<Vec3>,
    /// Largest overlap met, m.
    pub overlap: f64,
}

impl Forces {
    /// Room for `n` grains and some walls.
    pub(crate) fn new(n: usize, walls: usize) -> Self {
        let (zeros, walls) = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); walls]);
        Self { contact: zeros.clone(), torque: zeros.clone(), lubrication: zeros, walls, ..Self::default() }
    }
}
