//! Geometry of a run.

/// Geometry of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// Two axes (x, z), everything per unit depth.
    Plane,
    /// Two axes (r, z) without swirl, integrals over the full turn.
    Axisymmetric,
    /// Three axes (x, y, z).
    Space,
}

impl Geometry {
    /// Number of axes of a grain: 3 for a sphere, 2 for a disc.
    pub fn grain_dimensions(self) -> i32 {
        if self == Self::Plane { 2 } else { 3 }
    }
}
