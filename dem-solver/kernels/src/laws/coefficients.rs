//! Coefficients of a spring and dashpot along the normal and the tangent.

/// Coefficients per unit effective mass: multiply by m*.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearPair {
    /// k_n/m*, 1/s².
    pub stiffness: f64,
    /// γ_n/m*, 1/s.
    pub damping: f64,
    /// k_t/m*, 1/s².
    pub tangential_stiffness: f64,
    /// γ_t/m*, 1/s.
    pub tangential_damping: f64,
    /// μ_c.
    pub friction: f64,
}

impl LinearPair {
    /// F_n of eq. 15, N: `mass` is m*, `gap` δ_n < 0, `rate` its time derivative.
    #[inline(always)]
    #[must_use]
    pub fn normal_force(&self, mass: f64, gap: f64, rate: f64) -> f64 {
        (-mass * (self.stiffness * gap + self.damping * rate)).max(0.0)
    }
}
