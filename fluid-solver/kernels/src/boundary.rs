//! What holds on each face of the box.
//!
//! A wall is met by the halo alone: kernels never ask where they are. With `u₁` the first value
//! inside and `u₀` its mirror image outside, at the same distance from the wall,
//! no-slip sets `u₀ = 2 V − u₁` and free-slip `u₀ = u₁`. Both are what the transforms of
//! [`crate::helmholtz`] assume (odd and even continuation), so the direct solves are exact.
//! A face that fluid passes through is a no-slip wall in this sense, whose velocity, the normal one
//! too, differs from place to place: see [`crate::open`].

/// How the normal velocity of an inflow is spread over its face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// The same everywhere.
    Uniform,
    /// Laminar: a parabola along every axis with a no-slip wall, their product where there are two.
    Parabolic,
}

/// Condition on one face of the box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Boundary<const D: usize> {
    /// The field goes on at the opposite face; both faces of the axis must say so.
    Periodic,
    /// Fluid sticks to a wall that moves in its own plane.
    NoSlip {
        /// Velocity of the wall, m/s, one entry per axis of the grid; its normal entry must be zero.
        velocity: [f64; D],
    },
    /// Impermeable, without shear stress (also a plane of symmetry).
    FreeSlip,
    /// The line r = 0 of an axisymmetric grid: lower face of axis 0 only.
    Axis,
    /// Fluid enters with a given velocity, see [`crate::open`].
    Inflow {
        /// Mean velocity over the face, m/s, one entry per axis of the grid.
        velocity: [f64; D],
        /// How its normal component is spread.
        profile: Profile,
    },
    /// Fluid leaves as it comes, see [`crate::open`].
    Outflow,
}

impl<const D: usize> Boundary<D> {
    /// A no-slip wall at rest.
    pub const WALL: Self = Self::NoSlip { velocity: [0.0; D] };

    /// Whether the field goes on at the opposite face.
    pub fn is_periodic(&self) -> bool {
        matches!(self, Self::Periodic)
    }

    /// Whether a tangential component is given here (relative to the wall), instead of its slope.
    pub fn is_odd(&self) -> bool {
        matches!(self, Self::NoSlip { .. }) || self.is_open()
    }

    /// Whether fluid passes through.
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Inflow { .. } | Self::Outflow)
    }

    /// Velocity that the fluid takes on the face along `component`, m/s (zero where it is free).
    pub fn velocity(&self, component: usize) -> f64 {
        match self {
            Self::NoSlip { velocity } => velocity[component],
            _ => 0.0,
        }
    }
}
