//! Names of the bounds.

/// Names of all bounds of the coupler and of our solvers, in the order in which `bedload check` prints them.
/// `coupling.force` takes them, and those that a solver of the run sends.
pub const NAMES: &[&str] = &[
    "density-ratio",
    "density-range",
    "resting-weight",
    "cfl",
    "direct-forcing",
    "direct-forcing-accuracy",
    "dense-bed-forcing",
    "explicit-viscosity",
    "contact-steps",
    "contact-accuracy",
    "contact-dashpot",
    "window-over-contact",
    "wall-speed",
    "tangential-dashpot",
    "resolution",
    "resolution-accuracy",
    "drag-accuracy",
    "memory",
    OVERLAP,
    crate::unstable::NAME,
];

/// The bound on the step by the flow's speed, which a fluid sends.
pub(crate) const CFL: &str = "cfl";

/// The bound on how far grains sink into each other, before a run and in it.
pub(crate) const OVERLAP: &str = "overlap";
