//! Resistance to rolling: elastic–plastic spring and dashpot (Ai, Chen, Rotter & Ooi 2011, model C).
//!
//! With ω_r the relative spin across the normal, R_r = R_i R_j/(R_i + R_j), θ its integral (a vector that
//! turns with the contact, like the tangential spring):
//!
//! M = −k_r θ, cut back with θ to M_max = μ_r R_r F_n;  while |M| < M_max also −C_r ω_r,
//! k_r = 2.25 k_n μ_r² R_r²,  C_r = 2 η_r √(I_r k_r),  1/I_r = Σ 1/(I + m R²).
//!
//! One difference: here the sum of both is cut to M_max too. Uncut, the dashpot of a grain that begins
//! to roll at speed exceeds M_max many times until the spring is full (a sphere at 40 rad/s loses 0.5 %
//! of its speed in that moment, and stops 1 % short).
//!
//! Chosen over the constant directional torque (Ai et al., model A), which turns round with the sign
//! of ω_r: a heap at rest then jitters for ever, and no static torque can be held. Twisting about the
//! normal is not resisted. k_n is the stiffness that the normal law has at this overlap.

use crate::error::SpecError;
use crate::laws::tangential::carry;
use crate::motion::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the resistance to rolling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rolling {
    /// Coefficient of rolling friction μ_r, ≥ 0: largest torque over R_r F_n.
    pub friction: f64,
    /// Part η_r of the critical damping of the rolling spring, ≥ 0.
    #[serde(default = "default_damping")]
    pub damping: f64,
}

/// Ai et al. (2011) take 0.3 for a quiet heap.
fn default_damping() -> f64 {
    0.3
}

/// What rolls: one contact at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Roll {
    /// Normal from the second to the first partner.
    pub normal: Vec3,
    /// F_n, N.
    pub force: f64,
    /// Stiffness k_n of the normal law, N/m.
    pub stiffness: f64,
    /// R_r, m.
    pub radius: f64,
    /// I_r, kg m².
    pub inertia: f64,
}

impl Rolling {
    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        let values = [("rolling.friction", self.friction), ("rolling.damping", self.damping)];
        SpecError::if_negative("rolling", &values)
    }

    /// Torque on the first partner, N m, for the relative spin `rate` across the normal; cuts `angle`
    /// back where the torque is at its limit.
    #[inline(always)]
    pub fn torque(&self, roll: &Roll, rate: &Vec3, angle: &mut Vec3) -> Vec3 {
        let arm = self.friction * roll.radius;
        let stiffness = 2.25 * roll.stiffness * arm * arm;
        let limit = arm * roll.force;
        let elastic = *angle * -stiffness;
        let size2 = elastic.norm_squared();
        if size2 < limit * limit {
            let whole = elastic - rate * (2.0 * self.damping * (roll.inertia * stiffness).sqrt());
            let whole2 = whole.norm_squared();
            return if whole2 <= limit * limit { whole } else { whole * (limit / whole2.sqrt()) };
        }
        if size2 == 0.0 {
            return Vec3::zeros();
        }
        let torque = elastic * (limit / size2.sqrt());
        *angle = torque / -stiffness;
        torque
    }
}

/// Relative spin across the normal.
#[inline(always)]
#[must_use]
pub fn rolling_rate(normal: &Vec3, first: &Vec3, second: &Vec3) -> Vec3 {
    let relative = first - second;
    relative - normal * normal.dot(&relative)
}

/// The angle after one step: turned with the contact frame, grown by the rolling of the step.
#[inline(always)]
#[must_use]
pub fn grow(angle: Vec3, normal: &Vec3, turn: &Vec3, rate: &Vec3, dt: f64) -> Vec3 {
    carry(angle, normal, turn) + rate * dt
}
