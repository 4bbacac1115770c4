//! The last axis of a separable solve.

use crate::transform::Transform;
use crate::tridiagonal::Sweep;

/// How the last axis is treated.
pub(super) enum LastAxis {
    /// Tridiagonal sweep: stretched, radial or walled axis.
    Sweep(Sweep),
    /// Transform, division by the eigenvalue, transform back; with the width squared, m².
    Transform(Box<Transform>, f64),
}

impl LastAxis {
    /// With `before` idle unknowns in front, see [`Sweep::padded`]; a transform needs none.
    pub(super) fn padded(self, before: usize) -> Self {
        match self {
            Self::Sweep(sweep) => Self::Sweep(sweep.padded(before)),
            other => other,
        }
    }
}
