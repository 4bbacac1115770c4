//! Parts of the calibrated method. No key sets them: [`Calibration::default`] is the method, and tests switch
//! single parts to show what each of them does.

/// Which parts the method has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calibration {
    /// When the carried force goes with the grains.
    pub force_transport: ForceTransport,
    /// Whether the radius of the masks is that of the grains everywhere.
    pub nominal_radius: bool,
    /// Whether viscosity does not feel a change of the force in its own step.
    pub without_local_solve: bool,
    /// Whether convection near grains is that of the rest of the fluid ([`crate::near_convection`]).
    pub plain_convection: bool,
    /// Whether the loads have no virtual mass.
    pub without_virtual_mass: bool,
    /// Whether the loads do not take off ρ(∫β dV − V), the mass by which the mask on the grid differs from
    /// the grain.
    pub without_displaced_mass: bool,
}

/// How the carried force gets from one step to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ForceTransport {
    /// It moves with the grains in the steps in which it would lag by much.
    #[default]
    Auto,
    /// It stays in its cells.
    Eulerian,
    /// It moves with the grains in every step.
    Advected,
}
