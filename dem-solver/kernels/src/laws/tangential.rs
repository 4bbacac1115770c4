//! Tangential contact: spring, dashpot and slider with history (Izard et al. 2014, eq. 16).
//!
//! F_t = −min(|k_t δ_t + γ_t v_t|, μ_c F_n) along k_t δ_t + γ_t v_t. δ_t is a vector in the contact plane: it
//! grows by v_t dt, turns with the pair, and is cut back while the contact slides (Cundall & Strack 1979).
//! Eq. 16 read literally limits the force alone; for k_t/k_n ≤ 2/7 that gives the same figure 3
//! (`tests/dem/oblique.rs`).
//!
//! The plane turns at n × ṅ + ½ n (ω_i + ω_j)·n: the turn of the line of centres and the mean twist
//! about it, so that a rigid rotation of the pair about any axis turns the spring with it.

use crate::laws::coefficients::LinearPair;
use crate::motion::Vec3;

/// Turns the spring by the small rotation vector `turn`, lays it into the plane of `n` and restores
/// its length. Second order in the turn of one sub-step.
#[inline(always)]
#[must_use]
pub fn carry(spring: Vec3, n: &Vec3, turn: &Vec3) -> Vec3 {
    let length2 = spring.norm_squared();
    let first = turn.cross(&spring);
    let turned = spring + first + turn.cross(&first) * 0.5;
    let flat = turned - n * n.dot(&turned);
    let flat2 = flat.norm_squared();
    if flat2 > 0.0 { flat * (length2 / flat2).sqrt() } else { Vec3::zeros() }
}

/// F_t on the first partner, N, for the slip velocity `slip` of its surface against the other.
///
/// `mass` is m*, `normal` F_n ≥ 0, `part` the factor on the dashpot in the step in which a contact begins.
/// Cuts the spring back when the contact slides: for what the dashpot does from the next step on, no more of
/// it than acts there.
#[inline(always)]
pub fn tangential_force(
    law: &LinearPair,
    mass: f64,
    normal: f64,
    (slip, part): (&Vec3, f64),
    spring: &mut Vec3,
) -> Vec3 {
    let k_t = law.tangential_stiffness * mass;
    let gamma_t = law.tangential_damping * mass;
    let trial = -(*spring * k_t + slip * part * gamma_t);
    let limit = law.friction * normal;
    let trial2 = trial.norm_squared();
    if trial2 <= limit * limit {
        return trial;
    }
    let force = trial * (limit / trial2.sqrt());
    if k_t > 0.0 {
        *spring = -(force + slip * part.min(1.0) * gamma_t) / k_t;
    }
    force
}
